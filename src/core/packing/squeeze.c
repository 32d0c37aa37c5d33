/* Compression of cells without a piston. */
#include "packing/squeeze.h"

#include "base/base.h"
#include "packing/prepare.h"

#include <math.h>

/* Largest strain rate of an edge, over sqrt(p / rho)/d: the inertial number of the compaction. */
static const double INERTIAL = 0.03;
/* The cell comes this near to its stress, by the factor e, in no less than so many updates: elastic waves need the
 * time, and a faster cell would ring. */
static const double UPDATES = 6;
/* Shear strain after which a stress counts as one that the grains do not carry. */
static const double MOST_FLOW = 0.5;

/* Target stress of this stage: the whole tensor scales with the pressure. */
static void target_now(const compression *run, double target[6]) {
    sp_stress_target(run->whole, target);
    for (int c = 0; c < 6; c++)
        target[c] *= run->spec->pressure / run->whole->pressure;
}

static double mean(const dynamics *d, const double stress[6]) { return (stress[0] + stress[1] + stress[2]) / d->dim; }

double sp_squeeze_imbalance(const compression *run) {
    double stress[6], target[6], worst = 0;
    sp_dynamics_stress(&run->d, stress);
    target_now(run, target);
    if (run->spec->stress_count == 0)
        return fabs(mean(&run->d, stress) - run->spec->pressure);
    for (int c = 0; c < 6; c++)
        if (run->d.cell == SP_CELL_PERIODIC || c < 3)
            worst = fmax(worst, fabs(stress[c] - target[c]));
    return worst;
}

bool sp_squeeze_carried(const compression *run) {
    double stress[6];
    sp_dynamics_stress(&run->d, stress);
    return mean(&run->d, stress) > 0.5 * run->spec->pressure;
}

double sp_squeeze_progress(const compression *run) {
    const sp_pack_spec *s = run->whole;
    const dynamics *d = &run->d;
    const double grains = s->grains * (s->dim == 2 ? sp_sizes_mean_area(s) : sp_sizes_mean_volume(s));
    const double start = grains / (run->start_height * run->start_period[0] * (s->dim == 3 ? run->start_period[1] : 1));
    return (grains / (d->area * d->piston_y) - start) / ((s->dim == 2 ? 0.8 : 0.6) - start);
}

sp_status sp_squeeze_check(const compression *run, sp_error *err) {
    if (run->flow < MOST_FLOW || run->spec->stress_count == 0)
        return SP_OK;
    double stress[6];
    sp_dynamics_stress(&run->d, stress);
    return sp_fail_key(
        err, SP_EFAILED, "packing.stress",
        ": the grains do not carry it: at step %lld they have flowed by a shear strain of %.2g, and hold "
        "xx = %.4g, yy = %.4g, zz = %.4g, yz = %.4g, xz = %.4g, xy = %.4g: must be nearer to isotropic",
        (long long)run->steps, run->flow, stress[0], stress[1], stress[2], stress[3], stress[4], stress[5]);
}

/* Like a dashpot, which always dissipates energy: the cell gives way to the stress that exceeds the target. */
void sp_squeeze_drive(compression *run, double dt) {
    dynamics *d = &run->d;
    const double p = d->pressure = run->spec->pressure; /* no ramp: the strain rate is small at any difference */
    run->flow += dt * run->flow_rate;
    if (run->steps % LATERAL_STEPS != 0)
        return;
    double stress[6], target[6], excess[6];
    sp_dynamics_stress(d, stress);
    target_now(run, target);
    const double rate =
        fmin(INERTIAL * sqrt(p), p / (d->dim * compression_stiffness(p) * UPDATES * LATERAL_STEPS * dt));
    const double average = fmax(-1, fmin(1, mean(d, stress) / p - 1));
    for (int c = 0; c < 6; c++)
        excess[c] = fmax(-1, fmin(1, (stress[c] - target[c]) / p));
    const bool tensor = run->spec->stress_count > 0 && run->phase != PHASE_FLIGHT;
    run->flow_rate = 0;
    for (int a = 0; a < d->dim; a++) {
        d->strain_rate[a] = rate * (tensor ? excess[a] : average);
        run->flow_rate = fmax(run->flow_rate, fabs(d->strain_rate[a] - rate * average));
    }
    for (int k = 0; k < 3 && tensor && d->cell == SP_CELL_PERIODIC; k++) { /* xy, xz, yz */
        d->shear_rate[k] = rate * excess[5 - k];
        run->flow_rate = fmax(run->flow_rate, fabs(d->shear_rate[k]));
    }
}
