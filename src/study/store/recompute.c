/* Computes the results of a stored sample again from its packing, and compares. */
#include "base/base.h"
#include "ensemble/parts.h"
#include "store/folder.h"
#include "store/stated.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

/* Fronts are found in signals with errors of 1e-10, and moduli by solves with bounds far below this. What remains is
 * the rounding of other machines and versions. */
static const double relative = 1e-6;

/* The scene as it was for the parts that are stored: other studies may have made the signal and the planes. */
static sp_status scene_of(const sp_record *r, const sp_scene *given, sp_scene *out, sp_error *err) {
    const sp_sample *s = &r->sample;
    *out = *given;
    sp_status status = sp_scene_resolve(out, err);
    out->signal.threads = 1;
    if (s->have & SP_WANT_SIGNAL) {
        out->signal.points = s->signal.points;
        out->signal.until = s->signal.until;
        out->signal.method = s->signal.method;
        if (!isnan(s->signal.tolerance))
            out->signal.tolerance = s->signal.tolerance;
    }
    out->planes = s->planes;
    memcpy(out->plane, s->plane, sizeof s->plane);
    return status;
}

static bool agrees(double stored, double expected, double scale) {
    return (isnan(stored) && isnan(expected)) || fabs(stored - expected) <= relative * fmax(fabs(expected), scale);
}

/* Numbers that are measured against others: moduli against that from wall to wall, shares against 1. NAN: the residual,
 * which is nothing but rounding. */
static double scale_of(const sp_sample *s, size_t at) {
    if (at == offsetof(sp_sample, moduli.residual))
        return NAN;
    if (at >= offsetof(sp_sample, moduli) && at < offsetof(sp_sample, moduli.c_l))
        return fabs(s->dim == 3 ? s->moduli.c33 : s->moduli.c22);
    for (int k = 0; k < SP_PROBES; k++)
        if (at == offsetof(sp_sample, probe[0].left_out) + (size_t)k * sizeof(sp_probe_moduli) ||
            at == offsetof(sp_sample, probe[0].concentrated) + (size_t)k * sizeof(sp_probe_moduli))
            return 1;
    return 0;
}

/* Shares of probes are missing in files of earlier versions. The averages have been compared already. */
static sp_status compare_numbers(const sp_sample *s, const sp_sample *again, sp_error *err) {
    sp_result result[SP_RESULTS_MAX];
    const int results = sp_results(result);
    for (int k = 0; k < results; k++) {
        const sp_result *of = &result[k];
        const double scale = scale_of(again, of->offset);
        double stored, expected;
        if (!(s->have & of->want) || of->want == SP_WANT_STATICS || of->field->type != SP_H5_F64 || isnan(scale))
            continue;
        memcpy(&stored, (const char *)s + of->offset, sizeof stored);
        memcpy(&expected, (const char *)again + of->offset, sizeof expected);
        if (!agrees(stored, expected, scale) && !(scale == 1 && isnan(stored)))
            return sp_at_odds(err, of->field->name.path, stored, expected);
    }
    return SP_OK;
}

static sp_status compare_planes(const sp_sample *s, const sp_sample *again, sp_error *err) {
    if (again->planes != s->planes)
        return sp_at_odds(err, "/results/planes", s->planes, again->planes);
    for (int32_t k = 0; k < s->planes; k++) {
        const sp_front *a = &s->plane_front[k], *b = &again->plane_front[k];
        const struct {
            const char *field;
            double stored, expected;
        } mark[] = {{"/results/planes/t10", a->t10, b->t10},
                    {"/results/planes/t_peak", a->t_peak, b->t_peak},
                    {"/results/planes/t_zero", a->t_zero, b->t_zero},
                    {"/results/planes/amplitude", a->amplitude, b->amplitude},
                    {"/results/planes/width", a->width, b->width}};
        for (size_t m = 0; m < sizeof mark / sizeof *mark; m++)
            if (!agrees(mark[m].stored, mark[m].expected, 0))
                return sp_at_odds(err, mark[m].field, mark[m].stored, mark[m].expected);
    }
    return SP_OK;
}

/* Both signals lie within their errors of the exact one. */
static sp_status compare_signals(const sp_signal *stored, const sp_signal *again, sp_error *err) {
    double largest = 0;
    if (stored->n != again->n)
        return sp_at_odds(err, "/signal/F", stored->n, again->n);
    for (int32_t k = 0; k < again->n; k++)
        largest = fmax(largest, fabs(again->f[k]));
    const double allowed = stored->error + again->error + 1e-12 * largest;
    for (int32_t k = 0; k < again->n; k++)
        if (!(fabs(stored->f[k] - again->f[k]) <= allowed))
            return sp_at_odds(err, "/signal/F", stored->f[k], again->f[k]);
    if (!(stored->error >= 0.1 * again->error))
        return sp_at_odds(err, "/signal/error", stored->error, again->error);
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
        if (!(fabs(a * a - b * b) <= 1e-10 * largest * largest))
            return sp_at_odds(err, "/results/spectrum/omega", a, b);
    }
    return SP_OK;
}

sp_status sp_record_recompute(const sp_record *r, const sp_scene *given, const sp_packing *p, sp_error *err) {
    const unsigned have = r->sample.have;
    sp_sample again = sp_sample_blank();
    sp_sample_arrays arrays = sp_sample_arrays_none();
    sp_scene scene;
    sp_status status = scene_of(r, given, &scene, err);
    again.dim = r->sample.dim;
    again.height = r->sample.height;
    if (status == SP_OK)
        status = sp_parts_make(&scene, have, p, &again, &arrays, err);
    if (status != SP_OK && status != SP_ENOMEM) {
        sp_fail_prefix(err, "computed again");
        status = SP_EFAILED;
    }
    if (status == SP_OK)
        status = compare_numbers(&r->sample, &again, err);
    if (status == SP_OK && have & SP_WANT_PLANES)
        status = compare_planes(&r->sample, &again, err);
    if (status == SP_OK && have & SP_WANT_SIGNAL)
        status = compare_signals(&r->arrays.signal, &arrays.signal, err);
    if (status == SP_OK && have & SP_WANT_SPECTRUM)
        status = compare_spectra(&r->arrays, &arrays, err);
    sp_sample_arrays_free(&arrays);
    return status;
}
