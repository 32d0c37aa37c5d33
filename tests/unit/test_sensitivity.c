/* Derivatives of signals and first fronts. */
#include "sensitivity_changes.h"

#include "cells.h"

#define TIMES 3
static const double WEIGHTS[TIMES] = {1, -0.4, 0.7};

typedef struct functional_case {
    sp_sensitivity_options o;
    double t[TIMES];
    const int *order;
} functional_case;

static sp_gradient gradient_of(const sp_network *net, const functional_case *c) {
    const sp_functional j = {TIMES, c->t, WEIGHTS, c->order};
    sp_gradient g = sp_gradient_none();
    assert_ok(sp_sensitivity_signal(net, &c->o, 1, &j, &g, &err));
    return g;
}

static double value_of(const sp_network *net, void *with) {
    FREED(sp_gradient) g = gradient_of(net, with);
    const double value = g.value;
    return value;
}

/* Some springs or grains of all kinds, among them those of source and detector. */
static void compare(const sp_packing *p, bool prestress, functional_case *c, double h) {
    FREED(sp_network) net = network_of(p, prestress);
    c->o.packing = p;
    c->o.parameters = SP_BY_KN | SP_BY_KT | SP_BY_MASS | (p->dim > 1 ? SP_BY_RADIUS | SP_BY_POSITION : 0);
    FREED(sp_gradient) g = gradient_of(&net, c);
    double size = 0;
    for (int k = 0; k < net.n_springs; k++)
        size += fabs(net.springs[k].kn * g.kn.d[k]);
    assert_true(g.homogeneity_size > 0 && fabs(g.homogeneity) < 1e-11 * g.homogeneity_size);
    static const sp_parameter all[] = {SP_BY_KN, SP_BY_KT, SP_BY_MASS, SP_BY_RADIUS, SP_BY_POSITION};
    for (size_t q = 0; q < 5; q++) {
        const sp_partials *d = partials_of(&g, all[q]);
        for (int64_t k = 0; k < d->n; k += SANITIZED_STEP(3) * (d->n / 7 + 1)) {
            const int64_t at = d->n - 1 - k; /* from the walls on */
            if (all[q] == SP_BY_POSITION && at % 3 >= p->dim) {
                assert_true(d->d[at] == 0);
                continue;
            }
            assert_derivative(p, prestress, (parameter){all[q], (int)at}, d->d[at], h, value_of, c, size);
            assert_true(d->error[at] >= 0 &&
                        d->error[at] * scale_of(&net, p, (parameter){all[q], (int)at}) < 1e-8 * size);
        }
    }
}

static functional_case case_of(double t) {
    functional_case c = {.o = sp_sensitivity_options_default(), .t = {0.4 * t, 0.8 * t, t}};
    return c;
}

TEST(test_disks) {
    static const int orders[TIMES] = {0, 1, 2};
    sp_pack_spec spec = sp_pack_spec_default();
    spec.grains = 40;
    spec.width = 5;
    FREED(sp_packing) p = make_packing(&spec);
    functional_case c = case_of(60);
    follow(&p);
    compare(&p, false, &c, 1e-3);
    c.order = orders;
    compare(&p, false, &c, 1e-3);
    c.o.source = SP_SOURCE_DISPLACEMENT;
    compare(&p, false, &c, 1e-3);
    c.o.source = SP_SOURCE_VELOCITY;
    compare(&p, false, &c, 1e-3);
}

TEST(test_spheres) {
    static const int orders[TIMES] = {1, 0, 2};
    sp_pack_spec spec = spheres(60, 5, 0.3, 3);
    FREED(sp_packing) p = make_packing(&spec);
    functional_case c = case_of(60);
    follow(&p);
    compare(&p, false, &c, 1e-3);
    c.o.source = SP_SOURCE_DISPLACEMENT;
    c.order = orders;
    compare(&p, false, &c, 1e-3);
}

/* Without friction K with prestress is symmetric, and its forces at rest follow the positions. */
TEST(test_prestress) {
    sp_pack_spec spec = sp_pack_spec_default();
    spec.grains = 40;
    spec.width = 5;
    spec.friction = 0;
    spec.pressure = 1e-3;
    FREED(sp_packing) p = make_packing(&spec);
    functional_case c = case_of(40);
    follow(&p);
    compare(&p, true, &c, 1e-3);
    compare(&p, false, &c, 1e-3);
    sp_packing_free(&p);
    spec = spheres(60, 5, 0, 3);
    spec.pressure = 1e-3;
    p = make_packing(&spec);
    follow(&p);
    compare(&p, true, &c, 1e-3);
}

TEST(test_chain) {
    FREED(sp_packing) p = chain_packing(12, 1e-4);
    functional_case c = case_of(60);
    compare(&p, false, &c, 1e-3);
}

/* Planes and grains in a cell without walls; a detector of shear; parts of walls. */
TEST(test_places) {
    FREED(sp_packing) p = cells_triangular(6, 6, 1e-3, 0.5);
    const sp_place low = {.kind = SP_PLACE_PLANE, .height = 0.7}, high = {.kind = SP_PLACE_PLANE, .height = 3.1};
    const sp_place one = {.kind = SP_PLACE_GRAIN, .grain = 2, .shear = true},
                   two = {.kind = SP_PLACE_GRAIN, .grain = 20};
    functional_case c = case_of(30);
    c.o.from = &low;
    c.o.to = &high;
    compare(&p, false, &c, 1e-3);
    c.o.from = &one;
    c.o.to = &two;
    compare(&p, false, &c, 1e-3);
    c.o.source = SP_SOURCE_VELOCITY;
    compare(&p, false, &c, 1e-3);
    sp_packing_free(&p);
    sp_pack_spec spec = sp_pack_spec_default();
    spec.grains = 40;
    spec.width = 5;
    p = make_packing(&spec);
    follow(&p);
    const sp_place part = {.kind = SP_PLACE_PART, .shear = true, .from = 0, .to = 4};
    c.o = sp_sensitivity_options_default();
    c.o.from = &part;
    c.o.to = &part;
    compare(&p, false, &c, 1e-3);
}

TEST(test_pulses) {
    static const int orders[TIMES] = {1, 0, 2};
    sp_pack_spec spec = sp_pack_spec_default();
    spec.grains = 40;
    spec.width = 5;
    FREED(sp_packing) p = make_packing(&spec);
    functional_case c = case_of(60);
    follow(&p);
    const sp_pulse gauss = {.kind = SP_PULSE_GAUSS, .width = 3}, ricker = {.kind = SP_PULSE_RICKER, .omega = 0.4};
    c.o.pulse = &gauss;
    c.order = orders;
    compare(&p, false, &c, 1e-3);
    c.o.pulse = &ricker;
    compare(&p, false, &c, 1e-3);
}

/* Values and fronts are those of signals. */
TEST(test_values) {
    FREED(sp_packing) p = reference_packing(REFERENCE("packing_N600_p1e-4.txt"));
    FREED(sp_network) net = network_of(&p, false);
    sp_signal_options o = sp_signal_options_default();
    FREED(sp_signal) s = sp_signal_none();
    sp_front front;
    FREED(sp_front_gradient) g;
    const sp_front_options find = sp_front_options_default();
    o.until = 300;
    o.points = 3001;
    o.tolerance = 1e-12;
    assert_ok(sp_signal_make(&net, &o, &s, &err));
    assert_ok(sp_front_find(s.n, s.t, s.f, &find, &front, &err));
    functional_case c = {.o = sp_sensitivity_options_default(), .t = {s.t[1000], s.t[1500], s.t[2000]}};
    FREED(sp_gradient) j = gradient_of(&net, &c);
    const double value = WEIGHTS[0] * s.f[1000] + WEIGHTS[1] * s.f[1500] + WEIGHTS[2] * s.f[2000];
    assert_true(fabs(j.value - value) <= j.error + 3 * s.error);
    assert_true(j.error < 1e-11 * peak_of(s.n, s.f));
    c.o.until = o.until;
    c.o.points = o.points;
    assert_ok(sp_sensitivity_front(&net, &c.o, SP_FRONT_T10 | SP_FRONT_WIDTH, &g, &err));
    assert_true(fabs(g.sampled.t10 - front.t10) < 1e-9 && fabs(g.sampled.t_peak - front.t_peak) < 1e-6);
    /* linear interpolation between the points */
    assert_true(fabs(g.found.t10 - front.t10) < 2e-3 && fabs(g.found.t_peak - front.t_peak) < 2e-3);
    assert_true(g.t10.value == g.found.t10 && g.t10_error < 1e-9 && g.t_peak_error < 1e-8);
    assert_true(g.peak.kn.n == 0 && g.t10.kn.n == net.n_springs && g.width.kt.n == net.n_springs);
    double sum = 0;
    for (int k = 0; k < net.n_springs; k++)
        sum += net.springs[k].kn * g.t10.kn.d[k] + net.springs[k].kt * g.t10.kt.d[k];
    /* all springs stiffer: the same signal, sooner */
    assert_true(fabs(sum + 0.5 * g.found.t10) < 1e-10 * g.found.t10);
    assert_true(fabs(g.t10.homogeneity) < 1e-11 * g.t10.homogeneity_size);
}

/* Several blocks, which the fields reach one after the other, with two threads; the derivatives against differences in
 * the middle and at the walls. */
TEST(test_blocks) {
    FREED(sp_packing) p = cells_triangular(40, 120, 1e-3, 0.5);
    const sp_place low = {.kind = SP_PLACE_PLANE, .height = 2}, high = {.kind = SP_PLACE_PLANE, .height = 60};
    functional_case c = case_of(200);
    FREED(sp_network) net = network_of(&p, false);
    c.o.from = &low;
    c.o.to = &high;
    c.o.parameters = SP_BY_KN | SP_BY_KT | SP_BY_MASS | SP_BY_POSITION;
    c.o.packing = &p;
    FREED(sp_gradient) g = gradient_of(&net, &c);
    c.o.threads = 2;
    FREED(sp_gradient) h = gradient_of(&net, &c);
    double size = 0;
    for (int k = 0; k < net.n_springs; k++) {
        size += fabs(net.springs[k].kn * g.kn.d[k]);
        assert_true(g.kn.d[k] == h.kn.d[k] && g.kt.d[k] == h.kt.d[k]);
    }
    assert_true(fabs(g.homogeneity) < 1e-11 * g.homogeneity_size);
    c.o.parameters = SP_BY_KN;
    for (int k = 3; k < net.n_springs; k += 2000 * SANITIZED_STEP(4))
        assert_derivative(&p, false, (parameter){SP_BY_KN, k}, g.kn.d[k], 1e-3, value_of, &c, size);
    for (int k = 3; k < net.n; k += 1000 * SANITIZED_STEP(4))
        assert_derivative(&p, false, (parameter){SP_BY_MASS, k}, g.mass.d[k], 1e-3, value_of, &c, size);
}

typedef struct front_case {
    sp_sensitivity_options o;
    sp_front_quantity which;
} front_case;

static sp_gradient *part_of(sp_front_gradient *g, sp_front_quantity which) {
    switch (which) {
    case SP_FRONT_T10: return &g->t10;
    case SP_FRONT_T_PEAK: return &g->t_peak;
    case SP_FRONT_PEAK: return &g->peak;
    case SP_FRONT_T_ZERO: return &g->t_zero;
    default: return &g->width;
    }
}

static double front_value(const sp_network *net, void *with) {
    front_case *c = with;
    FREED(sp_front_gradient) g;
    c->o.parameters = SP_BY_KN;
    assert_ok(sp_sensitivity_front(net, &c->o, c->which, &g, &err));
    const double value = part_of(&g, c->which)->value;
    return value;
}

static void compare_fronts(const sp_packing *p, front_case *c) {
    FREED(sp_network) net = network_of(p, false);
    for (int q = 0; q < 5; q += SANITIZED_STEP(4)) {
        FREED(sp_front_gradient) g;
        c->which = (sp_front_quantity)(1 << q);
        c->o.parameters = SP_BY_KN | SP_BY_KT | SP_BY_MASS | SP_BY_RADIUS | SP_BY_POSITION;
        c->o.packing = p;
        assert_ok(sp_sensitivity_front(&net, &c->o, c->which, &g, &err));
        const sp_gradient *d = part_of(&g, c->which);
        double size = 0;
        for (int k = 0; k < net.n_springs; k++)
            size += fabs(net.springs[k].kn * d->kn.d[k]);
        static const sp_parameter all[] = {SP_BY_KN, SP_BY_KT, SP_BY_MASS, SP_BY_RADIUS, SP_BY_POSITION};
        for (int a = 0; a < 5; a++) {
            const int at = (int)(partials_of(d, all[a])->n / 2) / 3 * 3;
            assert_derivative(p, false, (parameter){all[a], at}, partials_of(d, all[a])->d[at], 1e-3, front_value, c,
                              100 * size);
        }
    }
}

TEST(test_fronts) {
    sp_pack_spec spec = sp_pack_spec_default();
    spec.grains = 80;
    spec.width = 5;
    FREED(sp_packing) p = make_packing(&spec);
    follow(&p);
    front_case c = {.o = sp_sensitivity_options_default()};
    compare_fronts(&p, &c);
    const sp_pulse gauss = {.kind = SP_PULSE_GAUSS, .width = 3};
    c.o.pulse = &gauss;
    compare_fronts(&p, &c);
}

TEST(test_refusals) {
    sp_pack_spec spec = sp_pack_spec_default();
    spec.grains = 40;
    spec.width = 5;
    FREED(sp_packing) p = make_packing(&spec);
    FREED(sp_network) net = network_of(&p, false), held = network_of(&p, true);
    const double t[1] = {30}, back[1] = {-1}, one[1] = {1};
    const int high[1] = {3};
    const sp_functional good = {1, t, one, NULL}, none = {0, t, one, NULL}, early = {1, back, one, NULL};
    const sp_functional steep = {1, t, one, high};
    sp_sensitivity_options o = sp_sensitivity_options_default();
    sp_gradient g = sp_gradient_none();
    sp_front_gradient f;
    sp_error reason;
    assert_int_equal(sp_sensitivity_signal(&net, &o, 1, &none, &g, &reason), SP_EINVAL);
    assert_int_equal(sp_sensitivity_signal(&net, &o, 1, &early, &g, &reason), SP_EINVAL);
    assert_int_equal(sp_sensitivity_signal(&net, &o, 1, &steep, &g, &reason), SP_EINVAL);
    assert_int_equal(sp_sensitivity_signal(&net, &o, 0, &good, &g, &reason), SP_EINVAL);
    assert_int_equal(sp_sensitivity_signal(&held, &o, 1, &good, &g, &reason), SP_EREFUSED);
    o.parameters = 64;
    assert_int_equal(sp_sensitivity_signal(&net, &o, 1, &good, &g, &reason), SP_EINVAL);
    o.parameters = SP_BY_RADIUS; /* without the packing */
    assert_int_equal(sp_sensitivity_signal(&net, &o, 1, &good, &g, &reason), SP_EINVAL);
    o.parameters = SP_BY_KN;
    assert_int_equal(sp_sensitivity_front(&net, &o, 0, &f, &reason), SP_EINVAL);
    o.until = 5; /* before the peak */
    assert_int_equal(sp_sensitivity_front(&net, &o, SP_FRONT_T10, &f, &reason), SP_EREFUSED);
    const sp_pulse square = {.kind = SP_PULSE_SQUARE, .width = 3};
    o.pulse = &square;
    assert_int_equal(sp_sensitivity_signal(&net, &o, 1, &good, &g, &reason), SP_EINVAL);
}

/* Every allocation fails once: the reason is told, and nothing is left behind (the checks of memory see that). */
TEST(test_memory) {
    sp_pack_spec spec = sp_pack_spec_default();
    spec.grains = 30;
    spec.width = 5;
    FREED(sp_packing) p = make_packing(&spec);
    FREED(sp_network) net = network_of(&p, false);
    sp_sensitivity_options o = sp_sensitivity_options_default();
    sp_status status = SP_ENOMEM;
    o.packing = &p;
    o.parameters = SP_BY_KN | SP_BY_KT | SP_BY_MASS | SP_BY_RADIUS | SP_BY_POSITION;
    o.points = 100;
    int count = 0;
    for (; status != SP_OK; count += count < 60 ? 1 : 7) {
        sp_front_gradient g;
        sp_error reason = {0};
        sp_alloc_fail_after(count);
        status = sp_sensitivity_front(&net, &o, SP_FRONT_T10, &g, &reason);
        sp_alloc_fail_after(-1);
        assert_true(status == SP_OK || status == SP_ENOMEM);
        if (status == SP_OK)
            sp_front_gradient_free(&g);
    }
    assert_true(count > 50);
}

RUN_TESTS(NULL, NULL)
