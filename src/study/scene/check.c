/* Checks a scene as a whole. */
#include "base/base.h"
#include "scene/reader.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double MOST_SAMPLES = 1e7; /* of a study; more are a typing error */

/* Whether one of the first `sweeps` sweeps is of this key. Those of study.sweep come first. */
static bool is_listed(const sp_scene *s, int sweeps, const char *key) {
    for (int i = 0; i < sweeps; i++)
        if (strcmp(s->sweep[i].key, key) == 0)
            return true;
    return false;
}

static bool is_swept(const sp_scene *s, const char *key) { return is_listed(s, s->sweeps, key); }

static int given_by(const sp_reader *r, const char *key) { return r->given[sp_field_index(sp_field_find(key))]; }

sp_status sp_reader_check_material(sp_reader *r) {
    static const char *const keys[] = {"material.E", "material.nu", "material.rho", "material.d"};
    enum { KEYS = sizeof keys / sizeof *keys };
    int given = 0;
    for (int k = 0; k < KEYS; k++)
        given += given_by(r, keys[k]) != 0;
    const sp_material *m = &r->scene.material;
    const bool named = m->young != 0 || m->poisson != 0 || m->density != 0 || m->diameter != 0;
    if (given == 0 || (given == KEYS && !named)) /* all 0, as `sonopack help scene' has them: not known */
        return SP_OK;
    for (int k = 0; k < KEYS; k++)
        if (given_by(r, keys[k]) == 0)
            return sp_fail_key(
                r->err, SP_EINVAL, keys[k],
                ": is missing: a material is { E = 70e9; nu = 0.22; rho = 2500; d = 1e-3; } (Pa, kg/m^3, m)");
    sp_status status = sp_material_check(m, r->err);
    if (status == SP_OK)
        r->scene.pack.poisson = m->poisson; /* unless packing.poisson follows */
    return status;
}

/* ---- combinations ----------------------------------------------------------------------------------------------- */

/* Checks the packing of every combination of swept values. */
static sp_status check_combinations(const sp_reader *r, int64_t combinations, int listed) {
    sp_scene one = r->scene; /* borrows the reader's sweeps and lists */
    sp_status status = SP_OK;
    for (int64_t k = 0; k < combinations && status == SP_OK; k++) {
        int64_t each = 1; /* the value of a sweep changes after so many combinations */
        for (int i = 0; i < one.sweeps && k % each == 0 && status == SP_OK; i++) {
            status = sp_scene_set_swept(&one, &one.sweep[i], (int)(k / each % one.sweep[i].count), r->err);
            each *= one.sweep[i].count;
        }
        sp_scene sample = one;
        if (status == SP_OK)
            status = sp_scene_resolve(&sample, r->err);
        if (status == SP_OK)
            status = sp_pack_spec_check(&sample.pack, r->err);
    }
    const char *key = r->err->key;
    if (status == SP_EINVAL && listed > 0 && (is_listed(&r->scene, listed, key) || !is_swept(&r->scene, key)))
        sp_fail_prefix_key(r->err, "study.sweep");
    return status;
}

/* The other key that decides the same quantity; the key itself if there is none. */
static const char *alternative_to(const char *key) {
    static const char *const pairs[][2] = {{"packing.height", "packing.grains"},
                                           {"packing.grains", "packing.height"},
                                           {"packing.diameters", "packing.diameter_file"}};
    for (size_t k = 0; k < sizeof pairs / sizeof *pairs; k++)
        if (strcmp(key, pairs[k][0]) == 0)
            return pairs[k][1];
    return key;
}

/* Whether an override gave a value to a key that is swept. No sample of the study would have that value. */
static bool is_overridden(const sp_reader *r, const char *key) {
    return given_by(r, key) == SP_FROM_OVERRIDE || given_by(r, alternative_to(key)) == SP_FROM_OVERRIDE;
}

/* ---- single keys ------------------------------------------------------------------------------------------------ */

/* packing.grains and packing.height decide the same quantity: only one of them may be given. */
static sp_status check_height(const sp_reader *r, int listed) {
    const sp_scene *s = &r->scene;
    const bool height_swept = is_swept(s, "packing.height"), grains_swept = is_swept(s, "packing.grains");
    const bool grains =
        grains_swept || (given_by(r, "packing.grains") != 0 && s->pack.grains != sp_pack_spec_default().grains);
    const char *one = height_swept ? "packing.height" : "packing.grains";
    const bool one_overridden = height_swept != grains_swept && is_listed(s, listed, one) && is_overridden(r, one);
    if (!(s->height > 0 || height_swept) || !grains || one_overridden) /* sp_scene_check_sweeps refuses that */
        return SP_OK;
    char height[32], number[32];
    snprintf(height, sizeof height, "= %s", sp_number_text(s->height, number));
    snprintf(number, sizeof number, "= %d", s->pack.grains);
    return sp_fail_key(
        r->err, SP_EINVAL, "packing.height",
        " %s: must not be given together with packing.grains %s, because the height decides the number of grains",
        height_swept ? "(swept)" : height, grains_swept ? "(swept)" : number);
}

static sp_status check_planes(const sp_scene *s, sp_error *err) {
    if (s->want & SP_WANT_PLANES && s->planes == 0)
        return sp_fail_key(err, SP_EINVAL, "study.want",
                           ": planes needs signal.planes = [12.5, 25], which must be given");
    return SP_OK;
}

static sp_status check_kind(sp_reader *r) {
    sp_scene *s = &r->scene;
    s->dimension_given = given_by(r, "packing.dimension") != 0 || is_swept(s, "packing.dimension");
    if (s->pack.kind == SP_PACK_CHAIN && !s->dimension_given)
        s->pack.dim = 1;
    if (s->pack.kind == SP_PACK_FILE && !s->from[0])
        return sp_fail_key(r->err, SP_EINVAL, "packing.file",
                           " = \"\": must name a packing for packing.kind = \"file\"");
    if (s->from[0] && is_swept(s, "packing.kind"))
        return sp_fail_key(r->err, SP_EINVAL, "packing.kind",
                           ": must not be swept where packing.file = \"%.200s\" is given", s->from);
    if (s->pack.kind != SP_PACK_FILE && s->pack.kind != SP_PACK_MINIMUM && s->from[0])
        return sp_fail_key(r->err, SP_EINVAL, "packing.kind",
                           ": must be \"file\" or \"minimum\" where packing.file = \"%.200s\" is given", s->from);
    return SP_OK;
}

static int compare_values(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Each swept seed is the first of study.samples consecutive seeds, which must not overlap. */
static sp_status check_swept_seeds(const sp_scene *s, sp_error *err) {
    const sp_sweep *sweep = s->sweep;
    while (sweep < s->sweep + s->sweeps && strcmp(sweep->key, "packing.seed") != 0)
        sweep++;
    if (sweep == s->sweep + s->sweeps)
        return SP_OK;
    double *sorted = sp_alloc((size_t)sweep->count, sizeof *sorted);
    if (!sorted)
        return sp_fail_memory(err, (size_t)sweep->count * sizeof *sorted);
    memcpy(sorted, sweep->values, (size_t)sweep->count * sizeof *sorted);
    qsort(sorted, (size_t)sweep->count, sizeof *sorted, compare_values);
    sp_status status = SP_OK;
    for (int k = 1; k < sweep->count && status == SP_OK; k++)
        if (sorted[k] - sorted[k - 1] < s->samples)
            status = sp_fail_key(err, SP_EINVAL, "packing.seed",
                                 ": %.0f and %.0f are swept: must differ by at least study.samples = %d, because "
                                 "each is the first of that many seeds",
                                 sorted[k - 1], sorted[k], s->samples);
    sp_free(sorted);
    return status;
}

static sp_status check_seeds(const sp_scene *s, sp_error *err) {
    if (s->pack.seed > (uint64_t)(INT64_MAX - (s->samples - 1)))
        return sp_fail_key(err, SP_EINVAL, "packing.seed", " = %llu: the seeds of %d samples must not exceed %lld",
                           (unsigned long long)s->pack.seed, s->samples, (long long)INT64_MAX);
    return check_swept_seeds(s, err);
}

/* ---- the whole -------------------------------------------------------------------------------------------------- */

/* Checks the scene's own packing. The number of grains follows from its height; a study keeps the height, because its
 * samples may have other widths. */
static sp_status check_packing(sp_reader *r) {
    const double height = r->scene.height;
    sp_status status = sp_scene_resolve(&r->scene, r->err);
    if (status == SP_OK && r->scene.sweeps > 0)
        r->scene.height = height;
    return status == SP_OK ? sp_pack_spec_check(&r->scene.pack, r->err) : status;
}

/* A study makes only the combinations of its sweeps. A fault of the scene's own packing alone is reported when that
 * packing is made. */
static sp_status check_packings(sp_reader *r, int64_t combinations, int listed) {
    sp_status own = check_packing(r);
    if (r->scene.sweeps == 0)
        return own;
    const sp_error reason = *r->err;
    sp_status status = check_combinations(r, combinations, listed);
    if (status == SP_EINVAL && own != SP_OK && !is_swept(&r->scene, reason.key))
        *r->err = reason;
    return status;
}

/* Counts the combinations, and marks the sweeps of study.sweep whose key an override gave a value. */
static sp_status count_combinations(sp_reader *r, int listed, int64_t *out) {
    double combinations = 1;
    for (int i = 0; i < r->scene.sweeps; i++) {
        sp_sweep *sweep = &r->scene.sweep[i];
        combinations *= sweep->count;
        sweep->overridden = i < listed && is_overridden(r, sweep->key);
    }
    if (combinations * r->scene.samples > MOST_SAMPLES)
        return sp_fail_key(r->err, SP_EINVAL, "study.samples",
                           " = %d: %d samples of %.0f combinations: must be %.0f together at the most",
                           r->scene.samples, r->scene.samples, combinations, MOST_SAMPLES);
    *out = (int64_t)combinations;
    return SP_OK;
}

sp_status sp_reader_check(sp_reader *r) {
    int listed = 0;
    int64_t combinations = 1;
    sp_status status = sp_join_sweeps(r, &listed);
    if (status == SP_OK && r->list[0])
        status = sp_reader_load_list(r);
    if (status == SP_OK)
        status = check_kind(r);
    if (status == SP_OK)
        status = count_combinations(r, listed, &combinations);
    if (status == SP_OK)
        status = check_seeds(&r->scene, r->err);
    if (status == SP_OK)
        status = check_height(r, listed);
    if (status == SP_OK)
        status = check_planes(&r->scene, r->err);
    return status == SP_OK ? check_packings(r, combinations, listed) : status;
}

sp_status sp_reader_check_tapped(sp_reader *r) {
    int listed = 0;
    sp_status status = sp_join_sweeps(r, &listed);
    return status == SP_OK ? sp_tapped_check(&r->scene.tapped, r->err) : status;
}
