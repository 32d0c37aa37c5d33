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
    sp_gradient g = gradient_of(net, with);
    const double value = g.value;
    sp_gradient_free(&g);
    return value;
}

/* Some springs or grains of all kinds, among them those of source and detector. */
static void compare(const sp_packing *p, bool prestress, functional_case *c, double h) {
    sp_network net = network_of(p, prestress);
    c->o.packing = p;
    c->o.parameters = SP_BY_KN | SP_BY_KT | SP_BY_MASS | (p->dim > 1 ? SP_BY_RADIUS | SP_BY_POSITION : 0);
    sp_gradient g = gradient_of(&net, c);
    double size = 0;
    for (int k = 0; k < net.n_springs; k++)
        size += fabs(net.springs[k].kn * g.kn.d[k]);
    assert_true(g.homogeneity_size > 0 && fabs(g.homogeneity) < 1e-11 * g.homogeneity_size);
    static const sp_parameter all[] = {SP_BY_KN, SP_BY_KT, SP_BY_MASS, SP_BY_RADIUS, SP_BY_POSITION};
    for (size_t q = 0; q < 5; q++) {
        const sp_partials *d = partials_of(&g, all[q]);
        for (int64_t k = 0; k < d->n; k += d->n / 7 + 1) {
            const int64_t at = d->n - 1 - k; /* from the walls on */
            if (all[q] == SP_BY_POSITION && at % 3 >= p->dim) {
                assert_true(d->d[at] == 0);
                continue;
            }
            assert_derivative(p, prestress, (parameter){all[q], (int)at}, d->d[at], h, value_of, c, size);
            assert_true(d->error[at] >= 0 && d->error[at] < 1e-8 * size);
        }
    }
    sp_gradient_free(&g);
    sp_network_free(&net);
}

static functional_case case_of(double t) {
    functional_case c = {.o = sp_sensitivity_options_default(), .t = {0.4 * t, 0.8 * t, t}};
    return c;
}

static void test_disks(void **state) {
    (void)state;
    static const int orders[TIMES] = {0, 1, 2};
    sp_pack_spec spec = sp_pack_spec_default();
    spec.grains = 40;
    spec.width = 5;
    sp_packing p = make_packing(&spec);
    functional_case c = case_of(60);
    follow(&p);
    compare(&p, false, &c, 1e-3);
    c.order = orders;
    compare(&p, false, &c, 1e-3);
    c.o.source = SP_SOURCE_DISPLACEMENT;
    compare(&p, false, &c, 1e-3);
    c.o.source = SP_SOURCE_VELOCITY;
    compare(&p, false, &c, 1e-3);
    sp_packing_free(&p);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_disks)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
