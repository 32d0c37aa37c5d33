/* Localisation in chains: the growth of the product of transfer matrices. */
#include "base/base.h"
#include "numeric/random.h"
#include "numeric/statistics.h"

#include <math.h>
#include <sonopack/transport.h>

enum { PARTS = 32, LEAST_OF_PART = 10 };

/* Displacement of a mass and force in the spring behind it, as multiples of exp(log). */
typedef struct transfer {
    double u, f, log;
} transfer;

static sp_status check(int64_t n, const double *mass, const double *stiffness, double omega, sp_error *err) {
    if (n < PARTS * LEAST_OF_PART)
        return sp_fail(err, SP_EINVAL, "localisation: %lld masses, must be at least %d", (long long)n,
                       PARTS * LEAST_OF_PART);
    if (!(omega > 0 && isfinite(omega)))
        return sp_fail(err, SP_EINVAL, "localisation: frequency %g, must be above 0", omega);
    for (int64_t j = 0; j <= n; j++)
        if (!(stiffness[j] > 0 && isfinite(stiffness[j])) || (j < n && !(mass[j] > 0 && isfinite(mass[j]))))
            return sp_fail(err, SP_EINVAL, "localisation: mass or spring %lld is not positive", (long long)j);
    return SP_OK;
}

/* Past mass j and the spring behind it. */
static void step(transfer *t, double omega, double mass, double stiffness) {
    t->f -= mass * omega * omega * t->u;
    t->u += t->f / stiffness;
}

static void rescale(transfer *t, double impedance) {
    const double size = fmax(fabs(t->u) * impedance, fabs(t->f));
    t->u /= size;
    t->f /= size;
    t->log += log(size);
}

sp_status sp_localisation_chain(int64_t n, const double *mass, const double *stiffness, double omega,
                                sp_localisation *out, sp_error *err) {
    double growth[PARTS];
    const sp_status status = check(n, mass, stiffness, omega, err);
    if (status != SP_OK)
        return status;
    /* u_1 = 1, and the force of the wall's spring; both in units in which they are alike */
    const double impedance = omega * sqrt(mass[0] * stiffness[0]);
    transfer t = {.u = 1, .f = stiffness[0]};
    double before = 0;
    for (int part = 0; part < PARTS; part++) {
        const int64_t from = n * part / PARTS, to = n * (part + 1) / PARTS;
        for (int64_t j = from; j < to; j++) {
            step(&t, omega, mass[j], stiffness[j + 1]);
            if (j % 16 == 15)
                rescale(&t, impedance);
        }
        rescale(&t, impedance);
        growth[part] = (t.log - before) / (double)(to - from);
        before = t.log;
    }
    if (!isfinite(t.log) || !isfinite(t.u))
        return sp_fail(err, SP_EREFUSED, "localisation: frequency %g, too far above those of the chain", omega);
    /* what the ends of the chain add to the logarithm is about 1, also where the parts are too short to show it */
    *out = (sp_localisation){.omega = omega,
                             .gamma = t.log / (double)n,
                             .gamma_err = fmax(sp_standard_error(PARTS, growth), 1 / (double)n),
                             .log_end = t.log + log(fabs(t.u))};
    return SP_OK;
}

double sp_localisation_law(double omega, double mean, double variance, double k) {
    return omega * omega * variance / (8 * k * mean);
}

sp_status sp_localisation_masses(int64_t n, double disorder, uint64_t seed, double *out, sp_error *err) {
    if (!(disorder >= 0 && disorder <= 0.577))
        return sp_fail(err, SP_EINVAL, "localisation: disorder %g, must be 0 .. 0.577", disorder);
    sp_random random = sp_random_make(seed, SP_STREAM_MASSES);
    for (int64_t j = 0; j < n; j++)
        out[j] = 1 + disorder * sqrt(12) * (sp_random_uniform(&random) - 0.5);
    return SP_OK;
}
