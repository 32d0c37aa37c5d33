/* Derivatives of frequencies, moduli and signals at all times; the pressure. */
#include "cells.h"
#include "sensitivity_changes.h"

#include <sonopack/modes.h>

static sp_packing disks(int grains, double friction, double pressure) {
    sp_pack_spec spec = sp_pack_spec_default();
    spec.grains = grains;
    spec.width = 5;
    spec.friction = friction;
    spec.pressure = pressure;
    sp_packing p = make_packing(&spec);
    follow(&p);
    return p;
}

static const sp_parameter ALL[] = {SP_BY_KN, SP_BY_KT, SP_BY_MASS, SP_BY_RADIUS, SP_BY_POSITION};
enum { KINDS = 5, EVERY = SP_BY_KN | SP_BY_KT | SP_BY_MASS | SP_BY_RADIUS | SP_BY_POSITION };

/* The gradient against differences at a few places of each kind. noise: of the quantity over that of assert_derivative.
 */
static void compare(const sp_packing *p, bool prestress, const sp_gradient *g, quantity *of, void *with, double noise) {
    FREED(sp_network) net = network_of(p, prestress);
    const double size = noise * g->value;
    for (int q = 0; q < KINDS; q++) {
        const sp_partials *d = partials_of(g, ALL[q]);
        for (int64_t k = 0; k < d->n; k += SANITIZED_STEP(3) * (d->n / 5 + 1)) {
            const int64_t at = d->n - 1 - k;
            if (ALL[q] == SP_BY_POSITION && at % 3 >= p->dim)
                continue;
            const parameter by = {ALL[q], (int)at};
            assert_derivative(p, prestress, by, d->d[at], 1e-3, of, with, size);
            assert_true(d->error[at] >= 0 && d->error[at] * scale_of(&net, p, by) < 1e-6 * g->value);
        }
    }
    assert_true(fabs(g->homogeneity) < 1e-10 * g->homogeneity_size);
}

/* ---- frequencies ---------------------------------------------------------------------------------------------- */

typedef struct mode_case {
    int64_t row, count;
} mode_case;

static sp_modes modes_of(const sp_network *net) {
    sp_modes_options o = sp_modes_options_default();
    const sp_modes_range all = sp_modes_range_all();
    sp_modes m = sp_modes_none();
    o.vectors = true;
    o.solver = SP_SOLVER_DENSE;
    assert_ok(sp_modes_make(net, &o, &all, &m, &err));
    return m;
}

static double mean_square(const sp_network *net, void *with) {
    const mode_case *c = with;
    FREED(sp_modes) m = modes_of(net);
    double sum = 0;
    for (int64_t k = c->row; k < c->row + c->count; k++)
        sum += m.omega[k] * m.omega[k] / (double)c->count;
    return sum;
}

static void compare_modes(const sp_packing *p, bool prestress, mode_case c) {
    FREED(sp_network) net = network_of(p, prestress);
    FREED(sp_modes) m = modes_of(&net);
    FREED(sp_gradient) g;
    assert_ok(sp_sensitivity_modes(&net, &m, c.row, c.count, EVERY, p, &g, &err));
    assert_true(fabs(g.value - mean_square(&net, &c)) <= g.error + 1e-15);
    compare(p, prestress, &g, mean_square, &c, 30);
}

TEST(test_modes) {
    FREED(sp_packing) p = disks(40, 0.5, 1e-4);
    compare_modes(&p, false, (mode_case){14, 1});
    compare_modes(&p, false, (mode_case){40, 2});
    sp_packing_free(&p);
    p = disks(40, 0, 1e-3);
    compare_modes(&p, true, (mode_case){3, 1});
    sp_packing_free(&p);
    const sp_pack_spec spec = spheres(60, 5, 0.3, 3);
    p = make_packing(&spec);
    follow(&p);
    compare_modes(&p, false, (mode_case){70, 1});
}

/* Modes of one frequency: only as a group. */
TEST(test_degenerate) {
    FREED(sp_packing) p = cells_triangular(4, 4, 1e-3, 0.5);
    FREED(sp_network) net = network_of(&p, false);
    FREED(sp_modes) m = modes_of(&net);
    sp_gradient g;
    sp_error reason;
    int64_t first = m.n_zero, count = 1;
    while (m.omega[first + count] - m.omega[first] < 1e-9)
        count++;
    assert_true(count > 1);
    assert_int_equal(sp_sensitivity_modes(&net, &m, first, 1, SP_BY_KN, NULL, &g, &reason), SP_EREFUSED);
    assert_int_equal(sp_sensitivity_modes(&net, &m, 0, 1, SP_BY_KN, NULL, &g, &reason), SP_EINVAL);
    mode_case c = {first, count};
    compare_modes(&p, false, c);
}

/* ---- moduli --------------------------------------------------------------------------------------------------- */

typedef struct modulus_case {
    sp_modulus which;
    unsigned parameters;
    const sp_packing *packing;
} modulus_case;

static sp_gradient modulus_gradient(const sp_network *net, const modulus_case *c) {
    sp_gradient g;
    assert_ok(sp_sensitivity_moduli(net, 0.6, 1, &c->which, c->parameters, c->packing, &g, &err));
    return g;
}

static double modulus_value(const sp_network *net, void *with) {
    modulus_case c = *(const modulus_case *)with;
    c.parameters = SP_BY_KN;
    FREED(sp_gradient) g = modulus_gradient(net, &c);
    const double value = g.value;
    return value;
}

static void compare_moduli(const sp_packing *p, bool prestress, int count, const sp_modulus *which) {
    FREED(sp_network) net = network_of(p, prestress);
    for (int k = 0; k < count; k++) {
        modulus_case c = {which[k], EVERY, p};
        FREED(sp_gradient) g = modulus_gradient(&net, &c);
        compare(p, prestress, &g, modulus_value, &c, 30);
    }
}

TEST(test_moduli) {
    static const sp_modulus plane[] = {SP_MODULUS_C11, SP_MODULUS_C12, SP_MODULUS_C22, SP_MODULUS_C33, SP_MODULUS_CL};
    static const sp_modulus space[] = {SP_MODULUS_C33, SP_MODULUS_C55, SP_MODULUS_C13, SP_MODULUS_CT};
    FREED(sp_packing) p = disks(40, 0.5, 1e-4);
    compare_moduli(&p, false, 5, plane);
    sp_packing_free(&p);
    p = disks(60, 0, 1e-3);
    compare_moduli(&p, true, 3, plane);
    sp_packing_free(&p);
    const sp_pack_spec spec = spheres(60, 5, 0.3, 3);
    p = make_packing(&spec);
    follow(&p);
    compare_moduli(&p, false, 4, space);
    sp_packing_free(&p);
    p = cells_triangular(5, 4, 1e-3, 0.5);
    compare_moduli(&p, false, 5, plane);
    FREED(sp_network) net = network_of(&p, false);
    const sp_modulus wrong = SP_MODULUS_C44;
    sp_gradient g;
    sp_error reason;
    assert_int_equal(sp_sensitivity_moduli(&net, 0.6, 1, &wrong, SP_BY_KN, NULL, &g, &reason), SP_EINVAL);
}

/* ---- all times ------------------------------------------------------------------------------------------------ */

static void compare_times(const sp_packing *p, sp_sensitivity_options o) {
    enum { TIMES = 4, SPRINGS = 4 };
    static const double t[TIMES] = {5, 60, 0, 30};
    FREED(sp_network) net = network_of(p, false);
    const int32_t spring[SPRINGS] = {0, net.n_springs / 2, net.n_bulk, net.n_springs - 1};
    double kn[SPRINGS * TIMES], kt[SPRINGS * TIMES], error[2 * SPRINGS];
    assert_ok(sp_sensitivity_times(&net, &o, SPRINGS, spring, TIMES, t, kn, kt, error, &err));
    for (int l = 0; l < TIMES; l++) {
        const double one = 1;
        const sp_functional j = {1, &t[l], &one, NULL};
        FREED(sp_gradient) g;
        assert_ok(sp_sensitivity_signal(&net, &o, 1, &j, &g, &err));
        for (int k = 0; k < SPRINGS; k++) {
            const int at = spring[k];
            assert_true(fabs(kn[k * TIMES + l] - g.kn.d[at]) <= error[2 * k] + g.kn.error[at]);
            if (g.kt.n)
                assert_true(fabs(kt[k * TIMES + l] - g.kt.d[at]) <= error[2 * k + 1] + g.kt.error[at]);
        }
    }
    double largest = 0;
    for (int k = 0; k < SPRINGS * TIMES; k++)
        largest = fmax(largest, fabs(kn[k]));
    for (int k = 0; k < 2 * SPRINGS; k++)
        assert_true(error[k] < 1e-11 * largest);
}

TEST(test_times) {
    sp_sensitivity_options o = sp_sensitivity_options_default();
    FREED(sp_packing) p = disks(40, 0.5, 1e-4);
    compare_times(&p, o);
    o.source = SP_SOURCE_DISPLACEMENT;
    compare_times(&p, o);
    o.source = SP_SOURCE_VELOCITY;
    compare_times(&p, o);
    sp_packing_free(&p);
    o.source = SP_SOURCE_IMPULSE;
    const sp_pack_spec spec = spheres(60, 5, 0.3, 3);
    p = make_packing(&spec);
    compare_times(&p, o);
}

/* ---- pressure ------------------------------------------------------------------------------------------------- */

/* A packing without friction, compressed a little more and a little less, is what the linear response with the forces
 * at rest makes of it, whether or not the network of the quantity has them. */
static void assert_recompressed(const sp_packing *p, bool prestress) {
    static const double h = 2e-4;
    const double one = 1, t = 25;
    const sp_functional j = {1, &t, &one, NULL};
    const sp_modulus which = SP_MODULUS_C22;
    double signal[2], modulus[2];
    for (int k = 0; k < 2; k++) {
        sp_pack_spec spec = sp_pack_spec_default();
        const sp_pack_hooks hooks = {.from = p};
        FREED(sp_packing) q = sp_packing_none();
        FREED(sp_gradient) g;
        spec.kind = SP_PACK_FILE;
        spec.friction = 0;
        spec.pressure = 1e-3 * (k == 0 ? 1 + h : 1 - h);
        spec.tolerance = 1e-13;
        assert_ok(sp_pack_spec_from(&spec, p, &err));
        assert_ok(sp_packing_make_with(&spec, &hooks, &q, &err));
        FREED(sp_network) net = network_of(&q, prestress);
        const sp_sensitivity_options o = sp_sensitivity_options_default();
        assert_ok(sp_sensitivity_signal(&net, &o, 1, &j, &g, &err));
        signal[k] = g.value;
        sp_gradient_free(&g);
        assert_ok(sp_sensitivity_moduli(&net, 0.6, 1, &which, SP_BY_KN, NULL, &g, &err));
        modulus[k] = g.value;
    }
    FREED(sp_network) net = network_of(p, prestress);
    sp_sensitivity_options o = sp_sensitivity_options_default();
    FREED(sp_gradient) g;
    o.parameters = SP_BY_PRESSURE;
    o.packing = p;
    assert_ok(sp_sensitivity_signal(&net, &o, 1, &j, &g, &err));
    double slope = (signal[0] - signal[1]) / (2e-3 * h);
    assert_true(fabs(g.pressure.d[0] - slope) < 1e-3 * fabs(slope) && g.pressure.error[0] < 1e-6 * fabs(slope));
    sp_gradient_free(&g);
    assert_ok(sp_sensitivity_moduli(&net, 0.6, 1, &which, SP_BY_PRESSURE, p, &g, &err));
    slope = (modulus[0] - modulus[1]) / (2e-3 * h);
    assert_true(fabs(g.pressure.d[0] - slope) < 1e-3 * fabs(slope));
}

TEST(test_pressure) {
    FREED(sp_packing) p = disks(60, 0, 1e-3);
    assert_recompressed(&p, true);
    assert_recompressed(&p, false);
}

RUN_TESTS(NULL, NULL)
