/* Reads the sweeps of a study: those of study.sweep, and keys that are given a list or a range in place of a value. */
#include "base/base.h"
#include "scene/reader.h"

#include <math.h>
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

/* ---- ranges ----------------------------------------------------------------------------------------------------- */

enum { MOST_VALUES = 10000 };

/* From one number to another in equal steps or equal ratios. */
typedef struct range {
    const sp_field *f;
    double from, to, step; /* NAN: not given */
    int count;             /* 0: not given */
    bool log;
} range;

static sp_status read_count(const sp_reader *r, range *g, const config_setting_t *setting) {
    sp_number number;
    if (!sp_reader_number(setting, &number) ||
        !(number.real >= 2 && number.real <= MOST_VALUES && number.real == floor(number.real)))
        return sp_fail_key(r->err, SP_EINVAL, g->f->key, ": count of a range must be an integer 2 .. %d", MOST_VALUES);
    g->count = (int)number.real;
    return SP_OK;
}

static sp_status read_step(const sp_reader *r, range *g, const config_setting_t *setting) {
    sp_number number;
    sp_status status = sp_reader_quantity(r, g->f, setting, &number);
    if (status == SP_OK && !(isfinite(number.real) && fabs(number.real) > 0))
        status = sp_fail_key(r->err, SP_EINVAL, g->f->key, ": step of a range must be a number other than 0");
    g->step = number.real;
    return status;
}

static sp_status read_spacing(const sp_reader *r, range *g, const config_setting_t *setting) {
    const char *word = config_setting_get_string(setting);
    g->log = word && strcmp(word, "log") == 0;
    return g->log || (word && strcmp(word, "linear") == 0)
               ? SP_OK
               : sp_fail_key(r->err, SP_EINVAL, g->f->key, ": spacing of a range must be \"linear\" or \"log\"");
}

static sp_status read_member(sp_reader *r, range *g, const config_setting_t *group, const config_setting_t *member) {
    static const char *const members[] = {"from", "to", "count", "step", "spacing"};
    enum { MEMBERS = sizeof members / sizeof *members };
    const char *name = config_setting_name(member);
    int which = 0;
    while (which < MEMBERS && strcmp(name, members[which]) != 0)
        which++;
    r->line = config_setting_source_line(member);
    switch (which) {
    case 0: return sp_reader_swept_number(r, g->f, member, &g->from);
    case 1: return sp_reader_swept_number(r, g->f, member, &g->to);
    case 2: return read_count(r, g, member);
    case 3: return read_step(r, g, member);
    case 4: return read_spacing(r, g, member);
    default: break;
    }
    if (strcmp(name, "key") == 0 && !config_setting_name(group)) /* an entry of study.sweep */
        return SP_OK;
    const char *near = sp_nearest_word(name, MEMBERS, members);
    return sp_fail_key(r->err, SP_EINVAL, g->f->key,
                       ": a range has no \"%.60s\": must be from, to, count or step, spacing%s%s%s", name,
                       near ? " (did you mean " : "", near ? near : "", near ? "?)" : "");
}

/* The number of values that a step makes, which must divide the range. */
static sp_status count_steps(const sp_reader *r, range *g) {
    const double steps = (g->to - g->from) / g->step, whole = floor(steps + 0.5);
    const char *key = g->f->key;
    if (!(steps > 0))
        return sp_fail_key(r->err, SP_EINVAL, key, ": step = %g of a range must lead from %g to %g", g->step, g->from,
                           g->to);
    if (steps > MOST_VALUES - 0.5)
        return sp_fail_key(r->err, SP_EINVAL, key, ": step = %g of a range makes %.6g values: must be %d at the most",
                           g->step, floor(steps) + 1, MOST_VALUES);
    if (whole < 1 || fabs(steps - whole) > 1e-9 * steps)
        return sp_fail_key(r->err, SP_EINVAL, key, ": step = %g of a range must divide its length %g, not %.6g times",
                           g->step, fabs(g->to - g->from), steps);
    g->count = (int)whole + 1;
    return SP_OK;
}

static sp_status check_range(const sp_reader *r, range *g) {
    const char *key = g->f->key;
    if (isnan(g->from) || isnan(g->to) || (g->count == 0) == isnan(g->step))
        return sp_fail_key(r->err, SP_EINVAL, key,
                           ": a range must be { from = 1e-7; to = 1e-4; count = 4; spacing = \"log\"; } or { from = 0; "
                           "to = 0.5; step = 0.1; }");
    if (!(g->from < g->to || g->from > g->to))
        return sp_fail_key(r->err, SP_EINVAL, key, ": a range from %g to %g: must have two ends", g->from, g->to);
    if (g->log && !(g->from > 0 && g->to > 0))
        return sp_fail_key(r->err, SP_EINVAL, key, ": a range from %g to %g with spacing = \"log\": must be above 0",
                           g->from, g->to);
    if (g->log && g->count == 0)
        return sp_fail_key(r->err, SP_EINVAL, key, ": a range with spacing = \"log\" must have a count, not a step");
    return g->count > 0 ? SP_OK : count_steps(r, g);
}

/* Removes rounding errors: a value within 1e-14 of a number of 12 digits becomes that number, so that decades are
 * exact. */
static double rounded(double value) {
    char text[SP_NUMBER_TEXT];
    snprintf(text, sizeof text, "%.12g", value);
    const double few = strtod(text, NULL);
    return fabs(few - value) <= 1e-14 * fabs(value) ? few + 0.0 : value;
}

/* Value k of a range. Long doubles make the last bit independent of the library's pow. */
static long double value_at(const range *g, int k) {
    const int last = g->count - 1;
    const long double from = g->from, to = g->to;
    if (k == 0 || k == last)
        return k == 0 ? from : to;
    return g->log ? from * powl(to / from, (long double)k / last) : (from * (last - k) + to * k) / last;
}

static sp_status make_integers(const sp_reader *r, const range *g, double *values) {
    const int last = g->count - 1;
    for (int k = 0; k < g->count; k++) {
        const __int128 sum = (__int128)g->from * (last - k) + (__int128)g->to * k; /* last times value k */
        if (!g->log && sum % last != 0)
            return sp_fail_key(r->err, SP_EINVAL, g->f->key,
                               ": the range from %.17g to %.17g has %.6Lg as value %d of %d: must be integers", g->from,
                               g->to, value_at(g, k), k + 1, g->count);
        values[k] = g->log ? (double)floorl(value_at(g, k) + 0.5L) : (double)(sum / last);
        if (k > 0 && !(values[k] < values[k - 1] || values[k] > values[k - 1]))
            return sp_fail_key(r->err, SP_EINVAL, g->f->key,
                               ": a range of %d integers from %.17g to %.17g has %.17g twice: must be fewer", g->count,
                               g->from, g->to, values[k]);
    }
    return SP_OK;
}

/* Reads { from = 1e-7; to = 1e-4; count = 4; spacing = "log"; } as the values of a sweep. */
static sp_status read_range(sp_reader *r, const sp_field *f, const config_setting_t *group, sp_sweep *sweep) {
    range g = {.f = f, .from = NAN, .to = NAN, .step = NAN};
    const unsigned line = r->line;
    sp_status status = sp_field_is_number(f) ? SP_OK
                                             : sp_fail_key(r->err, SP_EINVAL, f->key,
                                                           ": a range has numbers only: other values must be a list");
    for (int k = 0; k < config_setting_length(group) && status == SP_OK; k++)
        status = read_member(r, &g, group, config_setting_get_elem(group, (unsigned)k));
    if (status != SP_OK)
        return status;
    r->line = line;
    status = check_range(r, &g);
    if (status != SP_OK)
        return status;
    sweep->count = g.count;
    sweep->values = sp_alloc((size_t)g.count, sizeof *sweep->values);
    if (!sweep->values)
        return sp_fail_memory(r->err, (size_t)g.count * sizeof *sweep->values);
    if (f->type != SP_FIELD_REAL)
        return make_integers(r, &g, sweep->values);
    for (int k = 0; k < g.count; k++) {
        const bool end = k == 0 || k == g.count - 1;
        const double value = (double)value_at(&g, k);
        sweep->values[k] = end ? value : rounded(value);
    }
    return SP_OK;
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

/* Reads the values of a list into *sweep. Those of a key that is a list itself stand one after the other. */
static sp_status read_list_values(sp_reader *r, const sp_field *f, const config_setting_t *values, sp_sweep *sweep) {
    const bool lists = f->type == SP_FIELD_REALS;
    size_t total = lists ? 0 : (size_t)sweep->count;
    sp_status status = SP_OK;
    for (int k = 0; lists && k < sweep->count && status == SP_OK; k++) {
        const config_setting_t *list = config_setting_get_elem(values, (unsigned)k);
        r->line = config_setting_source_line(list);
        status = config_setting_is_list(list) ? sp_reader_length(r, f, list) : sp_reader_wrong(r, f, list);
        total += status == SP_OK ? (size_t)config_setting_length(list) : 0; /* below 2^25, the size of a text */
    }
    if (status != SP_OK)
        return status;
    sweep->values = sp_alloc(total, sizeof *sweep->values);
    sweep->begin = lists ? sp_alloc((size_t)sweep->count + 1, sizeof *sweep->begin) : NULL;
    if (!sweep->values || (lists && !sweep->begin))
        return sp_fail_memory(r->err, total * sizeof *sweep->values);
    for (int k = 0; k < sweep->count && status == SP_OK; k++) {
        const config_setting_t *one = config_setting_get_elem(values, (unsigned)k);
        if (lists)
            sweep->begin[k + 1] = sweep->begin[k] + config_setting_length(one);
        status = lists ? sp_reader_list(r, f, one, sweep->values + sweep->begin[k])
                       : read_value(r, f, one, &sweep->values[k]);
    }
    return status;
}

/* Reads the values of a list or a range into *sweep, which the caller frees even after a failure. */
static sp_status read_values(sp_reader *r, const sp_field *f, const config_setting_t *values, sp_sweep *sweep) {
    const unsigned line = r->line;
    sp_status status;
    snprintf(sweep->key, sizeof sweep->key, "%s", f->key);
    if (config_setting_is_group(values)) {
        status = read_range(r, f, values, sweep);
    } else {
        sweep->count = config_setting_is_list(values) ? config_setting_length(values) : 0;
        if (sweep->count < 1)
            return sp_fail_key(r->err, SP_EINVAL, sweep->key, ": what is swept must be a list of values, such as %s",
                               f->type == SP_FIELD_REALS  ? "([1e-4], [1e-3, 1e-4])"
                               : f->type == SP_FIELD_WORD ? "[\"...\", \"...\"]"
                               : f->type == SP_FIELD_BOOL
                                   ? "[false, true]"
                                   : "[1e-7, 1e-4], or a range { from = 1e-7; to = 1e-4; count = 4; }");
        status = read_list_values(r, f, values, sweep);
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
                           ": key \"%.60s\" is unknown: must be a key of packing or network, or signal.source%s%s%s",
                           key, hint ? " (did you mean " : "", hint ? near->key : "", hint ? "?)" : "");
    }
    *out = f;
    return SP_OK;
}

static sp_status read_sweep(sp_reader *r, const config_setting_t *one, sp_sweep *sweep) {
    const char *key = NULL;
    const config_setting_t *values = NULL;
    bool ranged = false;
    r->line = config_setting_source_line(one);
    if (config_setting_is_group(one)) {
        config_setting_lookup_string(one, "key", &key);
        values = config_setting_get_member(one, "values");
        ranged = config_setting_get_member(one, "from") || config_setting_get_member(one, "to");
    }
    if (!key || (!values && !ranged) || (values && config_setting_length(one) != 2))
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
