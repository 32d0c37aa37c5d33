/* Signals of networks with tangential forces at rest, whose stiffness is not symmetric: against Taylor's series of the
 * motion, step by step; what needs symmetry refuses. */
#include "carried.h"

#include <sonopack/elastic.h>
#include <sonopack/modes.h>
#include <sonopack/signal.h>
#include <sonopack/spectrum.h>

/* ---- the motion by Taylor's series ---------------------------------------------------------------------------- */

/* (u, v) after h: u(h) = sum_j (-A)^j (u h^2j/(2j)! + v h^(2j+1)/(2j+1)!), A = M^-1 J. work: [4][n]. */
static void taylor_step(const sp_network *net, double h, double *u, double *v, double *work) {
    const int64_t n = sp_network_dofs(net);
    double *x = work, *y = work + n, *ax = work + 2 * n, *ay = work + 3 * n, even = 1, odd = h, before = 0;
    memcpy(x, u, (size_t)n * sizeof *x);
    memcpy(y, v, (size_t)n * sizeof *y);
    for (int64_t k = 0; k < n; k++) {
        u[k] = x[k] + h * y[k];
        v[k] = y[k];
    }
    for (int j = 1; j <= 14; j++) {
        sp_network_apply(net, x, ax);
        sp_network_apply(net, y, ay);
        before = odd;
        even *= h * h / ((2.0 * j - 1) * (2.0 * j));
        odd *= h * h / ((2.0 * j) * (2.0 * j + 1));
        for (int64_t k = 0; k < n; k++) {
            x[k] = -ax[k] / net->mass[k];
            y[k] = -ay[k] / net->mass[k];
            u[k] += even * x[k] + odd * y[k];
            v[k] += before * x[k] + even * y[k];
        }
    }
}

/* F at `points` times up to `until`, at every detector; u at the end is left in *end. */
static void taylor_signal(const sp_network *net, sp_source source, const sp_place *from, int detectors,
                          const sp_place *to, double until, int points, double *f, double *end) {
    const int64_t n = sp_network_dofs(net);
    double *u = calloc(6 * (size_t)n, sizeof *u), *v = u + n, *work = u + 2 * n;
    RELEASED double *seen = calloc((size_t)detectors * (size_t)n, sizeof *seen);
    assert_ok(sp_network_source_at(net, source, from, source == SP_SOURCE_DISPLACEMENT ? u : v, &err));
    for (int64_t k = 0; k < n; k++)
        v[k] /= net->mass[k];
    for (int d = 0; d < detectors; d++)
        assert_ok(sp_network_detector_at(net, &to[d], seen + d * n, &err));
    const double gap = until / (points - 1);
    const int steps = 1 + (int)(gap * sp_network_omega_bound(net));
    for (int l = 0; l < points; l++) {
        for (int s = 0; s < steps && l > 0; s++)
            taylor_step(net, gap / steps, u, v, work);
        for (int d = 0; d < detectors; d++) {
            double sum = 0;
            for (int64_t k = 0; k < n; k++)
                sum += seen[d * n + k] * u[k];
            f[d * points + l] = sum;
        }
    }
    memcpy(end, u, (size_t)n * sizeof *u);
    free(u);
}

static sp_packing packed(int dim, double pressure, uint64_t seed) {
    sp_pack_spec spec = sp_pack_spec_default();
    sp_packing p = sp_packing_none();
    spec.dim = dim;
    spec.grains = dim == 2 ? 60 : 100;
    spec.width = dim == 2 ? 6 : 5;
    spec.pressure = pressure;
    spec.seed = seed;
    assert_ok(sp_packing_make(&spec, NULL, NULL, &p, &err));
    return p;
}

static sp_network usual_network(const sp_packing *p) { return network_with(p, .prestress = true); }

/* Both sources, one pair and several, whichever of the two is carried, and the field of displacements: each within its
 * error, which is small. */
TEST(test_signals) {
    enum { POINTS = 9, PLACES = 3 };
    static const int halves[] = {0, 3, 5, 6}; /* of the eight: each value of the three as often as the other */
    for (int h = 0; h < 4; h++) {
        const int q = halves[h], dim = 2 + q % 2;
        const sp_source source = q & 4 ? SP_SOURCE_DISPLACEMENT : SP_SOURCE_IMPULSE;
        FREED(sp_packing) p = packed(dim, q & 2 ? 1e-2 : 1e-4, 11 + (unsigned)q);
        FREED(sp_network) net = usual_network(&p);
        const int64_t n = sp_network_dofs(&net);
        const double height = net.box[dim - 1], until = 40 * 2 * 3.14159265358979 / sp_network_omega_bound(&net);
        const sp_place wall = sp_place_wall();
        const sp_place to[PLACES] = {
            wall, {.kind = SP_PLACE_PLANE, .height = 0.5 * height}, {.kind = SP_PLACE_WALL, .shear = true}};
        double f[PLACES * POINTS], *end = calloc((size_t)n, sizeof *end), *u = calloc((size_t)n, sizeof *u), peak = 0;
        assert_true(sp_network_skew(&net) > 0);
        taylor_signal(&net, source, &wall, PLACES, to, until, POINTS, f, end);
        for (int way = 0; way < 3; way++) { /* one pair; one source; three sources, more than detectors */
            const sp_place from[PLACES] = {to[2], wall, wall};
            sp_signal_options o = sp_signal_options_default();
            FREED(sp_signal) s = sp_signal_none();
            o.source = source;
            o.until = until;
            o.points = POINTS;
            o.tolerance = 1e-9;
            o.sources = way == 2 ? PLACES : 1;
            o.from = way == 2 ? from : &wall;
            o.detectors = way == 1 ? PLACES : 1;
            o.to = to;
            assert_ok(sp_signal_make(&net, &o, &s, &err));
            assert_int_equal(s.method, SP_SIGNAL_CHEBYSHEV);
            for (int d = 0; d < o.detectors; d++) {
                const double *at = s.f + ((way == 2 ? 1 : 0) * o.detectors + d) * POINTS;
                peak = 0;
                for (int l = 0; l < POINTS; l++)
                    peak = fmax(peak, fabs(f[d * POINTS + l]));
                assert_true(s.error < 1e-9 * peak || d > 0);
                for (int l = 0; l < POINTS; l++)
                    assert_close(at[l], f[d * POINTS + l], s.error + 1e-12 * peak);
            }
        }
        const double times[] = {0, until};
        const sp_field_options first = {.source = source, .times = 1, .t = times},
                               spec = {.source = source, .times = 1, .t = times + 1};
        double error;
        assert_ok(sp_signal_field(&net, &first, u, &error, &err));
        assert_true(source == SP_SOURCE_DISPLACEMENT || error < 1e-15);
        assert_ok(sp_signal_field(&net, &spec, u, &error, &err));
        for (int64_t k = 0; k < n; k++)
            peak = fmax(peak, fabs(end[k]));
        for (int64_t k = 0; k < n; k++)
            assert_close(u[k], end[k], error + 1e-12 * peak);
        assert_true(error < 1e-9 * peak);
        free(end);
        free(u);
    }
}

/* What needs symmetry says so, all of it in the same words. */
TEST(test_refusals) {
    FREED(sp_packing) p = packed(2, 1e-4, 5);
    FREED(sp_network) net = usual_network(&p);
    const sp_signal_method methods[] = {SP_SIGNAL_DENSE, SP_SIGNAL_SPARSE, SP_SIGNAL_VERLET, SP_SIGNAL_LAX_WENDROFF,
                                        SP_SIGNAL_FABER};
    sp_error reason = {0};
    for (size_t k = 0; k < sizeof methods / sizeof *methods; k++) {
        sp_signal_options o = sp_signal_options_default();
        sp_signal s = sp_signal_none();
        o.until = 10;
        o.method = methods[k];
        assert_int_equal(sp_signal_make(&net, &o, &s, &reason), SP_EREFUSED);
        assert_true(test_names(reason.text, sp_signal_method_name(methods[k])));
    }
    const sp_modes_options o = sp_modes_options_default();
    const sp_modes_range ranges[] = {sp_modes_range_all(), sp_modes_range_lowest(5), sp_modes_range_band(0.1, 0.2)};
    for (int k = 0; k < 3; k++) {
        sp_modes m = sp_modes_none();
        assert_int_equal(sp_modes_make(&net, &o, &ranges[k], &m, &reason), SP_EREFUSED);
        assert_true(*reason.text);
    }
}

/* Every allocation of what a network without symmetry needs fails once: the reason is told, nothing is left behind. */
TEST(test_no_memory) {
    FREED(sp_packing) p = packed(2, 1e-4, 6);
    sp_network net = usual_network(&p), other = sp_network_none();
    const sp_place wall = sp_place_wall();
    sp_signal_options o = sp_signal_options_default();
    sp_network_options n = sp_network_options_default();
    sp_signal s = sp_signal_none();
    sp_moduli m;
    sp_stability verdict;
    o.until = 5;
    o.from = o.to = &wall;
    n.prestress = true;
    EACH_ALLOCATION_FAILS(4, sp_network_make(&p, &n, &other, &err), sp_network_free(&other));
    EACH_ALLOCATION_FAILS(10, sp_signal_make(&net, &o, &s, &err), sp_signal_free(&s));
    EACH_ALLOCATION_FAILS(4, sp_moduli_make(&net, 0.5, &m, &err), );
    EACH_ALLOCATION_FAILS(4, sp_stability_make(&p, &net, &verdict, &err), );
    sp_network_free(&net);
}

RUN_TESTS(NULL, NULL)
