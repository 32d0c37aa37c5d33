/* Reads the sweeps of a study: those of study.sweep, and keys that are given a list or a range in place of a value. */
#include "base/base.h"
#include "scene/reader.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- values that differ ----------------------------------------------------------------------------------------- */

/* One value of a sweep, which may be a list. */
typedef struct swept_value {
    const double *number;
    int count, index;
} swept_value;

static int compare_values(const void *a, const void *b) {
    const swept_value *x = a, *y = b;
    for (int k = 0; k < x->count && k < y->count; k++)
        if (x->number[k] < y->number[k] || x->number[k] > y->number[k])
            return x->number[k] < y->number[k] ? -1 : 1;
    return (x->count > y->count) - (x->count < y->count);
}

/* Equal values would count the same samples twice. */
static sp_status check_values_differ(const sp_reader *r, const sp_sweep *sweep) {
    swept_value *sorted = sp_alloc((size_t)sweep->count, sizeof *sorted);
    if (!sorted)
        return sp_fail_memory(r->err, (size_t)sweep->count * sizeof *sorted);
    for (int k = 0; k < sweep->count; k++) {
        const int begin = sweep->begin ? sweep->begin[k] : k, end = sweep->begin ? sweep->begin[k + 1] : k + 1;
        sorted[k] = (swept_value){sweep->values + begin, end - begin, k};
    }
    qsort(sorted, (size_t)sweep->count, sizeof *sorted, compare_values);
    sp_status status = SP_OK;
    char value[64];
    for (int k = 1; k < sweep->count && status == SP_OK; k++)
        if (compare_values(&sorted[k - 1], &sorted[k]) == 0)
            status =
                sp_fail_key(r->err, SP_EINVAL, sweep->key, ": %s is there twice: the values of a sweep must differ",
                            sp_sweep_text(sweep, sorted[k].index, value, sizeof value));
    sp_free(sorted);
    return status;
}

/* ---- lists ------------------------------------------------------------------------------------------------------ */

/* Reads one value of a key that is no list. */
static sp_status read_value(sp_reader *r, const sp_field *f, const config_setting_t *setting, double *out) {
    if (sp_field_is_number(f))
        return sp_reader_swept_number(r, f, setting, out);
    r->line = config_setting_source_line(setting);
    if (f->type == SP_FIELD_BOOL && config_setting_type(setting) == CONFIG_TYPE_BOOL) {
        *out = config_setting_get_bool(setting) ? 1 : 0;
        return SP_OK;
    }
    const sp_word *word = f->type == SP_FIELD_WORD ? sp_reader_word(f, setting) : NULL;
    if (!word)
        return sp_reader_wrong(r, f, setting);
    if (strcmp(f->key, "packing.kind") == 0 && word->value == SP_PACK_FILE)
        return sp_fail_key(r->err, SP_EINVAL, "packing.kind",
                           " = \"file\": must not be swept: all samples of a study start from the same packing");
    *out = word->value;
    return SP_OK;
}

static sp_status read_scalars(sp_reader *r, const sp_field *f, const config_setting_t *values, sp_sweep *sweep) {
    sp_status status = SP_OK;
    sweep->values = sp_alloc((size_t)sweep->count, sizeof *sweep->values);
    if (!sweep->values)
        return sp_fail_memory(r->err, (size_t)sweep->count * sizeof *sweep->values);
    for (int k = 0; k < sweep->count && status == SP_OK; k++)
        status = read_value(r, f, config_setting_get_elem(values, (unsigned)k), &sweep->values[k]);
    return status;
}

static sp_status read_lists(sp_reader *r, const sp_field *f, const config_setting_t *values, sp_sweep *sweep) {
    size_t total = 0;
    sp_status status = SP_OK;
    for (int k = 0; k < sweep->count && status == SP_OK; k++) {
        const config_setting_t *list = config_setting_get_elem(values, (unsigned)k);
        r->line = config_setting_source_line(list);
        status = config_setting_is_list(list) ? sp_reader_length(r, f, list) : sp_reader_wrong(r, f, list);
        total += status == SP_OK ? (size_t)config_setting_length(list) : 0; /* below 2^25, the size of a text */
    }
    if (status != SP_OK)
        return status;
    sweep->values = sp_alloc(total, sizeof *sweep->values);
    sweep->begin = sp_alloc((size_t)sweep->count + 1, sizeof *sweep->begin);
    if (!sweep->values || !sweep->begin)
        return sp_fail_memory(r->err, total * sizeof *sweep->values);
    for (int k = 0; k < sweep->count && status == SP_OK; k++) {
        const config_setting_t *list = config_setting_get_elem(values, (unsigned)k);
        sweep->begin[k + 1] = sweep->begin[k] + config_setting_length(list);
        status = sp_reader_list(r, f, list, sweep->values + sweep->begin[k]);
    }
    return status;
}

/* Reads the values of a list or a range into *sweep, which the caller frees even after a failure. */
static sp_status read_values(sp_reader *r, const sp_field *f, const config_setting_t *values, sp_sweep *sweep) {
    const unsigned line = r->line;
    sp_status status;
    snprintf(sweep->key, sizeof sweep->key, "%s", f->key);
    if (config_setting_is_group(values)) {
        status = sp_read_range(r, f, values, sweep);
    } else {
        sweep->count = config_setting_is_list(values) ? config_setting_length(values) : 0;
        if (sweep->count < 1)
            return sp_fail_key(r->err, SP_EINVAL, sweep->key, ": what is swept must be a list of values, such as %s",
                               f->type == SP_FIELD_REALS  ? "([1e-4], [1e-3, 1e-4])"
                               : f->type == SP_FIELD_WORD ? "[\"...\", \"...\"]"
                               : f->type == SP_FIELD_BOOL
                                   ? "[false, true]"
                                   : "[1e-7, 1e-4], or a range { from = 1e-7; to = 1e-4; count = 4; }");
        status = f->type == SP_FIELD_REALS ? read_lists(r, f, values, sweep) : read_scalars(r, f, values, sweep);
    }
    if (status != SP_OK)
        return status;
    r->line = line;
    return check_values_differ(r, sweep);
}

/* ---- study.sweep ------------------------------------------------------------------------------------------------ */

/* Finds the field of a key in study.sweep. */
static sp_status find_key(const sp_reader *r, const char *key, const sp_field **out) {
    const sp_field *f = sp_field_find(key);
    if (f && sp_field_not_swept(f))
        return sp_fail_key(r->err, SP_EINVAL, "study.sweep", ": key \"%.60s\" cannot be swept: %s", key,
                           sp_field_not_swept(f));
    if (!f) {
        const char *dot = strchr(key, '.');
        char group[64];
        snprintf(group, sizeof group, "%.*s", dot ? (int)(dot - key < 60 ? dot - key : 60) : 7, dot ? key : "packing");
        const sp_field *near = sp_field_nearest(group, dot ? dot + 1 : key);
        const bool hint = near && !sp_field_not_swept(near);
        return sp_fail_key(r->err, SP_EINVAL, "study.sweep",
                           ": key \"%.60s\" is unknown: must be a key of packing or network, or "
                           "signal.source%s%s%s",
                           key, hint ? " (did you mean " : "", hint ? near->key : "", hint ? "?)" : "");
    }
    *out = f;
    return SP_OK;
}

static sp_status read_sweep(sp_reader *r, const config_setting_t *one, sp_sweep *sweep) {
    const char *key = NULL;
    const config_setting_t *values = NULL;
    bool range = false;
    r->line = config_setting_source_line(one);
    if (config_setting_is_group(one)) {
        config_setting_lookup_string(one, "key", &key);
        values = config_setting_get_member(one, "values");
        range = config_setting_get_member(one, "from") || config_setting_get_member(one, "to");
    }
    if (!key || (!values && !range) || (values && config_setting_length(one) != 2))
        return sp_fail_key(r->err, SP_EINVAL, "study.sweep",
                           ": each entry must be { key = \"packing.pressure\"; values = [1e-7, 1e-4]; }, or { "
                           "key = \"packing.pressure\"; from = 1e-7; to = 1e-4; count = 4; spacing = \"log\"; }");
    const sp_field *f = NULL;
    sp_status status = find_key(r, key, &f);
    if (status != SP_OK)
        return status;
    for (const sp_sweep *other = r->scene.sweep; other < sweep; other++)
        if (strcmp(other->key, key) == 0)
            return sp_fail_key(r->err, SP_EINVAL, "study.sweep", ": key \"%s\" is swept twice", key);
    if (values && config_setting_is_group(values))
        return sp_fail_key(r->err, SP_EINVAL, "study.sweep",
                           " of %s: values must be a list, a range has its place beside key", key);
    return read_values(r, f, values ? values : one, sweep);
}

sp_status sp_read_sweeps(sp_reader *r, const sp_field *f, const config_setting_t *setting) {
    sp_scene_free_sweeps(&r->scene);
    if (!config_setting_is_list(setting))
        return sp_reader_wrong(r, f, setting);
    const int count = config_setting_length(setting);
    if (count > SP_SWEEPS_MAX)
        return sp_fail_key(r->err, SP_EINVAL, "study.sweep", ": %d keys: must be %d at the most", count, SP_SWEEPS_MAX);
    for (int k = 0; k < count; k++) {
        r->scene.sweeps = k + 1;
        sp_status status = read_sweep(r, config_setting_get_elem(setting, (unsigned)k), &r->scene.sweep[k]);
        if (status != SP_OK)
            return status;
    }
    return SP_OK;
}

/* ---- keys that are given lists or ranges ------------------------------------------------------------------------ */

static int find_direct(const sp_reader *r, const sp_field *f) {
    for (int k = 0; k < r->directs; k++)
        if (sp_field_find(r->direct[k].key) == f)
            return k;
    return -1;
}

sp_status sp_read_direct(sp_reader *r, const sp_field *f, const config_setting_t *setting) {
    const char *reason = sp_field_not_swept(f);
    if (reason)
        return sp_fail_key(r->err, SP_EINVAL, f->key, " cannot be swept: %s: must be one value", reason);
    sp_sweep sweep = {0};
    int place = find_direct(r, f);
    sp_status status = read_values(r, f, setting, &sweep);
    if (status == SP_OK && place < 0 && r->directs == SP_SWEEPS_MAX)
        status = sp_fail_key(r->err, SP_EINVAL, sweep.key, ": one swept key too many: must be %d at the most",
                             SP_SWEEPS_MAX);
    if (status == SP_OK)
        status = sp_sweep_store(&r->scene, f, &sweep, 0, r->err);
    if (status != SP_OK) {
        sp_sweep_free(&sweep);
        return status;
    }
    if (place < 0)
        place = r->directs++;
    else
        sp_sweep_free(&r->direct[place]);
    r->direct[place] = sweep;
    return SP_OK;
}

void sp_drop_direct(sp_reader *r, const sp_field *f) {
    const int place = find_direct(r, f);
    if (place < 0)
        return;
    sp_sweep_free(&r->direct[place]);
    r->directs--;
    for (int k = place; k < r->directs; k++)
        r->direct[k] = r->direct[k + 1];
    r->direct[r->directs] = (sp_sweep){0};
}

sp_status sp_join_sweeps(sp_reader *r, int *listed) {
    sp_scene *s = &r->scene;
    *listed = s->sweeps;
    for (int k = 0; k < r->directs; k++)
        for (int i = 0; i < *listed; i++)
            if (strcmp(s->sweep[i].key, r->direct[k].key) == 0)
                return sp_fail_key(r->err, SP_EINVAL, r->direct[k].key,
                                   ": is swept here and by study.sweep: must be swept in one place");
    if (s->sweeps + r->directs > SP_SWEEPS_MAX)
        return sp_fail_key(r->err, SP_EINVAL, r->direct[0].key, ": one of %d swept keys: must be %d at the most",
                           s->sweeps + r->directs, SP_SWEEPS_MAX);
    for (int k = 0; k < r->directs; k++) {
        s->sweep[s->sweeps++] = r->direct[k];
        r->direct[k] = (sp_sweep){0};
    }
    r->directs = 0;
    return SP_OK;
}
