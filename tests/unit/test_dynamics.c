/* The motion that makes packings against brute force, and a pair that turns. What mechanics conserves is in
 * tests/properties, the kernel against the plain path in test_kernel.c, against the network's K in test_prestress.c. */
#include "test.h"

#include "base/base.h"
#include "packing/contact.h"
#include "packing/dynamics.h"
#include "packing/prepare.h"

static sp_pack_spec small_spec(int dim, uint64_t seed) {
    sp_pack_spec spec = sp_pack_spec_default();
    spec.dim = dim;
    spec.grains = dim == 2 ? 60 : 100;
    spec.width = dim == 2 ? 8 : 5;
    spec.seed = seed;
    return sp_pack_spec_resolve(&spec);
}

/* The gas of a spec, its grains flying about. */
static dynamics make_gas(const sp_pack_spec *spec, double speed) {
    const size_t n = (size_t)spec->grains;
    double *r = sp_alloc(n, 8), *x = sp_alloc(3 * n, 8), height;
    dynamics d;
    sp_radii_draw(spec, r);
    assert_ok(sp_gas_make(spec, r, x, &height, &err));
    assert_ok(sp_dynamics_make(spec, r, x, height, &d, &err));
    for (int32_t i = 0; i < d.n; i++) {
        double *v = dynamics_grain(&d, i) + d.at.v;
        v[0] = speed * sin(3.0 * i);
        v[1] = speed * cos(7.0 * i);
        if (d.dim == 3)
            v[2] = speed * sin(5.0 * i + 1);
    }
    d.v_max = 2 * speed;
    sp_free(x);
    sp_free(r);
    return d;
}

static bool touching(const dynamics *d, int32_t i, int32_t j) {
    const double *g = dynamics_grain(d, i), *h = dynamics_grain(d, j);
    double square = 0;
    for (int a = 0; a < d->dim; a++) {
        double x = h[a] - g[a];
        if (a < d->dim - 1)
            x -= d->period[a] * nearbyint(x / d->period[a]);
        square += x * x;
    }
    return sqrt(square) < g[d->at.r] + h[d->at.r];
}

/* The pairs on which the kernel found forces are those that touch, each once. Returns how many. */
static int32_t assert_pairs_are_complete(const dynamics *d, uint8_t *seen) {
    int32_t count = 0;
    memset(seen, 0, (size_t)d->n * (size_t)d->n);
    for (int32_t k = 0; k < d->inner.n; k++) {
        const int32_t i = d->inner.i[k], j = d->inner.j[k];
        if (d->rows.row[d->at.row * k + 3] > 0) /* sqrt(m_eff k_n) */
            seen[(i < j ? i : j) * d->n + (i < j ? j : i)]++;
    }
    for (int32_t i = 0; i < d->n; i++)
        for (int32_t j = i + 1; j < d->n; j++) {
            assert_int_equal(seen[i * d->n + j], touching(d, i, j));
            count += seen[i * d->n + j];
        }
    return count;
}

static void check_lists(const sp_pack_spec *spec, double dt) {
    dynamics d = make_gas(spec, 0.05);
    uint8_t *seen = sp_alloc((size_t)d.n * (size_t)d.n, 1);
    int32_t contacts = 0;
    d.law.damping = 0; /* the motion goes on */
    d.law.friction = 0;
    d.dt = dt;
    for (int step = 0; step < 2000; step++) {
        assert_ok(sp_neighbours_refresh(&d, &err));
        sp_dynamics_forces(&d, dt);
        contacts += assert_pairs_are_complete(&d, seen);
        sp_dynamics_advance(&d, dt);
    }
    printf("%dD: %d contacts in 2000 steps, %lld outer and %lld inner lists\n", d.dim, contacts, (long long)d.rebuilds,
           (long long)d.refills);
    assert_true(contacts > 500);
    assert_true(d.rebuilds > 3 && d.refills < 1500); /* not in every step */
    sp_free(seen);
    sp_dynamics_free(&d);
}

TEST(test_lists_equal_brute_force) {
    sp_pack_spec spec = small_spec(2, 11);
    check_lists(&spec, 0.1);
    spec = small_spec(3, 11);
    check_lists(&spec, 0.1);
    for (int dim = 2; dim <= 3; dim++) { /* 10:1 */
        spec = small_spec(dim, 12);
        spec.width = 8;
        spec.depth = dim == 3 ? 8 : 0;
        spec.diameter_min = 0.2;
        spec.diameter_max = 2;
        check_lists(&spec, 0.1);
    }
}

/* ---- a pair that turns as one body --------------------------------------------------------------------------- */

/* v turned about the unit vector e by an angle. */
static void turned(const double e[3], double angle, const double v[3], double out[3]) {
    const double c = cos(angle), s = sin(angle), along = e[0] * v[0] + e[1] * v[1] + e[2] * v[2];
    for (int a = 0; a < 3; a++)
        out[a] =
            c * v[a] + s * (e[(a + 1) % 3] * v[(a + 2) % 3] - e[(a + 2) % 3] * v[(a + 1) % 3]) + (1 - c) * along * e[a];
}

/* Positions of the pair at one time, and the velocities that brought it there. Lever arms are the undeformed radii:
 * a spin Omega (R1 + R2 - n)/(R1 + R2) across the normal is what does not slip, along the normal it is Omega. */
static void place_pair(dynamics *d, const double e[3], double angle, double step, double dt) {
    const double n0[3] = {0, 0.6, 0.8}, r1 = dynamics_radius(d, 0), r2 = dynamics_radius(d, 1), apart = r1 + r2 - 0.1;
    double now[3], past[3], along = 0;
    turned(e, angle, n0, now);
    turned(e, angle - step, n0, past);
    for (int a = 0; a < 3; a++)
        along += e[a] * now[a];
    for (int i = 0; i < 2; i++) {
        double *g = dynamics_grain(d, i), arm = i == 0 ? -0.4 * apart : 0.6 * apart;
        for (int a = 0; a < 3; a++) {
            g[a] = 10 + arm * now[a];
            g[d->at.v + a] = arm * (now[a] - past[a]) / dt;
            g[d->at.w + a] = g[d->at.r] * step / dt * (along * now[a] + (e[a] - along * now[a]) * apart / (r1 + r2));
        }
    }
}

/* How far the tangential force is from the one that has turned with the pair by 2 radians about e, over its size. */
static double carried_error(const double e[3], int steps, bool plain) {
    sp_pack_spec spec = small_spec(3, 1);
    const double r[2] = {0.4, 0.6}, x[6] = {10, 10, 10, 10, 10.54, 10.72}, dt = 0.01, step = 2.0 / steps;
    dynamics d;
    spec.grains = 2;
    spec.width = spec.depth = 20;
    spec.reference = plain;
    assert_ok(sp_dynamics_make(&spec, r, x, 20, &d, &err));
    place_pair(&d, e, 0, step, dt);
    assert_ok(sp_neighbours_refresh(&d, &err));
    pair_list *list = plain ? &d.outer : &d.inner;
    assert_int_equal(list->n, 1);
    const bool swapped = list->i[0] == 1;
    const double size = 0.1 * contact_force(contact_stiffness(r[0], r[1]), 0.1);
    const double t0[3] = {0.6 * size, 0.8 * 0.8 * size, -0.8 * 0.6 * size}; /* across (0, 0.6, 0.8) */
    for (int a = 0; a < 3; a++)
        list->ft[a * list->capacity] = swapped ? -t0[a] : t0[a];
    for (int k = 1; k <= steps; k++) {
        place_pair(&d, e, k * step, step, dt);
        sp_dynamics_forces(&d, dt);
    }
    double right[3], error = 0;
    turned(e, 2.0, t0, right);
    for (int a = 0; a < 3; a++)
        error += pow((swapped ? -1 : 1) * list->ft[a * list->capacity] - right[a], 2);
    sp_dynamics_free(&d);
    return sqrt(error) / size;
}

TEST(test_tangential_force_is_carried) {
    const double axes[4][3] = {{0, 0.6, 0.8}, {1, 0, 0}, {0, 0.8, -0.6}, {2.0 / 3, -1.0 / 3, 2.0 / 3}};
    for (int k = 0; k < 4; k++)
        for (int plain = 0; plain <= 1; plain++) {
            const double coarse = carried_error(axes[k], 20000, plain), fine = carried_error(axes[k], 40000, plain);
            printf("axis %d, %s: error %.3g, at half the step %.3g\n", k, plain ? "plain" : "kernel", coarse, fine);
            assert_true(fine < 5e-3);
            assert_true(fine < 0.55 * coarse || fine < 1e-8);
        }
}

TEST(test_allocation_failures) {
    for (int64_t k = 0; k < 120; k++) {
        sp_pack_spec spec = small_spec(k % 2 ? 2 : 3, 2);
        spec.max_steps = 400;
        sp_packing p = sp_packing_none();
        sp_error err = {0};
        sp_alloc_fail_after(k / 2);
        sp_status status = sp_packing_make(&spec, NULL, NULL, &p, &err);
        sp_alloc_fail_after(-1);
        assert_true(status == SP_ENOMEM || status == SP_EFAILED);
        assert_null(p.x);
    }
}

RUN_TESTS(NULL, NULL)
