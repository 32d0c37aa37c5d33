/* Motion of grains under a piston: time step, forces on grains, and measures of equilibrium. */
#include "packing/dynamics.h"

#include "base/base.h"
#include "base/clones.h"
#include "base/vector.h"
#include "packing/contact.h"
#include "packing/kernel.h"
#include "packing/plain.h"

#include <math.h>
#include <string.h>

static bool alloc_arrays(dynamics *d) {
    const size_t n = (size_t)d->n;
    d->g = sp_alloc((n + 1) * (size_t)d->at.stride, sizeof *d->g);
    d->listed = sp_alloc(n * (size_t)d->dim, sizeof *d->listed);
    d->rows.slot = sp_alloc(n * SLOTS, sizeof *d->rows.slot);
    d->rows.count = sp_alloc(n, sizeof *d->rows.count);
    d->rows.further = sp_alloc(n, sizeof *d->rows.further);
    d->plain_f = d->plain ? sp_alloc(6 * n, sizeof *d->plain_f) : NULL;
    bool ok = d->g && d->listed && d->rows.slot && d->rows.count && d->rows.further && (d->plain_f || !d->plain);
    for (int side = 0; side < d->walls; side++) {
        d->wall_ft[side] = sp_alloc(n * (size_t)(d->dim - 1), sizeof(double));
        d->wall[side].i = sp_alloc(n, sizeof(int32_t));
        d->wall[side].push = sp_alloc(2 * n, sizeof(double));
        d->wall_past[side] = d->at.past > 0 ? sp_alloc(n * (size_t)d->at.past, sizeof(double)) : NULL;
        d->wall_u[side] = sp_alloc(n * (size_t)d->dim, sizeof(double));
        ok = ok && d->wall_ft[side] && d->wall_u[side] && d->wall[side].i && d->wall[side].push &&
             (d->wall_past[side] || !d->at.past);
    }
    return ok;
}

static double power_of_two(double x) {
    int exponent;
    const double part = frexp(x, &exponent); /* 0.5 .. 1 */
    return ldexp(1, part < 0.70710678118654752440 ? exponent - 1 : exponent);
}

static contact_law law_of(const sp_pack_spec *spec) {
    contact_law law = {.exponent = spec->law_exponent,
                       .friction = spec->friction,
                       .damping = spec->damping,
                       .viscous_limit = spec->viscous_limit,
                       .spin = 1 / sp_types_inertia(spec),
                       .mixed = sp_types_mixed(spec)};
    const sp_types_range all = sp_types_limits(spec);
    law.stiffest = all.stiffest;
    law.softest = all.softest;
    for (int s = 0; s < sp_types_count(spec); s++) {
        law.wall[s] = sp_types_rule(spec, s, -1);
        for (int t = 0; t < sp_types_count(spec); t++)
            law.pair[s][t] = sp_types_rule(spec, s, t);
    }
    law.eta = law.pair[0][0].eta;
    law.sqrt_eta = law.pair[0][0].sqrt_eta;
    return law;
}

void sp_dynamics_set_types(dynamics *d, const sp_pack_spec *spec, const int32_t *type) {
    d->m_min = INFINITY;
    for (int32_t i = 0; i < d->n; i++) {
        double *g = dynamics_grain(d, i);
        if (type)
            g[d->at.type] = type[i];
        const double m = sp_types_mass(spec, (int)g[d->at.type], g[d->at.r]);
        g[d->at.inv_m] = 1.0 / m;
        d->m_min = fmin(d->m_min, m);
    }
}

sp_status sp_dynamics_make(const sp_pack_spec *spec, const double *r, const double *x, double height, dynamics *out,
                           sp_error *err) {
    const double depth = spec->dim == 3 ? (spec->depth > 0 ? spec->depth : spec->width) : 1;
    double sum = 0;
    dynamics d = {.dim = spec->dim,
                  .at = grain_layout_of(spec->dim),
                  .n = spec->grains,
                  .cell = spec->cell,
                  .affine = spec->cell != SP_CELL_PISTON,
                  .walls = spec->cell == SP_CELL_PERIODIC ? 0
                           : spec->cell == SP_CELL_BOX    ? 2 * spec->dim
                                                          : 2,
                  .period = {spec->width, depth},
                  .gravity = spec->gravity,
                  .area = spec->width * depth,
                  .pressure = spec->pressure,
                  .plain = spec->reference,
                  .lag = spec->reference ? 0 : spec->lag,
                  .piston_y = height,
                  .piston_mass = spec->cell == SP_CELL_PISTON ? spec->piston_mass * spec->width * depth : INFINITY,
                  .outer_travel = INFINITY};
    d.law = law_of(spec);
    if (d.dim == 3 && !(d.law.friction > 0))
        d.at.row = d.at.turn; /* smooth grains have no torques */
    if (spec->tangential == SP_TANGENTIAL_HISTORY && d.law.friction > 0)
        d.at.past = MINDLIN_NUMBERS;
    d.rows.both = d.dim == 2 && d.n <= BOTH_MOST;
    d.at.averaged = d.lag > 0 ? d.dim : 0;
    if (!alloc_arrays(&d)) {
        sp_dynamics_free(&d);
        return sp_fail_memory(err, (size_t)d.n * (size_t)(8 * d.at.stride + 100));
    }
    for (int32_t i = 0; i < d.n; i++) {
        double *g = dynamics_grain(&d, i);
        memcpy(g, x + 3 * (size_t)i, (size_t)d.dim * sizeof *g);
        g[d.at.r] = r[i];
        if (d.dim == 3)
            g[d.at.inv_m + 1] = 1.0 / r[i];
        d.r_max = fmax(d.r_max, r[i]);
        sum += r[i];
    }
    sp_dynamics_set_types(&d, spec, NULL);
    d.scale = power_of_two(2 * sum / d.n);
    sp_status status = sp_cells_make(d.dim, d.n, d.r_max, &d.cells, err);
    for (int a = 0; a < d.dim && d.cell != SP_CELL_PISTON; a++)
        d.cells.periodic[a] = d.cell == SP_CELL_PERIODIC;
    if (status == SP_OK)
        *out = d;
    else
        sp_dynamics_free(&d);
    return status;
}

void sp_dynamics_free(dynamics *d) {
    sp_pair_list_free(&d->outer);
    sp_pair_list_free(&d->inner);
    sp_pair_list_free(&d->spare);
    for (int side = 0; side < MOST_WALLS; side++) {
        sp_free(d->wall_ft[side]);
        sp_free(d->wall_u[side]);
        sp_free(d->wall_past[side]);
        sp_free(d->wall[side].i);
        sp_free(d->wall[side].push);
    }
    sp_free(d->rows.row);
    sp_free(d->rows.slot);
    sp_free(d->rows.count);
    sp_free(d->rows.further);
    sp_free(d->rows.chain);
    sp_cells_free(&d->cells);
    sp_free(d->plain_f);
    sp_free(d->listed);
    sp_free(d->g);
    sp_pool_free(d->pool);
    *d = (dynamics){0};
}

/* ---- one step ------------------------------------------------------------------------------------------------ */

/* Velocity of the grain's surface along a wall, reversed: slip of the wall on the grain, -v - W x n, W = R omega. */
static void slip_at_wall(const dynamics *d, const wall_frame *f, const double *g, double slip[2]) {
    const double *v = g + d->at.v, *w = g + d->at.w;
    if (d->dim == 2) {
        slip[0] = -v[f->along[0]] + (f->axis == 1 ? f->sign : -f->sign) * w[0];
        slip[1] = 0;
    } else {
        slip[0] = -v[f->along[0]] - f->sign * w[f->along[1]];
        slip[1] = -v[f->along[1]] + f->sign * w[f->along[0]];
    }
}

/* n x f_t, into the row of a grain at a wall. */
static void turn_at_wall(const dynamics *d, const wall_frame *f, double *row) {
    double *turn = row + d->at.turn;
    if (d->dim == 2) {
        turn[0] = (f->axis == 1 ? -f->sign : f->sign) * row[f->along[0]];
    } else {
        turn[f->along[0]] = -f->sign * row[f->along[1]];
        turn[f->along[1]] = f->sign * row[f->along[0]];
    }
}

/* Averages the relative velocity at a wall, along it and across; closed: whether it touches the grain. */
static void average_at_wall(const dynamics *d, bool closed, double *u, double slip[2], double *apart) {
    double now[3] = {slip[0], slip[1], *apart};
    for (int a = 0; a < 3; a++) {
        double *past = u + (a < d->dim - 1 ? a : d->dim - 1);
        if (a < d->dim - 1 || a == 2)
            *past = now[a] = closed ? now[a] + d->lag * (*past - now[a]) : now[a];
    }
    slip[0] = now[0];
    slip[1] = now[1];
    *apart = now[2];
}

/* A wall is a non-rotating grain of infinite radius with E12 = E*. Returns the rate of the contact, times
 * SINGLE_CONTACT. */
static double wall_pair(const dynamics *d, int side, int32_t k, double dt) {
    const int32_t i = d->wall[side].i[k];
    double *row = d->rows.row + (int64_t)d->at.row * (d->rows.wall[side] + k), *push = d->wall[side].push + 2 * k;
    const contact_law *law = &d->law;
    const contact_rule *rule = dynamics_wall_rule(d, i);
    const int up = d->dim - 1; /* number of directions along the wall */
    const wall_frame frame = dynamics_wall(d, side);
    const double sign = frame.sign, *g = dynamics_grain(d, i), distance = dynamics_wall_distance(d, side, g);
    const double overlap = g[d->at.r] - distance;
    double *ft = d->wall_ft[side] + (int64_t)up * i, t[2] = {0, 0}, slip[2], old = 0, new = 0, size = 0;
    double *past = d->at.past > 0 ? d->wall_past[side] + (int64_t)d->at.past * i : ft;
    double apart = (side == 1 ? d->piston_v : 0) - g[d->at.v + frame.axis]; /* the wall moves with the cell too */
    apart = sign * apart + d->strain_rate[frame.axis] * distance;
    slip_at_wall(d, &frame, g, slip);
    double slow[2] = {slip[0], slip[1]};
    average_at_wall(d, overlap > 0, d->wall_u[side] + (int64_t)d->dim * i, slow, &apart);
    memset(row, 0, (size_t)d->at.row * sizeof *row);
    push[0] = push[1] = 0;
    if (!(overlap > 0)) {
        memset(ft, 0, (size_t)up * sizeof *ft);
        memset(past, 0, (size_t)d->at.past * sizeof(double));
        return 0;
    }
    const double kn = rule->stiffness * contact_normal_stiffness(sqrt(g[d->at.r]), overlap);
    const double elastic = 2.0 / 3.0 * kn * overlap, cap = rule->friction * elastic;
    const double s = sqrt(kn / g[d->at.inv_m]), viscous = 2.0 * law->damping * s;
    const double normal = fmax(0, elastic - viscous * apart);
    const double twist = up == 2 ? 0.5 * dt * sign * g[d->at.w + frame.axis] * g[d->at.inv_m + 1] : 0;
    for (int a = 0; a < up; a++) {
        t[a] = ft[a] + (up == 2 ? sign * twist * (a == 0 ? -ft[1] : ft[0]) : 0);
        old += ft[a] * ft[a];
        new += t[a] * t[a];
    }
    for (int a = 0; a < up; a++) {
        t[a] = (up == 2 && new > 0 ? sqrt(old / new) : 1) * t[a] + rule->eta * dt * kn * slip[a];
        if (d->at.past > 0)
            t[a] = sp_mindlin_slip(past, 1, ft[a], cap, rule->eta * kn, slip[a] * dt);
        size += t[a] * t[a];
    }
    size = sqrt(size);
    for (int a = 0; a < up; a++) {
        ft[a] = size > cap ? t[a] * (cap / size) : t[a];
        t[a] = ft[a] + viscous * rule->sqrt_eta * slow[a];
    }
    size = sqrt(t[0] * t[0] + t[1] * t[1]);
    const double limit = rule->friction * law->viscous_limit * normal;
    for (int a = 0; a < up; a++)
        row[frame.along[a]] = size > limit ? t[a] * (limit / size) : t[a];
    row[frame.axis] = -sign * normal;
    if (d->at.turn < d->at.row)
        turn_at_wall(d, &frame, row);
    row[3] = s;
    push[0] = normal;
    push[1] = kn;
    return g[d->at.inv_m] * (SINGLE_CONTACT * s);
}

typedef struct step_work {
    dynamics *d;
    double dt;
    kernel_maxima seen[SP_POOL_MOST];
    double single[SP_POOL_MOST]; /* of each part */
} step_work;

static void forces_part(void *data, int part, int parts) {
    step_work *work = data;
    const dynamics *d = work->d;
    double single = 0;
    for (int side = 0; side < d->walls; side++)
        for (int32_t k = sp_pool_share(d->wall[side].n, part, parts);
             k < sp_pool_share(d->wall[side].n, part + 1, parts); k++)
            single = fmax(single, wall_pair(d, side, k, work->dt));
    const int64_t blocks = (d->inner.padded + BLOCK - 1) / BLOCK;
    for (int64_t b = blocks * part / parts; b < blocks * (part + 1) / parts; b++) {
        const int32_t first = (int32_t)(b * BLOCK), left = d->inner.padded - first;
        const int32_t count = left < BLOCK ? left : BLOCK;
        single = fmax(single, d->at.past > 0 ? sp_history_pairs(d, work->dt, first, count)
                              : d->dim == 2  ? sp_kernel_pairs_2d(d, work->dt, first, count)
                                             : sp_kernel_pairs_3d(d, work->dt, first, count));
    }
    work->single[part] = single;
}

/* Adds what the grains push on the walls, always in the same order. */
static void add_pushes(dynamics *d) {
    memset(d->wall_force, 0, sizeof d->wall_force);
    d->piston_k = 0;
    for (int side = 0; side < d->walls; side++)
        for (int32_t k = 0; k < d->wall[side].n; k++) {
            d->wall_force[side] += d->wall[side].push[2 * k];
            d->piston_k += side == 1 ? d->wall[side].push[2 * k + 1] : 0;
        }
}

void sp_dynamics_forces(dynamics *d, double dt_past) {
    step_work work = {.d = d, .dt = dt_past};
    if (d->plain) {
        sp_plain_forces(d, dt_past);
        return;
    }
    sp_pool_run(d->pool, forces_part, &work);
    d->single = 0;
    for (int part = 0; part < sp_pool_parts(d->pool); part++)
        d->single = fmax(d->single, work.single[part]);
    add_pushes(d);
}

static void move_part(void *data, int part, int parts) {
    step_work *work = data;
    const dynamics *d = work->d;
    const int32_t first = (int32_t)((int64_t)d->n * part / parts), last = (int32_t)((int64_t)d->n * (part + 1) / parts);
    work->seen[part] = (d->dim == 2 ? sp_kernel_move_2d : sp_kernel_move_3d)(d, work->dt, first, last);
}

static void move_grains(dynamics *d, double dt) {
    step_work work = {.d = d, .dt = dt};
    kernel_maxima all = {0, 0};
    sp_pool_run(d->pool, move_part, &work);
    for (int part = 0; part < sp_pool_parts(d->pool); part++) {
        all.v2 = work.seen[part].v2 > all.v2 ? work.seen[part].v2 : all.v2;
        all.rate = work.seen[part].rate > all.rate ? work.seen[part].rate : all.rate;
    }
    d->v_max = sqrt(all.v2);
    d->rate = d->lag > 0 ? fmax(all.rate, d->single) : all.rate;
}

void sp_dynamics_advance(dynamics *d, double dt) {
    if (d->plain)
        sp_plain_advance(d, dt);
    else
        move_grains(d, dt);
    const double keep = 1.0 - d->drag * dt;
    if (d->strain_rate[d->dim - 1] == 0) /* else the piston follows the strain */
        d->piston_v = keep * d->piston_v + dt * (d->wall_force[1] - d->pressure * d->area) / d->piston_mass;
    d->piston_y += dt * d->piston_v;
    d->v_max = fmax(d->v_max, fabs(d->piston_v));
    const double strain = sp_deform_cell(d, dt);
    if (d->affine) /* the next step must not carry grains into each other either */
        d->v_max = fmax(d->v_max, strain);
    d->inner_travel += (2 * d->v_max + strain) * dt;
    d->outer_travel += (2 * d->v_max + strain) * dt;
    d->outer_strain += strain * dt;
    d->dt = dt;
}

/* ---- what acts on a grain ------------------------------------------------------------------------------------ */

/* slot: as in force_rows */
static void add_row(const dynamics *d, int64_t slot, double force[3], double turn[3]) {
    const double *row = d->rows.row + (slot & ~(int64_t)1), sign = slot & 1 ? -1 : 1;
    for (int a = 0; a < d->dim; a++)
        force[a] += sign * row[a];
    for (int a = 0; a < (d->dim == 3 ? 3 : 1) && d->at.turn < d->at.row; a++)
        turn[a] += row[d->at.turn + a];
}

void sp_dynamics_force_on(const dynamics *d, int32_t i, double force[3], double turn[3]) {
    memset(force, 0, 3 * sizeof *force);
    memset(turn, 0, 3 * sizeof *turn);
    if (d->plain) {
        const double *f = d->plain_f + 6 * (int64_t)i;
        memcpy(force, f, 3 * sizeof *f);
        memcpy(turn, d->dim == 3 ? f + 3 : f + 5, (d->dim == 3 ? 3 : 1) * sizeof *f);
        return;
    }
    const force_rows *rows = &d->rows;
    for (int s = 0; s < SLOTS && s < rows->count[i]; s++)
        add_row(d, rows->slot[SLOTS * (int64_t)i + s], force, turn);
    for (int32_t c = rows->further[i]; c >= 0; c = rows->chain[c])
        add_row(d, (int64_t)d->at.row * (c >> 1) + (c & 1), force, turn);
}

static double acceleration(const dynamics *d, int32_t i, const double force[3], const double turn[3]) {
    double net[3] = {force[0], force[1], force[2]};
    const double inv_m = dynamics_grain(d, i)[d->at.inv_m];
    if (d->gravity != 0)
        net[d->dim - 1] -= d->gravity / inv_m;
    return inv_m * fmax(length3(net), d->law.spin * length3(turn));
}

/* Whether the grains carry about the load. A heavy piston in free fall has a small acceleration but is not supported.
 */
static bool supported(const dynamics *d) {
    double stress[6], load = d->pressure * d->area, force = d->wall_force[1];
    if (d->cell != SP_CELL_PISTON) {
        sp_dynamics_stress(d, stress);
        force = (stress[0] + stress[1] + stress[2]) / d->dim;
        load = d->pressure;
    }
    return !(fabs(force - load) > 0.5 * load);
}

/* What threads measure, each on its part. */
typedef struct measure {
    const dynamics *d;
    double *f;                  /* [n][6] force and torque/R */
    double worst[SP_POOL_MOST]; /* largest acceleration of each part; or 1: something is wrong */
} measure;

static double largest(const measure *work) {
    double worst = 0;
    for (int part = 0; part < sp_pool_parts(work->d->pool); part++)
        worst = fmax(worst, work->worst[part]);
    return worst;
}

static void accelerate_part(void *data, int part, int parts) {
    measure *work = data;
    const dynamics *d = work->d;
    for (int32_t i = sp_pool_share(d->n, part, parts); i < sp_pool_share(d->n, part + 1, parts); i++) {
        double force[3], turn[3];
        sp_dynamics_force_on(d, i, force, turn);
        work->worst[part] = fmax(work->worst[part], acceleration(d, i, force, turn));
    }
}

double sp_dynamics_acceleration(const dynamics *d) {
    if (!supported(d))
        return INFINITY;
    measure work = {.d = d};
    sp_pool_run(d->pool, accelerate_part, &work);
    return fmax(largest(&work), fabs(d->wall_force[1] - d->pressure * d->area) / d->piston_mass);
}

/* ---- how far from rest --------------------------------------------------------------------------------------- */

/* Vector from grain i to grain j of a pair; returns its length. */
static ALWAYS_INLINE double separation(const dynamics *d, const pair_list *p, int32_t k, double x[3]) {
    const double *g = dynamics_grain(d, p->i[k]), *h = dynamics_grain(d, p->j[k]);
    x[2] = 0;
    for (int a = 0; a < d->dim; a++)
        x[a] = h[a] - g[a] + (a < d->dim - 1 ? p->image[k + (int64_t)a * p->capacity] * d->period[a] : 0);
    if (d->affine) {
        const double up = p->image[k + (int64_t)(d->dim - 1) * p->capacity];
        x[d->dim - 1] += up * d->piston_y;
        x[0] += p->image[k + p->capacity] * d->tilt[0] + (d->dim == 3 ? up * d->tilt[1] : 0);
        x[1] += d->dim == 3 ? up * d->tilt[2] : 0;
    }
    return length3(x);
}

double sp_dynamics_normal(const dynamics *d, int32_t i, int32_t j, double overlap) {
    const double a = d->law.exponent, r1 = dynamics_radius(d, i), r2 = dynamics_radius(d, j);
    const double force = a == 1.5 ? contact_force(contact_stiffness(r1, r2), overlap)
                                  : contact_strength(r1, r2, a) * contact_power(overlap, a);
    return dynamics_rule(d, i, j)->stiffness * force;
}

/* Elastic force on i of a pair, and its torque/R. False for an open pair. */
static ALWAYS_INLINE bool elastic_pair(const dynamics *d, const pair_list *p, int32_t k, double force[3],
                                       double turn[3]) {
    double x[3], r = separation(d, p, k, x), overlap = p->reach[k] - r, t[3] = {0, 0, 0};
    if (!(overlap > 0))
        return false;
    const double normal = sp_dynamics_normal(d, p->i[k], p->j[k], overlap);
    const double n[3] = {x[0] / r, x[1] / r, x[2] / r};
    if (d->dim == 2) {
        t[0] = -p->ft[k] * n[1];
        t[1] = p->ft[k] * n[0];
        turn[0] = p->ft[k];
        turn[1] = turn[2] = 0;
    } else {
        for (int a = 0; a < 3; a++)
            t[a] = p->ft[k + (int64_t)a * p->capacity];
        cross3(n, t, turn);
    }
    for (int a = 0; a < 3; a++)
        force[a] = t[a] - normal * n[a];
    return true;
}

/* Elastic force of a wall on grain i, as a row of force_rows. Returns its normal part, 0 for an open contact. */
static double elastic_wall(const dynamics *d, int side, int32_t i, double row[8]) {
    const wall_frame frame = dynamics_wall(d, side);
    const double *g = dynamics_grain(d, i), *t = d->wall_ft[side] + (int64_t)(d->dim - 1) * i;
    const double overlap = g[d->at.r] - dynamics_wall_distance(d, side, g);
    memset(row, 0, 8 * sizeof *row);
    if (!(overlap > 0))
        return 0;
    const double normal = dynamics_wall_rule(d, i)->stiffness * contact_force(sqrt(g[d->at.r]), overlap);
    for (int a = 0; a < d->dim - 1; a++)
        row[frame.along[a]] = t[a];
    row[frame.axis] = -frame.sign * normal;
    turn_at_wall(d, &frame, row);
    return normal;
}

/* Adds the elastic force on i of a pair to f: [n][6] force and torque/R, for its grains among [first, last). */
static void add_elastic_pair(const dynamics *d, const pair_list *p, int32_t k, int32_t first, int32_t last, double *f) {
    double force[3], turn[3];
    const bool i_is_here = p->i[k] >= first && p->i[k] < last, j_is_here = p->j[k] >= first && p->j[k] < last;
    if (!(i_is_here || j_is_here) || !elastic_pair(d, p, k, force, turn))
        return;
    double *on_i = f + 6 * (int64_t)p->i[k], *on_j = f + 6 * (int64_t)p->j[k];
    for (int a = 0; a < 3 && i_is_here; a++) {
        on_i[a] += force[a];
        on_i[3 + a] += turn[a];
    }
    for (int a = 0; a < 3 && j_is_here; a++) {
        on_j[a] -= force[a];
        on_j[3 + a] += turn[a];
    }
}

static void add_elastic_wall(const dynamics *d, int side, int32_t i, double *f) {
    double row[8], *on = f + 6 * (int64_t)i;
    if (!(elastic_wall(d, side, i, row) > 0))
        return;
    for (int a = 0; a < d->dim; a++)
        on[a] += row[a];
    for (int a = 0; a < (d->dim == 3 ? 3 : 1); a++)
        on[3 + a] += row[d->at.turn + a];
}

/* Each thread adds the forces on its grains in the order of the list; pairs at the edge of a part are computed twice.
 */
static void balance_part(void *data, int part, int parts) {
    measure *work = data;
    const dynamics *d = work->d;
    const pair_list *p = dynamics_pairs(d);
    const int32_t first = sp_pool_share(d->n, part, parts), last = sp_pool_share(d->n, part + 1, parts);
    for (int32_t b = 0; SPAN * b < p->n; b++)
        if (parts == 1 || sp_rows_may_touch(p, b, first, last))
            for (int32_t k = SPAN * b; k < p->n && k < SPAN * (b + 1); k++)
                add_elastic_pair(d, p, k, first, last, work->f);
    for (int side = 0; side < d->walls; side++)
        for (int32_t k = 0; k < d->wall[side].n; k++)
            if (d->wall[side].i[k] >= first && d->wall[side].i[k] < last)
                add_elastic_wall(d, side, d->wall[side].i[k], work->f);
    for (int32_t i = first; i < last; i++) {
        const double *f = work->f + 6 * (int64_t)i;
        work->worst[part] = fmax(work->worst[part], acceleration(d, i, f, f + 3));
    }
}

sp_status sp_dynamics_residual(const dynamics *d, double *residual, double *wall_imbalance, sp_error *err) {
    measure work = {.d = d, .f = sp_alloc((size_t)d->n * 6, sizeof *work.f)};
    double top = 0, row[8];
    if (!work.f)
        return sp_fail_memory(err, (size_t)d->n * 6 * sizeof *work.f);
    sp_pool_run(d->pool, balance_part, &work);
    for (int32_t k = 0; d->walls > 1 && k < d->wall[1].n; k++)
        top += elastic_wall(d, 1, d->wall[1].i[k], row);
    sp_free(work.f);
    *wall_imbalance = d->cell == SP_CELL_PISTON ? fabs(top / d->area - d->pressure) : 0;
    *residual = fmax(largest(&work), fabs(top - d->pressure * d->area) / d->piston_mass);
    return SP_OK;
}

/* Adds what the walls contribute to the sum of force times branch vector: force is what acts on the grain. */
static void add_walls_stress(const dynamics *d, double sum[3][3]) {
    double row[8];
    for (int side = 0; side < d->walls; side++) {
        const wall_frame frame = dynamics_wall(d, side);
        for (int32_t k = 0; k < d->wall[side].n; k++) {
            const int32_t i = d->wall[side].i[k];
            const double branch = frame.sign * dynamics_wall_distance(d, side, dynamics_grain(d, i));
            if (elastic_wall(d, side, i, row) > 0)
                for (int a = 0; a < d->dim; a++)
                    sum[a][frame.axis] -= row[a] * branch;
        }
    }
}

void sp_dynamics_stress(const dynamics *d, double stress[6]) {
    const pair_list *p = dynamics_pairs(d);
    const double volume = d->area * d->piston_y;
    double sum[3][3] = {{0}};
    for (int32_t k = 0; k < p->n; k++) {
        double x[3], force[3], turn[3];
        if (!elastic_pair(d, p, k, force, turn))
            continue;
        separation(d, p, k, x);
        for (int a = 0; a < 3; a++)
            for (int b = 0; b < 3; b++)
                sum[a][b] -= force[a] * x[b];
    }
    add_walls_stress(d, sum);
    for (int c = 0; c < 6; c++)
        stress[c] = 0;
    for (int a = 0; a < d->dim; a++)
        stress[a] = sum[a][a] / volume;
    for (int a = 0; a < d->dim; a++) /* yz, xz, xy: the two halves are equal at rest */
        for (int b = a + 1; b < d->dim; b++)
            stress[6 - a - b] = 0.5 * (sum[a][b] + sum[b][a]) / volume;
}

double sp_dynamics_lateral_pressure(const dynamics *d, int a) {
    const pair_list *p = dynamics_pairs(d);
    double sum = 0;
    for (int32_t k = 0; k < p->n; k++) {
        double x[3], force[3], turn[3];
        if (elastic_pair(d, p, k, force, turn)) {
            separation(d, p, k, x);
            sum -= force[a] * x[a];
        }
    }
    return sum / (d->area * d->piston_y);
}

static ALWAYS_INLINE bool grain_is_sane(const dynamics *d, int32_t i) {
    const double *g = dynamics_grain(d, i), r = g[d->at.r];
    if (!(d->piston_y > r))
        return false;
    for (int side = 0; side < d->walls; side++)
        if (!(dynamics_wall_distance(d, side, g) > 0.2 * r))
            return false;
    for (int a = 0; a < d->at.r; a++)
        if (!isfinite(g[a]))
            return false;
    return true;
}

static void check_part(void *data, int part, int parts) {
    measure *work = data;
    const dynamics *d = work->d;
    const pair_list *p = dynamics_pairs(d);
    bool sane = true;
    for (int32_t i = sp_pool_share(d->n, part, parts); i < sp_pool_share(d->n, part + 1, parts); i++)
        sane = sane && grain_is_sane(d, i);
    for (int32_t k = sp_pool_share(p->n, part, parts); k < sp_pool_share(p->n, part + 1, parts) && sane; k++) {
        double x[3], smaller = fmin(dynamics_radius(d, p->i[k]), dynamics_radius(d, p->j[k]));
        sane = !(separation(d, p, k, x) < p->reach[k] - 0.8 * smaller);
    }
    work->worst[part] = !sane;
}

bool sp_dynamics_sane(const dynamics *d) {
    measure work = {.d = d};
    if (!isfinite(d->piston_y) || !isfinite(d->v_max))
        return false;
    sp_pool_run(d->pool, check_part, &work);
    return largest(&work) == 0;
}
