/* Compression by a piston, Somfai et al. 2005, section III: a massive rough piston compresses a loose gas until all
 * motion stops. Values that the paper does not give (damping, piston mass, time step) default to those that reproduce
 * its tables. */
#include "base/base.h"
#include "base/vector.h"
#include "packing/compression.h"
#include "packing/contact.h"
#include "packing/dynamics.h"
#include "packing/geometry.h"
#include "packing/prepare.h"

#include <math.h>
#include <string.h>

/* The tangential forces are those of the last evaluation, before the last step. Makes them tangential to the stored
 * normal and limits them by Coulomb's law at the stored overlap. */
static void finish_contact(const dynamics *d, double friction, sp_contact *c) {
    double along = 0, square = 0;
    for (int a = 0; a < 3; a++)
        along += c->ft[a] * c->n[a];
    for (int a = 0; a < 3; a++) {
        c->ft[a] -= d->dim == 3 ? along * c->n[a] : 0;
        square += c->ft[a] * c->ft[a];
    }
    const double size = sqrt(square), limit = friction * c->fn;
    for (int a = 0; a < 3; a++)
        c->ft[a] = (size > limit ? c->ft[a] * (limit / size) : c->ft[a]) + 0.0; /* no negative zero */
}

/* Adds pair k of the list as a contact, from the lower to the higher index, if it is closed. */
static void add_pair(const compression *run, const pair_list *list, int32_t k, sp_packing *p, int32_t *count) {
    const dynamics *d = &run->d;
    const int32_t one = run->id[list->i[k]], two = run->id[list->j[k]], i = one < two ? one : two,
                  j = one < two ? two : one;
    double n[3], t[3] = {0, 0, 0};
    sp_packing_separation(p, i, j, n);
    const double r = length3(n), overlap = p->r[i] + p->r[j] - r, flip = one < two ? 1 : -1;
    if (!(overlap > 0))
        return;
    for (int a = 0; a < d->dim; a++)
        n[a] /= r;
    if (d->dim == 2) { /* the scalar along (-ny, nx) does not depend on the order of i and j */
        t[0] = -list->ft[k] * n[1];
        t[1] = list->ft[k] * n[0];
    } else {
        for (int a = 0; a < 3; a++)
            t[a] = flip * list->ft[k + (int64_t)a * list->capacity];
    }
    sp_contact *c = &p->contacts[(*count)++];
    *c = (sp_contact){.i = i, .j = j, .overlap = overlap, .n = {n[0], n[1], n[2]}, .ft = {t[0], t[1], t[2]}};
    c->fn = sp_dynamics_normal(d, list->i[k], list->j[k], overlap);
    finish_contact(d, dynamics_rule(d, list->i[k], list->j[k])->friction, c);
}

static void add_wall(const compression *run, int side, int32_t at, sp_packing *p, int32_t *count) {
    const dynamics *d = &run->d;
    const int32_t i = run->id[at];
    const wall_frame frame = dynamics_wall(d, side);
    const double *ft = d->wall_ft[side] + (int64_t)(d->dim - 1) * at;
    double overlap = p->r[i] - sp_packing_wall_distance(p, i, -1 - side);
    if (!(overlap > 0))
        return;
    sp_contact c = {.i = i, .j = -1 - side, .overlap = overlap};
    const contact_rule *rule = dynamics_wall_rule(d, at);
    c.fn = rule->stiffness * contact_force(contact_wall_stiffness(p->r[i], p->wall), overlap);
    c.n[frame.axis] = frame.sign;
    for (int a = 0; a < d->dim - 1; a++)
        c.ft[frame.along[a]] = ft[a];
    finish_contact(d, rule->friction, &c);
    p->contacts[(*count)++] = c;
}

/* The tilts may have grown beyond half of the edges since the lists were built. */
static void set_cell(const dynamics *d, sp_packing *p) {
    dynamics now = *d;
    sp_deform_reduce(&now);
    const sp_packing cell = sp_dynamics_cell(&now);
    p->cell = cell.cell;
    memcpy(p->box, cell.box, sizeof cell.box);
    memcpy(p->tilt, cell.tilt, sizeof cell.tilt);
}

/* Extracts the packing from the final state. */
static sp_status freeze(const compression *run, sp_packing *out, sp_error *err) {
    const dynamics *d = &run->d;
    const sp_pack_spec *spec = run->spec;
    const pair_list *list = dynamics_pairs(d);
    sp_packing p = sp_packing_none();
    int32_t walls = 0;
    for (int side = 0; side < d->walls; side++)
        walls += d->wall[side].n;
    int32_t *type = sp_alloc((size_t)d->n, sizeof *type);
    sp_status status = type ? SP_OK : sp_fail_memory(err, (size_t)d->n * sizeof *type);
    if (status == SP_OK)
        status = sp_packing_alloc(&p, d->dim, d->n, list->n + walls, err);
    if (status != SP_OK) {
        sp_free(type);
        return status;
    }
    set_cell(d, &p);
    p.gravity = spec->gravity;
    p.pressure = run->stage > run->whole->history_count ? sp_squeeze_pressure(run) : spec->pressure;
    p.friction = d->law.friction;
    p.poisson = spec->poisson;
    p.seed = spec->seed;
    p.steps = run->steps;
    p.residual = run->residual;
    for (int32_t at = 0; at < d->n; at++) {
        const double *g = dynamics_grain(d, at);
        double *x = p.x + 3 * (size_t)run->id[at];
        p.r[run->id[at]] = g[d->at.r];
        type[run->id[at]] = dynamics_type(d, at);
        for (int a = 0; a < d->dim; a++)
            x[a] = g[a];
        if (p.cell == SP_CELL_PERIODIC)
            sp_packing_wrap(&p, x);
        for (int a = 0; a < d->dim - 1 && p.cell == SP_CELL_PISTON; a++) {
            x[a] -= d->period[a] * floor(x[a] / d->period[a]);
            x[a] = x[a] < d->period[a] ? x[a] : 0;
        }
    }
    int32_t count = 0;
    for (int32_t k = 0; k < list->n; k++)
        add_pair(run, list, k, &p, &count);
    for (int side = 0; side < d->walls; side++)
        for (int32_t k = 0; k < d->wall[side].n; k++)
            add_wall(run, side, d->wall[side].i[k], &p, &count);
    p.n_contacts = count;
    sp_packing_sort(&p);
    status = sp_types_finish(spec, type, &p, err);
    sp_free(type);
    if (status == SP_OK)
        *out = p;
    else
        sp_packing_free(&p);
    return status;
}

/* ---- the time step ------------------------------------------------------------------------------------------- */

/* Damping that limits the step like zeta does without lag. Leapfrog whose viscous forces act on u = v + lag (u - v)
 * of half a step before is stable for q (viscous rate) dt + (omega dt)^2/2 < 2, q = (1 - lag)/(1 + lag). */
static double lagging(const dynamics *d) { return d->law.damping * (1 - d->lag) / (1 + d->lag); }

/* Largest stable step times `rate`, the largest sum of sqrt(m_eff k_n)/m over the contacts of a grain, for contacts
 * with fraction zeta of critical damping. The largest viscous rate is 6.25 zeta rate, and the largest frequency is
 * rate, both within 5% (measured on packings at 1e-4 and 1e-7). */
static double stable_step(double zeta) {
    const double viscous = 6.25 * zeta;
    return sqrt(viscous * viscous + 4) - viscous;
}

/* Fraction of the stable step. While the packing forms, 0.7 of it makes the packing slightly denser (Phi2 by 0.2
 * standard deviations). During equilibration steps only need to be stable, which 0.7 is not in lattices of equal
 * disks. */
static double step_fraction(const compression *run) {
    const sp_pack_spec *spec = run->spec;
    const double longer = fmax(spec->time_step, fmin(0.7, 1.4 * spec->time_step));
    return run->phase == PHASE_EQUILIBRATION && !sp_sizes_alike(spec) ? longer : spec->time_step;
}

/* The same for two equal grains without other contacts, which matters if there is little damping. Their frequency is 2
 * rate or, without sliding, when they rotate against each other, sqrt(7/2) times that. In the longer steps of dashpots
 * that lag, a row of grains that all turn in the same sense matters too where they hardly slide: sqrt(5) times. */
static double stable_pair(const dynamics *d, double zeta) {
    const bool sticks = d->law.friction > 2, lags = d->lag > 0;
    const double square = sticks && lags ? 1.0 / 5 : sticks || (lags && d->law.friction > 0) ? 2.0 / 7 : 1;
    return (lags ? SINGLE_CONTACT : 1) * (sqrt(zeta * zeta + square) - zeta);
}

/* Length of the next step, from the stiffest grain. A contact that closes during the step counts with the stiffness it
 * would have after a step at the largest speed, and with a looser factor, because it is only one step. A dashpot does
 * not lag in that step. */
static double next_step(const compression *run) {
    const dynamics *d = &run->d;
    const double zeta = lagging(d);
    const double factor = fmin(step_fraction(run) * stable_step(zeta), 0.95 * stable_pair(d, zeta));
    const double past = d->dt;
    const double fast = d->v_max + fabs(d->strain_rate[d->dim - 1]) * 2 * d->r_max; /* of grains that may touch */
    const double a = d->law.exponent;
    double soon = 2.0 * sqrt(run->r_min * 2.0 * fast * past); /* k_n = 2 E* sqrt(R n) at a wall, n = 2 v dt */
    if (a != 1.5)
        soon = 2 * a * contact_strength(d->r_max, d->r_max, a) * contact_power(2 * fast * past, a - 1);
    double rate =
        fmax(d->rate, (d->lag > 0 ? fmax(0.8, d->law.damping) : 0.5) * sqrt(d->law.stiffest * soon / d->m_min));
    double dt = rate > 0 ? factor / rate : INFINITY;
    if (d->piston_k > 0) /* a light piston on many grains */
        dt = fmin(dt, 0.4 * factor * sqrt(d->piston_mass / d->piston_k));
    return fmin(dt, past > 0 ? 1.25 * past : INFINITY);
}

/* Step of the reference code: a small fraction of the period of the lightest grain at the stiffest contact. */
static double plain_step(const compression *run) {
    const dynamics *d = &run->d;
    const double factor = 0.05, past = d->dt, fast = d->v_max + fabs(d->strain_rate[d->dim - 1]) * 2 * d->r_max;
    const double soon = 2.0 * sqrt(d->r_max * 2.0 * fast * past);
    double dt = factor * sqrt(d->m_min / fmax(d->k_max, 0.16 * d->law.stiffest * soon));
    if (d->piston_k > 0)
        dt = fmin(dt, factor * sqrt(d->piston_mass / d->piston_k));
    return fmin(dt, past > 0 ? 1.5 * past : INFINITY);
}

/* ---- rest ---------------------------------------------------------------------------------------------------- */

/* Rate of the global damping, which should damp the slowest waves but not hold them back. Their frequency decreases
 * with the pressure and as one over their length, which is four times the height between bottom and piston, and the
 * period across. At heights up to 30 d the protocol's value is used: at 24 and 25 d it was best. */
static double find_drag(const compression *run) {
    const dynamics *d = &run->d;
    const double longest = fmax(4 * d->piston_y, fmax(d->period[0], d->dim == 3 ? d->period[1] : 0));
    const double p = run->spec->pressure, a = run->spec->law_exponent;
    const double faster =
        a == 1.5 ? cbrt(p / 1e-4) : sqrt(compression_stiffness(p, a) / compression_stiffness(1e-4, 1.5));
    return run->spec->drag * faster * fmin(1, 120 / longest);
}

/* A lag damps fast oscillations less, in which contacts of spheres that slid lose hold of their limit. Where cells are
 * strained until the end that shows: of periodic ones at 1e-4, mu 0.3, 0.141(7) of all contacts were left there with a
 * lag at the end of the motion, 0.173(7) without, and 0.187(6) without any. */
static double lag_of(const sp_pack_spec *s, bool calm) {
    const bool rough = s->dim == 3 && s->friction > 0 && s->protocol != SP_PROTOCOL_AFFINE;
    return s->reference || (calm && rough && s->cell != SP_CELL_PISTON) ? 0 : s->lag;
}

static void start_equilibration(compression *run) {
    run->phase = PHASE_EQUILIBRATION;
    run->ease = 1;
    run->stall_step = run->steps;
    run->stall_residual = INFINITY;
    run->d.law.viscous_limit = 1;
    run->d.law.damping = run->spec->calm_damping;
    run->d.lag = lag_of(run->spec, true);
    run->full_drag = run->d.drag = find_drag(run);
    /* others only where they would stall: it changes how many contacts are about to slide */
    run->d.sparing = run->spec->lag > 0 && run->spec->protocol == SP_PROTOCOL_AFFINE;
}

/* Some grains roll along a mechanism without stiffness, such as a ball between two strong contacts. Their speed is set
 * by the balance of drag and a tiny force, and they would need 1e7 steps to reach the next contact. If the residual has
 * not halved for STALL_STEPS, the drag is reduced for as long, each time further. */
static void ease_drag(compression *run) {
    const int64_t patience = run->d.lag > 0 ? LONG_STALL_STEPS : STALL_STEPS;
    if (run->phase != PHASE_EQUILIBRATION || run->steps - run->stall_step < patience)
        return;
    const bool stalled = run->residual > 0.5 * run->stall_residual, full = run->d.drag == run->full_drag;
    run->d.sparing = run->d.sparing || (run->spec->lag > 0 && stalled);
    if (stalled && full)
        run->ease = fmax(0.3 * run->ease, 1e-3);
    run->d.drag = run->full_drag * (stalled && full ? run->ease : 1);
    run->stall_step = run->steps;
    run->stall_residual = run->residual;
}

static bool at_rest(const compression *run) {
    /* rattlers in free flight have no elastic force, so their speed counts */
    bool still = run->d.drag == 0 || run->d.v_max * run->full_drag < run->spec->tolerance;
    /* the piston weighs as much as hundreds of grains: its acceleration alone would allow a pressure error of 1e-5 */
    bool balanced = run->wall_imbalance < run->spec->tolerance;
    bool settled = run->phase == PHASE_EQUILIBRATION || run->spec->calm == 0;
    /* a slowly changing period has no acceleration either */
    bool still_sides = (run->d.strain_rate[0] == 0 && run->d.strain_rate[1] == 0) || run->d.cell != SP_CELL_PISTON;
    bool driven = sp_compression_driven(run) && still_sides && run->lateral_imbalance < 1e-3 * run->spec->pressure;
    return driven && settled && still && balanced && run->residual < run->spec->tolerance;
}

/* Steps between two progress reports: some tenths of a second, also for many grains. */
static int64_t watch_steps(int32_t grains) {
    const int32_t checks = 60000 / grains;
    return (int64_t)CHECK_STEPS * (checks > 100 ? 100 : checks > 1 ? checks : 1);
}

/* Pressure that the weight of all grains adds at the bottom. */
static double weight_pressure(const compression *run) {
    const dynamics *d = &run->d;
    double mass = 0;
    for (int32_t i = 0; i < d->n && d->gravity != 0; i++)
        mass += 1 / dynamics_grain(d, i)[d->at.inv_m];
    return d->gravity * mass / d->area;
}

/* What is the most likely to have pushed grains through each other. */
static void name_cause(const compression *run, sp_error *err) {
    const sp_pack_spec *s = run->spec;
    const double layer = run->d.area / (s->dim == 2 ? sp_sizes_moment(s, 1) : sp_sizes_moment(s, 2));
    const double weight = weight_pressure(run);
    if (weight > s->pressure)
        sp_fail_key(
            err, SP_EFAILED, "packing.gravity",
            " = %g: the weight of the grains, a pressure of %.3g on the bottom, is too much for them or arrives "
            "too fast, or packing.time_step = %g is too large",
            s->gravity, weight, s->time_step);
    else if (run->d.n < layer)
        sp_fail(err, SP_EFAILED,
                "packing.grains = %d are less than a layer, %.3g, of this box, and each carries more than "
                "packing.pressure = %g",
                run->d.n, layer, s->pressure);
    else if (s->diameter_max > 3 * s->diameter_min)
        sp_fail(err, SP_EFAILED,
                "packing.pressure = %g is too much for grains as small as packing.diameter_min = %g between ones of "
                "packing.diameter_max = %g",
                s->pressure, s->diameter_min, s->diameter_max);
    else
        sp_fail(err, SP_EFAILED,
                "packing.pressure = %g is too much for it or arrives too fast (a larger packing.piston_mass is "
                "slower), or packing.time_step = %g is too large",
                s->pressure, s->time_step);
}

static sp_status fail_insane(const compression *run, sp_error *err) {
    name_cause(run, err);
    return sp_fail_prefix(err, "seed %llu: a grain went through a wall or another grain at step %lld",
                          (unsigned long long)run->spec->seed, (long long)run->steps);
}

/* Isotropic: if too few grains hold the box open, it collapses. */
static sp_status check_periods(const compression *run, sp_error *err) {
    const dynamics *d = &run->d;
    const double narrowest = sp_neighbours_narrowest(d);
    for (int a = 0; a < d->dim && d->cell != SP_CELL_PISTON; a++)
        if (!(dynamics_edge(d, a) > narrowest))
            return sp_fail_key(err, SP_EFAILED, "packing.grains",
                               " = %d: too few for this cell: an edge has become %.3g, must stay above %.3g (two of "
                               "the largest grains and the gaps around them)",
                               d->n, dynamics_edge(d, a), narrowest);
    for (int a = 0; a < d->dim - 1; a++)
        if (!(d->period[a] > narrowest) && run->period_end[a] == 0 && run->lateral_free)
            return sp_fail(
                err, SP_EFAILED,
                "packing.grains = %d: too few for packing.compression = \"isotropic\" in this box: the sides have come "
                "as near as %.3g, must stay above %.3g (two of the largest grains and the gaps around them)",
                d->n, d->period[a], narrowest);
    return SP_OK;
}

/* Shares of the work, estimated from packings of hundreds of grains. */
static const double FLIGHT_PART = 0.1, SETTLED_PART = 0.6;

/* Sets the estimate to the fraction x of the way from one share to another. It never decreases. */
static void estimate_progress(compression *run, double from, double to, double x) {
    const double part = from + (to - from) * fmax(0, fmin(1, x)); /* fmax(0, NAN) is 0 */
    run->fraction = fmax(run->fraction, (run->stage + part) / sp_pack_stages(run->whole));
}

/* Progress from the residual, or during the flight from the piston's height. */
static void estimate_from_residual(compression *run) {
    const double grains =
        run->d.n * (run->d.dim == 2 ? sp_sizes_mean_area(run->whole) : sp_sizes_mean_volume(run->whole));
    if (run->phase == PHASE_FLIGHT && run->d.cell != SP_CELL_PISTON) {
        estimate_progress(run, 0, FLIGHT_PART, sp_squeeze_progress(run));
    } else if (run->phase == PHASE_FLIGHT) {
        const double end = grains / (run->d.area * (run->d.dim == 2 ? 0.8 : 0.6));
        estimate_progress(run, 0, FLIGHT_PART, (run->start_height - run->d.piston_y) / (run->start_height - end));
    }
    if (run->phase != PHASE_EQUILIBRATION)
        return;
    run->first_residual = fmax(run->first_residual, run->residual);
    estimate_progress(run, SETTLED_PART, 1,
                      log(run->first_residual / run->residual) / log(run->first_residual / run->spec->tolerance));
}

static void find_lateral_imbalance(compression *run) {
    run->lateral_imbalance = 0;
    if (run->spec->compression != SP_COMPRESSION_ISOTROPIC)
        return;
    for (int a = 0; a < run->d.dim - 1; a++)
        run->lateral_imbalance =
            fmax(run->lateral_imbalance, fabs(sp_dynamics_lateral_pressure(&run->d, a) - run->spec->pressure));
}

static sp_status report_progress(compression *run, sp_error *err) {
    static const char *const names[] = {"flight", "compaction", "equilibration"};
    if (!run->hooks->watch || run->steps % watch_steps(run->d.n) != 0)
        return SP_OK;
    const sp_pack_progress progress = {.phase = names[run->squeezed ? PHASE_COMPACTION : run->phase],
                                       .steps = run->steps,
                                       .height = run->d.piston_y,
                                       .strain = 1 - run->d.piston_y / run->start_height,
                                       .residual = run->residual,
                                       .fraction = run->fraction};
    if (!run->hooks->watch(&progress, run->hooks->user))
        return sp_fail(err, SP_EINTERRUPTED, "stopped after %lld steps", (long long)run->steps);
    return SP_OK;
}

/* Every CHECK_STEPS: checks the motion, looks for equilibrium and reports progress. */
static sp_status inspect(compression *run, bool *done, sp_error *err) {
    if (!sp_dynamics_sane(&run->d))
        return fail_insane(run, err);
    const bool carried = run->d.cell == SP_CELL_PISTON ? run->d.wall_force[1] > 0.5 * run->d.pressure * run->d.area
                                                       : sp_squeeze_carried(run);
    if (run->phase == PHASE_FLIGHT && !run->squeezed && carried)
        run->phase = PHASE_COMPACTION;
    sp_status status = check_periods(run, err);
    if (status == SP_OK)
        status = sp_squeeze_check(run, err);
    const bool asked = run->hooks->watch && run->steps % watch_steps(run->d.n) == 0;
    const bool may_rest = run->phase == PHASE_EQUILIBRATION || run->spec->calm == 0 || run->steps >= run->max_steps;
    if (status == SP_OK && (may_rest || asked))
        status = sp_dynamics_residual(&run->d, &run->residual, &run->wall_imbalance, err);
    if (status != SP_OK)
        return status;
    find_lateral_imbalance(run);
    if (run->d.cell != SP_CELL_PISTON)
        run->wall_imbalance = sp_squeeze_imbalance(run);
    ease_drag(run);
    estimate_from_residual(run);
    run->rest_checks = at_rest(run) ? run->rest_checks + 1 : 0;
    *done = run->rest_checks >= REST_STEPS / CHECK_STEPS;
    if (!*done && run->steps >= run->max_steps)
        return sp_fail(err, SP_EFAILED,
                       "seed %llu: not at rest after %lld steps: largest acceleration %.3g, %s off "
                       "by %.3g: both must be below packing.tolerance = %.3g before packing.max_steps = %lld",
                       (unsigned long long)run->spec->seed, (long long)run->steps, run->residual,
                       run->d.cell == SP_CELL_PISTON ? "pressure on the piston" : "stress", run->wall_imbalance,
                       run->spec->tolerance, (long long)run->max_steps);
    return report_progress(run, err);
}

/* Saves the state if wanted, and rebuilds the lists in any case (see state.c). */
static sp_status save_state(compression *run, sp_error *err) {
    sp_status status = SP_OK;
    if (run->hooks->save && !run->resumed && run->steps > 0)
        status = sp_state_save(run, err);
    run->d.outer_travel = INFINITY;
    return status;
}

/* Looks for the start of equilibration, at the forces of this step. The acceleration includes viscous forces because
 * during creep these balance the elastic ones. Not while a homogeneous strain compresses the gas: then a few grains may
 * happen to carry the wall. */
static void look_for_equilibration(compression *run) {
    if (run->squeezed)
        return;
    const double acceleration = sp_dynamics_acceleration(&run->d), end = run->spec->calm * run->spec->pressure;
    const bool isotropic = run->spec->compression == SP_COMPRESSION_ISOTROPIC;
    if (run->steps > 0 && acceleration < end && sp_compression_driven(run))
        start_equilibration(run);
    /* not earlier: grains in flight offer no resistance */
    if (isotropic && run->steps > 0 && acceleration < fmax(end, 0.01 * run->spec->pressure) &&
        sp_compression_pressed(run))
        run->lateral_free = 1;
    if (isinf(acceleration) || !(end > 0))
        return;
    run->first_acceleration = fmax(run->first_acceleration, acceleration);
    estimate_progress(run, FLIGHT_PART, SETTLED_PART,
                      log(run->first_acceleration / acceleration) / log(run->first_acceleration / end));
}

static sp_status compress(compression *run, sp_error *err) {
    for (bool done = false;; run->steps++) {
        sp_status status = run->steps % STATE_STEPS == 0 ? save_state(run, err) : SP_OK;
        run->resumed = false;
        if (status == SP_OK)
            status = sp_neighbours_refresh(&run->d, err);
        if (status == SP_OK && run->steps % CHECK_STEPS == 0)
            status = inspect(run, &done, err);
        if (status != SP_OK || done)
            return status;
        sp_dynamics_forces(&run->d, run->past);
        if (run->phase != PHASE_EQUILIBRATION && run->steps % CHECK_STEPS == 0)
            look_for_equilibration(run);
        run->past = run->d.plain ? plain_step(run) : next_step(run);
        sp_compression_drive(run, run->past);
        sp_dynamics_advance(&run->d, run->past);
    }
}

/* ---- stages -------------------------------------------------------------------------------------------------- */

/* Continues from the equilibrium of one stage to the next. */
static void next_stage(compression *run) {
    dynamics *d = &run->d;
    run->stage++;
    sp_compression_set_stage(run);
    run->phase = PHASE_COMPACTION;
    run->rest_checks = 0;
    run->first_acceleration = run->first_residual = run->ramp_time = 0;
    d->drag = 0;
    d->sparing = false;
    run->flow = 0;
    if (run->stage > run->whole->history_count) /* the path decides which sides of the cell move */
        memset(d->strain_rate, 0, sizeof d->strain_rate), memset(d->shear_rate, 0, sizeof d->shear_rate);
    d->law.viscous_limit = run->spec->viscous_limit;
    d->law.damping = run->spec->damping;
    d->lag = lag_of(run->spec, false);
}

static sp_status report_stage(compression *run, sp_error *err) {
    if (!run->hooks->stage)
        return SP_OK;
    sp_packing p = sp_packing_none();
    sp_status status = freeze(run, &p, err);
    if (status == SP_OK)
        status = run->hooks->stage(&p, run->stage, run->hooks->user, err);
    sp_packing_free(&p);
    return status;
}

sp_status sp_piston_make(const sp_pack_spec *spec, const sp_pack_hooks *hooks, sp_packing *out, sp_error *err) {
    compression run = {.whole = spec, .hooks = hooks};
    sp_status status = sp_compression_start(&run, err);
    while (status == SP_OK) {
        status = compress(&run, err);
        if (status != SP_OK || run.stage == sp_pack_stages(spec) - 1)
            break;
        status = report_stage(&run, err);
        next_stage(&run);
        if (status == SP_OK)
            status = save_state(&run, err);
    }
    if (status == SP_OK)
        status = freeze(&run, out, err);
    sp_compression_free(&run);
    return status;
}
