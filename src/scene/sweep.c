/* The sweeps of a study, and the checks of the whole scene. */
#include "base/base.h"
#include "scene/reader.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double MOST_SAMPLES = 1e7; /* of a study: a slip of the keyboard, not an ensemble, is above */

static int compare_values(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The same value twice would count the same samples twice. */
static sp_status check_values_differ(const sp_reader *r, const sp_sweep *sweep) {
    double *sorted = sp_alloc((size_t)sweep->count, sizeof *sorted);
    if (!sorted)
        return sp_fail_memory(r->err, (size_t)sweep->count * sizeof *sorted);
    memcpy(sorted, sweep->values, (size_t)sweep->count * sizeof *sorted);
    qsort(sorted, (size_t)sweep->count, sizeof *sorted, compare_values);
    sp_status status = SP_OK;
    char value[32];
    for (int k = 1; k < sweep->count && status == SP_OK; k++)
        if (sorted[k] <= sorted[k - 1])
            status = sp_fail(r->err, SP_EINVAL, "study.sweep of %s: value %s stands there twice", sweep->key,
                             sp_number_text(sorted[k], value));
    sp_free(sorted);
    return status;
}

static sp_status read_values(sp_reader *r, const sp_field *f, const config_setting_t *values, sp_sweep *sweep) {
    if (!config_setting_is_list(values) || config_setting_length(values) < 1)
        return sp_fail(r->err, SP_EINVAL, "study.sweep of %s: values must be a list of numbers, [1e-7, 1e-4]",
                       sweep->key);
    const int count = config_setting_length(values);
    sweep->values = sp_alloc((size_t)count, sizeof *sweep->values);
    if (!sweep->values)
        return sp_fail_memory(r->err, (size_t)count * sizeof *sweep->values);
    sweep->count = count;
    for (int k = 0; k < count; k++) {
        const config_setting_t *value = config_setting_get_elem(values, (unsigned)k);
        sp_number number;
        r->line = config_setting_source_line(value);
        if (!sp_reader_number(value, &number))
            return sp_reader_wrong(r, f, value);
        sp_status status = sp_field_check(f, &number, r->err);
        if (status != SP_OK)
            return status;
        sweep->values[k] = number.real + 0.0;
    }
    return check_values_differ(r, sweep);
}

static sp_status read_sweep(sp_reader *r, const config_setting_t *one, sp_sweep *sweep) {
    const char *key = NULL;
    const config_setting_t *values = NULL;
    r->line = config_setting_source_line(one);
    if (config_setting_is_group(one)) {
        config_setting_lookup_string(one, "key", &key);
        values = config_setting_get_member(one, "values");
    }
    if (!key || !values || config_setting_length(one) != 2)
        return sp_fail(r->err, SP_EINVAL,
                       "study.sweep: each entry must be { key = \"packing.pressure\"; values = [1e-7, 1e-4]; }");
    const sp_field *f = sp_field_find(key);
    if (!f || !sp_field_is_swept(f)) {
        const char *dot = strchr(key, '.');
        const sp_field *near = f ? NULL : sp_field_nearest("packing", dot ? dot + 1 : key);
        const bool hint = near && sp_field_is_swept(near);
        return sp_fail(
            r->err, SP_EINVAL,
            "study.sweep: key \"%.60s\" %s: must be a numeric key of packing or network, not the seed%s%s%s%s%s", key,
            f ? "cannot be swept" : "is unknown", hint ? " (did you mean " : "", hint ? near->group : "",
            hint ? "." : "", hint ? near->name : "", hint ? "?)" : "");
    }
    for (const sp_sweep *other = r->scene.sweep; other < sweep; other++)
        if (strcmp(other->key, key) == 0)
            return sp_fail(r->err, SP_EINVAL, "study.sweep: key \"%s\" is swept twice", key);
    snprintf(sweep->key, sizeof sweep->key, "%s", key);
    return read_values(r, f, values, sweep);
}

sp_status sp_read_sweeps(sp_reader *r, const sp_field *f, const config_setting_t *setting) {
    sp_scene_free_sweeps(&r->scene);
    if (!config_setting_is_list(setting))
        return sp_reader_wrong(r, f, setting);
    const int count = config_setting_length(setting);
    if (count > SP_SWEEPS_MAX)
        return sp_fail(r->err, SP_EINVAL, "study.sweep: %d keys: must be %d at the most", count, SP_SWEEPS_MAX);
    for (int k = 0; k < count; k++) {
        r->scene.sweeps = k + 1;
        sp_status status = read_sweep(r, config_setting_get_elem(setting, (unsigned)k), &r->scene.sweep[k]);
        if (status != SP_OK)
            return status;
    }
    return SP_OK;
}

/* Every combination of the swept values must make a packing. */
static sp_status check_combinations(const sp_reader *r, int64_t combinations) {
    sp_scene one = r->scene; /* its sweeps stay the reader's */
    const sp_field *fields[SP_SWEEPS_MAX];
    for (int i = 0; i < one.sweeps; i++)
        fields[i] = sp_field_find(one.sweep[i].key);
    for (int64_t k = 0; k < combinations; k++) {
        int64_t rest = k;
        for (int i = 0; i < one.sweeps; i++) {
            const sp_sweep *sweep = &one.sweep[i];
            sp_field_store(&one, fields[i], &(sp_number){.real = sweep->values[rest % sweep->count]}, NULL);
            rest /= sweep->count;
        }
        sp_scene sample = one;
        sp_status status = sp_scene_resolve(&sample, r->err);
        if (status == SP_OK)
            status = sp_pack_spec_check(&sample.pack, r->err);
        if (status != SP_OK)
            return sp_fail_prefix(r->err, "study.sweep");
    }
    return SP_OK;
}

static bool is_swept(const sp_scene *s, const char *key) {
    for (int i = 0; i < s->sweeps; i++)
        if (strcmp(s->sweep[i].key, key) == 0)
            return true;
    return false;
}

static int given_by(const sp_reader *r, const char *key) { return r->given[sp_field_index(sp_field_find(key))]; }

/* Whether an override gave the swept key a value, which no sample of the study would have. Grains and height say the
 * same in two ways. */
static bool is_overridden(const sp_reader *r, const char *key) {
    const char *other = strcmp(key, "packing.height") == 0   ? "packing.grains"
                        : strcmp(key, "packing.grains") == 0 ? "packing.height"
                                                             : key;
    return given_by(r, key) == SP_FROM_OVERRIDE || given_by(r, other) == SP_FROM_OVERRIDE;
}

static sp_status check_height(const sp_reader *r) {
    const sp_scene *s = &r->scene;
    const bool height_swept = is_swept(s, "packing.height"), grains_swept = is_swept(s, "packing.grains");
    const bool grains =
        grains_swept || (given_by(r, "packing.grains") != 0 && s->pack.grains != sp_pack_spec_default().grains);
    const bool one_overridden = (height_swept && is_overridden(r, "packing.height") && !grains_swept) ||
                                (grains_swept && is_overridden(r, "packing.grains") && !height_swept);
    if (!(s->height > 0 || height_swept) || !grains || one_overridden) /* of which a study takes neither */
        return SP_OK;
    char height[32], number[32];
    snprintf(height, sizeof height, "= %s", sp_number_text(s->height, number));
    snprintf(number, sizeof number, "= %d", s->pack.grains);
    return sp_fail(r->err, SP_EINVAL,
                   "packing.height %s: must not be given beside packing.grains %s: the height says how many grains",
                   height_swept ? "(swept)" : height, grains_swept ? "(swept)" : number);
}

/* What is wanted must be said in full. */
static sp_status check_wants(const sp_scene *s, sp_error *err) {
    if (s->want & SP_WANT_PLANES && s->planes == 0)
        return sp_fail(err, SP_EINVAL,
                       "study.want: planes are those of signal.planes = [12.5, 25], which must be given");
    return SP_OK;
}

/* The number of grains of one packing is that of its height. A study keeps the height for its other widths. */
static sp_status take_height(sp_reader *r) {
    const double height = r->scene.height;
    sp_status status = sp_scene_resolve(&r->scene, r->err);
    if (status == SP_OK && r->scene.sweeps > 0)
        r->scene.height = height;
    return status;
}

sp_status sp_reader_check(sp_reader *r) {
    if (r->list[0]) {
        sp_status listed = sp_reader_load_list(r);
        if (listed != SP_OK)
            return listed;
    }
    const sp_field *dimension = sp_field_find("packing.dimension");
    if (r->scene.pack.kind == SP_PACK_CHAIN && r->given[sp_field_index(dimension)] == 0)
        r->scene.pack.dim = 1;
    if (r->scene.pack.kind == SP_PACK_FILE && !r->scene.from[0])
        return sp_fail(r->err, SP_EINVAL, "packing.file = \"\": must name a packing for packing.kind = \"file\"");
    if (r->scene.pack.kind != SP_PACK_FILE && r->scene.from[0])
        return sp_fail(r->err, SP_EINVAL, "packing.kind: must be \"file\" where packing.file = \"%.200s\" is given",
                       r->scene.from);
    double combinations = 1;
    for (int i = 0; i < r->scene.sweeps; i++) {
        sp_sweep *sweep = &r->scene.sweep[i];
        combinations *= sweep->count;
        sweep->overridden = is_overridden(r, sweep->key);
    }
    if (combinations * r->scene.samples > MOST_SAMPLES)
        return sp_fail(r->err, SP_EINVAL,
                       "study.samples = %d: %d samples of %.0f combinations: must be %.0f together at the most",
                       r->scene.samples, r->scene.samples, combinations, MOST_SAMPLES);
    if (r->scene.pack.seed > (uint64_t)(INT64_MAX - r->scene.samples))
        return sp_fail(r->err, SP_EINVAL, "packing.seed = %llu: the seeds of %d samples must stay below %lld",
                       (unsigned long long)r->scene.pack.seed, r->scene.samples, (long long)INT64_MAX);
    sp_status status = check_height(r);
    if (status == SP_OK)
        status = check_wants(&r->scene, r->err);
    if (status == SP_OK)
        status = take_height(r);
    if (status == SP_OK)
        status = sp_pack_spec_check(&r->scene.pack, r->err);
    return status == SP_OK && r->scene.sweeps > 0 ? check_combinations(r, (int64_t)combinations) : status;
}
