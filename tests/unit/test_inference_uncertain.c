/* Errors of the sound of measured packings, against closed forms and against each other. */
#include "reference.h"
#include "signals.h"

#include <sonopack/uncertainty.h>

#define SMALL REFERENCE("packing_N200_p1e-4.txt")

static const sp_uncertain *named(const sp_uncertainty *u, const char *name) {
    for (int k = 0; k < u->n; k++)
        if (strcmp(u->quantity[k].name, name) == 0)
            return &u->quantity[k];
    fail_msg("no quantity %s", name);
    return NULL;
}

static sp_uncertainty made(const sp_packing *p, const sp_uncertainty_options *o) {
    sp_uncertainty u = sp_uncertainty_none();
    assert_ok(sp_uncertainty_make(p, o, &u, &err));
    return u;
}

/* All stiffnesses times s, lognormal: times go as s^(-1/2), moduli as s. The moments of such numbers are known. */
TEST(test_calibration) {
    SKIP_SANITIZED();
    FREED(sp_packing) p = reference_packing(SMALL);
    sp_uncertainty_options o = sp_uncertainty_options_default();
    const struct {
        const char *name;
        double power;
    } each[] = {{"t10", -0.5}, {"t_peak", -0.5}, {"width", -0.5}, {"c", 0.5},
                {"C22", 1},    {"c_l", 0.5},     {"omega_1", 0.5}};
    o.errors.calibration = 0.2;
    o.samples = 400;
    o.modes = 2;
    FREED(sp_uncertainty) u = made(&p, &o);
    assert_int_equal(u.loose, 0);
    for (size_t k = 0; k < sizeof each / sizeof *each; k++) {
        const sp_uncertain *q = named(&u, each[k].name);
        const double v = pow(0.2 * each[k].power, 2), mean = q->value * exp(v / 2);
        assert_int_equal(q->samples, 400);
        assert_close(q->bias, mean - q->value, 4 * q->bias_error);
        assert_close(q->sd, mean * sqrt(expm1(v)), 4 * q->sd_error);
        if (strcmp(q->name, "t_peak") == 0 || strcmp(q->name, "t10") == 0 || q->name[0] == 'w')
            assert_relative(q->first_order, 0.1 * q->value, 2e-3); /* found on the continuous signal */
        else
            assert_relative(q->first_order, 0.2 * each[k].power * q->value, 2e-3);
        assert_relative(q->share[SP_ERROR_CALIBRATION], 1.0, 1e-12);
        assert_int_equal(q->linear, SP_LINEAR_YES);
    }
}

/* A chain of equal springs with independent errors: C22 = 1/sum(1/k), so that sd(C)/C = s/sqrt(N + 1), and
 * d ln(omega_1^2)/d ln k_c = 2/(N + 1) cos^2(pi (c + 1/2)/(N + 1)) with wall springs as the others. */
TEST(test_chain) {
    enum { N = 9 };
    FREED(sp_packing) p = chain_packing(N, 1e-4);
    sp_uncertainty_options o = sp_uncertainty_options_default();
    double sum = 0;
    p.wall = SP_WALL_GRAIN;
    for (int c = 0; c <= N; c++)
        sum += pow(cos(3.14159265358979323846 * (c + 0.5) / (N + 1)), 4);
    o.errors.stiffness = 0.03;
    o.modes = 1;
    o.margin = 0;
    o.samples = 2000;
    FREED(sp_uncertainty) u = made(&p, &o);
    const sp_uncertain *c22 = named(&u, "C22"), *omega = named(&u, "omega_1");
    assert_relative(c22->first_order, 0.03 / sqrt(N + 1) * c22->value, 1e-6);
    assert_relative(omega->first_order, 0.5 * 0.03 * 2.0 / (N + 1) * sqrt(sum) * omega->value, 1e-6);
    assert_relative(c22->share[SP_ERROR_STIFFNESS], 1.0, 1e-12);
    for (int k = 0; k < u.n; k++)
        assert_close(u.quantity[k].sd, u.quantity[k].first_order,
                     4 * u.quantity[k].sd_error + 0.005 * u.quantity[k].first_order);
}

/* Equal springs in series have equal parts in C22; all parts together are the shares. */
TEST(test_parts) {
    enum { N = 9 };
    FREED(sp_packing) chain = chain_packing(N, 1e-4);
    FREED(sp_packing) p = reference_packing(SMALL);
    sp_uncertainty_options o = sp_uncertainty_options_default();
    chain.wall = SP_WALL_GRAIN;
    o.parts = true;
    o.samples = 0;
    o.errors.stiffness = 0.03;
    FREED(sp_uncertainty) one = made(&chain, &o);
    const int64_t c22 = named(&one, "C22") - one.quantity;
    assert_int_equal(one.springs, N + 1);
    for (int k = 0; k <= N; k++)
        assert_relative(one.by_contact[c22 * (N + 1) + k], 1.0 / (N + 1), 1e-6);
    o.errors = (sp_errors){
        .position = 0.01, .radius = 0.02, .force = 0.1, .stiffness = 0.05, .calibration = 0.01, .false_part = 0.01};
    FREED(sp_uncertainty) u = made(&p, &o);
    for (int q = 0; q < u.n; q++) {
        const double *share = u.quantity[q].share;
        double grains = 0, contacts = 0;
        for (int k = 0; k < u.grains; k++)
            grains += u.by_grain[q * u.grains + k];
        for (int k = 0; k < u.springs; k++)
            contacts += u.by_contact[q * u.springs + k];
        assert_relative(grains, share[SP_ERROR_POSITION] + share[SP_ERROR_RADIUS], 1e-12);
        assert_relative(contacts, share[SP_ERROR_FORCE] + share[SP_ERROR_STIFFNESS] + share[SP_ERROR_FALSE], 1e-12);
    }
}

/* Forces do nothing where stiffnesses are given: what is left is rounding, and is no departure from first order. */
TEST(test_rounding) {
    FREED(sp_packing) p = reference_packing(SMALL);
    sp_uncertainty_options o = sp_uncertainty_options_default();
    for (int32_t k = 0; k < p.n_contacts; k++)
        p.contacts[k].kn = p.contacts[k].kt = 0.01 + 1e-5 * k;
    o.errors.force = 0.1;
    o.samples = 10;
    FREED(sp_uncertainty) u = made(&p, &o);
    for (int q = 0; q < u.n; q++) {
        assert_true(u.quantity[q].first_order == 0);
        assert_int_equal(u.quantity[q].linear, SP_LINEAR_YES);
    }
}

/* A chain without one of its contacts carries no sound: such samples are counted. */
TEST(test_loose) {
    FREED(sp_packing) p = chain_packing(9, 1e-4);
    sp_uncertainty_options o = sp_uncertainty_options_default();
    o.errors.false_part = 0.05;
    o.samples = 1000;
    o.moduli = false;
    FREED(sp_uncertainty) u = made(&p, &o);
    const double part = 1 - pow(0.95, 10);
    assert_close(u.loose / 1000.0, part, 4 * sqrt(part * (1 - part) / 1000));
    assert_true(u.why[0] != '\0');
    assert_int_equal(named(&u, "t10")->samples, 1000 - u.loose);
    assert_int_equal(named(&u, "t10")->linear, SP_LINEAR_NO);
}

/* Small errors of each kind by itself, of both ways of measuring: the standard deviations of first order and of samples
 * agree, by chi^2 over all quantities. */
static void check_agreement(const sp_packing *p, const sp_errors *errors) {
    sp_uncertainty_options o = sp_uncertainty_options_default();
    double chi2 = 0;
    o.errors = *errors;
    o.samples = 250;
    o.modes = errors->stiffness > 0 || errors->radius > 0 ? 1 : 0; /* they take most of the time */
    o.threads = 2;
    FREED(sp_uncertainty) u = made(p, &o);
    for (int k = 0; k < u.n; k++) {
        const sp_uncertain *q = &u.quantity[k];
        double shares = 0;
        for (int e = 0; e < SP_ERROR_KINDS; e++)
            shares += q->share[e];
        assert_relative(shares, 1.0, 1e-12);
        assert_true(q->first_order > 0 && q->sd > 0);
        if (fabs(q->sd - q->first_order) > 4 * q->sd_error)
            print_message("%s: first %g, sd %g +- %g\n", q->name, q->first_order, q->sd, q->sd_error);
        chi2 += pow((q->sd - q->first_order) / q->sd_error, 2);
    }
    assert_int_equal(u.loose, 0);
    /* the quantities are correlated, so that the sum scatters more than that of independent ones */
    if (!(chi2 < 3 * u.n))
        fail_msg("chi^2 = %g of %d quantities", chi2, u.n);
}

TEST(test_agreement) {
    SKIP_SANITIZED();
    const sp_errors each[] = {{.position = 1e-3},
                              {.radius = 1e-3},
                              {.force = 0.02},
                              {.stiffness = 0.005},
                              {.measured = SP_MEASURED_OVERLAPS, .position = 1e-6},
                              {.measured = SP_MEASURED_OVERLAPS, .radius = 1e-6}};
    FREED(sp_packing) p = reference_packing(SMALL);
    for (size_t k = 0; k < sizeof each / sizeof *each; k++)
        check_agreement(&p, &each[k]);
}

/* Seeds decide, threads do not. */
TEST(test_reproducible) {
    FREED(sp_packing) p = reference_packing(SMALL);
    sp_uncertainty_options o = sp_uncertainty_options_default();
    o.errors.force = 0.1;
    o.samples = 12;
    o.first_order = false;
    FREED(sp_uncertainty) one = made(&p, &o);
    o.threads = 3;
    FREED(sp_uncertainty) same = made(&p, &o);
    o.seed = 2;
    FREED(sp_uncertainty) other = made(&p, &o);
    for (int k = 0; k < one.n; k++) {
        assert_true(one.quantity[k].sd == same.quantity[k].sd && one.quantity[k].bias == same.quantity[k].bias);
        assert_true(one.quantity[k].value == other.quantity[k].value);
        assert_true(one.quantity[k].sd != other.quantity[k].sd);
        assert_true(isnan(one.quantity[k].first_order) && one.quantity[k].linear == SP_LINEAR_UNKNOWN);
    }
}

/* Errors of positions as large as overlaps are beyond first order, and it is told. */
TEST(test_departs) {
    FREED(sp_packing) p = reference_packing(SMALL);
    sp_uncertainty_options o = sp_uncertainty_options_default();
    o.errors.measured = SP_MEASURED_OVERLAPS;
    o.errors.position = 0.004;
    o.samples = 50;
    o.moduli = false;
    FREED(sp_uncertainty) u = made(&p, &o);
    assert_true(u.overlap > 0.001 && u.overlap < 0.01);
    assert_true(u.contacts < 0.95);
    assert_int_equal(named(&u, "t10")->linear, SP_LINEAR_NO);
}

TEST(test_refuses) {
    FREED(sp_packing) p = reference_packing(SMALL);
    sp_uncertainty_options o = sp_uncertainty_options_default();
    sp_uncertainty u;
    o.samples = 5;
    assert_fails(sp_uncertainty_make(&p, &o, &u, &err), SP_EINVAL, "samples 5");
    o.samples = 0;
    o.first_order = false;
    assert_fails(sp_uncertainty_make(&p, &o, &u, &err), SP_EINVAL, "samples 0");
    o = sp_uncertainty_options_default();
    o.modes = -1;
    assert_fails(sp_uncertainty_make(&p, &o, &u, &err), SP_EINVAL, "modes -1");
    o = sp_uncertainty_options_default();
    o.errors.gap = INFINITY;
    assert_fails(sp_uncertainty_make(&p, &o, &u, &err), SP_EINVAL, "gap");
    o = sp_uncertainty_options_default();
    o.parts = true;
    o.first_order = false;
    assert_fails(sp_uncertainty_make(&p, &o, &u, &err), SP_EINVAL, "parts");
}

/* Every allocation fails once. */
TEST(test_memory) {
    FREED(sp_packing) p = chain_packing(3, 1e-4);
    sp_uncertainty_options o = sp_uncertainty_options_default();
    o.samples = 10;
    o.margin = 0;
    o.errors.force = 0.1;
    o.errors.missing = 0.5;
    sp_uncertainty u = sp_uncertainty_none();
    EACH_ALLOCATION_FAILS(10, sp_uncertainty_make(&p, &o, &u, &err), assert_true(!lacks || !u.quantity),
                          sp_uncertainty_free(&u));
    o.errors.missing = 0;
    o.samples = 0;
    o.parts = true;
    EACH_ALLOCATION_FAILS(10, sp_uncertainty_make(&p, &o, &u, &err), assert_true(!lacks || !u.by_grain),
                          sp_uncertainty_free(&u));
}

RUN_TESTS(NULL, NULL)
