/* Fronts over distance: power laws that are known, errors that are known, and what is missing. */
#include "base/base.h"
#include "test.h"

#include <sonopack/chain.h>
#include <sonopack/scaling.h>

enum { ROWS = 5, MOST = 40 };

typedef struct data {
    int64_t samples[ROWS];
    double distance[ROWS][MOST];
    sp_front front[ROWS][MOST];
    const double *distances[ROWS];
    const sp_front *fronts[ROWS];
    sp_scaling_input in;
} data;

static const double length[ROWS] = {8, 25, 50, 100, 200};

/* t10 = 5 + L/0.25, amplitude 3 L^-1.5, t_zero - t10 = 2 L^0.8, t_zero - t_peak = 0.7 L^0.6. */
static sp_front law(double l) {
    sp_front f = {.t10 = 5 + l / 0.25, .amplitude = 3 * pow(l, -1.5)};
    f.t_zero = f.t10 + 2 * pow(l, 0.8);
    f.t_peak = f.t_zero - 0.7 * pow(l, 0.6);
    f.width = f.t_zero - f.t10;
    return f;
}

static data make(int rows, int64_t samples, bool joint) {
    data d = {.in = {.rows = rows, .joint = joint}};
    for (int r = 0; r < rows; r++) {
        d.samples[r] = samples;
        for (int64_t k = 0; k < samples; k++) {
            d.distance[r][k] = length[r];
            d.front[r][k] = law(length[r]);
        }
    }
    return d;
}

/* Pointers are set where the data lie. */
static const sp_scaling_input *input(data *d) {
    for (int r = 0; r < ROWS; r++) {
        d->distances[r] = d->distance[r];
        d->fronts[r] = d->front[r];
    }
    d->in.samples = d->samples;
    d->in.distance = d->distances;
    d->in.front = d->fronts;
    return &d->in;
}

static sp_scaling scaling_of(data *d) {
    sp_scaling s;
    assert_ok(sp_scaling_make(input(d), &s, &err));
    return s;
}

/* ---- known laws -------------------------------------------------------------------------------------------------- */

TEST(exact_laws) {
    for (int joint = 0; joint < 2; joint++) {
        data d = make(ROWS, 4, joint == 1);
        sp_scaling s = scaling_of(&d);
        for (int r = 0; r < ROWS; r++) {
            const sp_scaling_row *row = &s.row[r];
            assert_int_equal(row->samples, 4);
            assert_relative(row->distance.value, length[r], 1e-15);
            assert_relative(row->width.value, 2 * pow(length[r], 0.8), 1e-12);
            assert_relative(row->width_peak.value, 0.7 * pow(length[r], 0.6), 1e-12);
            assert_close(row->log_amplitude.value, log(3) - 1.5 * log(length[r]), 1e-12);
            assert_close(row->amplitude.error, 0, 1e-15);
            if (r + 1 == ROWS) {
                assert_true(isnan(row->speed.value) && isnan(row->gamma.value) && isnan(row->between));
                continue;
            }
            assert_relative(row->between, sqrt(length[r] * length[r + 1]), 1e-15);
            assert_relative(row->speed.value, 0.25, 1e-12);
            assert_close(row->gamma.value, 1.5, 1e-12);
            assert_close(row->alpha.value, 0.8, 1e-12);
            assert_close(row->alpha_peak.value, 0.6, 1e-12);
            assert_close(row->gamma.error, 0, 1e-12); /* samples that are all alike */
            const double zero = law(length[r + 1]).t_zero - law(length[r]).t_zero;
            assert_relative(row->speed_zero.value, (length[r + 1] - length[r]) / zero, 1e-12);
        }
        const sp_scaling_fit fit[] = {s.gamma, s.gamma_log, s.alpha, s.alpha_peak, s.speed};
        const double value[] = {1.5, 1.5, 0.8, 0.6, 0.25}, prefactor[] = {3, 3, 2, 0.7, 5};
        for (int k = 0; k < 5; k++) {
            assert_close(fit[k].value.value, value[k], 1e-12);
            assert_relative(fit[k].prefactor, prefactor[k], 1e-10);
            assert_int_equal(fit[k].freedom, ROWS - 2);
            assert_true(isnan(fit[k].chi2)); /* no scatter, no weights */
            assert_close(fit[k].value.error, 0, 1e-12);
        }
        sp_scaling_free(&s);
        assert_null(s.row);
    }
}

/* The chain's own limits, 2/3 and 1/3 (Table III of Somfai et al. 2005): local exponents differ from them by
 * corrections of the relative order N^(-2/3). */
TEST(fronts_of_chains) {
    const int64_t grains[3] = {10000, 32000, 100000};
    data d = make(3, 1, false);
    for (int r = 0; r < 3; r++) {
        d.distance[r][0] = (double)grains[r];
        assert_ok(sp_chain_front(grains[r], SP_CHAIN_VELOCITY, &d.front[r][0], &err));
    }
    FREED(sp_scaling) s = scaling_of(&d);
    for (int r = 0; r < 2; r++) {
        const double off = pow(s.row[r].between, -2.0 / 3);
        assert_close(s.row[r].gamma.value, 2.0 / 3, 1.5 * off);
        assert_close(s.row[r].alpha.value, 1.0 / 3, 1.5 * off);
        assert_close(s.row[r].alpha_peak.value, 1.0 / 3, 1.5 * off);
        assert_close(s.row[r].speed.value, 1, 1.5 * off); /* arrival is early by about N^(1/3) */
        assert_true(isnan(s.row[r].gamma.error));
    }
    assert_close(s.gamma.value.value, 2.0 / 3, 2e-3);
    assert_true(isnan(s.gamma.value.error) && isnan(s.gamma.chi2) && s.gamma.freedom == 1);
}

/* ---- known errors ------------------------------------------------------------------------------------------------ */

static double uniform(uint64_t *random) { /* xorshift64* */
    *random ^= *random >> 12;
    *random ^= *random << 25;
    *random ^= *random >> 27;
    return (double)((*random * UINT64_C(2685821657736338717)) >> 11) * 0x1p-53;
}

static double normal(uint64_t *random) {
    const double u = 1 - uniform(random), v = uniform(random);
    return sqrt(-2 * log(u)) * cos(2 * M_PI * v);
}

/* Amplitudes scatter by 10%, arrivals by 1, widths by 5%; distances by 0.2, which moves arrivals with them. */
static void scatter(data *d, uint64_t *random) {
    for (int r = 0; r < d->in.rows; r++)
        for (int64_t k = 0; k < d->samples[r]; k++) {
            const double l = length[r] + 0.2 * normal(random);
            sp_front f = law(length[r]);
            f.amplitude *= 1 + 0.1 * normal(random);
            const double width = f.width * (1 + 0.05 * normal(random));
            f.t10 = 5 + l / 0.25 + normal(random);
            f.t_zero = f.t10 + width;
            f.t_peak = f.t_zero - 0.7 * pow(length[r], 0.6);
            d->distance[r][k] = l;
            d->front[r][k] = f;
        }
}

/* Over many data sets of n = 20 samples a row: (value - truth)/error has mean 0 and the spread of Student's t with 19
 * degrees of freedom, sqrt(19/17) = 1.057; chi2 has the mean freedom x 19/17 (each row's variance is estimated from
 * 20). 150 sets know a spread to 6%, of which three times are allowed, and chi2 (whose own spread is sqrt(2 x 3)) to
 * 0.2. */
TEST(errors_cover) {
    enum { SETS = 150, N = 20, PULLS = 6 };
    uint64_t random = 20261121;
    print_message("seed %llu\n", (unsigned long long)random);
    double sum[PULLS] = {0}, squares[PULLS] = {0}, chi2[4] = {0};
    for (int set = 0; set < SETS; set++) {
        data d = make(ROWS, N, false);
        scatter(&d, &random);
        FREED(sp_scaling) s = scaling_of(&d);
        const double pull[PULLS] = {
            (s.row[1].gamma.value - 1.5) / s.row[1].gamma.error, (s.row[1].speed.value - 0.25) / s.row[1].speed.error,
            (s.row[0].alpha.value - 0.8) / s.row[0].alpha.error, (s.gamma.value.value - 1.5) / s.gamma.value.error,
            (s.speed.value.value - 0.25) / s.speed.value.error,  (s.alpha.value.value - 0.8) / s.alpha.value.error};
        for (int k = 0; k < PULLS; k++) {
            sum[k] += pull[k];
            squares[k] += pull[k] * pull[k];
        }
        const double one[4] = {s.gamma.chi2, s.speed.chi2, s.alpha.chi2, s.gamma_log.chi2};
        for (int k = 0; k < 4; k++)
            chi2[k] += one[k] / SETS;
        /* the fit's own error is the bootstrap's, to the noise of both: 1/sqrt(2 x 20) for each row */
        assert_relative(s.gamma.fit_error, s.gamma.value.error, 0.5);
    }
    for (int k = 0; k < PULLS; k++) {
        const double spread = sqrt(squares[k] / SETS);
        if (!(fabs(spread - sqrt(19.0 / 17)) < 0.19) || !(fabs(sum[k] / SETS) < 3 * 1.06 / sqrt(SETS)))
            fail_msg("pull %d: mean %g, spread %g", k, sum[k] / SETS, spread);
    }
    for (int k = 0; k < 3; k++) /* of the logarithms the mean is lower than truth by half their variance, everywhere */
        assert_close(chi2[k], 3 * 19.0 / 17, 0.65);
    assert_close(chi2[3], 3 * 19.0 / 17, 0.65);
}

/* A factor that a packing has at all its planes moves no exponent; between boxes it would. */
TEST(packings_are_drawn_whole) {
    for (int joint = 0; joint < 2; joint++) {
        data d = make(3, 10, joint == 1);
        double ln[10], mean = 0, square = 0;
        for (int k = 0; k < 10; k++) {
            const double factor = 1 + 0.03 * (k - 4.5);
            ln[k] = factor;
            mean += factor / 10;
            for (int r = 0; r < 3; r++)
                d.front[r][k].amplitude *= factor;
        }
        for (int k = 0; k < 10; k++)
            square += (ln[k] - mean) * (ln[k] - mean) / 9;
        FREED(sp_scaling) s = scaling_of(&d);
        assert_close(s.row[0].gamma.value, 1.5, 1e-12);
        const double independent = sqrt(2 * square / 10) / mean / log(length[1] / length[0]);
        if (joint)
            assert_true(s.row[0].gamma.error < 1e-12 && s.gamma.value.error < 1e-12);
        else
            assert_relative(s.row[0].gamma.error, independent, 0.1); /* 1000 resamples: 2%, and ln is not straight */
        assert_int_equal(s.joint, joint);
    }
}

/* ---- what is missing -----------------------------------------------------------------------------------------------
 */

TEST(few_samples_and_rows) {
    data d = make(3, 1, false);
    FREED(sp_scaling) s = scaling_of(&d);
    assert_close(s.row[0].gamma.value, 1.5, 1e-12);
    assert_true(isnan(s.row[0].gamma.error) && isnan(s.row[0].t10.error) && isnan(s.row[0].speed.error));
    assert_close(s.gamma.value.value, 1.5, 1e-12);
    assert_true(isnan(s.gamma.value.error) && isnan(s.gamma.chi2));
    sp_scaling_free(&s);
    d = make(1, 5, false);
    s = scaling_of(&d);
    assert_true(isnan(s.row[0].gamma.value) && isnan(s.gamma.value.value) && isnan(s.speed.value.error));
    assert_relative(s.row[0].t10.value, 5 + 8 / 0.25, 1e-12);
    sp_scaling_free(&s);
    /* a row of one among rows of many: no error where it takes part, errors where it does not */
    d = make(3, 6, false);
    d.samples[2] = 1;
    for (int k = 0; k < 6; k++)
        for (int r = 0; r < 3; r++)
            d.front[r][k].amplitude *= 1 + 0.01 * k;
    s = scaling_of(&d);
    assert_true(s.row[0].gamma.error > 0 && isnan(s.row[1].gamma.error) && isnan(s.gamma.value.error));
    assert_true(isnan(s.gamma.chi2)); /* equal weights */
    sp_scaling_free(&s);
    /* two distances: a line through both, nothing left over */
    d = make(2, 6, false);
    for (int k = 0; k < 6; k++)
        for (int r = 0; r < 2; r++)
            d.front[r][k].amplitude *= 1 + 0.01 * k;
    s = scaling_of(&d);
    assert_close(s.gamma.value.value, 1.5, 1e-12);
    assert_int_equal(s.gamma.freedom, 0);
    assert_close(s.gamma.chi2, 0, 1e-12);
}

TEST(missing_marks) {
    data d = make(4, 4, true);
    const sp_front none = {NAN, NAN, NAN, NAN, NAN, 0};
    d.front[1][2].t_zero = d.front[1][2].width = NAN; /* one sample without a zero crossing */
    d.front[0][3] = none;                             /* one without a front */
    for (int k = 0; k < 4; k++)
        d.front[3][k].t_zero = NAN; /* a row without zero crossings */
    FREED(sp_scaling) s = scaling_of(&d);
    assert_int_equal(s.row[0].samples, 3);
    assert_int_equal(s.row[1].samples, 4);
    for (int r = 0; r < 2; r++) {
        assert_close(s.row[r].alpha.value, 0.8, 1e-12); /* the others say the same */
        assert_close(s.row[r].gamma.value, 1.5, 1e-12);
    }
    assert_true(isnan(s.row[2].alpha.value) && isnan(s.row[3].width.value) && isnan(s.row[2].speed_zero.value));
    assert_close(s.row[2].gamma.value, 1.5, 1e-12);
    assert_close(s.alpha.value.value, 0.8, 1e-12);
    assert_int_equal(s.alpha.freedom, 1);
    assert_int_equal(s.gamma.freedom, 2);
    sp_scaling_free(&s);
    /* no sample of a row has a front */
    for (int k = 0; k < 4; k++)
        d.front[2][k] = none;
    s = scaling_of(&d);
    assert_int_equal(s.row[2].samples, 0);
    assert_true(isnan(s.row[2].distance.value) && isnan(s.row[1].gamma.value) && isnan(s.row[2].gamma.value));
    assert_int_equal(s.gamma.freedom, 1);
}

TEST(values_without_logarithm) {
    data d = make(3, 3, false);
    for (int k = 0; k < 3; k++)
        d.front[1][k].amplitude = -1;
    d.front[2][1].t10 = d.front[2][1].t_peak = d.front[2][1].t_zero = -1e4; /* <t10> falls */
    FREED(sp_scaling) s = scaling_of(&d);
    assert_true(isnan(s.row[0].gamma.value) && isnan(s.row[1].gamma.value) && isnan(s.row[0].gamma.error));
    assert_int_equal(s.gamma.freedom, 0); /* two rows are left */
    assert_close(s.gamma.value.value, 1.5, 1e-12);
    assert_true(isnan(s.row[1].speed.value) && s.row[0].speed.value > 0);
}

TEST(wrong_input) {
    sp_scaling s;
    data d = make(2, 3, true);
    d.in.rows = 0;
    assert_fails(sp_scaling_make(input(&d), &s, &err), SP_EINVAL, "1");
    d = make(2, 3, true);
    d.samples[1] = 2;
    assert_fails(sp_scaling_make(input(&d), &s, &err), SP_EINVAL, "1 2 3");
    d = make(2, 3, false);
    d.samples[0] = 0;
    assert_fails(sp_scaling_make(input(&d), &s, &err), SP_EINVAL, "0 samples");
    d = make(2, 3, false);
    d.distance[1][1] = -1;
    assert_fails(sp_scaling_make(input(&d), &s, &err), SP_EINVAL, "distance -1 1");
    d.distance[1][1] = NAN;
    assert_fails(sp_scaling_make(input(&d), &s, &err), SP_EINVAL, "nan 1");
    d = make(2, 3, false);
    for (int k = 0; k < 3; k++)
        d.distance[1][k] = 8;
    assert_fails(sp_scaling_make(input(&d), &s, &err), SP_EINVAL, "8");
}

TEST(lack_of_memory) {
    data d = make(3, 4, false);
    sp_scaling s = {0};
    EACH_ALLOCATION_FAILS(4, (d = make(3, 4, false), sp_scaling_make(input(&d), &s, &err)),
                          assert_true(!lacks || !s.row), sp_scaling_free(&s));
}

RUN_TESTS(NULL, NULL)
