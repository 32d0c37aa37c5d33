/* The preparation of Somfai et al. 2005, section III: a loose gas compressed by a massive rough piston until all motion
 * stops. Where the paper is silent (damping, piston mass, time step) the spec's defaults are those that reproduce its
 * tables. */
#include "base/base.h"
#include "packing/contact.h"
#include "packing/dynamics.h"
#include "packing/making.h"
#include "packing/pairs.h"

#include <math.h>

enum { CHECK_STEPS = 40, REST_STEPS = 200 };

typedef struct piston_run {
    const sp_pack_spec *spec;
    dynamics d;
    double r_max;
    int64_t steps, max_steps;
    int rest_checks; /* checks in a row that found equilibrium */
    bool calm;       /* the final phase: global damping, viscous friction limited */
    double residual, wall_imbalance;
    sp_pack_watch watch;
    void *user;
} piston_run;

/* Explicit steps follow the stiffest contact: dt = time_step sqrt(m_min/k_max). A contact that closes within the step
 * counts as well, with the stiffness it has after a step at the largest speed and a looser factor, as it is one step
 * only. */
static double next_step(const piston_run *run) {
    const dynamics *d = &run->d;
    const double factor = run->spec->time_step, past = d->dt;
    double soon = 2.0 * sqrt(run->r_max * 2.0 * d->v_max * past); /* k_n = 2 E* sqrt(R n) at a wall, n = 2 v dt */
    double k = fmax(d->k_max, 0.16 * soon);                       /* 0.16 = 1/2.5^2: a factor of 2.5 time_step */
    double dt = k > 0 ? factor * sqrt(d->m_min / k) : INFINITY;
    if (d->piston_k > 0) /* a light piston on many grains */
        dt = fmin(dt, factor * sqrt(d->piston_mass / d->piston_k));
    return fmin(dt, past > 0 ? 1.5 * past : INFINITY);
}

/* A stiffness that the packing certainly has at the end, for the first step: one grain that carries p d^2. */
static double first_step(const piston_run *run) {
    double e = contact_stiffness(0.5, 0.5), overlap = contact_overlap(e, run->spec->pressure);
    return run->spec->time_step * sqrt(run->d.m_min / contact_normal_stiffness(e, overlap));
}

/* Gas, compaction and creep of 600 grains take 1e5 steps at 1e-4 and 6.5e5 at 1e-7, with the height (the number of
 * grains across) and the grains' mass ratio: thirty times that means that it never comes to rest. */
static int64_t default_max_steps(const sp_pack_spec *spec, double height) {
    const double diameter = 0.5 * (spec->diameter_min + spec->diameter_max);
    double layers = fmax(1.0, height / (75.0 * diameter)), slowness = pow(spec->pressure / 1e-4, -0.3);
    double roughness = pow(spec->diameter_max / spec->diameter_min, 1.5) * 0.1 / spec->time_step;
    return (int64_t)(4e6 * layers * fmax(1, slowness) * roughness);
}

static void start_calm(piston_run *run) {
    run->calm = true;
    run->d.law.limit_viscous = true;
    run->d.drag = run->spec->drag * cbrt(run->spec->pressure / 1e-4);
}

static bool at_rest(const piston_run *run) {
    /* rattlers in free flight have no elastic force on them: they must have stopped, too */
    bool still = run->d.drag == 0 || run->d.v_max * run->d.drag < run->spec->tolerance;
    /* the piston weighs as much as hundreds of grains: its acceleration alone would leave the pressure wrong by 1e-5 */
    bool balanced = run->wall_imbalance < run->spec->tolerance;
    bool calm = run->calm || run->spec->calm == 0;
    return calm && still && balanced && run->residual < run->spec->tolerance;
}

/* Steps between two calls of the watch: some tenths of a second for many grains, too. */
static int64_t watch_steps(int32_t grains) {
    const int32_t checks = 60000 / grains;
    return (int64_t)CHECK_STEPS * (checks > 100 ? 100 : checks > 1 ? checks : 1);
}

/* Every CHECK_STEPS: sane, calm, at rest? */
static sp_status inspect(piston_run *run, bool *done, sp_error *err) {
    if (!dynamics_sane(&run->d))
        return sp_fail(err, SP_EFAILED,
                       "seed %llu: a grain went through a wall or another grain at step %lld: packing.pressure = %g is "
                       "too much for it or arrives too fast (a larger packing.piston_mass is slower), or "
                       "packing.time_step = %g is too large",
                       (unsigned long long)run->spec->seed, (long long)run->steps, run->spec->pressure,
                       run->spec->time_step);
    /* creep is slow motion in which viscous forces balance the elastic ones: no acceleration, but not yet rest */
    if (!run->calm && run->steps > 0 && dynamics_acceleration(&run->d) < run->spec->calm * run->spec->pressure)
        start_calm(run);
    run->residual = dynamics_residual(&run->d, &run->wall_imbalance);
    run->rest_checks = at_rest(run) ? run->rest_checks + 1 : 0;
    *done = run->rest_checks >= REST_STEPS / CHECK_STEPS;
    if (!*done && run->steps >= run->max_steps)
        return sp_fail(err, SP_EFAILED,
                       "seed %llu: not at rest after %lld steps: largest acceleration %.3g, pressure on the piston off "
                       "by %.3g: both must be below packing.tolerance = %.3g",
                       (unsigned long long)run->spec->seed, (long long)run->steps, run->residual, run->wall_imbalance,
                       run->spec->tolerance);
    if (run->watch && run->steps % watch_steps(run->d.n) == 0) {
        sp_pack_progress progress = {run->calm ? "equilibration" : "compaction", run->steps, run->d.piston_y,
                                     run->residual};
        if (!run->watch(&progress, run->user))
            return sp_fail(err, SP_EINTERRUPTED, "stopped after %lld steps", (long long)run->steps);
    }
    return SP_OK;
}

static sp_status compress(piston_run *run, sp_error *err) {
    double past = 0;
    run->d.dt = first_step(run);
    for (bool done = false;; run->steps++) {
        sp_status status = dynamics_refresh(&run->d, err);
        if (status == SP_OK && run->steps % CHECK_STEPS == 0)
            status = inspect(run, &done, err);
        if (status != SP_OK || done)
            return status;
        dynamics_forces(&run->d, past);
        past = next_step(run);
        dynamics_advance(&run->d, past);
    }
}

/* ---- the packing out of the final state ------------------------------------------------------------------------ */

static void add_pair(const dynamics *d, int32_t k, sp_packing *p, int32_t *count) {
    const pair_list *list = &d->inner;
    const int32_t i = list->i[k], j = list->j[k];
    double dx = p->x[3 * (size_t)j] - p->x[3 * (size_t)i], dy = p->x[3 * (size_t)j + 1] - p->x[3 * (size_t)i + 1];
    dx -= d->width * nearbyint(dx / d->width);
    double r = sqrt(dx * dx + dy * dy), overlap = p->r[i] + p->r[j] - r;
    if (!(overlap > 0))
        return;
    double nx = dx / r, ny = dy / r, t = list->ft[k];
    p->contacts[(*count)++] = (sp_contact){.i = i,
                                           .j = j,
                                           .n = {nx, ny},
                                           .overlap = overlap,
                                           .fn = contact_force(contact_stiffness(p->r[i], p->r[j]), overlap),
                                           .ft = {-t * ny + 0.0, t * nx + 0.0}}; /* no negative zero */
}

static void add_wall(const dynamics *d, int side, int32_t i, sp_packing *p, int32_t *count) {
    const double sign = side == 0 ? -1 : 1, y = p->x[3 * (size_t)i + 1];
    double overlap = p->r[i] - (side == 0 ? y : d->piston_y - y);
    if (!(overlap > 0))
        return;
    p->contacts[(*count)++] = (sp_contact){.i = i,
                                           .j = side == 0 ? SP_BOTTOM : SP_TOP,
                                           .n = {0, sign},
                                           .overlap = overlap,
                                           .fn = contact_force(contact_wall_stiffness(p->r[i], p->wall), overlap),
                                           .ft = {-sign * d->wall_ft[side][i] + 0.0, 0}};
}

static sp_status freeze(const piston_run *run, sp_packing *out, sp_error *err) {
    const dynamics *d = &run->d;
    const sp_pack_spec *spec = run->spec;
    sp_packing p = sp_packing_none();
    sp_status status = sp_packing_alloc(&p, 2, d->n, d->inner.n + d->wall[0].n + d->wall[1].n, err);
    if (status != SP_OK)
        return status;
    p.box[0] = d->width;
    p.box[1] = d->piston_y;
    p.pressure = spec->pressure;
    p.friction = spec->friction;
    p.poisson = spec->poisson;
    p.seed = spec->seed;
    p.steps = run->steps;
    p.residual = run->residual;
    for (int32_t i = 0; i < d->n; i++) {
        double x = d->g[i].x - d->width * floor(d->g[i].x / d->width);
        p.x[3 * (size_t)i] = x < d->width ? x : 0;
        p.x[3 * (size_t)i + 1] = d->g[i].y;
        p.r[i] = d->g[i].r;
    }
    int32_t count = 0;
    for (int32_t k = 0; k < d->inner.n; k++)
        add_pair(d, k, &p, &count);
    for (int side = 0; side < 2; side++)
        for (int32_t k = 0; k < d->wall[side].n; k++)
            add_wall(d, side, d->wall[side].i[k], &p, &count);
    p.n_contacts = count;
    sp_packing_sort(&p);
    *out = p;
    return SP_OK;
}

sp_status sp_piston_make(const sp_pack_spec *spec, sp_pack_watch watch, void *user, sp_packing *out, sp_error *err) {
    piston_run run = {.spec = spec, .watch = watch, .user = user, .r_max = 0.5 * spec->diameter_max};
    double *r = sp_alloc((size_t)spec->grains, sizeof *r), *x = sp_alloc((size_t)spec->grains * 3, sizeof *x);
    double height = 0;
    sp_status status = r && x ? SP_OK : sp_fail_memory(err, (size_t)spec->grains * 32);
    if (status != SP_OK)
        goto out;
    sp_radii_draw(spec, r);
    status = sp_gas_make(spec, r, x, &height, err);
    if (status == SP_OK)
        status = dynamics_make(spec, r, x, height, &run.d, err);
    if (status != SP_OK)
        goto out;
    run.max_steps = spec->max_steps ? spec->max_steps : default_max_steps(spec, height);
    status = compress(&run, err);
    if (status == SP_OK)
        status = freeze(&run, out, err);
out:
    dynamics_free(&run.d);
    sp_free(x);
    sp_free(r);
    return status;
}
