/* The kernel against the plain path from one dense state, threads against none, and the root that the kernel takes. */
#include "test.h"

#include "base/base.h"
#include "base/pool.h"
#include "packing/contact.h"
#include "packing/dynamics.h"
#include "packing/kernel.h"
#include "packing/prepare.h"

typedef struct dense {
    int dim;
    bool wide; /* diameters 0.2 .. 2 */
    sp_packing p;
} dense;

static sp_pack_spec dense_spec(int dim, bool wide) {
    sp_pack_spec spec = sp_pack_spec_default();
    spec.dim = dim;
    spec.grains = dim == 2 ? 80 : 120;
    spec.width = wide ? 8 : dim == 2 ? 8 : 5;
    spec.seed = 21;
    if (wide) {
        spec.diameter_min = 0.2;
        spec.diameter_max = 2;
    }
    spec.tolerance = 0.01 * spec.pressure;
    spec.lag = 0; /* the reference has none; test_lag.c */
    return sp_pack_spec_resolve(&spec);
}

static dense states[4];

static int make_states(void **state) {
    (void)state;
    for (int k = 0; k < 4; k++) {
        states[k] = (dense){.dim = 2 + k / 2, .wide = k % 2, .p = sp_packing_none()};
        const sp_pack_spec spec = dense_spec(states[k].dim, states[k].wide);
        assert_ok(sp_packing_make(&spec, NULL, NULL, &states[k].p, &err));
    }
    return 0;
}

static int free_states(void **state) {
    (void)state;
    for (int k = 0; k < 4; k++)
        sp_packing_free(&states[k].p);
    return 0;
}

/* A number in [-1, 1) that depends on what it is for only (a 32-bit finaliser of avalanche type). */
static double noise(uint32_t what, uint32_t i, uint32_t j, uint32_t axis) {
    uint32_t h = what * 0x9e3779b1u + i * 0x85ebca77u + j * 0xc2b2ae3du + axis * 0x27d4eb2fu;
    for (int round = 0; round < 3; round++) {
        h ^= h >> 15;
        h *= 0x2c1b3c6du;
        h ^= h >> 13;
    }
    return ldexp((double)h, -31) - 1;
}

typedef struct conditions {
    double friction, viscous_limit, dt;
    bool history; /* of contacts (mindlin.h) */
    double lag;
    bool mixed; /* three materials, of which one pair is smooth */
} conditions;

static const sp_types MATERIALS = {.fraction = (const double[]){0.4, 0.3, 0.3},
                                   .modulus = (const double[]){1, 0.2, 5},
                                   .poisson = (const double[]){0.3, 0, 0.45},
                                   .density = (const double[]){1, 0.3, 7},
                                   .friction = (const double[]){0.1, 0.5, 0, 0.2, 0.4, 0.3},
                                   .fractions = 3,
                                   .moduli = 3,
                                   .poissons = 3,
                                   .densities = 3,
                                   .frictions = 6};

static double separation(const dynamics *d, int32_t i, int32_t j) {
    const double *g = dynamics_grain(d, i), *h = dynamics_grain(d, j);
    double square = 0;
    for (int a = 0; a < d->dim; a++) {
        double x = h[a] - g[a];
        x -= a < d->dim - 1 ? d->period[a] * nearbyint(x / d->period[a]) : 0;
        square += x * x;
    }
    return sqrt(square);
}

/* The number of a tangential force: of the pair in its list's order, planes of the list apart. */
static double *tangential(pair_list *p, int32_t k, int axis) { return p->ft + k + (int64_t)axis * p->capacity; }

/* A packing that moves and whose tangential forces are of the size of friction's limit, below and above it. */
static dynamics make_moving(const dense *from, const conditions *c, bool plain) {
    const int dim = from->dim, planes = dim == 2 ? 1 : 3;
    sp_pack_spec spec = dense_spec(dim, from->wide);
    dynamics d;
    spec.friction = c->friction;
    spec.viscous_limit = c->viscous_limit;
    spec.lag = c->lag;
    spec.poisson = 0.3;
    spec.reference = plain;
    spec.tangential = c->history ? SP_TANGENTIAL_HISTORY : SP_TANGENTIAL_CONSTANT;
    spec.width = from->p.box[0];
    if (c->mixed)
        spec.types = MATERIALS;
    assert_ok(sp_dynamics_make(&spec, from->p.r, from->p.x, sp_packing_height(&from->p), &d, &err));
    d.v_max = 0.01; /* lists with many open pairs */
    d.dt = 5;
    for (int32_t i = 0; i < d.n; i++)
        dynamics_grain(&d, i)[d.at.type] = c->mixed ? i % 3 : 0;
    sp_dynamics_set_types(&d, &spec, NULL);
    assert_ok(sp_neighbours_refresh(&d, &err));
    for (int32_t i = 0; i < d.n; i++) {
        double *g = dynamics_grain(&d, i);
        for (int a = 0; a < dim; a++)
            g[d.at.v + a] = 1e-3 * noise(1, (uint32_t)i, 0, (uint32_t)a);
        for (int a = 0; a < planes && c->friction > 0; a++) /* smooth grains never begin to turn */
            g[d.at.w + a] = 1e-3 * noise(2, (uint32_t)i, 0, (uint32_t)a);
    }
    d.piston_v = -2e-4;
    pair_list *list = plain ? &d.outer : &d.inner;
    for (int32_t k = 0; k < list->n; k++) {
        const int32_t i = list->i[k], j = list->j[k], low = i < j ? i : j, high = i < j ? j : i;
        const double overlap = list->reach[k] - separation(&d, i, j), sign = dim == 3 && i > j ? -1 : 1;
        const double normal = contact_force(contact_stiffness(d.r_max, d.r_max), fmax(overlap, 1e-4));
        for (int a = 0; a < planes; a++)
            *tangential(list, k, a) = sign * normal * noise(3, (uint32_t)low, (uint32_t)high, (uint32_t)a);
    }
    for (int side = 0; side < 2; side++)
        for (int32_t i = 0; i < d.n; i++) {
            const double *g = dynamics_grain(&d, i), y = side == 0 ? g[dim - 1] : d.piston_y - g[dim - 1];
            for (int a = 0; a < dim - 1 && y - g[d.at.r] < 0.05; a++) /* nearer than any gap */
                d.wall_ft[side][i * (dim - 1) + a] = 1e-4 * noise(4, (uint32_t)i, (uint32_t)side, (uint32_t)a);
        }
    return d;
}

static int32_t find_pair(const pair_list *p, int32_t i, int32_t j) {
    for (int32_t k = 0; k < p->n; k++)
        if ((p->i[k] == i && p->j[k] == j) || (p->i[k] == j && p->j[k] == i))
            return k;
    return -1;
}

typedef struct difference {
    double worst, scale;
} difference;

static void differ(difference *d, double one, double other) {
    d->worst = fmax(d->worst, fabs(one - other));
    d->scale = fmax(d->scale, fabs(other));
}

static void assert_same_tangential(dynamics *fast, dynamics *plain) {
    const int planes = fast->dim == 2 ? 1 : 3;
    difference all = {0, 0};
    int32_t open = 0, closed = 0;
    for (int32_t k = 0; k < fast->inner.n; k++) {
        const int32_t i = fast->inner.i[k], j = fast->inner.j[k], q = find_pair(&plain->outer, i, j);
        assert_true(q >= 0);
        const double flip = planes == 3 && plain->outer.i[q] != i ? -1 : 1;
        double error = 0, size = 0;
        for (int a = 0; a < planes; a++) {
            const double one = *tangential(&fast->inner, k, a), other = flip * *tangential(&plain->outer, q, a);
            differ(&all, one, other);
            error = fmax(error, fabs(one - other));
            size = fmax(size, fabs(other));
        }
        assert_true(error <= 1e-11 * size);
        const bool touch = separation(fast, i, j) < fast->inner.reach[k];
        assert_true(touch || size == 0);
        open += !touch;
        closed += touch;
    }
    assert_true(open > 0 && closed > fast->n / 2);
    assert_true(all.worst <= 1e-13 * all.scale);
    for (int side = 0; side < 2; side++)
        for (int32_t i = 0; i < fast->n * (fast->dim - 1); i++)
            assert_close(fast->wall_ft[side][i], plain->wall_ft[side][i], 1e-13 * 1e-4);
}

static void assert_same_forces(dynamics *fast, dynamics *plain) {
    difference forces = {0, 0}, turns = {0, 0};
    for (int32_t i = 0; i < fast->n; i++) {
        double f[2][3], t[2][3];
        sp_dynamics_force_on(fast, i, f[0], t[0]);
        sp_dynamics_force_on(plain, i, f[1], t[1]);
        for (int a = 0; a < 3; a++) {
            differ(&forces, f[0][a], f[1][a]);
            differ(&turns, t[0][a], t[1][a]);
        }
    }
    assert_true(forces.scale > 1e-6);
    assert_true(forces.worst <= 1e-13 * forces.scale);
    assert_true(turns.worst <= 1e-13 * forces.scale);
    assert_true((turns.scale > 1e-7) == (fast->law.friction > 0));
    for (int side = 0; side < 2; side++)
        assert_relative(fast->wall_force[side], plain->wall_force[side], 1e-13);
    assert_relative(fast->piston_k, plain->piston_k, 1e-13);
}

static void assert_same_motion(dynamics *fast, dynamics *plain, double dt) {
    sp_dynamics_advance(fast, dt);
    sp_dynamics_advance(plain, dt);
    for (int32_t i = 0; i < fast->n; i++) {
        const double *g = dynamics_grain(fast, i), *h = dynamics_grain(plain, i);
        for (int a = 0; a < fast->at.stride; a++)
            assert_close(g[a], h[a], 1e-13 * fmax(fabs(h[a]), a < fast->dim ? 1 : 1e-3));
    }
    assert_relative(fast->piston_y, plain->piston_y, 1e-15);
    assert_relative(fast->v_max, plain->v_max, 1e-13);
}

TEST(test_kernel_equals_plain) {
    const double friction[] = {0, 0.5, 1e6}, limit[] = {1, 1e6}, dt[] = {0, 0.01, 0.3, 1};
    for (int k = 0; k < 4 * 3 * 2 * 4; k += SANITIZED_STEP(5)) {
        const conditions c = {friction[k / 8 % 3], limit[k / 4 % 2], dt[k % 4], .mixed = k / 8 % 3 == 1};
        dynamics fast = make_moving(&states[k / 24], &c, false), plain = make_moving(&states[k / 24], &c, true);
        if (k % 3 == 0) /* sides that shrink */
            for (int a = 0; a < fast.dim - 1; a++)
                fast.strain_rate[a] = plain.strain_rate[a] = -1e-4 * (a + 1);
        sp_dynamics_forces(&fast, c.dt);
        sp_dynamics_forces(&plain, c.dt);
        assert_same_forces(&fast, &plain);
        assert_same_tangential(&fast, &plain);
        fast.drag = plain.drag = 0.01;
        assert_same_motion(&fast, &plain, 0.3);
        sp_dynamics_free(&plain);
        sp_dynamics_free(&fast);
    }
}

/* The same with the history of contacts, over steps back and forth, so that contacts remember reversals. */
TEST(test_history_equals_plain) {
    for (int k = 0; k < 4; k++) {
        const conditions c = {0.5, k / 2 ? 1 : 1e6, 0.1, .history = true};
        dynamics fast = make_moving(&states[k % 2], &c, false), plain = make_moving(&states[k % 2], &c, true);
        double turns = 0;
        for (int step = 0; step < 6; step++) {
            for (int64_t a = 0; a < (int64_t)fast.n * fast.at.stride && step > 0; a++)
                if (a % fast.at.stride >= fast.at.v && a % fast.at.stride < fast.at.r)
                    plain.g[a] = fast.g[a] = -0.8 * fast.g[a];
            sp_dynamics_forces(&fast, c.dt);
            sp_dynamics_forces(&plain, c.dt);
            assert_same_forces(&fast, &plain);
            assert_same_tangential(&fast, &plain);
        }
        for (int32_t q = 0; q < fast.inner.n; q++)
            turns = fmax(turns, fabs(*tangential(&fast.inner, q, 1)) - 1);
        assert_true(turns >= 3);
        sp_dynamics_free(&plain);
        sp_dynamics_free(&fast);
    }
}

static void assert_same_list(const pair_list *one, const pair_list *two, int dim) {
    const size_t n = (size_t)one->n;
    assert_int_equal(one->n, two->n);
    assert_memory_equal(one->i, two->i, n * sizeof *one->i);
    assert_memory_equal(one->j, two->j, n * sizeof *one->j);
    assert_memory_equal(one->reach, two->reach, n * sizeof *one->reach);
    assert_memory_equal(one->sm, two->sm, n * sizeof *one->sm);
    for (int64_t a = 0; a < dim - 1; a++)
        assert_memory_equal(one->image + a * one->capacity, two->image + a * two->capacity, n * sizeof(double));
    for (int64_t a = 0; a < (dim == 2 ? 1 : 3); a++)
        assert_memory_equal(one->ft + a * one->capacity, two->ft + a * two->capacity, n * sizeof(double));
}

static void assert_same_bits(dynamics *one, dynamics *two) {
    double rest[2][2];
    assert_memory_equal(one->g, two->g, (size_t)(one->n * one->at.stride) * sizeof *one->g);
    assert_same_list(&one->outer, &two->outer, one->dim);
    assert_same_list(&one->inner, &two->inner, one->dim);
    for (int side = 0; side < 2; side++) {
        assert_int_equal(one->wall[side].n, two->wall[side].n);
        assert_memory_equal(one->wall[side].i, two->wall[side].i, (size_t)one->wall[side].n * sizeof(int32_t));
        assert_memory_equal(&one->wall_force[side], &two->wall_force[side], sizeof(double));
    }
    assert_memory_equal(&one->piston_y, &two->piston_y, sizeof one->piston_y);
    assert_memory_equal(&one->piston_k, &two->piston_k, sizeof one->piston_k);
    assert_memory_equal(&one->v_max, &two->v_max, sizeof one->v_max);
    assert_memory_equal(&one->rate, &two->rate, sizeof one->rate);
    assert_true(one->v_max < 1 && sp_dynamics_sane(one) == sp_dynamics_sane(two));
    assert_ok(sp_dynamics_residual(one, &rest[0][0], &rest[0][1], &err));
    assert_ok(sp_dynamics_residual(two, &rest[1][0], &rest[1][1], &err));
    assert_memory_equal(rest[0], rest[1], sizeof rest[0]);
    assert_true(rest[0][0] > 0 && sp_dynamics_acceleration(one) == sp_dynamics_acceleration(two));
}

/* New lists now and then, as if the grains had gone far. */
static void run_steps(dynamics *d, int steps, double dt) {
    for (int step = 0; step < steps; step++) {
        if (step % 30 == 0)
            *(step % 60 == 0 ? &d->outer_travel : &d->inner_travel) = INFINITY;
        assert_ok(sp_neighbours_refresh(d, &err));
        sp_dynamics_forces(d, dt);
        sp_dynamics_advance(d, dt);
    }
}

/* The rate of a grain from the rows of its contacts, of which a single one counts more where dashpots lag. */
static double rate_of(const dynamics *d, int32_t i) {
    double sum = 0, most = 0;
    for (int s = 0; s < SLOTS && s < d->rows.count[i]; s++) {
        const double one = d->rows.row[(d->rows.slot[SLOTS * (int64_t)i + s] & ~1) + 3];
        sum += one;
        most = fmax(most, one);
    }
    return dynamics_grain(d, i)[d->at.inv_m] * fmax(sum, d->lag > 0 ? SINGLE_CONTACT * most : 0);
}

TEST(test_rate) {
    for (int k = 0; k < 4; k += 2)
        for (int lags = 0; lags < 2; lags++) {
            const conditions c = {0.5, 1e6, 0.1, .lag = lags ? 0.6 : 0};
            dynamics d = make_moving(&states[k], &c, false);
            double rate = 0, at_wall = 0;
            sp_dynamics_forces(&d, 0.1);
            for (int32_t i = 0; i < d.n; i++)
                rate = d.rows.count[i] <= SLOTS ? fmax(rate, rate_of(&d, i)) : rate;
            sp_dynamics_advance(&d, 0.1);
            assert_relative(d.rate, rate, 1e-14);
            /* a grain that touches nothing but the wall, all others pulled apart */
            for (int32_t i = 0; i < d.n; i++)
                dynamics_grain(&d, i)[d.dim - 1] = i == 0 ? 0.9 * dynamics_radius(&d, 0) : 10.0 + 3 * i;
            d.piston_y = 20 + 3 * d.n;
            d.outer_travel = INFINITY;
            assert_ok(sp_neighbours_refresh(&d, &err));
            sp_dynamics_forces(&d, 0.1);
            at_wall = rate_of(&d, 0);
            sp_dynamics_advance(&d, 0.1);
            assert_relative(d.rate, at_wall, 1e-14);
            assert_true(at_wall > 0);
            sp_dynamics_free(&d);
        }
}

static const int THREADS[] = {2, 3, 5};

TEST(test_threads) {
    for (int k = 0; k < 4; k++) {
        const conditions c = {0.5, 1e6, 0.1, .history = k == 1, .lag = 0.6};
        dynamics alone = make_moving(&states[k], &c, false);
        run_steps(&alone, 300, 0.1);
        assert_true(alone.refills >= 5 && alone.rebuilds >= 5);
        for (int q = 0; q < 3; q++) {
            dynamics d = make_moving(&states[k], &c, false);
            assert_ok(sp_pool_make(THREADS[q], &d.pool, &err));
            assert_int_equal(sp_pool_parts(d.pool), THREADS[q]);
            run_steps(&d, 300, 0.1);
            assert_same_bits(&d, &alone);
            sp_dynamics_free(&d);
        }
        sp_dynamics_free(&alone);
    }
}

/* A dense gas that collides, so large that its lists have many spans. */
static dynamics make_crowd(int dim, bool wide) {
    sp_pack_spec spec = dense_spec(dim, wide);
    double *r, *x, height = 0;
    dynamics d;
    spec.grains = 3000;
    spec.gas_fraction = dim == 2 ? 0.4 : 0.25;
    spec.width = dim == 2 ? 40 : 16;
    spec.friction = 0.5;
    spec = sp_pack_spec_resolve(&spec);
    spec.depth = spec.width;
    r = sp_alloc((size_t)spec.grains, sizeof *r);
    x = sp_alloc(3 * (size_t)spec.grains, sizeof *x);
    sp_radii_draw(&spec, r);
    assert_ok(sp_gas_make(&spec, r, x, &height, &err));
    assert_ok(sp_dynamics_make(&spec, r, x, height, &d, &err));
    for (int32_t i = 0; i < d.n; i++)
        for (int a = 0; a < dim; a++)
            dynamics_grain(&d, i)[d.at.v + a] = 0.05 * noise(5, (uint32_t)i, 0, (uint32_t)a);
    d.v_max = 0.1;
    d.dt = 0.1;
    sp_free(x);
    sp_free(r);
    return d;
}

TEST(test_lists_of_threads) {
    for (int k = 0; k < 4; k += SANITIZED_STEP(3)) {
        dynamics alone = make_crowd(2 + k / 2, k % 2);
        run_steps(&alone, 100, k % 2 ? 0.01 : 0.1);
        assert_true(alone.outer.n > 2 * SPAN && (k % 2 == 1 || (alone.inner.n > 2 * SPAN && alone.wall[0].n > 3)));
        for (int q = 0; q < 3; q += SANITIZED_STEP(2)) {
            dynamics d = make_crowd(2 + k / 2, k % 2);
            assert_ok(sp_pool_make(THREADS[q], &d.pool, &err));
            run_steps(&d, 100, k % 2 ? 0.01 : 0.1);
            assert_same_bits(&d, &alone);
            sp_dynamics_free(&d);
        }
        sp_dynamics_free(&alone);
    }
}

/* Disks with a row of forces for both grains of a pair, and with one that they share. */
TEST(test_shared_rows) {
    const conditions c = {0.5, 1e6, 0.1, .history = false};
    for (int k = 0; k < 2; k++) {
        dynamics both = make_moving(&states[k], &c, false), shared = make_moving(&states[k], &c, false);
        assert_true(both.rows.both);
        shared.rows.both = false;
        shared.inner_travel = both.inner_travel = INFINITY;
        run_steps(&both, 300, 0.1);
        run_steps(&shared, 300, 0.1);
        assert_true(shared.rows.other == 0 && both.rows.other > 0);
        assert_same_bits(&both, &shared);
        sp_dynamics_free(&shared);
        sp_dynamics_free(&both);
    }
}

/* Against long double, over all exponents of normal numbers, at mantissas that are dense and odd. */
TEST(test_fourth_root) {
    double worst = 0;
    for (int exponent = -1021; exponent <= 1022; exponent++)
        for (int k = 0; k < 257; k++) {
            const double x = ldexp(1 + k / 257.0, exponent);
            const long double right = 1 / sqrtl(sqrtl((long double)x)), ulp = ldexpl(1, ilogbl(right) - 52);
            worst = fmax(worst, (double)(fabsl(inverse_fourth_root(x) - right) / ulp));
        }
    printf("inverse fourth root: %.3f ulp\n", worst);
    assert_true(worst < 1.1);
    for (int k = 0; k <= 20; k++) { /* powers of 16 are exact */
        assert_true(inverse_fourth_root(ldexp(1, 4 * k)) == ldexp(1, -k));
        assert_true(inverse_fourth_root(ldexp(1, -4 * k)) == ldexp(1, k));
    }
}

RUN_TESTS(make_states, free_states)
