/* The numbers of a run of LAMMPS: contact law, time steps, and when it ends. */
#include "base/base.h"
#include "foreign/engine.h"
#include "packing/contact.h"
#include "packing/prepare.h"

#include <math.h>

/* The fraction of the stable step of packing.time_step, 0.7, corresponds to 0.1 sqrt(m/k) of the lightest grain and the
 * stiffest contact. LAMMPS has one step for a whole run, so that it must be stable at the hardest impact. */
static const double STEP_AT_DEFAULT = 0.1, DEFAULT_STEP = 0.7;

/* Once LAMMPS has come to this many pressures our own compression takes over. */
static const double REST = 1e-5;

/* How much weaker the springs of the viscous contacts are. */
static const double WEAK = 1e-8;

/* ---- what LAMMPS can do ----------------------------------------------------------------------------------------- */

sp_status sp_engine_check(const sp_pack_spec *given, sp_error *err) {
    sp_status status = sp_pack_spec_check(given, err);
    if (status != SP_OK)
        return status;
    const sp_pack_spec s = sp_pack_spec_resolve(given);
    if (s.kind != SP_PACK_PISTON)
        return sp_fail_key(err, SP_EINVAL, "packing.kind", ": must be \"piston\" for --engine lammps");
    if (s.cell != SP_CELL_PISTON)
        return sp_fail_key(err, SP_EINVAL, "packing.cell", ": must be \"piston\" for --engine lammps");
    if (s.tangential != SP_TANGENTIAL_CONSTANT)
        return sp_fail_key(err, SP_EINVAL, "packing.tangential", ": must be \"constant\" for --engine lammps");
    if (s.gravity != 0)
        return sp_fail_key(err, SP_EINVAL, "packing.gravity", " = %g: must be 0 for --engine lammps", s.gravity);
    if (s.protocol == SP_PROTOCOL_AFFINE)
        return sp_fail_key(err, SP_EINVAL, "packing.protocol",
                           " = \"affine\": must be another for --engine lammps, which pushes with a piston");
    if (s.compression != SP_COMPRESSION_PISTON)
        return sp_fail_key(err, SP_EINVAL, "packing.compression", ": must be \"piston\" for --engine lammps");
    if (s.history_count > 0)
        return sp_fail_key(err, SP_EINVAL, "packing.history",
                           " = (%d pressures): must be empty for --engine lammps; give the packing that it makes to "
                           "packing.kind = \"file\"",
                           s.history_count);
    if (s.reference)
        return sp_fail_key(err, SP_EINVAL, "packing.reference", " = true: must be false for --engine lammps");
    if (s.viscous_limit != 1 && s.viscous_limit < 1000)
        return sp_fail_key(err, SP_EINVAL, "packing.viscous_limit",
                           " = %g: must be 1, or at least 1000 (no limit), for --engine lammps", s.viscous_limit);
    return SP_OK;
}

/* ---- damping ---------------------------------------------------------------------------------------------------- */

static double tsuji(double e) {
    return 1.2728 + e * (-4.2783 + e * (11.087 + e * (-22.348 + e * (27.467 + e * (-18.022 + e * 4.8218)))));
}

/* Between 0 and 1 the polynomial falls from 1.2728 to 0, and it grows without bounds above 1.3. LAMMPS takes any number
 * there. */
double sp_engine_restitution(double alpha) {
    double low = 0, high = 1;
    if (alpha > tsuji(0)) {
        low = 10;
        high = 1.3;
    }
    for (int k = 0; k < 200; k++) {
        const double middle = 0.5 * (low + high);
        *(tsuji(middle) > alpha ? &low : &high) = middle;
    }
    return 0.5 * (low + high);
}

/* ---- time steps ------------------------------------------------------------------------------------------------- */

/* Stiffness of a wall contact of the largest grain under so many times the load of one grain. */
static double loaded(const sp_pack_spec *s, double pressure) {
    const double e = contact_wall_stiffness(0.5 * s->diameter_max, SP_WALL_RIGID);
    const double area = s->diameter_max * s->diameter_max;
    return contact_normal_stiffness(e, contact_overlap(e, 10 * pressure * area));
}

/* The same at the impact of the piston, which pressure has accelerated over the whole height of the gas. */
static double struck(const sp_pack_spec *s, double pressure, double height) {
    const double r = 0.5 * s->diameter_max, e = contact_wall_stiffness(r, SP_WALL_RIGID);
    const double square = 2 * pressure * height / s->piston_mass;
    return contact_normal_stiffness(e, pow(0.9375 * grain_mass(r) * square / e, 0.4));
}

static double step_at(const sp_pack_spec *s, double stiffness) {
    /* a lighter damping allows longer steps */
    const double viscous = 6.25 * s->damping, stable = sqrt(viscous * viscous + 4) - viscous;
    const double usual = 6.25 * 0.8, least = sqrt(usual * usual + 4) - usual;
    /* longer steps need grains with more inertia, which LAMMPS does not have */
    const double step = fmin(s->time_step, DEFAULT_STEP);
    const double factor = STEP_AT_DEFAULT * step / DEFAULT_STEP * fmin(2, stable / least);
    return factor * sqrt(grain_mass(0.5 * s->diameter_min) / stiffness);
}

/* ---- all -------------------------------------------------------------------------------------------------------- */

double sp_engine_pressure(const sp_pack_spec *given) {
    const sp_pack_spec s = sp_pack_spec_resolve(given);
    const double small = s.diameter_min / sp_sizes_moment(&s, 1);
    return fmin(s.pressure, 1e-3 * fmin(1, 4 * small * small));
}

/* As many steps as our own compression may take. */
static int64_t most_steps(const sp_pack_spec *s, double height) {
    if (s->max_steps > 0)
        return s->max_steps;
    return (int64_t)(4e6 * fmax(1, height / 75) * fmax(1, pow(s->pressure / 1e-4, -0.3)));
}

sp_engine_deck sp_engine_plan(const sp_pack_spec *given, double height) {
    const sp_pack_spec s = sp_pack_spec_resolve(given);
    const double p = sp_engine_pressure(&s), area = s.width * (s.dim == 3 ? s.depth : 1), eta = contact_eta(s.poisson);
    const double longest = fmax(s.width, fmax(s.depth, 0.5 * height));
    const bool friction = s.friction > 0;
    /* c = 2 zeta sqrt(m k_n) with k_n = 1.5 F_n/n; `damping tsuji' is c = alpha sqrt(m F_n/n) */
    const double alpha = 2 * s.damping * sqrt(1.5);
    sp_engine_deck d = {.dim = s.dim,
                        .grains = s.grains,
                        .period = {s.width, s.depth},
                        .height = height,
                        .pressure = p,
                        .friction = s.friction,
                        .kn = 2.0 / 3.0,
                        .kt = friction ? eta : 0,
                        .restitution = sp_engine_restitution(alpha),
                        .tangential_damping = friction ? sqrt(eta) : 0,
                        .free_viscosity = friction && s.viscous_limit > 1,
                        .weak_kn = WEAK * 2.0 / 3.0,
                        .weak_restitution = 0.1,
                        .piston_mass = s.piston_mass * area,
                        .smallest = s.diameter_min,
                        .skin = 0.15 * s.diameter_max,
                        .calm = s.calm * p,
                        .rest = REST * p,
                        .drag = s.drag * cbrt(p / 1e-4) * fmin(1, 30 / longest)};
    if (d.free_viscosity)
        d.weak_damping = sqrt(eta / WEAK) * alpha / tsuji(d.weak_restitution);
    d.step = step_at(&s, fmax(loaded(&s, p), struck(&s, p, height)));
    d.steps = most_steps(&s, height);
    return d;
}
