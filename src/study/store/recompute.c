/* Computes what a file says of a sample again, from its packing and its scene, and compares. */
#include "base/base.h"
#include "ensemble/sample.h"
#include "store/folder.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

/* Fronts are found in signals with errors of 1e-10, and moduli by solves with bounds far below this. What remains is
 * the rounding of other machines and versions. */
static const double relative = 1e-6;

/* ---- keys ------------------------------------------------------------------------------------------------------ */

/* Compares the keys of a sample with its scene and its packing. */
static sp_status compare_keys(const sp_sample *s, const sp_scene *scene, const sp_packing *p, sp_error *err) {
    sp_sample own = *s;
    sp_status status = sp_sample_describe(scene, &own, err);
    if (status != SP_OK)
        return status;
    sp_sample_measure(p, &own);
    if (strcmp(own.name, s->name) != 0)
        return sp_fail_key(err, SP_EFAILED, "/results/sample/scene",
                           " makes the sample %s: another, or one of other algorithms", own.name);
    if (s->material != own.material)
        return sp_fail_key(err, SP_EFAILED, "/results/sample/material", " = %llu: must be %llu",
                           (unsigned long long)s->material, (unsigned long long)own.material);
    const struct {
        const char *field;
        double stored, expected;
    } pair[] = {{"/results/sample/seed", (double)s->seed, (double)own.seed},
                {"/results/sample/kind", s->kind, own.kind},
                {"/results/sample/dim", s->dim, p->dim},
                {"/results/sample/grains", s->grains, p->n},
                {"/results/sample/width", s->width, own.width},
                {"/results/sample/pressure", s->pressure, own.pressure},
                {"/results/sample/friction", s->friction, own.friction},
                {"/results/sample/fraction", s->fraction, own.fraction},
                {"/results/sample/stage", s->stage, own.stage},
                {"/results/sample/strain", s->strain, own.strain},
                {"/results/sample/mean_stress", s->mean_stress, own.mean_stress},
                {"/results/sample/height", s->height, sp_packing_height(p)}};
    for (size_t k = 0; k < sizeof pair / sizeof *pair; k++)
        if (pair[k].stored != pair[k].expected)
            return sp_at_odds(err, pair[k].field, pair[k].stored, pair[k].expected);
    return SP_OK;
}

/* ---- numbers --------------------------------------------------------------------------------------------------- */

/* The scene as it was for the parts that are stored: other studies may have made the signal and the planes. */
static void take_made(const sp_sample *s, sp_scene *scene) {
    scene->signal.threads = 1;
    if (s->have & SP_WANT_SIGNAL) {
        scene->signal.points = s->signal.points;
        scene->signal.until = s->signal.until;
        scene->signal.method = s->signal.method;
        if (!isnan(s->signal.tolerance))
            scene->signal.tolerance = s->signal.tolerance;
    }
    scene->planes = s->planes;
    memcpy(scene->plane, s->plane, sizeof s->plane);
}

static bool agrees(double stored, double expected, double scale) {
    return (isnan(stored) && isnan(expected)) || fabs(stored - expected) <= relative * fmax(fabs(expected), scale);
}

/* K and G, which older versions did not write. */
static bool is_isotropic(size_t at) {
    return at == offsetof(sp_sample, moduli.bulk) || at == offsetof(sp_sample, moduli.shear);
}

/* Numbers that are measured against others: moduli against that from wall to wall, stresses against the pressure,
 * shares and residuals against 1. */
static double scale_of(const sp_sample *s, size_t at, double pressure) {
    if (at >= offsetof(sp_sample, statics) && at < offsetof(sp_sample, statics) + sizeof s->statics)
        return at >= offsetof(sp_sample, statics.s_xx) ? pressure : 1;
    if (at == offsetof(sp_sample, moduli.residual))
        return 1;
    if ((at >= offsetof(sp_sample, moduli) && at < offsetof(sp_sample, moduli.c_l)) || is_isotropic(at))
        return fabs(s->dim == 3 ? s->moduli.c33 : s->moduli.c22);
    for (int k = 0; k < SP_PROBES; k++)
        if (at == offsetof(sp_sample, probe[0].left_out) + (size_t)k * sizeof(sp_probe_moduli) ||
            at == offsetof(sp_sample, probe[0].concentrated) + (size_t)k * sizeof(sp_probe_moduli))
            return 1;
    return 0;
}

static double number_at(const sp_sample *s, const sp_result *of) {
    const char *place = (const char *)s + of->offset;
    double real;
    int32_t integer;
    memcpy(&integer, place, sizeof integer);
    if (of->field->type != SP_H5_F64)
        return integer;
    memcpy(&real, place, sizeof real);
    return real;
}

static sp_status compare_numbers(const sp_sample *s, const sp_sample *again, double pressure, sp_error *err) {
    sp_result result[SP_RESULTS_MAX];
    const int results = sp_results(result);
    for (int k = 0; k < results; k++) {
        const sp_result *of = &result[k];
        const double stored = number_at(s, of), expected = number_at(again, of);
        const bool unwritten = is_isotropic(of->offset) && isnan(stored);
        if (s->have & of->want && !unwritten && !agrees(stored, expected, scale_of(again, of->offset, pressure)))
            return sp_at_odds(err, of->field->name.path, stored, expected);
    }
    return SP_OK;
}

static sp_status compare_planes(const sp_sample *s, const sp_sample *again, sp_error *err) {
    if (again->planes != s->planes)
        return sp_at_odds(err, "/results/planes", s->planes, again->planes);
    for (int32_t k = 0; k < s->planes; k++)
        for (const sp_plane_field *f = sp_plane_fields; f < sp_plane_fields + SP_PLANE_FIELDS; f++) {
            const double stored = sp_plane_number(f, s, k), expected = sp_plane_number(f, again, k);
            if (!agrees(stored, expected, 0))
                return sp_at_odds(err, f->name.path, stored, expected);
        }
    return SP_OK;
}

/* ---- arrays ---------------------------------------------------------------------------------------------------- */

/* Both signals lie within their errors of the exact one. The stored error is neither far below the new one, nor far
 * above the signal, unless that ends before the wave arrives. */
static sp_status compare_signals(const sp_signal *stored, const sp_signal *again, sp_error *err) {
    double largest = 0;
    if (stored->n != again->n)
        return sp_at_odds(err, "/signal/F", stored->n, again->n);
    for (int32_t k = 0; k < again->n; k++)
        largest = fmax(largest, fabs(again->f[k]));
    if (!(stored->error >= 0.1 * again->error && stored->error <= 2 * fmax(largest, 1e-6)))
        return sp_at_odds(err, "/signal/error", stored->error, again->error);
    const double allowed = stored->error + again->error + 1e-12 * largest, until = again->t[again->n - 1];
    for (int32_t k = 0; k < again->n; k++) {
        if (!(fabs(stored->t[k] - again->t[k]) <= 1e-9 * until))
            return sp_at_odds(err, "/signal/t", stored->t[k], again->t[k]);
        if (!(fabs(stored->f[k] - again->f[k]) <= allowed))
            return sp_at_odds(err, "/signal/F", stored->f[k], again->f[k]);
    }
    if (stored->products < 0)
        return sp_at_odds(err, "/signal/products", stored->products, again->products);
    return agrees(stored->omega_max, again->omega_max, 0)
               ? SP_OK
               : sp_at_odds(err, "/signal/omega_max", stored->omega_max, again->omega_max);
}

/* Squared frequencies are eigenvalues, which have errors of the same size, small beside the largest. */
static sp_status compare_spectra(const sp_sample_arrays *stored, const sp_sample_arrays *again, sp_error *err) {
    if (stored->modes != again->modes)
        return sp_at_odds(err, "/results/spectrum/omega", (double)stored->modes, (double)again->modes);
    const double largest = again->modes > 0 ? again->omega[again->modes - 1] : 0;
    for (int64_t k = 0; k < again->modes; k++) {
        const double a = stored->omega[k], b = again->omega[k];
        if (!(a >= 0 && fabs(a * a - b * b) <= 1e-10 * largest * largest))
            return sp_at_odds(err, "/results/spectrum/omega", a, b);
    }
    return SP_OK;
}

static sp_status compare(const sp_record *r, const sp_record *again, double pressure, sp_error *err) {
    const unsigned have = r->sample.have;
    sp_status status = compare_numbers(&r->sample, &again->sample, pressure, err);
    if (status == SP_OK && have & SP_WANT_PLANES)
        status = compare_planes(&r->sample, &again->sample, err);
    if (status == SP_OK && have & SP_WANT_SIGNAL)
        status = compare_signals(&r->arrays.signal, &again->arrays.signal, err);
    if (status == SP_OK && have & SP_WANT_SPECTRUM)
        status = compare_spectra(&r->arrays, &again->arrays, err);
    return status;
}

/* ---- all of it ------------------------------------------------------------------------------------------------- */

/* What does not come from the network: the packing by itself, and what is stated of it. */
static sp_status check_packing(const char *path, const sp_packing *p, double threshold, double tolerance,
                               sp_error *err) {
    sp_audit audit;
    char reason[SP_ERROR_TEXT];
    sp_status status = sp_packing_audit(p, threshold, &audit, err);
    if (status != SP_OK)
        return status;
    sp_audit_worst(&audit, tolerance, reason, sizeof reason);
    return *reason ? sp_fail(err, SP_EFAILED, "%s", reason) : sp_packing_check_stated(path, p, &audit, err);
}

static sp_status make_again(const sp_scene *scene, const sp_record *r, const sp_packing *p, sp_error *err) {
    sp_record again = {.sample = sp_sample_blank(), .arrays = sp_sample_arrays_none()};
    again.sample.dim = r->sample.dim;
    again.sample.height = r->sample.height;
    sp_status status = sp_parts_make(scene, r->sample.have, p, &again.sample, &again.arrays, err);
    if (status != SP_OK && status != SP_ENOMEM) {
        sp_fail_prefix(err, "computed again");
        status = SP_EFAILED;
    }
    if (status == SP_OK)
        status = compare(r, &again, p->pressure, err);
    sp_record_free(&again);
    return status;
}

sp_status sp_record_recompute(const char *path, const sp_record *r, const sp_packing *p, double tolerance,
                              sp_error *err) {
    sp_scene scene = sp_scene_default();
    if (!r->scene)
        return sp_fail_key(err, SP_EFAILED, "/results/sample/scene", ": is missing, and the results follow from it");
    sp_status status = sp_scene_parse(r->scene, r->sample.name, 0, NULL, &scene, err);
    if (status == SP_OK)
        status = sp_scene_resolve(&scene, err);
    if (status == SP_OK)
        status = compare_keys(&r->sample, &scene, p, err);
    if (status == SP_OK)
        status = check_packing(path, p, scene.network.threshold, tolerance, err);
    if (status == SP_OK) {
        take_made(&r->sample, &scene);
        status = make_again(&scene, r, p, err);
    }
    sp_scene_free(&scene);
    return status;
}
