/* Coda-wave interferometry: kernels against differences, and changes that are found again. */
#include "making.h"
#include "reference.h"
#include "signals.h"

#include <sonopack/coda.h>

#define SMALL REFERENCE("packing_N200_p1e-4.txt")
enum { TIMES = 150 };

static void fill_times(double *t, double low, double high) {
    for (int l = 0; l < TIMES; l++)
        t[l] = low + (high - low) * l / (TIMES - 1);
}

static sp_coda_options options_of(const double *t) { return (sp_coda_options){.times = TIMES, .t = t, .threads = 1}; }

/* The kernel of a grain is the derivative of the signal by the logarithm of its stiffness: the error of a central
 * difference falls with the square of the step. */
TEST(test_kernels) {
    FREED(sp_packing) p = reference_packing(SMALL);
    FREED(sp_network) net = network_of(&p, false);
    double t[TIMES], more[TIMES], less[TIMES];
    fill_times(t, 20, 200);
    const sp_coda_options o = options_of(t);
    FREED(sp_coda) c = sp_coda_none();
    assert_ok(sp_coda_make(&net, &o, &c, &err));
    assert_int_equal(c.n, net.n);
    assert_int_equal(c.pairs, 1);
    for (int g = 3; g < c.n; g += 61) {
        const double *kernel = c.kernel + (size_t)g * TIMES;
        double off[2] = {0, 0}, size = peak_of(TIMES, kernel);
        for (int k = 0; k < 2; k++) {
            const double h = k ? 0.005 : 0.01;
            assert_ok(sp_coda_signal(&net, &o, c.grain[g], expm1(h), more, &err));
            assert_ok(sp_coda_signal(&net, &o, c.grain[g], expm1(-h), less, &err));
            for (int l = 0; l < TIMES; l++)
                off[k] = fmax(off[k], fabs((more[l] - less[l]) / (2 * h) - kernel[l]));
        }
        assert_true(off[0] < 0.05 * size);
        assert_close(off[0] / off[1], 4, 0.3);
    }
}

/* The signal at any times is that on equal spacings. */
TEST(test_signal) {
    FREED(sp_packing) p = reference_packing(SMALL);
    FREED(sp_network) net = network_of(&p, false);
    FREED(sp_signal) s = sp_signal_none();
    sp_signal_options so = sp_signal_options_default();
    double t[TIMES], f[TIMES];
    fill_times(t, 0, 149);
    const sp_coda_options o = options_of(t);
    so.until = 149;
    so.points = TIMES;
    assert_ok(sp_signal_make(&net, &so, &s, &err));
    assert_ok(sp_coda_signal(&net, &o, -1, 0, f, &err));
    assert_true(difference(TIMES, f, s.f) < 1e-7 * peak_of(TIMES, f));
}

/* A small change without noise is found in every grain: place, size, and nothing left. */
TEST(test_locate) {
    FREED(sp_packing) p = reference_packing(SMALL);
    FREED(sp_network) net = network_of(&p, false);
    double t[TIMES], before[TIMES], change[TIMES];
    fill_times(t, 60, 300);
    const sp_coda_options o = options_of(t);
    FREED(sp_coda) c = sp_coda_none();
    RELEASED sp_coda_candidate *found = calloc((size_t)net.n, sizeof *found);
    assert_ok(sp_coda_make(&net, &o, &c, &err));
    assert_ok(sp_coda_signal(&net, &o, -1, 0, before, &err));
    int hits = 0, tried = 0;
    for (int g = 0; g < c.n; g += 5, tried++) {
        double sum = 0;
        assert_ok(sp_coda_signal(&net, &o, c.grain[g], 1e-3, change, &err));
        for (int l = 0; l < TIMES; l++)
            change[l] -= before[l];
        assert_ok(sp_coda_locate(&c, change, 0, found, &err));
        hits += found[0].grain == c.grain[g];
        for (int k = 0; k < c.n; k++) {
            sum += found[k].probability;
            assert_true(k == 0 || found[k].misfit >= found[k - 1].misfit);
        }
        assert_relative(sum, 1.0, 1e-9);
        if (found[0].grain == c.grain[g])
            assert_relative(found[0].change, 1e-3, 0.05);
    }
    assert_true(hits > 0.95 * tried);
}

/* With noise the probabilities mean what they say: the true grain is within the most probable ones that together have
 * 90% in about 90% of the trials. */
TEST(test_probabilities) {
    FREED(sp_packing) p = reference_packing(SMALL);
    FREED(sp_network) net = network_of(&p, false);
    double t[TIMES], before[TIMES], after[TIMES], change[TIMES];
    fill_times(t, 60, 300);
    const sp_coda_options o = options_of(t);
    FREED(sp_coda) c = sp_coda_none();
    RELEASED sp_coda_candidate *found = calloc((size_t)net.n, sizeof *found);
    assert_ok(sp_coda_make(&net, &o, &c, &err));
    assert_ok(sp_coda_signal(&net, &o, -1, 0, before, &err));
    const double noise = 5e-2 * peak_of(TIMES, before);
    enum { TRIALS = 200 };
    int covered = 0, exact = 0;
    srand(11);
    for (int k = 0; k < TRIALS; k++) {
        const int32_t g = c.grain[rand() % c.n];
        assert_ok(sp_coda_signal(&net, &o, g, 0.02, after, &err));
        for (int l = 0; l < TIMES; l++) {
            double z = -6; /* nearly normal */
            for (int q = 0; q < 12; q++)
                z += rand() / (double)RAND_MAX;
            change[l] = after[l] - before[l] + noise * z;
        }
        assert_ok(sp_coda_locate(&c, change, noise, found, &err));
        double sum = 0;
        for (int q = 0; q < c.n && sum < 0.9; sum += found[q++].probability)
            covered += found[q].grain == g;
        exact += found[0].grain == g;
    }
    print_message("exact %d, covered %d of %d\n", exact, covered, TRIALS);
    assert_true(exact < TRIALS); /* else the noise tests nothing */
    assert_true(covered > 0.8 * TRIALS);
}

/* Several sources and detectors know more: the error of the change falls. */
TEST(test_pairs) {
    FREED(sp_packing) p = reference_packing(SMALL);
    FREED(sp_network) net = network_of(&p, false);
    double t[TIMES];
    const double width = p.box[0];
    const sp_place parts[2] = {{.kind = SP_PLACE_PART, .from = 0, .to = width / 2},
                               {.kind = SP_PLACE_PART, .from = width / 2, .to = width}};
    fill_times(t, 60, 300);
    sp_coda_options o = options_of(t);
    o.sources = o.detectors = 2;
    o.from = o.to = parts;
    FREED(sp_coda) whole = sp_coda_none(), halves = sp_coda_none();
    const sp_coda_options one = options_of(t);
    assert_ok(sp_coda_make(&net, &one, &whole, &err));
    assert_ok(sp_coda_make(&net, &o, &halves, &err));
    assert_int_equal(halves.pairs, 4);
    /* the wall's signal is the sum of those of its parts */
    for (int g = 0; g < net.n; g += 17)
        for (int l = 0; l < TIMES; l += 13) {
            double sum = 0;
            for (int pair = 0; pair < 4; pair++)
                sum += halves.kernel[((size_t)pair * (size_t)net.n + (size_t)g) * TIMES + (size_t)l];
            assert_close(sum, whole.kernel[(size_t)g * TIMES + (size_t)l],
                         1e-9 * peak_of(TIMES, whole.kernel + (size_t)g * TIMES));
        }
}

/* All stiffnesses by a factor 1 + 2 e: speeds by 1 + e, and the signal by the same scale of time. */
TEST(test_stretch) {
    enum { FINE = 3000 };
    FREED(sp_packing) p = reference_packing(SMALL);
    FREED(sp_network) net = network_of(&p, false);
    double *t = calloc(3 * FINE, sizeof *t), *before = t + FINE, *change = before + FINE, stretch, error;
    for (int l = 0; l < FINE; l++)
        t[l] = 50 + 0.05 * l;
    const sp_coda_options o = {.times = FINE, .t = t, .threads = 1};
    assert_ok(sp_coda_signal(&net, &o, -1, 0, before, &err));
    for (int l = 0; l < FINE; l++)
        t[l] *= 1 + 1e-4;
    assert_ok(sp_coda_signal(&net, &o, -1, 0, change, &err));
    for (int l = 0; l < FINE; l++) {
        t[l] /= 1 + 1e-4;
        change[l] -= before[l];
    }
    sp_coda_stretch(FINE, t, before, change, &stretch, &error);
    assert_relative(stretch, 1e-4, 5e-3);
    assert_true(error < 1e-6);
    free(t);
}

TEST(test_refuses) {
    FREED(sp_packing) p = chain_packing(5, 1e-4);
    FREED(sp_network) net = network_of(&p, false);
    double t[TIMES], change[TIMES] = {0};
    FREED(sp_coda) c = sp_coda_none();
    sp_coda_candidate found[5];
    fill_times(t, 10, 60);
    sp_coda_options o = options_of(t);
    assert_ok(sp_coda_make(&net, &o, &c, &err));
    assert_fails(sp_coda_locate(&c, change, 0, found, &err), SP_EREFUSED, "");
    change[3] = NAN;
    assert_fails(sp_coda_locate(&c, change, 0, found, &err), SP_EINVAL, "");
    change[3] = 1;
    assert_fails(sp_coda_locate(&c, change, -1, found, &err), SP_EINVAL, "noise -1");
    assert_fails(sp_coda_signal(&net, &o, 9, 0.1, change, &err), SP_EINVAL, "grain 9");
    assert_fails(sp_coda_signal(&net, &o, 1, -1, change, &err), SP_EINVAL, "-1");
    t[5] = t[4];
    sp_coda other = sp_coda_none();
    assert_fails(sp_coda_make(&net, &o, &other, &err), SP_EINVAL, "time 5");
}

TEST(test_memory) {
    FREED(sp_packing) p = chain_packing(3, 1e-4);
    FREED(sp_network) net = network_of(&p, false);
    double t[TIMES];
    fill_times(t, 10, 60);
    const sp_coda_options o = options_of(t);
    sp_coda c = sp_coda_none();
    EACH_ALLOCATION_FAILS(3, sp_coda_make(&net, &o, &c, &err), assert_true(!lacks || !c.kernel), sp_coda_free(&c));
}

RUN_TESTS(NULL, NULL)
