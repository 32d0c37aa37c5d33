/* The motion of grains in cells that are periodic along all axes, tilted too, or have walls on all sides: forces
 * against brute force over all images, and the stress against the derivative of the elastic energy. What mechanics
 * conserves, and the kernel against the plain path, are in tests/properties. */
#include "test.h"

#include "base/base.h"
#include "base/pool.h"
#include "packing/contact.h"
#include "packing/dynamics.h"
#include "packing/geometry.h"
#include "packing/prepare.h"

typedef struct scene {
    int dim;
    sp_cell cell;
    double edge[3], tilt[3];
    double friction;
} scene;

enum { PER_EDGE = 6 };

static const scene scenes[] = {
    {2, SP_CELL_PERIODIC, {6, 5.8, 1}, {0, 0, 0}, 0.5},
    {2, SP_CELL_PERIODIC, {6, 5.8, 1}, {2.7, 0, 0}, 0.5},
    {2, SP_CELL_BOX, {6, 5.8, 1}, {0, 0, 0}, 0.5},
    {3, SP_CELL_PERIODIC, {6, 5.8, 6.1}, {0, 0, 0}, 0.5},
    {3, SP_CELL_PERIODIC, {6, 5.8, 6.1}, {-2.2, 2.9, 1.7}, 0.5},
    {3, SP_CELL_BOX, {6, 5.8, 6.1}, {0, 0, 0}, 0.5},
};
enum { SCENES = sizeof scenes / sizeof *scenes };

/* In (-1, 1), different for each k. */
static double noise(int32_t k) { return sin(12.9898 * k + 0.7 * sin(78.233 * k)); }

/* Grains near the points of a grid, dense enough that each touches several. `shift` moves all of them. */
static dynamics make(const scene *s, bool plain, const double shift[3]) {
    const int32_t n = s->dim == 2 ? PER_EDGE * PER_EDGE : PER_EDGE * PER_EDGE * PER_EDGE;
    sp_pack_spec spec = sp_pack_spec_default();
    spec.dim = s->dim;
    spec.cell = s->cell;
    spec.grains = n;
    spec.width = s->edge[0];
    spec.depth = s->edge[1];
    spec.friction = s->friction;
    spec.reference = plain;
    spec.lag = 0; /* the reference has none; test_lag.c */
    spec = sp_pack_spec_resolve(&spec);
    sp_packing cell = {.dim = s->dim, .cell = s->cell, .n = n};
    memcpy(cell.box, s->edge, sizeof cell.box);
    memcpy(cell.tilt, s->tilt, sizeof cell.tilt);
    double *r = sp_alloc((size_t)n, 8), *x = sp_alloc(3 * (size_t)n, 8);
    for (int32_t i = 0; i < n; i++) {
        double f[3], *at = x + 3 * (size_t)i;
        r[i] = 0.53 + 0.04 * noise(i);
        for (int a = 0, m = i; a < 3; a++, m /= PER_EDGE)
            f[a] = a < s->dim ? (m % PER_EDGE + 0.5 + 0.15 * noise(3 * i + a + 1000)) / PER_EDGE : 0;
        at[0] = f[0] * s->edge[0] + f[1] * s->tilt[0] + f[2] * s->tilt[1] + shift[0];
        at[1] = f[1] * s->edge[1] + f[2] * s->tilt[2] + shift[1];
        at[2] = f[2] * s->edge[2] + (s->dim == 3 ? shift[2] : 0);
        if (s->cell == SP_CELL_PERIODIC)
            sp_packing_wrap(&cell, at);
    }
    dynamics d;
    assert_ok(sp_dynamics_make(&spec, r, x, s->edge[s->dim - 1], &d, &err));
    memcpy(d.tilt, s->tilt, sizeof d.tilt);
    assert_ok(sp_neighbours_refresh(&d, &err));
    sp_free(x);
    sp_free(r);
    return d;
}

static const double nowhere[3] = {0, 0, 0};

/* Gives the grains velocities and spins, and the cell a velocity gradient. */
static void stir(dynamics *d) {
    for (int32_t i = 0; i < d->n; i++) {
        double *g = dynamics_grain(d, i);
        for (int a = 0; a < d->dim; a++)
            g[d->at.v + a] = 1e-2 * noise(3 * i + a + 5000);
        for (int a = 0; a < (d->dim == 3 ? 3 : 1); a++)
            g[d->at.w + a] = 1e-2 * noise(3 * i + a + 9000);
    }
    for (int a = 0; a < d->dim; a++)
        d->strain_rate[a] = 1e-3 * (a + 1);
    for (int a = 0; a < (d->dim == 3 ? 3 : 1) && d->cell == SP_CELL_PERIODIC; a++)
        d->shear_rate[a] = 2e-3 * (2 - a);
}

/* ---- forces -------------------------------------------------------------------------------------------------- */

/* Elastic energy, and the normal forces on all grains, from all images: f is [n][3] or NULL. */
static double brute_energy(const dynamics *d, double *f) {
    const int reach = d->cell == SP_CELL_PERIODIC ? 2 : 0;
    double sum = 0;
    for (int32_t i = 0; i < d->n; i++)
        for (int32_t j = i + 1; j < d->n; j++)
            for (int k = 0; k < 125; k++) {
                const int m[3] = {k % 5 - 2, k / 5 % 5 - 2, k / 25 - 2};
                if (abs(m[0]) > reach || abs(m[1]) > reach || abs(m[2]) > (d->dim == 3 ? reach : 0))
                    continue;
                const double *g = dynamics_grain(d, i), *h = dynamics_grain(d, j);
                double x[3] = {h[0] - g[0] + m[0] * d->period[0] + m[1] * d->tilt[0] + m[2] * d->tilt[1],
                               h[1] - g[1] + m[1] * dynamics_edge(d, 1) + m[2] * d->tilt[2],
                               d->dim == 3 ? h[2] - g[2] + m[2] * d->piston_y : 0};
                const double r = sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]), overlap = g[d->at.r] + h[d->at.r] - r;
                if (!(overlap > 0))
                    continue;
                const double normal = contact_force(contact_stiffness(g[d->at.r], h[d->at.r]), overlap);
                sum += 0.4 * normal * overlap; /* integral of Hertz's law */
                for (int a = 0; a < 3 && f; a++) {
                    f[3 * i + a] -= normal * x[a] / r;
                    f[3 * j + a] += normal * x[a] / r;
                }
            }
    for (int side = 0; side < d->walls; side++)
        for (int32_t i = 0; i < d->n; i++) {
            const wall_frame frame = dynamics_wall(d, side);
            const double *g = dynamics_grain(d, i), overlap = g[d->at.r] - dynamics_wall_distance(d, side, g);
            const double normal = overlap > 0 ? contact_force(sqrt(g[d->at.r]), overlap) : 0;
            sum += 0.4 * normal * overlap;
            if (f)
                f[3 * i + frame.axis] -= frame.sign * normal;
        }
    return sum;
}

TEST(test_forces_are_all_images) {
    for (int k = 0; k < SCENES; k++)
        for (int plain = 0; plain < 2; plain++) {
            scene smooth = scenes[k];
            smooth.friction = 0;
            dynamics d = make(&smooth, plain, nowhere);
            double *f = sp_alloc(3 * (size_t)d.n, sizeof *f), largest = 0;
            assert_true(brute_energy(&d, f) > 0);
            sp_dynamics_forces(&d, 0);
            for (int32_t i = 0; i < d.n; i++) {
                double force[3], turn[3];
                sp_dynamics_force_on(&d, i, force, turn);
                for (int a = 0; a < d.dim; a++) {
                    assert_close(force[a], f[3 * i + a], 1e-14);
                    largest = fmax(largest, fabs(force[a]));
                }
            }
            assert_true(largest > 1e-3);
            sp_free(f);
            sp_dynamics_free(&d);
        }
}

/* Moving all grains by a vector moves some of them through the faces, and changes no force. */
TEST(test_translation) {
    const double shift[3] = {3.1, -8.7, 14.2};
    for (int k = 0; k < SCENES; k++) {
        if (scenes[k].cell != SP_CELL_PERIODIC)
            continue;
        dynamics here = make(&scenes[k], false, nowhere), there = make(&scenes[k], false, shift);
        stir(&here);
        stir(&there);
        sp_dynamics_forces(&here, 0.5);
        sp_dynamics_forces(&there, 0.5);
        for (int32_t i = 0; i < here.n; i++) {
            double f[2][3], t[2][3];
            sp_dynamics_force_on(&here, i, f[0], t[0]);
            sp_dynamics_force_on(&there, i, f[1], t[1]);
            for (int a = 0; a < 3; a++) {
                assert_close(f[0][a], f[1][a], 1e-13);
                assert_close(t[0][a], t[1][a], 1e-13);
            }
        }
        sp_dynamics_free(&there);
        sp_dynamics_free(&here);
    }
}

/* ---- stress -------------------------------------------------------------------------------------------------- */

/* Energy after the cell and its grains are strained in one component: x' = x + h x_b along a. */
static double strained_energy(const scene *s, int a, int b, double h) {
    dynamics d = make(s, false, nowhere);
    if (a == b)
        d.strain_rate[a] = 1;
    else
        d.shear_rate[a + b - 1] = 1;
    for (int32_t i = 0; i < d.n; i++)
        dynamics_grain(&d, i)[a] += h * dynamics_grain(&d, i)[b];
    sp_deform_cell(&d, h);
    const double energy = brute_energy(&d, NULL);
    sp_dynamics_free(&d);
    return energy;
}

static double stress_error(const scene *s, int a, int b, double measured, double h) {
    const double volume = s->edge[0] * s->edge[1] * s->edge[2];
    return (strained_energy(s, a, b, -h) - strained_energy(s, a, b, h)) / (2 * h * volume) - measured;
}

/* Stress is -dE / (V d strain): central differences miss it by h^2. */
TEST(test_stress_is_derivative) {
    for (int k = 0; k < SCENES; k++) {
        scene smooth = scenes[k];
        smooth.friction = 0;
        dynamics d = make(&smooth, false, nowhere);
        double stress[6];
        sp_dynamics_stress(&d, stress);
        sp_dynamics_free(&d);
        for (int a = 0; a < smooth.dim; a++)
            for (int b = a; b < (smooth.cell == SP_CELL_PERIODIC ? smooth.dim : a + 1); b++) {
                const double measured = stress[a == b ? a : 6 - a - b];
                const double coarse = stress_error(&smooth, a, b, measured, 2e-5);
                const double fine = stress_error(&smooth, a, b, measured, 1e-5);
                assert_true(fabs(measured) > 1e-5);
                assert_close(coarse, 0, 1e-4 * fabs(measured) + 1e-8);
                assert_close(fine, 0, 0.5 * fabs(coarse) + 1e-10);
            }
    }
}

/* ---- deformation --------------------------------------------------------------------------------------------- */

/* One step of x' = L x, as the grains take it. */
static void flow(const dynamics *d, double dt, double x[3]) {
    x[0] += dt * (d->strain_rate[0] * x[0] + d->shear_rate[0] * x[1] + d->shear_rate[1] * x[2]);
    x[1] += dt * (d->strain_rate[1] * x[1] + d->shear_rate[2] * x[2]);
    x[2] += dt * d->strain_rate[2] * x[2];
}

/* Grains that nothing can push are carried by the cell, except for lattice vectors: the strain is so large that the
 * cell takes other ones. */
TEST(test_grains_follow_the_cell) {
    for (int k = 0; k < SCENES; k++) {
        dynamics d = make(&scenes[k], false, nowhere);
        double *x = sp_alloc(3 * (size_t)d.n, sizeof *x), turned = d.tilt[0];
        stir(&d);
        for (int32_t i = 0; i < d.n; i++) {
            double *g = dynamics_grain(&d, i);
            memcpy(x + 3 * (size_t)i, g, (size_t)d.dim * sizeof *x);
            memset(g + d.at.v, 0, (size_t)d.dim * sizeof *g);
            g[d.at.inv_m] = 1e-40;
        }
        for (int step = 0; step < 400; step++) {
            assert_ok(sp_neighbours_refresh(&d, &err));
            sp_dynamics_forces(&d, 1);
            for (int32_t i = 0; i < d.n; i++)
                flow(&d, 1, x + 3 * (size_t)i);
            sp_dynamics_advance(&d, 1);
        }
        d.outer_travel = INFINITY;
        assert_ok(sp_neighbours_refresh(&d, &err));
        const sp_packing cell = sp_dynamics_cell(&d);
        for (int32_t i = 0; i < d.n; i++) {
            double apart[3] = {0, 0, 0};
            for (int a = 0; a < d.dim; a++)
                apart[a] = dynamics_grain(&d, i)[a] - x[3 * i + a];
            sp_packing_nearest(&cell, apart);
            for (int a = 0; a < d.dim; a++)
                assert_close(apart[a], 0, 1e-11);
        }
        for (int a = 0; a < d.dim; a++)
            assert_relative(cell.box[a], scenes[k].edge[a] * pow(1 + 1e-3 * (a + 1), 400), 1e-12);
        assert_true(fabs(d.tilt[0]) <= 0.5 * d.period[0] && d.rebuilds >= 2);
        assert_true((d.tilt[0] != turned) == (d.cell == SP_CELL_PERIODIC));
        sp_free(x);
        sp_dynamics_free(&d);
    }
}

/* Bytes after some hundred steps of a deforming cell, alone and with threads. */
TEST(test_threads) {
    for (int k = 0; k < SCENES; k++) {
        dynamics d[2] = {make(&scenes[k], false, nowhere), make(&scenes[k], false, nowhere)};
        assert_ok(sp_pool_make(3, &d[1].pool, &err));
        for (int t = 0; t < 2; t++) {
            stir(&d[t]);
            for (int step = 0; step < 200; step++) {
                assert_ok(sp_neighbours_refresh(&d[t], &err));
                sp_dynamics_forces(&d[t], 0.05);
                sp_dynamics_advance(&d[t], 0.05);
            }
        }
        assert_memory_equal(d[0].g, d[1].g, (size_t)(d[0].n * d[0].at.stride) * sizeof *d[0].g);
        assert_memory_equal(d[0].tilt, d[1].tilt, sizeof d[0].tilt);
        assert_memory_equal(d[0].wall_force, d[1].wall_force, sizeof d[0].wall_force);
        sp_dynamics_free(&d[1]);
        sp_dynamics_free(&d[0]);
    }
}

RUN_TESTS(NULL, NULL)
