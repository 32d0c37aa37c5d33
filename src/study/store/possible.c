/* Whether the numbers of a sample are values that such results can have. Looks at nothing but the sample itself, so
 * that every reader of samples can afford it. */
#include "base/base.h"
#include "store/folder.h"
#include "store/stated.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

/* ---- ranges ---------------------------------------------------------------------------------------------------- */

#define AT(member) offsetof(sp_sample, member)
/* Averages over nothing, and moduli where they do not exist, are NAN. Prestress makes moduli negative. */
static const struct range {
    unsigned want;
    size_t offset;
    double low, high;
    bool maybe_nan;
} ranges[] = {
    {SP_WANT_STATICS, AT(statics.phi2), 0, 2, true},
    {SP_WANT_STATICS, AT(statics.phi3), 0, 2, true},
    {SP_WANT_STATICS, AT(statics.phi3s), 0, 2, true},
    {SP_WANT_STATICS, AT(statics.zs), 0, 20, true},
    {SP_WANT_STATICS, AT(statics.f0), 0, 100, true},
    {SP_WANT_STATICS, AT(statics.n_over_p), 0, HUGE_VAL, true},
    {SP_WANT_STATICS, AT(statics.z2), 1 - 1e-9, HUGE_VAL, true},
    {SP_WANT_STATICS, AT(statics.z3), 1 - 1e-9, HUGE_VAL, true},
    {SP_WANT_STATICS, AT(statics.f2), 0, 1 + 1e-9, true},
    {SP_WANT_STATICS, AT(statics.f2s), 0, 1 + 1e-9, true},
    {SP_WANT_STATICS, AT(statics.s1_over_s2), -HUGE_VAL, HUGE_VAL, true},
    {SP_WANT_STATICS, AT(statics.s12_over_s2), -HUGE_VAL, HUGE_VAL, true},
    {SP_WANT_STATICS, AT(statics.s32_over_s2), -HUGE_VAL, HUGE_VAL, true},
    {SP_WANT_STATICS, AT(statics.mobilised), 0, 1, true},
    {SP_WANT_STATICS, AT(statics.s_xx), -HUGE_VAL, HUGE_VAL, true},
    {SP_WANT_STATICS, AT(statics.s_yy), -HUGE_VAL, HUGE_VAL, true},
    {SP_WANT_STATICS, AT(statics.s_zz), -HUGE_VAL, HUGE_VAL, true},
    {SP_WANT_STATICS, AT(statics.s_yz), -HUGE_VAL, HUGE_VAL, true},
    {SP_WANT_STATICS, AT(statics.s_xz), -HUGE_VAL, HUGE_VAL, true},
    {SP_WANT_STATICS, AT(statics.s_xy), -HUGE_VAL, HUGE_VAL, true},
    {SP_WANT_MODULI, AT(moduli.c11), -HUGE_VAL, HUGE_VAL, true},
    {SP_WANT_MODULI, AT(moduli.c12), -HUGE_VAL, HUGE_VAL, true},
    {SP_WANT_MODULI, AT(moduli.c22), -HUGE_VAL, HUGE_VAL, true},
    {SP_WANT_MODULI, AT(moduli.c33), -HUGE_VAL, HUGE_VAL, true},
    {SP_WANT_MODULI, AT(moduli.c13), -HUGE_VAL, HUGE_VAL, true},
    {SP_WANT_MODULI, AT(moduli.c23), -HUGE_VAL, HUGE_VAL, true},
    {SP_WANT_MODULI, AT(moduli.c44), -HUGE_VAL, HUGE_VAL, true},
    {SP_WANT_MODULI, AT(moduli.c55), -HUGE_VAL, HUGE_VAL, true},
    {SP_WANT_MODULI, AT(moduli.c66), -HUGE_VAL, HUGE_VAL, true},
    {SP_WANT_MODULI, AT(moduli.c_l), 0, HUGE_VAL, true},
    {SP_WANT_MODULI, AT(moduli.c_t), 0, HUGE_VAL, true},
    {SP_WANT_MODULI, AT(moduli.residual), 0, 1, false},
#define PROBE(row)                                                                                                     \
    {SP_WANT_PROBES, AT(probe[row].along), -HUGE_VAL, HUGE_VAL, true},                                                 \
        {SP_WANT_PROBES, AT(probe[row].shear), -HUGE_VAL, HUGE_VAL, true},                                             \
        {SP_WANT_PROBES, AT(probe[row].left_out), 0, 1, true}, {                                                       \
        SP_WANT_PROBES, AT(probe[row].concentrated), 0, 1 + 1e-9, true                                                 \
    }
    PROBE(SP_SINE_1),
    PROBE(SP_SINE_2),
    PROBE(SP_LINES_1),
    PROBE(SP_LINES_3),
    {SP_WANT_SPECTRUM, AT(spectrum.omega_max), 0, HUGE_VAL, false},
    {SP_WANT_SIGNAL, AT(signal.until), 0, HUGE_VAL, false},
    {SP_WANT_SIGNAL, AT(signal.tolerance), 0, HUGE_VAL, true},
};

/* The dataset of a number; those of signals have a group of their own. */
static const char *path_of(size_t offset) {
    sp_result result[SP_RESULTS_MAX];
    const int results = sp_results(result);
    for (int k = 0; k < results; k++)
        if (result[k].offset == offset)
            return result[k].field->name.path;
    return offset == AT(signal.until) ? "/signal/t" : "/signal/tolerance";
}

static sp_status check_ranges(const sp_sample *s, sp_error *err) {
    for (size_t k = 0; k < sizeof ranges / sizeof *ranges; k++) {
        const struct range *r = &ranges[k];
        double x;
        memcpy(&x, (const char *)s + r->offset, sizeof x);
        if (!(s->have & r->want) || (x >= r->low && x <= r->high && isfinite(x)) || (isnan(x) && r->maybe_nan))
            continue;
        if (isinf(r->high))
            return sp_fail_key(err, SP_EFAILED, path_of(r->offset), " = %g: must be finite%s", x,
                               r->low >= 0 ? ", and not negative" : "");
        return sp_fail_key(err, SP_EFAILED, path_of(r->offset), " = %g: must be %g .. %g", x, r->low, r->high);
    }
    return SP_OK;
}

/* ---- what belongs together --------------------------------------------------------------------------------------- */

/* A front lies within the window in which it was looked for, and its marks follow each other. */
static sp_status check_front(const sp_front *f, const char *group, double window, sp_error *err) {
    char field[64];
    const bool ends = !isnan(f->t_zero);
    const struct {
        const char *name;
        double value;
        bool good;
        const char *rule;
    } mark[] = {
        {"t10", f->t10, f->t10 > 0 && f->t10 <= f->t_peak, "above 0 and at most t_peak"},
        {"t_peak", f->t_peak, f->t_peak <= window, "within the window of the front"},
        {"t_zero", f->t_zero, !ends || (f->t_zero >= f->t_peak && f->t_zero <= window), "after t_peak, or nan"},
        {"amplitude", f->amplitude, f->amplitude > 0 && isfinite(f->amplitude), "above 0 and finite"},
        {"width", f->width, ends ? fabs(f->width - (f->t_zero - f->t10)) <= 1e-9 * f->t_zero : isnan(f->width),
         "t_zero - t10"},
    };
    for (size_t k = 0; k < sizeof mark / sizeof *mark; k++)
        if (!mark[k].good) {
            snprintf(field, sizeof field, "/results/%s/%s", group, mark[k].name);
            return sp_fail_key(err, SP_EFAILED, field, " = %g: must be %s", mark[k].value, mark[k].rule);
        }
    return SP_OK;
}

static sp_status check_planes(const sp_sample *s, sp_error *err) {
    for (int32_t k = 0; k < s->planes; k++) {
        const sp_front *f = &s->plane_front[k];
        if (!(s->plane[k] < s->height))
            return sp_fail_key(err, SP_EFAILED, "/results/planes/height", " = %g: must be below the height %g",
                               s->plane[k], s->height);
        const bool none = isnan(f->t10) && isnan(f->t_peak) && isnan(f->t_zero) && isnan(f->amplitude);
        const double window = (1 + 1e-9) * sp_signal_window(s->plane[k], s->pressure);
        sp_status status = none ? SP_OK : check_front(f, "planes", window, err);
        if (status != SP_OK)
            return status;
    }
    return SP_OK;
}

/* Speeds follow from moduli and Phi_3*; they are NAN where the modulus is negative. */
static sp_status check_speeds(const sp_sample *s, sp_error *err) {
    const sp_moduli *m = &s->moduli;
    const bool space = s->dim == 3;
    const double density = s->statics.phi3s;
    const double modulus[] = {space ? m->c33 : m->c22, space ? 0.5 * (m->c44 + m->c55) : m->c33};
    const double stored[] = {m->c_l, m->c_t};
    if (!(s->have & SP_WANT_MODULI))
        return SP_OK;
    if (isnan(modulus[0])) /* a solve gives it; shear moduli may not exist */
        return sp_fail_key(err, SP_EFAILED, space ? "/results/moduli/c33" : "/results/moduli/c22",
                           " = nan: must be finite");
    if (!(s->have & SP_WANT_STATICS))
        return SP_OK;
    for (int k = 0; k < 2; k++) {
        const double expected = density > 0 && modulus[k] >= 0 ? sqrt(modulus[k] / density) : NAN;
        if (!(fabs(stored[k] - expected) <= 1e-9 * expected) && !(isnan(stored[k]) && isnan(expected)))
            return sp_at_odds(err, k ? "/results/moduli/c_t" : "/results/moduli/c_l", stored[k], expected);
    }
    return SP_OK;
}

static sp_status check_counts(const sp_sample *s, sp_error *err) {
    const unsigned parts = SP_WANT_CTOF | SP_WANT_STATICS | SP_WANT_MODULI | SP_WANT_SIGNAL | SP_WANT_PROBES |
                           SP_WANT_PLANES | SP_WANT_SPECTRUM;
    const sp_spectrum_made *m = &s->spectrum;
    const int most = s->dim == 1 ? 1 : s->dim == 2 ? 3 : 6;
    if (s->kind < SP_PACK_PISTON || s->kind > SP_PACK_FILE)
        return sp_fail_key(err, SP_EFAILED, "/results/sample/kind", " = %d: must be 0 .. 3", s->kind);
    if (s->lacks & ~parts)
        return sp_fail_key(err, SP_EFAILED, "/results/sample/lacks", " = %u: must be a sum of parts", s->lacks);
    if (!(s->have & SP_WANT_SPECTRUM))
        return SP_OK;
    if (m->carrying < 1 || m->carrying > s->grains)
        return sp_fail_key(err, SP_EFAILED, "/results/spectrum/carrying", " = %d: must be 1 .. %d", m->carrying,
                           s->grains);
    if (m->dof != most && m->dof != s->dim)
        return sp_fail_key(err, SP_EFAILED, "/results/spectrum/dof", " = %d: must be %d, or %d without friction",
                           m->dof, most, s->dim);
    if (m->zero_modes < 0 || m->zero_modes > (int64_t)m->carrying * m->dof)
        return sp_fail_key(err, SP_EFAILED, "/results/spectrum/zero_modes", " = %d: must be 0 .. %lld", m->zero_modes,
                           (long long)m->carrying * m->dof);
    return SP_OK;
}

sp_status sp_sample_possible(const sp_sample *s, sp_error *err) {
    if (s->failed)
        return SP_OK;
    const double window = (1 + 1e-9) * sp_signal_window(s->height, s->pressure);
    sp_status status = check_ranges(s, err);
    if (status == SP_OK)
        status = check_counts(s, err);
    if (status == SP_OK && s->have & SP_WANT_CTOF)
        status = check_front(&s->front, "front", window, err);
    if (status == SP_OK && s->have & SP_WANT_PLANES)
        status = check_planes(s, err);
    return status == SP_OK ? check_speeds(s, err) : status;
}

/* ---- arrays ------------------------------------------------------------------------------------------------------ */

static sp_status check_signal(const sp_signal *s, sp_error *err) {
    double largest = 0;
    for (int32_t k = 0; k < s->n; k++) {
        if (!isfinite(s->t[k]) || !isfinite(s->f[k]) || (k > 0 ? !(s->t[k] > s->t[k - 1]) : s->t[k] != 0))
            return sp_fail_key(err, SP_EFAILED, "/signal",
                               ": t = %g, F = %g at point %d: must be finite, at rising times from 0", s->t[k], s->f[k],
                               k);
        largest = fmax(largest, fabs(s->f[k]));
    }
    /* methods that step may miss the tolerance, but no bound is far above the signal, unless that ends before the wave
     * arrives */
    largest = fmax(largest, 1e-6);
    if (!(s->error >= 0 && s->error <= 2 * largest))
        return sp_fail_key(err, SP_EFAILED, "/signal/error", " = %g: must be 0 .. %g, where the largest |F| is %g",
                           s->error, 2 * largest, largest);
    if (!(s->omega_max >= 0 && isfinite(s->omega_max)))
        return sp_fail_key(err, SP_EFAILED, "/signal/omega_max", " = %g: must be finite, and not negative",
                           s->omega_max);
    if (s->products < 0)
        return sp_fail_key(err, SP_EFAILED, "/signal/products", " = %d: must not be negative", s->products);
    return SP_OK;
}

static sp_status check_spectrum(const sp_spectrum_made *made, const sp_sample_arrays *a, sp_error *err) {
    int64_t zeros = 0;
    for (int64_t k = 0; k < a->modes; k++) {
        if (!isfinite(a->omega[k]) || a->omega[k] < (k > 0 ? a->omega[k - 1] : 0))
            return sp_fail_key(err, SP_EFAILED, "/results/spectrum/omega",
                               " = %g of mode %lld: must be finite, not below 0, and not below the one before",
                               a->omega[k], (long long)k);
        zeros += !(a->omega[k] > 0);
    }
    if (a->modes > 0 && zeros != made->zero_modes)
        return sp_at_odds(err, "/results/spectrum/zero_modes", made->zero_modes, (double)zeros);
    if (a->modes > 0 && a->omega[a->modes - 1] != made->omega_max)
        return sp_at_odds(err, "/results/spectrum/omega_max", made->omega_max, a->omega[a->modes - 1]);
    return SP_OK;
}

sp_status sp_arrays_possible(const sp_sample *s, const sp_sample_arrays *a, sp_error *err) {
    sp_status status = check_signal(&a->signal, err);
    return status == SP_OK ? check_spectrum(&s->spectrum, a, err) : status;
}
