/* The forces that make packings: against brute force, against the network's K, and step by step. */
#include "test.h"

#include "base/base.h"
#include "packing/contact.h"
#include "packing/dynamics.h"
#include "packing/making.h"
#include "packing/pairs.h"

#include <sonopack/network.h>

static sp_pack_spec small_spec(uint64_t seed) {
    sp_pack_spec spec = sp_pack_spec_default();
    spec.grains = 60;
    spec.width = 8;
    spec.seed = seed;
    return spec;
}

/* The packing without its rattlers, so that every touching pair is a spring. */
static sp_packing make_bare(uint64_t seed) {
    sp_pack_spec spec = small_spec(seed);
    sp_packing p = sp_packing_none(), bare = sp_packing_none();
    assert_ok(sp_packing_make(&spec, NULL, NULL, &p, &err));
    uint8_t *rattler = sp_alloc((size_t)p.n, 1), *carrying = sp_alloc((size_t)p.n_contacts, 1);
    int32_t *number = sp_alloc((size_t)p.n, sizeof *number), rattlers, n = 0, contacts = 0;
    assert_ok(sp_packing_rattlers(&p, 0, rattler, carrying, &rattlers, &err));
    assert_ok(sp_packing_alloc(&bare, 2, p.n - rattlers, p.n_contacts, &err));
    bare.box[0] = p.box[0];
    bare.box[1] = p.box[1];
    bare.pressure = p.pressure;
    bare.friction = p.friction;
    for (int32_t i = 0; i < p.n; i++) {
        if (rattler[i])
            continue;
        number[i] = n;
        bare.r[n] = p.r[i];
        memcpy(bare.x + 3 * n, p.x + 3 * i, 3 * sizeof(double));
        n++;
    }
    for (int32_t c = 0; c < p.n_contacts; c++) {
        if (!carrying[c])
            continue;
        sp_contact k = p.contacts[c];
        k.i = number[k.i];
        k.j = k.j >= 0 ? number[k.j] : k.j;
        bare.contacts[contacts++] = k;
    }
    bare.n_contacts = contacts;
    sp_free(number);
    sp_free(carrying);
    sp_free(rattler);
    sp_packing_free(&p);
    return bare;
}

/* Motion without viscosity and without slip, from the packing's positions, tangential springs slack. */
static dynamics make_stick(const sp_packing *p) {
    sp_pack_spec spec = small_spec(1);
    dynamics d;
    spec.grains = p->n;
    spec.friction = 1e6;
    spec.poisson = p->poisson;
    spec.damping = 0;
    assert_ok(dynamics_make(&spec, p->r, p->x, p->box[1], &d, &err));
    assert_ok(dynamics_refresh(&d, &err));
    return d;
}

/* Generalised forces (fx, fy, torque) after every grain has moved by s u (translations, angle). */
static void forces_after(const sp_packing *p, const double *u, double s, double *out) {
    dynamics d = make_stick(p);
    for (int32_t i = 0; i < p->n; i++) {
        grain *g = &d.g[i];
        g->x += s * u[3 * i];
        g->y += s * u[3 * i + 1];
        g->vx = s * u[3 * i];
        g->vy = s * u[3 * i + 1];
        g->w = g->r * s * u[3 * i + 2];
    }
    dynamics_forces(&d, 1.0);
    for (int32_t i = 0; i < p->n; i++) {
        out[3 * i] = d.f[i].x;
        out[3 * i + 1] = d.f[i].y;
        out[3 * i + 2] = d.g[i].r * d.f[i].t;
    }
    dynamics_free(&d);
}

/* Largest |K u - central difference of the forces| over the largest |K u|. */
static double jacobian_error(const sp_packing *p, const sp_network *net, const double *u, double h) {
    const int32_t n = 3 * p->n;
    double *plus = sp_alloc((size_t)n, 8), *minus = sp_alloc((size_t)n, 8), *ku = sp_alloc((size_t)n, 8);
    forces_after(p, u, h, plus);
    forces_after(p, u, -h, minus);
    sp_network_apply(net, u, ku);
    double worst = 0, scale = 0;
    for (int32_t k = 0; k < n; k++) {
        worst = fmax(worst, fabs(ku[k] + (plus[k] - minus[k]) / (2 * h)));
        scale = fmax(scale, fabs(ku[k]));
    }
    sp_free(ku);
    sp_free(minus);
    sp_free(plus);
    return worst / scale;
}

static double *some_displacement(int32_t n) {
    double *u = sp_alloc((size_t)(3 * n), sizeof *u);
    for (int32_t k = 0; k < 3 * n; k++)
        u[k] = sin(12.9898 * k + 1.0);
    return u;
}

static void test_stiffness_is_jacobian(void **state) {
    (void)state;
    sp_packing p = make_bare(7);
    sp_network_options with = sp_network_options_default();
    with.threshold = 0;
    with.prestress = true;
    sp_network net = sp_network_none();
    assert_ok(sp_network_make(&p, &with, &net, &err));
    assert_int_equal(net.n, p.n);
    double *u = some_displacement(p.n);
    double e1 = jacobian_error(&p, &net, u, 4e-6), e2 = jacobian_error(&p, &net, u, 2e-6);
    printf("Jacobian error %.3g, at half the step %.3g\n", e1, e2);
    assert_true(e2 < 1e-5);
    assert_close(log2(e1 / e2), 2.0, 0.15); /* central differences: h^2 */

    /* without prestress the difference is -F_n/r times the transverse part of u_j - u_i, nothing else */
    sp_network_options without = with;
    without.prestress = false;
    sp_network plain = sp_network_none();
    assert_ok(sp_network_make(&p, &without, &plain, &err));
    double *a = sp_alloc((size_t)(3 * p.n), 8), *b = sp_alloc((size_t)(3 * p.n), 8);
    sp_network_apply(&net, u, a);
    sp_network_apply(&plain, u, b);
    for (int32_t c = 0; c < p.n_contacts; c++) {
        const sp_contact *k = &p.contacts[c];
        if (k->j < 0)
            continue;
        double r = p.r[k->i] + p.r[k->j] - k->overlap, t[2] = {-k->n[1], k->n[0]};
        double across = (u[3 * k->j] - u[3 * k->i]) * t[0] + (u[3 * k->j + 1] - u[3 * k->i + 1]) * t[1];
        for (int x = 0; x < 2; x++) {
            b[3 * k->i + x] += k->fn / r * across * t[x];
            b[3 * k->j + x] -= k->fn / r * across * t[x];
        }
    }
    for (int32_t k = 0; k < 3 * p.n; k++)
        assert_close(b[k], a[k], 1e-14);
    sp_free(a);
    sp_free(b);
    sp_free(u);
    sp_network_free(&plain);
    sp_network_free(&net);
    sp_packing_free(&p);
}

/* Newton's third law and torques: what the grains give each other sums to nothing but the walls' forces. */
static void test_momentum(void **state) {
    (void)state;
    sp_packing p = make_bare(3);
    double *u = some_displacement(p.n), *f = sp_alloc((size_t)(3 * p.n), 8);
    dynamics d = make_stick(&p);
    for (int32_t i = 0; i < p.n; i++)
        d.g[i].vx = 1e-3 * u[3 * i];
    d.law.friction = 0.5;
    d.law.damping = 0.8;
    for (int32_t k = 0; k < d.inner.n; k++)
        d.inner.c[k] = 0.3;
    dynamics_forces(&d, 1.0);
    double sum = 0, scale = 0;
    for (int32_t i = 0; i < p.n; i++) {
        sum += d.f[i].y;
        scale += fabs(d.f[i].y);
    }
    assert_close(sum, d.wall_force[0] - d.wall_force[1], 1e-13 * scale);
    dynamics_free(&d);
    sp_free(f);
    sp_free(u);
    sp_packing_free(&p);
}

/* The two lists together find what all pairs find, while grains fly about. */
static void test_lists_equal_brute_force(void **state) {
    (void)state;
    sp_pack_spec spec = small_spec(11);
    double *r = sp_alloc(60, 8), *x = sp_alloc(180, 8), height;
    spec = sp_pack_spec_resolve(&spec);
    sp_radii_draw(&spec, r);
    assert_ok(sp_gas_make(&spec, r, x, &height, &err));
    dynamics d;
    assert_ok(dynamics_make(&spec, r, x, height, &d, &err));
    for (int32_t i = 0; i < d.n; i++) {
        d.g[i].vx = 0.05 * sin(3.0 * i);
        d.g[i].vy = 0.05 * cos(7.0 * i);
    }
    int32_t seen = 0;
    d.dt = 0.1;
    for (int step = 0; step < 3000; step++) {
        assert_ok(dynamics_refresh(&d, &err));
        dynamics_forces(&d, 0.1);
        int32_t open = 0, brute = 0;
        for (int32_t k = 0; k < d.inner.n; k++)
            open += d.inner.kn[k] > 0;
        for (int32_t i = 0; i < d.n; i++)
            for (int32_t j = i + 1; j < d.n; j++) {
                double dx = d.g[j].x - d.g[i].x, dy = d.g[j].y - d.g[i].y, reach = d.g[i].r + d.g[j].r;
                dx -= d.width * nearbyint(dx / d.width);
                brute += sqrt(dx * dx + dy * dy) < reach;
            }
        assert_int_equal(open, brute);
        seen += brute;
        dynamics_advance(&d, 0.1);
    }
    assert_true(seen > 1000);
    assert_true(d.rebuilds > 3 && d.refills < 2000);
    dynamics_free(&d);
    sp_free(x);
    sp_free(r);
}

/* Without friction and viscosity a collision keeps its energy; leapfrog's error falls with the square of the step. */
static double energy_error(double dt) {
    sp_pack_spec spec = small_spec(1);
    spec.grains = 2;
    spec.friction = 0;
    spec.damping = 0;
    const double r[2] = {0.5, 0.5}, x[6] = {3, 4, 0, 4.2, 4.1, 0};
    dynamics d;
    assert_ok(dynamics_make(&spec, r, x, 8, &d, &err));
    d.pressure = 0;
    d.g[0].vx = 0.05;
    d.g[1].vx = -0.05;
    d.dt = dt;
    d.v_max = 0.05;
    for (double t = 0; t < 20; t += dt) {
        assert_ok(dynamics_refresh(&d, &err));
        dynamics_forces(&d, dt);
        dynamics_advance(&d, dt);
    }
    double before = 2 * 0.05 * 0.05, after = 0;
    for (int i = 0; i < 2; i++)
        after += d.g[i].vx * d.g[i].vx + d.g[i].vy * d.g[i].vy;
    assert_true(d.g[0].vx < 0); /* it did collide */
    dynamics_free(&d);
    return fabs(after / before - 1);
}

static void test_energy(void **state) {
    (void)state;
    assert_true(energy_error(0.01) < 1e-5);
    assert_true(energy_error(0.1) < 1e-3);
}

static void test_allocation_failures(void **state) {
    (void)state;
    for (int64_t k = 0; k < 60; k++) {
        sp_pack_spec spec = small_spec(2);
        spec.max_steps = 400;
        sp_packing p = sp_packing_none();
        sp_error err = {0};
        sp_alloc_fail_after(k);
        sp_status status = sp_packing_make(&spec, NULL, NULL, &p, &err);
        sp_alloc_fail_after(-1);
        assert_true(status == SP_ENOMEM || status == SP_EFAILED);
        assert_null(p.x);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_stiffness_is_jacobian),   cmocka_unit_test(test_momentum),
        cmocka_unit_test(test_lists_equal_brute_force), cmocka_unit_test(test_energy),
        cmocka_unit_test(test_allocation_failures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
