/* The motion while packings form, step by step through the real kernel, from random states of random cells: what
 * mechanics conserves, what it never gives back, and what a change of the frame or a mirror leaves alone. */
#include "properties/changes.h"
#include "properties/scenes.h"
/* after cells.h, whose lattices have a number of cells */
#include "base/base.h"
#include "packing/dynamics.h"
#include "packing/prepare.h"

#include <float.h>

#ifndef SCENES
#define SCENES 40
#endif

/* ---- states ----------------------------------------------------------------------------------------------------- */

static sp_packing crowd(sp_random *draw) {
    sp_packing p = sp_packing_none();
    const int dim = whole(draw, 2, 3);
    int per[3] = {1, 1, 1}, n = 1;
    for (int a = 0; a < dim; a++)
        n *= per[a] = dim == 2 ? whole(draw, 6, 8) : whole(draw, 6, 7);
    assert_ok(sp_packing_alloc(&p, dim, n, 0, &err));
    const double spacing = between(draw, 0.9, 1.1);
    scene_cell(draw, &p, per, spacing);
    scene_place(draw, &p, per, spacing);
    for (int32_t i = 0; i < n; i++)
        p.r[i] = fmin(p.r[i], 0.6);
    return p;
}

static sp_pack_spec spec_of(const sp_packing *p, sp_random *draw) {
    static const double frictions[] = {0, 0.1, 0.5, 1e6}, limits[] = {1, 1e6};
    sp_pack_spec spec = sp_pack_spec_default();
    spec.dim = p->dim;
    spec.cell = p->cell;
    spec.grains = p->n;
    spec.width = p->box[0];
    spec.depth = p->box[1];
    spec.friction = one_of(draw, 4, frictions);
    spec.poisson = between(draw, 0, 0.5);
    spec.viscous_limit = one_of(draw, 2, limits);
    spec.damping = between(draw, 0.01, 1);
    spec.lag = 0; /* dashpots that lag do not take energy from every motion */
    spec.reference = chance(draw, 0.3);
    if (p->dim == 2 && chance(draw, 0.3) && spec.friction > 0)
        spec.tangential = SP_TANGENTIAL_HISTORY;
    return sp_pack_spec_resolve(&spec);
}

static dynamics moving(const sp_pack_spec *spec, const sp_packing *p) {
    dynamics d;
    assert_ok(sp_dynamics_make(spec, p->r, p->x, sp_packing_height(p), &d, &err));
    memcpy(d.tilt, p->tilt, sizeof d.tilt);
    assert_ok(sp_neighbours_refresh(&d, &err));
    return d;
}

static int turns_of(const dynamics *d) { return d->law.friction > 0 ? (d->dim == 3 ? 3 : 1) : 0; }

static void stir(dynamics *d, sp_random *draw, double speed) {
    for (int32_t i = 0; i < d->n; i++) {
        double *g = dynamics_grain(d, i);
        for (int a = 0; a < d->dim; a++)
            g[d->at.v + a] = speed * between(draw, -1, 1);
        for (int a = 0; a < turns_of(d); a++)
            g[d->at.w + a] = speed * between(draw, -1, 1);
    }
}

/* Forces and torques over R, [n][6]. */
static double *forces_of(dynamics *d, double dt) {
    double *f = calloc(6 * (size_t)d->n, sizeof *f);
    assert_ok(sp_neighbours_refresh(d, &err));
    sp_dynamics_forces(d, dt);
    for (int32_t i = 0; i < d->n; i++)
        sp_dynamics_force_on(d, i, f + 6 * (size_t)i, f + 6 * (size_t)i + 3);
    return f;
}

static double largest(int64_t n, const double *f) {
    double most = 0;
    for (int64_t k = 0; k < n; k++)
        most = fmax(most, fabs(f[k]));
    return most;
}

/* A force is a sum over some contacts, whose overlaps are known to a rounding of the box. */
static double rounding(const dynamics *d, double largest_force) {
    return 32 * DBL_EPSILON * (largest_force + dynamics_edge(d, 0));
}

/* ---- single states ---------------------------------------------------------------------------------------------- */

/* Without walls the forces sum to 0; with walls to what these give, and friction along them. */
static void check_momentum(claims *c, const dynamics *d, const double *f) {
    for (int a = 0; a < d->dim && d->cell == SP_CELL_PERIODIC; a++) {
        double sum = 0, size = 0;
        for (int32_t i = 0; i < d->n; i++) {
            sum += f[6 * i + a];
            size += fabs(f[6 * i + a]);
        }
        claims_check(c, "forces sum to 0", fabs(sum), DBL_EPSILON * (double)d->n * size);
    }
    for (int a = 0; a < d->dim && d->cell != SP_CELL_PERIODIC && d->law.friction == 0; a++) {
        double sum = 0, size = 0;
        for (int32_t i = 0; i < d->n; i++) {
            sum += f[6 * i + a];
            size += fabs(f[6 * i + a]);
        }
        for (int side = 0; side < d->walls; side++)
            if (dynamics_wall(d, side).axis == a)
                sum += dynamics_wall(d, side).sign * d->wall_force[side];
        claims_check(c, "walls take what is left", fabs(sum), DBL_EPSILON * (double)d->n * size);
    }
}

static void compare(claims *c, const char *name, const dynamics *d, const double *f, const double *g,
                    const double sign[6]) {
    double off = 0;
    for (int64_t k = 0; k < 6 * (int64_t)d->n; k++)
        off = fmax(off, fabs(f[k] - sign[k % 6] * g[k]));
    claims_check(c, name, off, rounding(d, largest(6 * (int64_t)d->n, f)));
}

/* Every grain and wall faster by the same. */
static void check_galilei(claims *c, const sp_pack_spec *spec, const sp_packing *p, const sp_random *draw) {
    static const double same[6] = {1, 1, 1, 1, 1, 1};
    sp_random one = *draw, two = *draw;
    dynamics d = moving(spec, p), e = moving(spec, p);
    stir(&d, &one, 1e-2);
    stir(&e, &two, 1e-2);
    for (int32_t i = 0; i < d.n; i++)
        for (int a = 0; a < d.dim; a++)
            dynamics_grain(&e, i)[e.at.v + a] += 0.3 * (a + 1);
    RELEASED double *f = forces_of(&d, 0.4), *g = forces_of(&e, 0.4);
    if (d.cell == SP_CELL_PERIODIC)
        compare(c, "another frame", &d, f, g, same);
    check_momentum(c, &d, f);
    sp_dynamics_free(&e);
    sp_dynamics_free(&d);
}

/* In a mirror forces are vectors, and torques turn the other way, but for the axis of the mirror. */
static void check_mirror(claims *c, const sp_pack_spec *spec, const sp_packing *p, int axis, const sp_random *draw) {
    sp_random one = *draw, two = *draw;
    FREED(sp_packing) q = mirrored(p, axis);
    dynamics d = moving(spec, p), e = moving(spec, &q);
    double sign[6] = {1, 1, 1, 1, 1, 1};
    sign[axis] = -1;
    for (int a = 0; a < 3; a++)
        sign[3 + a] = d.dim == 2 || a != axis ? -1 : 1;
    stir(&d, &one, 1e-2);
    stir(&e, &two, 1e-2);
    for (int32_t i = 0; i < d.n; i++) {
        double *g = dynamics_grain(&e, i);
        g[e.at.v + axis] *= -1;
        for (int a = 0; a < turns_of(&e); a++)
            g[e.at.w + a] *= sign[3 + a];
    }
    for (int step = 0; step < 3; step++) {
        RELEASED double *f = forces_of(&d, 0.4), *g = forces_of(&e, 0.4);
        compare(c, "a mirror", &d, f, g, sign);
        if (d.cell == SP_CELL_PISTON)
            break; /* the other wall moves */
        sp_dynamics_advance(&d, 0.05);
        sp_dynamics_advance(&e, 0.05);
    }
    sp_dynamics_free(&e);
    sp_dynamics_free(&d);
}

/* Both codes for the same state, over some steps. */
static void check_codes(claims *c, const sp_pack_spec *spec, const sp_packing *p, const sp_random *draw) {
    static const double same[6] = {1, 1, 1, 1, 1, 1};
    sp_random one = *draw, two = *draw;
    sp_pack_spec other = *spec;
    other.reference = !spec->reference;
    dynamics d = moving(spec, p), e = moving(&other, p);
    stir(&d, &one, 1e-2);
    stir(&e, &two, 1e-2);
    for (int step = 0; step < 3; step++) {
        RELEASED double *f = forces_of(&d, step ? 0.1 : 0), *g = forces_of(&e, step ? 0.1 : 0);
        compare(c, "two codes", &d, f, g, same);
        sp_dynamics_advance(&d, 0.1);
        sp_dynamics_advance(&e, 0.1);
    }
    sp_dynamics_free(&e);
    sp_dynamics_free(&d);
}

/* Dashpots take energy from every motion, whatever limits them: the power of the forces beyond those at rest. */
static void check_power(claims *c, const sp_pack_spec *spec, const sp_packing *p, sp_random *draw) {
    dynamics d = moving(spec, p);
    double *rest = forces_of(&d, 0), power = 0, size = 0;
    stir(&d, draw, pow(10, between(draw, -5, 0)));
    RELEASED double *f = forces_of(&d, 0);
    for (int32_t i = 0; i < d.n; i++) {
        const double *g = dynamics_grain(&d, i);
        for (int a = 0; a < d.dim; a++) {
            power += (f[6 * i + a] - rest[6 * i + a]) * g[d.at.v + a];
            size += (fabs(f[6 * i + a]) + fabs(rest[6 * i + a])) * fabs(g[d.at.v + a]);
        }
        for (int a = 0; a < turns_of(&d); a++) {
            power += (f[6 * i + 3 + a] - rest[6 * i + 3 + a]) * g[d.at.w + a];
            size += (fabs(f[6 * i + 3 + a]) + fabs(rest[6 * i + 3 + a])) * fabs(g[d.at.w + a]);
        }
    }
    claims_check(c, "dashpots take energy", power, 1000 * DBL_EPSILON * size);
    free(rest);
    sp_dynamics_free(&d);
}

/* ---- motion ----------------------------------------------------------------------------------------------------- */

static double kinetic(const dynamics *d, const double *f, double dt) {
    double sum = 0;
    for (int32_t i = 0; i < d->n; i++) {
        const double *g = dynamics_grain(d, i);
        for (int a = 0; a < d->dim; a++) { /* velocities of the middle of the step */
            const double v = g[d->at.v + a] + 0.5 * dt * f[6 * i + a] * g[d->at.inv_m];
            sum += 0.5 * v * v / g[d->at.inv_m];
        }
    }
    return sum;
}

/* Energy of Hertz's contacts, all images of few grains by the packing's geometry. */
static double elastic(const dynamics *d) {
    sp_packing p = sp_dynamics_cell(d);
    double sum = 0;
    for (int32_t i = 0; i < d->n; i++) {
        const double *g = dynamics_grain(d, i), r = g[d->at.r];
        for (int32_t j = i + 1; j < d->n; j++) {
            const double *h = dynamics_grain(d, j);
            double x[3] = {h[0] - g[0], h[1] - g[1], d->dim == 3 ? h[2] - g[2] : 0};
            sp_packing_nearest(&p, x);
            const double overlap = r + h[d->at.r] - sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
            if (overlap > 0)
                sum += 0.4 * contact_force(contact_stiffness(r, h[d->at.r]), overlap) * overlap;
        }
        for (int side = 0; side < d->walls; side++) {
            const double overlap = r - dynamics_wall_distance(d, side, g);
            if (overlap > 0)
                sum += 0.4 * contact_force(sqrt(r), overlap) * overlap;
        }
    }
    return sum;
}

/* Largest change of the energy on the way, of a motion without friction and dashpots; runs back at the end, and gives
 * how far from the start that leads. */
static double there_and_back(const sp_pack_spec *spec, const sp_packing *p, const sp_random *draw, double dt, int steps,
                             double *off) {
    sp_random own = *draw;
    dynamics d = moving(spec, p);
    double first = 0, worst = 0, *f = NULL;
    d.law.damping = 0;
    stir(&d, &own, 1e-3);
    for (int step = 0; step <= steps; step++) {
        free(f);
        f = forces_of(&d, dt);
        const double energy = kinetic(&d, f, step ? dt : 0) + elastic(&d);
        first = step ? first : energy;
        worst = fmax(worst, fabs(energy - first) / first);
        if (step == 0) /* the first velocities are those of the start: half a step */
            for (int32_t i = 0; i < d.n; i++)
                for (int a = 0; a < d.dim; a++)
                    dynamics_grain(&d, i)[d.at.v + a] -= 0.5 * dt * f[6 * i + a] * dynamics_grain(&d, i)[d.at.inv_m];
        if (step < steps)
            sp_dynamics_advance(&d, dt);
    }
    for (int32_t i = 0; i < d.n; i++)
        for (int a = 0; a < d.dim; a++) {
            double *v = dynamics_grain(&d, i) + d.at.v + a;
            *v = -(*v + dt * f[6 * i + a] * dynamics_grain(&d, i)[d.at.inv_m]);
        }
    free(f);
    for (int step = 0; step < steps; step++) {
        free(forces_of(&d, dt));
        sp_dynamics_advance(&d, dt);
    }
    const sp_packing cell = sp_dynamics_cell(&d);
    *off = 0;
    for (int32_t i = 0; i < d.n; i++) {
        double x[3] = {0};
        for (int a = 0; a < d.dim; a++)
            x[a] = dynamics_grain(&d, i)[a] - p->x[3 * i + a];
        sp_packing_nearest(&cell, x);
        *off = fmax(*off, largest(3, x));
    }
    sp_dynamics_free(&d);
    return worst;
}

/* Energy is kept to second order in the step; the way back leads to the start. */
static void check_energy(claims *c, const sp_pack_spec *given, const sp_packing *p, const sp_random *draw) {
    sp_pack_spec spec = *given;
    double off[2];
    if (p->cell == SP_CELL_PISTON)
        return; /* the piston does work */
    spec.friction = 0;
    spec.tangential = SP_TANGENTIAL_CONSTANT;
    const double coarse = there_and_back(&spec, p, draw, 0.04, 20, &off[0]),
                 fine = there_and_back(&spec, p, draw, 0.02, 40, &off[1]);
    claims_check(c, "energy to second order", fine, 0.35 * coarse + 1e-12);
    claims_check(c, "energy", fine, 1e-3);
    for (int k = 0; k < 2; k++) /* each step adds a rounding to each place */
        claims_check(c, "the way back", off[k], 4 * DBL_EPSILON * p->box[0] * 40);
}

/* ---- scenes ----------------------------------------------------------------------------------------------------- */

static void run(claims *c, sp_random *draw) {
    FREED(sp_packing) p = crowd(draw);
    const sp_pack_spec spec = spec_of(&p, draw);
    char words[120];
    snprintf(words, sizeof words, "%dD, cell %d, %d grains, friction %g, reference %d, history %d", p.dim, (int)p.cell,
             p.n, spec.friction, spec.reference, spec.tangential == SP_TANGENTIAL_HISTORY);
    c->words = words;
    check_galilei(c, &spec, &p, draw);
    for (int axis = 0; axis < p.dim; axis++)
        check_mirror(c, &spec, &p, axis, draw);
    check_codes(c, &spec, &p, draw);
    check_energy(c, &spec, &p, draw);
    check_power(c, &spec, &p, draw);
}

TEST(test_motion) {
    claims c = {0};
    claims_scenes(&c, SCENES, run);
    claims_close(&c);
}

RUN_TESTS(NULL, NULL)
