/* What the expansion does beyond one pair of small networks: blocks that sleep, threads, many places in one pass,
 * signals that end with their fronts. */
#include "base/base.h"
#include "carried.h"
#include "extended.h"
#include "signal/recurrence.h"
#include "signals.h"

#include <sonopack/front.h>

static sp_signal_options options_of(sp_source source, double until, int points) {
    sp_signal_options o = sp_signal_options_default();
    o.method = SP_SIGNAL_CHEBYSHEV;
    o.source = source;
    o.until = until;
    o.points = points;
    return o;
}

/* All pairs of sources and detectors against long double; the bound is never below the error. */
static void check_places(const char *name, const sp_network *net, sp_signal_options o) {
    const size_t n = (size_t)sp_network_dofs(net);
    double *sent = calloc(2 * n, sizeof *sent), *seen = sent + n, *exact = calloc((size_t)o.points, sizeof *exact);
    FREED(sp_signal) s = sp_signal_none();
    assert_ok(sp_signal_make(net, &o, &s, &err));
    assert_true(s.sources == (o.from ? o.sources : 1) && s.detectors == (o.to ? o.detectors : 1));
    for (int a = 0; a < s.sources; a++)
        for (int b = 0; b < s.detectors; b++) {
            const sp_place wall = sp_place_wall();
            assert_ok(sp_network_source_at(net, o.source, o.from ? &o.from[a] : &wall, sent, &err));
            assert_ok(sp_network_detector_at(net, o.to ? &o.to[b] : &wall, seen, &err));
            extended_signal_of(net, sent, seen, o.source != SP_SOURCE_DISPLACEMENT, s.n, s.t, exact);
            const double *f = s.f + ((int64_t)a * s.detectors + b) * s.n, bound = s.errors[a * s.detectors + b];
            const double error = difference(s.n, f, exact);
            if (!(error <= bound))
                fail_msg("%s: source %d of %d, detector %d of %d, until %g: error %g above its bound %g (peak %g)",
                         name, a, s.sources, b, s.detectors, o.until, error, bound, peak_of(s.n, exact));
            assert_true(bound <= 1e-9 * fmax(peak_of(s.n, exact), 1e-5));
        }
    free(exact);
    free(sent);
}

TEST(test_places) {
    const struct {
        const char *name;
        sp_packing p;
        bool prestress;
    } all[] = {{"2D", scattered_packing(2, 8, 0.5, 1), false},
               {"2D without friction", scattered_packing(2, 8, 0, 2), false},
               {"3D", scattered_packing(3, 4, 0.5, 3), false},
               {"3D without friction", scattered_packing(3, 4, 0, 4), false},
               {"reference", without_tangential(reference_packing(REFERENCE("packing_N200_p1e-4.txt"))), true}};
    const double spans[] = {2, 12, 90};
    const int counts[][2] = {{1, 2}, {1, 5}, {3, 1}, {2, 2}, {5, 3}};
    for (size_t q = 0; q < sizeof all / sizeof *all; q++) {
        FREED(sp_packing) p = all[q].p;
        FREED(sp_network) net = network_of(&p, all[q].prestress);
        sp_place from[5], to[5];
        for (int k = 0; k < 5; k++) {
            from[k] = (sp_place){.kind = SP_PLACE_GRAIN, .grain = net.grain[k * (net.n - 1) / 5], .shear = k == 2};
            to[k] = (sp_place){.kind = k == 4 ? SP_PLACE_GRAIN : SP_PLACE_PLANE,
                               .grain = net.grain[net.n / 2],
                               .height = net.box[net.dim - 1] * (k + 1.37) / 6};
        }
        for (size_t span = 0; span < (q < 4 ? 3 : 2); span++)
            for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
                sp_signal_options o = options_of(c % 2 ? SP_SOURCE_DISPLACEMENT : SP_SOURCE_IMPULSE, spans[span], 11);
                o.from = counts[c][0] > 1 ? from : NULL;
                o.sources = counts[c][0];
                o.to = counts[c][1] > 1 ? to : NULL;
                o.detectors = counts[c][1];
                o.tolerance = 1e-9;
                check_places(all[q].name, &net, o);
            }
    }
}

/* Blocks that nothing has reached sleep, and the bound allows for what was dropped there. */
TEST(test_sleep) {
    FREED(sp_packing) p = chain_packing(2600, 1e-4);
    FREED(sp_network) net = network_of(&p, false);
    const double spans[] = {300, 2600}; /* sound takes some 4900 */
    FREED(sp_operator) op = {0};
    recurrence r = {0};
    int64_t at[2] = {0, 0};
    double one[2] = {1, 1};
    assert_ok(sp_operator_make(&net, &op, &err));
    assert_ok(sp_recurrence_make(&op, net.mass, net.omega_bound, 1, &r, &err));
    assert_true(op.blocks == 3);
    at[1] = 2L * op.row_of[net.n - 1];
    for (int lane = 0; lane < 2; lane++)
        sp_recurrence_start(&r, lane, true, &(sparse_row){1, &at[lane], &one[lane]});
    r.doubled = true;
    for (int k = 0; k < 700; k++) {
        sp_recurrence_step(&r);
        assert_true(r.n_active == 3 && r.awake[0] && r.awake[2] && r.awake[1] == 0);
    }
    assert_true(r.dropped == 0 || sp_recurrence_dropped(&r, 700) < 1e-25);
    sp_recurrence_free(&r);
    for (size_t k = 0; k < sizeof spans / sizeof *spans; k++) {
        const sp_place to[] = {{.kind = SP_PLACE_GRAIN, .grain = 800}, {.kind = SP_PLACE_GRAIN, .grain = 1500}};
        sp_signal_options o = options_of(SP_SOURCE_IMPULSE, spans[k], 11);
        if (k == 0) {
            o.to = to;
            o.detectors = 2;
        }
        check_places("long chain", &net, o);
    }
}

static sp_packing lattice_packing(int side) {
    sp_pack_spec spec = sp_pack_spec_default();
    sp_packing p = sp_packing_none();
    spec.kind = SP_PACK_TRIANGULAR;
    spec.grains = side * side;
    spec.width = side;
    spec.diameter_min = spec.diameter_max = 1;
    spec.pressure = 1e-4;
    assert_ok(sp_packing_make(&spec, NULL, NULL, &p, &err));
    return p;
}

/* The same bits for any number of threads, and by any vectors. */
TEST(test_threads) {
    FREED(sp_packing) p = lattice_packing(185);
    FREED(sp_network) net = network_of(&p, false);
    sp_signal_options o = options_of(SP_SOURCE_IMPULSE, 60, 31);
    const sp_place to[] = {{.kind = SP_PLACE_PLANE, .height = 11.1}, {.kind = SP_PLACE_PLANE, .height = 5.5}};
    o.to = to;
    o.detectors = 2;
    FREED(sp_signal) one = sp_signal_none();
    FREED(sp_operator) op = {0};
    assert_ok(sp_signal_make(&net, &o, &one, &err));
    assert_true(peak_of(one.n, one.f) > 0);
    for (int threads = 2; threads < 8; threads += 3) {
        FREED(sp_signal) s = sp_signal_none();
        o.threads = threads;
        assert_ok(sp_signal_make(&net, &o, &s, &err));
        assert_memory_equal(s.f, one.f, 2 * (size_t)s.n * sizeof *s.f);
        assert_true(s.error == one.error);
    }
    assert_ok(sp_operator_make(&net, &op, &err));
    assert_true(op.blocks > 32); /* enough for several threads */
    recurrence r[2] = {{0}, {0}};
    int64_t at[2] = {3 * op.row, (op.n - 2) * (int64_t)op.row + 2};
    double ones[2] = {1, 1};
    const bool wide = op.wide;
    for (int q = 0; q < 2; q++) {
        assert_ok(sp_recurrence_make(&op, net.mass, net.omega_bound, 1 + q, &r[q], &err));
        r[q].doubled = true;
        assert_true((r[q].pool != NULL) == (q == 1));
        r[q].past_caches = q == 0;
        for (int lane = 0; lane < 2; lane++)
            sp_recurrence_start(&r[q], lane, lane == 0, &(sparse_row){1, &at[lane], &ones[lane]});
    }
    for (int k = 0; k < 40; k++) {
        op.wide = wide;
        const recurrence_products a = sp_recurrence_step(&r[0]);
        op.wide = false;
        const recurrence_products b = sp_recurrence_step(&r[1]);
        assert_memory_equal(&a, &b, sizeof a);
    }
    assert_memory_equal(r[0].u, r[1].u, (size_t)op.n * (size_t)op.row * sizeof *r[0].u);
    sp_recurrence_free(&r[0]);
    sp_recurrence_free(&r[1]);
}

/* Both recurrences with the same start: the same bits by vectors of eight and past the caches as by vectors of two. */
static void same_by_vectors(const char *name, const sp_network *net, bool doubled) {
    enum { PLACES = 5, STEPS = 20 };
    recurrence r[2] = {{0}, {0}};
    sp_operator op[2] = {{.n = 0}, {.n = 0}};
    recurrence_products products[2][STEPS];
    for (int q = 0; q < 2; q++) {
        int64_t at[PLACES];
        double value[PLACES];
        assert_ok(sp_operator_make(net, &op[q], &err));
        op[q].wide = op[q].wide && q == 0;
        for (int k = 0; k < PLACES; k++) {
            at[k] = sp_operator_at(&op[q], (sp_network_dofs(net) - 1) * k / (PLACES - 1));
            value[k] = 0.3 + 0.1 * k;
        }
        assert_ok(sp_recurrence_make(&op[q], net->mass, net->omega_bound, 1, &r[q], &err));
        r[q].doubled = doubled;
        r[q].past_caches = q == 0;
        for (int lane = 0; lane < 2; lane++)
            sp_recurrence_start(&r[q], lane, lane == 0, &(sparse_row){PLACES - lane, at, value});
        for (int k = 0; k < STEPS; k++)
            products[q][k] = sp_recurrence_step(&r[q]);
    }
    if (memcmp(r[0].u, r[1].u, ((size_t)op[0].n + 1) * (size_t)op[0].row * sizeof *r[0].u) != 0 ||
        memcmp(products[0], products[1], sizeof products[0]) != 0)
        fail_msg("%s: vectors of eight give other bits than vectors of two", name);
    assert_true(fabs(products[0][STEPS - 1].dot[0]) > 0 || !doubled);
    for (int q = 0; q < 2; q++) {
        sp_recurrence_free(&r[q]);
        sp_operator_free(&op[q]);
    }
}

TEST(test_vectors) {
    const struct {
        const char *name;
        int dim;
        double friction;
    } all[] = {{"chain", 1, 0}, {"2D", 2, 0}, {"2D with friction", 2, 0.5}, {"3D", 3, 0}, {"3D with friction", 3, 0.5}};
    for (size_t q = 0; q < sizeof all / sizeof *all; q++)
        for (int prestress = 0; prestress < 2; prestress++) {
            FREED(sp_packing)
            p = all[q].dim == 1 ? chain_packing(300, 1e-4)
                                : scattered_packing(all[q].dim, all[q].dim == 2 ? 17 : 7, all[q].friction, 3);
            carry(&p, 0.4, 5);
            FREED(sp_network) net = network_of(&p, prestress);
            same_by_vectors(all[q].name, &net, true);
            same_by_vectors(all[q].name, &net, false);
        }
}

/* A signal that ends with its front is the beginning of the longer one, ends not long after the zero crossing, and has
 * the front that the rule finds in the longer one up to there. */
TEST(test_front) {
    const char *const names[] = {REFERENCE("packing_N200_p1e-4.txt"), REFERENCE("packing_N600_p1e-4.txt")};
    for (int q = 0; q < 2; q++) {
        FREED(sp_packing) p = reference_packing(names[q]);
        FREED(sp_network) net = network_of(&p, false);
        sp_signal_options o = options_of(SP_SOURCE_IMPULSE, sp_signal_window(p.box[1], p.pressure), 961);
        const sp_place to[] = {{.kind = SP_PLACE_WALL}, {.kind = SP_PLACE_PLANE, .height = 0.4 * p.box[1]}};
        for (int detectors = 1; detectors <= 2; detectors++) {
            o.to = to;
            o.detectors = detectors;
            FREED(sp_signal) whole = sp_signal_none(), part = sp_signal_none();
            o.front = false;
            assert_ok(sp_signal_make(&net, &o, &whole, &err));
            o.front = true;
            assert_ok(sp_signal_make(&net, &o, &part, &err));
            assert_true(part.n < whole.n && part.products < whole.products && part.detectors == detectors);
            double last = 0;
            for (int d = 0; d < detectors; d++) {
                const double *f = part.f + (int64_t)d * part.n, *g = whole.f + (int64_t)d * whole.n;
                const sp_front_options rule = sp_front_options_default();
                sp_front a, b;
                assert_memory_equal(part.t, whole.t, (size_t)part.n * sizeof *part.t);
                assert_true(difference(part.n, f, g) <= part.errors[d] + whole.errors[d]);
                assert_ok(sp_front_find(part.n, part.t, f, &rule, &a, &err));
                assert_ok(sp_front_find(whole.n, whole.t, g, &rule, &b, &err));
                assert_true(isfinite(a.t_zero));
                assert_relative(a.t_zero, b.t_zero, 1e-8);
                assert_relative(a.t10, b.t10, 1e-8);
                last = fmax(last, a.t_zero);
            }
            assert_true(part.t[part.n - 1] < last + 2.1 * o.until / 48);
        }
        o.to = NULL; /* too short for a front: all of it */
        o.detectors = 0;
        o.until = 20;
        sp_signal s = sp_signal_none();
        assert_ok(sp_signal_make(&net, &o, &s, &err));
        assert_int_equal(s.n, o.points);
        sp_signal_free(&s);
        o.method = SP_SIGNAL_DENSE;
        assert_fails(sp_signal_make(&net, &o, &s, &err), SP_EINVAL, "chebyshev auto");
    }
}

RUN_TESTS(NULL, NULL)
