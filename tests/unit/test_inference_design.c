/* Design: the set of allowed factors, gradients against differences, and optima that are known. */
#include "inference/design_problem.h"

#include "making.h"
#include "reference.h"
#include "signals.h"

#define SMALL REFERENCE("packing_N200_p1e-4.txt")
static const double PI = 3.14159265358979323846;

static sp_design_problem problem_of(const sp_packing *p, const sp_design_options *o, double *weight) {
    sp_design_problem d = {.p = p, .opt = o, .weight = weight, .scale = 1};
    for (int i = 0; i < p->n; i++)
        d.total += weight[i];
    return d;
}

/* The nearest allowed point: no exchange between two grains brings it nearer, and the total is kept. */
TEST(test_project) {
    enum { N = 40 };
    sp_packing p = {.n = N};
    sp_design_options o = sp_design_options_default();
    double weight[N], wish[N], got[N], total = 0;
    srand(3);
    for (int i = 0; i < N; i++) {
        weight[i] = i == 7 ? 0 : 0.3 + rand() / (double)RAND_MAX;
        wish[i] = got[i] = 3 * (rand() / (double)RAND_MAX) - 0.5;
    }
    const sp_design_problem d = problem_of(&p, &o, weight);
    sp_design_project(&d, got);
    assert_true(got[7] == 1);
    double low = -1e9, high = 1e9; /* bounds of the multiplier by each grain */
    for (int i = 0; i < N; i++) {
        assert_true(got[i] >= o.low && got[i] <= o.high);
        total += weight[i] * got[i];
        if (weight[i] == 0)
            continue;
        const double shift = (wish[i] - got[i]) / weight[i];
        if (got[i] < o.high)
            low = fmax(low, got[i] > o.low ? shift : low > shift ? low : shift);
        if (got[i] > o.low)
            high = fmin(high, shift);
    }
    assert_relative(total, d.total, 1e-12);
    assert_true(low <= high + 1e-9);
    o.free = true;
    sp_design_project(&d, wish);
    for (int i = 0; i < N; i++)
        assert_true(wish[i] >= o.low && wish[i] <= o.high);
}

/* The best corner of a linear programme: no grain below the upper limit gains more a weight than one above the lower.
 */
TEST(test_extreme) {
    enum { N = 30 };
    sp_packing p = {.n = N};
    sp_design_options o = sp_design_options_default();
    double weight[N], g[N], best[N], total = 0;
    srand(4);
    for (int i = 0; i < N; i++) {
        weight[i] = 0.3 + rand() / (double)RAND_MAX;
        g[i] = rand() / (double)RAND_MAX - 0.5;
    }
    const sp_design_problem d = problem_of(&p, &o, weight);
    const double level = sp_design_extreme(&d, g, best);
    int between = 0;
    for (int i = 0; i < N; i++) {
        total += weight[i] * best[i];
        assert_true(best[i] >= o.low && best[i] <= o.high);
        if (best[i] > o.low && best[i] < o.high) {
            between++;
            assert_close(g[i] / weight[i], level, 1e-9);
        } else {
            assert_true((best[i] == o.high) == (g[i] / weight[i] > level));
        }
    }
    assert_relative(total, d.total, 1e-12);
    assert_true(between <= 1);
    o.free = true;
    sp_design_extreme(&d, g, best);
    for (int i = 0; i < N; i++)
        assert_true(best[i] == (g[i] > 0 ? o.high : o.low));
}

/* The energy in a band against the integral of |F(omega)|^2, and its weights against differences. All frequencies have
 * the integral of F^2. */
TEST(test_band) {
    enum { N = 90, STEPS = 4000 };
    const double spacing = 0.3, low = 0.4, high = 1.1;
    double f[N], weight[N], scratch[N], direct = 0, all = 0;
    for (int l = 0; l < N; l++) {
        f[l] = exp(-0.01 * pow(l * spacing - 6, 2)) * cos(0.8 * l * spacing);
        f[l] *= l < 60 ? 1 : 0; /* before the end of the record fades */
        all += f[l] * f[l] * spacing;
    }
    for (int k = 0; k < STEPS; k++) {
        const double w = low + (high - low) * (k + 0.5) / STEPS;
        double re = 0, im = 0;
        for (int l = 0; l < N; l++) {
            re += f[l] * cos(w * l * spacing) * spacing;
            im += f[l] * sin(w * l * spacing) * spacing;
        }
        direct += (re * re + im * im) * (high - low) / STEPS / PI;
    }
    const double energy = sp_design_band(N, spacing, f, low, high, scratch, weight);
    assert_relative(energy, direct, 1e-6);
    assert_relative(sp_design_band(N, spacing, f, 0, PI / spacing, scratch, weight), all, 1e-10);
    sp_design_band(N, spacing, f, low, high, scratch, weight);
    for (int l = 0; l < N; l += 7) {
        double other[N];
        f[l] += 1e-4;
        const double more = sp_design_band(N, spacing, f, low, high, scratch, other);
        f[l] -= 2e-4;
        const double less = sp_design_band(N, spacing, f, low, high, scratch, other);
        f[l] += 1e-4;
        assert_close(weight[l], (more - less) / 2e-4, 1e-9);
    }
}

/* Gradients by factors against central differences along a direction, for both goals and all that can be varied. */
static void check_gradient(const sp_packing *p, sp_design_goal goal, sp_design_variable vary, double h,
                           double tolerance) {
    sp_design_options o = sp_design_options_default();
    const size_t n = (size_t)p->n;
    double *weight = calloc(4 * n, sizeof *weight), *factor = weight + n, *gradient = factor + n, *way = gradient + n;
    double slope = 0;
    sp_design_value at, value[2];
    RELEASED uint8_t *rattler = calloc(n, 1);
    o.goal = goal;
    o.vary = vary;
    o.band_low = 0.1;
    o.band_high = 0.3;
    assert_ok(sp_packing_rattlers(p, 1e-4, rattler, NULL, NULL, &err));
    srand(5);
    for (size_t i = 0; i < n; i++) {
        weight[i] = rattler[i] ? 0 : 1;
        factor[i] = vary == SP_DESIGN_RADIUS || rattler[i] ? 1 : 0.8 + 0.4 * rand() / RAND_MAX;
        way[i] = rattler[i] ? 0 : rand() / (double)RAND_MAX - 0.5;
    }
    const sp_design_problem d = problem_of(p, &o, weight);
    assert_ok(sp_design_evaluate(&d, factor, gradient, &at, NULL, &err));
    for (size_t i = 0; i < n; i++)
        slope += gradient[i] * way[i];
    for (int side = 0; side < 2; side++) {
        for (size_t i = 0; i < n; i++)
            factor[i] += (side ? -2 : 1) * h * way[i];
        assert_ok(sp_design_evaluate(&d, factor, NULL, &value[side], NULL, &err));
    }
    assert_relative(slope, (value[0].objective - value[1].objective) / (2 * h), tolerance);
    free(weight);
}

TEST(test_gradients) {
    FREED(sp_packing) p = reference_packing(SMALL);
    for (int goal = 0; goal < 3; goal++)
        for (int vary = SP_DESIGN_MASS; vary <= SP_DESIGN_MODULUS; vary++)
            check_gradient(&p, (sp_design_goal)goal, (sp_design_variable)vary, 1e-4, 1e-5);
}

/* Radii: the packing is really compressed again. The response is that of the springs without their prestress, which is
 * some percent of it. */
TEST(test_radius_gradient) {
    sp_pack_spec spec = sp_pack_spec_default();
    spec.grains = 60;
    spec.width = 8;
    spec.friction = 0;
    spec.tolerance = 1e-13;
    spec.protocol = SP_PROTOCOL_SOMFAI2005; /* in other packings the prestress, which is left out, matters more */
    FREED(sp_packing) p = make_packing(&spec);
    check_gradient(&p, SP_DESIGN_DELAY, SP_DESIGN_RADIUS, 1e-6, 0.1);
}

/* Rows of a triangular lattice move as a chain. Its optical and acoustic branches are apart where light and heavy rows
 * alternate, and that is what the design finds, away from the walls. */
TEST(test_diatomic) {
    SKIP_SANITIZED();
    sp_pack_spec spec = sp_pack_spec_default();
    sp_design_options o = sp_design_options_default();
    FREED(sp_design) d = sp_design_none();
    spec.kind = SP_PACK_TRIANGULAR;
    spec.grains = 120;
    spec.width = 6;
    FREED(sp_packing) p = make_packing(&spec);
    o.goal = SP_DESIGN_BAND;
    o.band_low = 0.45;
    o.band_high = 0.6;
    o.low = 0.5;
    o.high = 1.5;
    o.iterations = 200;
    assert_ok(sp_design_make(&p, &o, &d, &err));
    assert_true(d.step[d.steps - 1].value < 1e-3);
    double mass = 0, before = 0;
    for (int i = 0; i < p.n; i++) {
        assert_true(d.factor[i] >= 0.5 && d.factor[i] <= 1.5);
        mass += d.packing.mass[i];
        before += grain_mass(p.r[i]);
        assert_relative(d.packing.mass[i], d.factor[i] * grain_mass(p.r[i]), 1e-14);
        assert_relative(d.factor[i], d.factor[i / 6 * 6], 1e-6); /* a row is one */
    }
    assert_relative(mass, before, 1e-12);
    for (int row = 4; row < 9; row++) /* of 20; the design is symmetric about the middle */
        assert_true((d.factor[6 * row] - 1) * (d.factor[6 * (row + 1)] - 1) < 0);
}

/* The front of the packing that comes out is that which the last step tells; every step gains. */
TEST(test_front) {
    FREED(sp_packing) p = reference_packing(SMALL);
    for (int goal = SP_DESIGN_DELAY; goal <= SP_DESIGN_ADVANCE; goal++) {
        sp_design_options o = sp_design_options_default();
        FREED(sp_design) d = sp_design_none();
        FREED(sp_signal) s = sp_signal_none();
        sp_front front;
        o.goal = (sp_design_goal)goal;
        o.iterations = 8;
        assert_ok(sp_design_make(&p, &o, &d, &err));
        const double sign = goal == SP_DESIGN_DELAY ? 1 : -1;
        for (int k = 1; k < d.steps; k++)
            assert_true(sign * (d.step[k].value - d.step[k - 1].value) > 0);
        assert_true(d.steps >= 2 && sign * log(d.step[d.steps - 1].value / d.step[0].value) > 0.05);
        assert_true(d.effective > 10 && d.effective < p.n);
        FREED(sp_network) net = network_of(&d.packing, false);
        sp_signal_options so = sp_signal_options_default();
        const sp_front_options rule = sp_front_options_default();
        so.until = sp_signal_window(p.box[1], p.pressure);
        so.points = 8001;
        so.method = SP_SIGNAL_VERLET; /* by other means */
        so.tolerance = 1e-4;
        assert_ok(sp_signal_make(&net, &so, &s, &err));
        assert_ok(sp_front_find(s.n, s.t, s.f, &rule, &front, &err));
        assert_relative(front.t10, d.step[d.steps - 1].value, 1e-3);
    }
}

TEST(test_refuses) {
    FREED(sp_packing) p = reference_packing(SMALL);
    sp_design d;
    sp_design_options o = sp_design_options_default();
    o.low = 1.2;
    assert_fails(sp_design_make(&p, &o, &d, &err), SP_EINVAL, "limits 1.2");
    o = sp_design_options_default();
    o.goal = SP_DESIGN_BAND;
    o.band_low = 2;
    o.band_high = 1;
    assert_fails(sp_design_make(&p, &o, &d, &err), SP_EINVAL, "goal");
    o = sp_design_options_default();
    o.iterations = -1;
    assert_fails(sp_design_make(&p, &o, &d, &err), SP_EINVAL, "iterations -1");
    o = sp_design_options_default();
    o.vary = SP_DESIGN_RADIUS;
    assert_ok(sp_packing_alloc_masses(&p, &err));
    assert_fails(sp_design_make(&p, &o, &d, &err), SP_EREFUSED, "");
}

TEST(test_memory) {
    FREED(sp_packing) p = chain_packing(4, 1e-4);
    sp_design_options o = sp_design_options_default();
    o.iterations = 2;
    sp_design d = sp_design_none();
    EACH_ALLOCATION_FAILS(10, sp_design_make(&p, &o, &d, &err), assert_true(!lacks || !d.factor), sp_design_free(&d));
}

RUN_TESTS(NULL, NULL)
