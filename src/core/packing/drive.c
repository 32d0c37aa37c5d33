/* Loading: the pressure, which approaches that of the stage slowly, and the strain rates; with a piston and without. */
#include "base/base.h"
#include "packing/compression.h"
#include "packing/prepare.h"

#include <math.h>

/* ---- cells without a piston -------------------------------------------------------------------------------------- */

/* Largest strain rate of an edge, over sqrt(p / rho)/d: the inertial number of the compaction. */
static const double INERTIAL = 0.03;
/* Up to this part of the pressure the grains do not carry the cell. */
static const double UNLOADED = 0.01;
/* The cell comes this near to its stress, by the factor e, in no less than so many updates: elastic waves need the
 * time, and a faster cell would ring. */
static const double UPDATES = 6;
/* Inertial number along a path of strain. */
static const double QUASISTATIC = 1e-3;
/* Mean normal stress over the pressure below which a strained packing has come apart. */
static const double APART = 1e-4;
/* Shear strain after which a stress counts as one that the grains do not carry. */
static const double MOST_FLOW = 0.5;

/* Target stress of this stage: the whole tensor scales with the pressure. */
static void target_now(const compression *run, double target[6]) {
    sp_stress_target(run->whole, target);
    for (int c = 0; c < 6; c++)
        target[c] *= run->spec->pressure / run->whole->pressure;
}

static double mean(const dynamics *d, const double stress[6]) { return (stress[0] + stress[1] + stress[2]) / d->dim; }

/* Whether the stage belongs to the path of strain. */
static bool on_path(const compression *run) { return run->stage > run->whole->history_count; }

bool sp_squeeze_strained(const compression *run) { return !on_path(run) || run->strained == run->goal; }

/* Whether a component of the cell gives way to its stress. */
static bool is_free(const compression *run, int c) {
    const bool moves = sp_tensor_has(run->d.dim, c) && (c < 3 || run->d.cell == SP_CELL_PERIODIC);
    return moves && (!on_path(run) || sp_path_frees(run->whole, c));
}

double sp_squeeze_imbalance(const compression *run) {
    double stress[6], target[6], worst = 0;
    sp_dynamics_stress(&run->d, stress);
    target_now(run, target);
    if (run->spec->stress_count == 0 && !on_path(run))
        return fabs(mean(&run->d, stress) - run->spec->pressure);
    for (int c = 0; c < 6; c++)
        if (is_free(run, c))
            worst = fmax(worst, fabs(stress[c] - target[c]));
    return worst;
}

double sp_squeeze_pressure(const compression *run) {
    double stress[6];
    sp_dynamics_stress(&run->d, stress);
    return mean(&run->d, stress);
}

bool sp_squeeze_carried(const compression *run) { return sp_squeeze_pressure(run) > 0.5 * run->spec->pressure; }

double sp_squeeze_progress(const compression *run) {
    const sp_pack_spec *s = run->whole;
    const dynamics *d = &run->d;
    const double grains = s->grains * (s->dim == 2 ? sp_sizes_mean_area(s) : sp_sizes_mean_volume(s));
    const double start = grains / (run->start_height * run->start_period[0] * (s->dim == 3 ? run->start_period[1] : 1));
    return (grains / (d->area * d->piston_y) - start) / ((s->dim == 2 ? 0.8 : 0.6) - start);
}

sp_status sp_squeeze_check(const compression *run, sp_error *err) {
    double stress[6];
    const double now = on_path(run) && sp_squeeze_strained(run) ? sp_squeeze_pressure(run) : run->spec->pressure;
    if (now < APART * run->spec->pressure)
        return sp_fail_key(err, SP_EFAILED, "packing.path.strain",
                           ": at %.6g of it the packing has come apart: its mean normal stress is %.3g E*",
                           run->strained, now);
    if (run->flow < MOST_FLOW || (run->spec->stress_count == 0 && !on_path(run)))
        return SP_OK;
    sp_dynamics_stress(&run->d, stress);
    return sp_fail_key(
        err, SP_EFAILED, "packing.stress",
        ": the grains do not carry it: at step %lld they have flowed by a shear strain of %.2g, and hold "
        "xx = %.4g, yy = %.4g, zz = %.4g, yz = %.4g, xz = %.4g, xy = %.4g: must be nearer to isotropic",
        (long long)run->steps, run->flow, stress[0], stress[1], stress[2], stress[3], stress[4], stress[5]);
}

/* Strain rates along the path, and 0 from its end on. The last step is as short as it takes. */
static void follow_path(compression *run, double dt) {
    dynamics *d = &run->d;
    const double left = run->goal - run->strained;
    double strain[6], largest = 0;
    sp_path_strain(run->whole, strain);
    for (int c = 0; c < 6; c++)
        largest = fmax(largest, fabs(strain[c]));
    const double most = dt * QUASISTATIC * sqrt(run->spec->pressure) / largest;
    const double step = fabs(left) <= most ? left : copysign(most, left);
    run->strained = step == left ? run->goal : run->strained + step;
    for (int a = 0; a < d->dim; a++)
        if (strain[a] != 0)
            d->strain_rate[a] = -step / dt * strain[a];
    for (int k = 0; k < 3; k++) /* xy, xz, yz */
        if (strain[5 - k] != 0)
            d->shear_rate[k] = -step / dt * strain[5 - k];
}

/* Like a dashpot, which always dissipates energy: the cell gives way to the stress that exceeds the target. */
static void squeeze(compression *run, double dt) {
    dynamics *d = &run->d;
    const double p = run->spec->pressure; /* no ramp: the strain rate is small at any difference */
    run->flow += dt * run->flow_rate;
    if (on_path(run))
        follow_path(run, dt);
    if (run->steps % LATERAL_STEPS != 0)
        return;
    double stress[6], target[6], excess[6];
    sp_dynamics_stress(d, stress);
    target_now(run, target);
    d->pressure = on_path(run) ? fmax(mean(d, stress), APART * p) : p;
    double rate = fmin(INERTIAL * sqrt(p),
                       p / (d->dim * compression_stiffness(p, run->spec->law_exponent) * UPDATES * LATERAL_STEPS * dt));
    if (run->whole->strain_rate > 0 && mean(d, stress) < UNLOADED * p)
        rate = run->whole->strain_rate * sqrt(p);
    const double average = fmax(-1, fmin(1, mean(d, stress) / p - 1));
    for (int c = 0; c < 6; c++)
        excess[c] = fmax(-1, fmin(1, (stress[c] - target[c]) / p));
    const bool tensor = (run->spec->stress_count > 0 && run->phase != PHASE_FLIGHT) || on_path(run);
    run->flow_rate = 0;
    for (int a = 0; a < d->dim; a++) {
        if (!is_free(run, a))
            continue;
        d->strain_rate[a] = rate * (tensor ? excess[a] : average);
        run->flow_rate = fmax(run->flow_rate, fabs(d->strain_rate[a] - (on_path(run) ? 0 : rate * average)));
    }
    for (int k = 0; k < 3 && tensor; k++) { /* xy, xz, yz */
        if (!is_free(run, 5 - k))
            continue;
        d->shear_rate[k] = rate * excess[5 - k];
        run->flow_rate = fmax(run->flow_rate, fabs(d->shear_rate[k]));
    }
}

/* ---- under a piston -------------------------------------------------------------------------------------------- */

void sp_compression_set_stage(compression *run) {
    const sp_pack_spec *whole = run->whole;
    run->now = *whole;
    run->now.pressure = sp_pack_stage_pressure(whole, run->stage);
    run->goal = sp_path_place(whole, run->stage);
    run->now.tolerance = fmin(whole->tolerance * run->now.pressure / whole->pressure, fmax(1e-10, whole->tolerance));
    run->spec = &run->now;
}

/* Period of the piston's oscillation on the packing, over 2 pi. */
static double swing_time(const compression *run) {
    const dynamics *d = &run->d;
    const double soft = d->law.softest;
    double mass = 0;
    for (int32_t i = 0; i < d->n; i++)
        mass += 1 / dynamics_grain(d, i)[d->at.inv_m];
    return sqrt((d->piston_mass + 0.5 * mass) / d->area * d->piston_y /
                (soft * compression_stiffness(d->pressure / soft, run->spec->law_exponent)));
}

/* Changes the pressure slowly compared with the oscillation; after a jump the piston would rebound and open the
 * packing. */
static void ramp_pressure(compression *run, double dt) {
    dynamics *d = &run->d;
    const double end = run->spec->pressure;
    if (d->pressure == end || run->phase == PHASE_FLIGHT)
        return;
    if (run->ramp_time == 0 || run->steps % CHECK_STEPS == 0)
        run->ramp_time = 8 * swing_time(run);
    const double change = fmin(0.1, dt / run->ramp_time);
    d->pressure = d->pressure < end ? fmin(end, d->pressure * (1 + change)) : fmax(end, d->pressure * (1 - change));
}

/* Strain rate that the grains follow at pressure p: a small fraction of sqrt(p / rho)/d. */
static double gentle_rate(double pressure) { return 3e-3 * sqrt(pressure); }

/* Changes a period towards its required start, and stops exactly there. */
static void shrink_period(compression *run, int a, double dt) {
    dynamics *d = &run->d;
    const double left = run->period_end[a] / d->period[a] - 1;
    if (fabs(left) < 1e-14) {
        run->period_end[a] = d->strain_rate[a] = 0;
        return;
    }
    const double rate = gentle_rate(run->spec->pressure);
    d->strain_rate[a] = fabs(left) < rate * dt ? left / dt : copysign(rate, left);
}

/* Changes a period at a rate proportional to the excess pressure, like a dashpot, which always dissipates energy. The
 * rate is limited to what the packing can follow within a few updates. It becomes 0 once the grains have settled and
 * the pressures are equal. */
static void follow_pressure(compression *run, int a, double dt) {
    dynamics *d = &run->d;
    const double p = d->pressure, excess = sp_dynamics_lateral_pressure(d, a) / p - 1;
    const double stop = d->strain_rate[a] == 0 ? 3e-4 : 1e-5;
    const double rate =
        fmin(gentle_rate(p), p / (compression_stiffness(p, run->spec->law_exponent) * 6 * LATERAL_STEPS * dt));
    const bool settled = run->phase == PHASE_EQUILIBRATION && d->pressure == run->spec->pressure;
    d->strain_rate[a] = settled && fabs(excess) < stop ? 0 : rate * fmax(-1, fmin(1, excess));
}

/* Inertial number of the homogeneous compression, the rate over sqrt(p / rho)/d. Of 0.1 and 0.3 the packings of the
 * second are the nearer to those of Somfai et al. 2005 (docs/physics.md, Preparation). */
static const double INERTIAL_NUMBER = 0.3;

void sp_compression_squeeze(compression *run) {
    dynamics *d = &run->d;
    const sp_pack_spec *spec = run->whole;
    if (spec->protocol != SP_PROTOCOL_AFFINE || spec->kind != SP_PACK_PISTON || spec->cell != SP_CELL_PISTON ||
        run->phase != PHASE_FLIGHT)
        return;
    run->squeezed = d->affine = true;
    d->strain_rate[d->dim - 1] = -INERTIAL_NUMBER * sqrt(d->pressure);
}

/* Once both walls carry the pressure, the piston takes over at rest. What the strain carried along then stops with it
 * all at once, without a wave: only the velocities beyond the strain are there. */
static void end_squeeze(compression *run) {
    dynamics *d = &run->d;
    if (!run->squeezed || fmin(d->wall_force[0], d->wall_force[1]) < d->pressure * d->area)
        return;
    run->squeezed = d->affine = false;
    d->strain_rate[d->dim - 1] = 0;
    d->outer_travel = INFINITY; /* displacements in the lists are those within the strained cell */
    run->phase = PHASE_COMPACTION;
}

void sp_compression_drive(compression *run, double dt) {
    if (run->d.cell != SP_CELL_PISTON) {
        squeeze(run, dt);
        return;
    }
    end_squeeze(run);
    ramp_pressure(run, dt);
    for (int a = 0; a < run->d.dim - 1; a++) {
        if (run->period_end[a] > 0)
            shrink_period(run, a, dt);
        else if (run->lateral_free && run->steps % LATERAL_STEPS == 0)
            follow_pressure(run, a, dt);
    }
}

bool sp_compression_pressed(const compression *run) {
    if (run->d.cell != SP_CELL_PISTON)
        return true;
    return run->d.pressure == run->spec->pressure && run->period_end[0] == 0 && run->period_end[1] == 0;
}

bool sp_compression_driven(const compression *run) {
    if (!sp_compression_pressed(run))
        return false;
    if (run->d.cell != SP_CELL_PISTON)
        return sp_squeeze_strained(run) && run->wall_imbalance < 0.05 * run->spec->pressure;
    return run->spec->compression == SP_COMPRESSION_PISTON ||
           (run->lateral_free && run->lateral_imbalance < 0.05 * run->spec->pressure);
}
