/* Laws of the diameters, the gas that is made of them, and the lattice that unequal grains start from. */
#include "test.h"

#include "base/base.h"
#include "ensemble/sample.h"
#include "packing/prepare.h"

static sp_pack_spec law(sp_sizes sizes, double low, double high, int32_t grains) {
    sp_pack_spec s = sp_pack_spec_default();
    s.sizes = sizes;
    s.diameter_min = low;
    s.diameter_max = high;
    s.grains = grains;
    s.seed = 7;
    return sp_pack_spec_resolve(&s);
}

static double *draw(const sp_pack_spec *s) {
    double *r = sp_alloc((size_t)s->grains, sizeof *r);
    sp_radii_draw(s, r);
    for (int32_t i = 0; i < s->grains; i++)
        assert_true(2 * r[i] >= s->diameter_min && 2 * r[i] <= s->diameter_max);
    return r;
}

static int compare(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double normal_below(double z) { return 0.5 * erfc(-z * sqrt(0.5)); }

static double part_below(const sp_pack_spec *s, double d) {
    if (s->sizes == SP_SIZES_UNIFORM)
        return (d - s->diameter_min) / (s->diameter_max - s->diameter_min);
    const double w = s->size_spread, m = -0.5 * w * w;
    const double a = normal_below((log(s->diameter_min) - m) / w), b = normal_below((log(s->diameter_max) - m) / w);
    return (normal_below((log(d) - m) / w) - a) / (b - a);
}

/* Kolmogorov and Smirnov: the largest distance of the two distributions is above 1.95/sqrt(N) once in a thousand. */
TEST(drawn_as_the_law_says) {
    const int32_t n = 40000;
    sp_pack_spec specs[] = {law(SP_SIZES_UNIFORM, 0, 0, n), law(SP_SIZES_UNIFORM, 0.1, 2, n),
                            law(SP_SIZES_LOGNORMAL, 0, 0, n), law(SP_SIZES_LOGNORMAL, 1.2, 3, n),
                            law(SP_SIZES_LOGNORMAL, 0.5, 0.9, n)};
    for (size_t k = 0; k < sizeof specs / sizeof *specs; k++) {
        double *r = draw(&specs[k]), worst = 0;
        qsort(r, (size_t)n, sizeof *r, compare);
        for (int32_t i = 0; i < n; i++)
            worst = fmax(worst, fabs(part_below(&specs[k], 2 * r[i]) - (i + 0.5) / n));
        print_message("law %d: distance %.2g\n", (int)k, worst);
        assert_true(worst < 1.95 / sqrt(n));
        sp_free(r);
    }
}

/* By the midpoint rule over the density, d = exp(u); its error falls as the square of the step. */
static double moment_by_sum(const sp_pack_spec *s, int k) {
    const int steps = 20000;
    const double a = log(s->diameter_min), b = log(s->diameter_max), w = s->size_spread;
    double sum = 0, norm = 0;
    for (int i = 0; i < steps; i++) {
        const double u = a + (b - a) * (i + 0.5) / steps, z = (u + 0.5 * w * w) / w;
        const double density = s->sizes == SP_SIZES_UNIFORM ? exp(u) : exp(-0.5 * z * z);
        norm += density;
        sum += density * exp(k * u);
    }
    return sum / norm;
}

TEST(moments_are_those_of_the_law) {
    const int32_t n = 20000;
    sp_pack_spec specs[] = {law(SP_SIZES_UNIFORM, 0.3, 1.7, n), law(SP_SIZES_LOGNORMAL, 0, 0, n),
                            law(SP_SIZES_LOGNORMAL, 1.1, 2, n), law(SP_SIZES_LOGNORMAL, 0.4, 0.95, n)};
    for (size_t l = 0; l < sizeof specs / sizeof *specs; l++) {
        double *r = draw(&specs[l]);
        for (int k = 1; k <= 3; k++) {
            const double mean = sp_sizes_moment(&specs[l], k), square = sp_sizes_moment(&specs[l], 2 * k);
            assert_relative(mean, moment_by_sum(&specs[l], k), 1e-6);
            double sum = 0;
            for (int32_t i = 0; i < n; i++)
                sum += pow(2 * r[i], k);
            assert_close(sum / n, mean, 4 * sqrt((square - mean * mean) / n)); /* four standard errors */
        }
        assert_relative(sp_sizes_mean_area(&specs[l]), 0.785398163397 * sp_sizes_moment(&specs[l], 2), 1e-11);
        assert_relative(sp_sizes_mean_volume(&specs[l]), 0.523598775598 * sp_sizes_moment(&specs[l], 3), 1e-11);
        sp_free(r);
    }
    /* a whole lognormal law has mean 1; three standard deviations hold all but 0.0027 of it */
    sp_pack_spec whole = law(SP_SIZES_LOGNORMAL, exp(-0.02 - 2), exp(-0.02 + 2), 1);
    assert_close(sp_sizes_moment(&whole, 1), 1, 1e-12);
    assert_close(sp_sizes_within(&specs[1]), 0.9973002039, 1e-9);
    assert_relative(specs[1].diameter_min, exp(-0.02 - 0.6), 1e-15);
    assert_relative(specs[1].diameter_max, exp(-0.02 + 0.6), 1e-15);
}

TEST(of_two_sizes_the_number_is_exact) {
    const double fractions[] = {0, 0.1, 0.5, 0.777, 1};
    for (int k = 0; k < 5; k++) {
        sp_pack_spec s = law(SP_SIZES_BIDISPERSE, 0.7, 1.4, 1001);
        s.large_fraction = fractions[k];
        double *r = draw(&s);
        int large = 0, changes = 0;
        for (int i = 0; i < s.grains; i++) {
            assert_true(2 * r[i] == 0.7 || 2 * r[i] == 1.4);
            large += 2 * r[i] > 1;
            changes += i > 0 && r[i] != r[i - 1];
        }
        assert_int_equal(large, (int)floor(fractions[k] * 1001 + 0.5));
        /* mixed: a place is a change with probability 2 f (1 - f); five standard deviations of at most sqrt(N)/2 */
        assert_close(changes, 2000 * fractions[k] * (1 - fractions[k]), 5 * 0.5 * sqrt(1001));
        assert_relative(sp_sizes_moment(&s, 1), 0.7 + 0.7 * fractions[k], 1e-14);
        sp_free(r);
    }
}

TEST(a_list_is_taken_in_order) {
    const double list[] = {0.9, 1.3, 0.8, 1, 5};
    sp_pack_spec s = sp_pack_spec_default();
    s.sizes = SP_SIZES_LIST;
    s.grains = 4;
    s.diameters = list;
    s.diameter_count = 5;
    s = sp_pack_spec_resolve(&s);
    assert_true(s.diameter_min == 0.8 && s.diameter_max == 1.3); /* the fifth belongs to no grain */
    double *r = draw(&s);
    for (int i = 0; i < 4; i++)
        assert_true(2 * r[i] == list[i]);
    assert_close(sp_sizes_moment(&s, 1), 1, 1e-15);
    sp_free(r);
    const sp_pack_spec again = sp_pack_spec_resolve(&s);
    assert_memory_equal(&s, &again, sizeof s);
    assert_ok(sp_pack_spec_check(&s, &err));
}

/* The same on every machine: no bit comes from its mathematical library. */
TEST(drawn_alike_everywhere) {
    sp_pack_spec s = law(SP_SIZES_LOGNORMAL, 0, 0, 1000);
    double *r = draw(&s);
    char hash[SP_NAME_MAX];
    sp_hash128(r, 1000 * sizeof *r, hash);
    assert_string_equal(hash, "d0c772ade15c2a8f8a6e6f51b237d6bd");
    sp_free(r);
}

/* ---- gas ------------------------------------------------------------------------------------------------------- */

static double volume_of(int dim, const sp_pack_spec *s, const double *r) {
    double sum = 0;
    for (int32_t i = 0; i < s->grains; i++)
        sum += dim == 2 ? 3.14159265358979 * r[i] * r[i] : 4.18879020478639 * r[i] * r[i] * r[i];
    return sum;
}

static void assert_no_overlap(const sp_pack_spec *s, const double *r, const double *x, const double box[3]) {
    const int up = s->dim - 1;
    for (int32_t i = 0; i < s->grains; i++) {
        const double *a = x + 3 * (size_t)i;
        for (int k = 0; k < up; k++)
            assert_true(a[k] >= 0 && a[k] < box[k]);
        assert_true(a[up] >= r[i] * (1 - 1e-15) && a[up] <= box[up] - r[i] * (1 - 1e-15));
        assert_true(s->dim == 3 || a[2] == 0);
        for (int32_t j = i + 1; j < s->grains; j++) {
            double sum = 0;
            for (int k = 0; k < s->dim; k++) {
                double d = fabs(a[k] - x[3 * (size_t)j + (size_t)k]);
                d = k < up ? fmin(d, box[k] - d) : d;
                sum += d * d;
            }
            const double reach = r[i] + r[j]; /* the distance is rounded along another way than in the gas */
            if (!(sum >= reach * reach * (1 - 1e-12)))
                fail_msg("grains %d and %d overlap: distance %g, radii %g %g", i, j, sqrt(sum), r[i], r[j]);
        }
    }
}

static void check_gas(sp_pack_spec s) {
    s.dim = s.dim ? s.dim : 2;
    s = sp_pack_spec_resolve(&s);
    assert_ok(sp_pack_spec_check(&s, &err));
    const size_t n = (size_t)s.grains;
    double *r = draw(&s), *x = sp_alloc(3 * n, sizeof *x), *again = sp_alloc(3 * n, sizeof *x), h = 0, h_again = 0;
    assert_ok(sp_gas_make(&s, r, x, &h, &err));
    assert_ok(sp_gas_make(&s, r, again, &h_again, &err));
    assert_memory_equal(x, again, 3 * n * sizeof *x);
    const double box[] = {s.width, s.dim == 3 ? s.depth : h, h};
    assert_no_overlap(&s, r, x, box);
    const double volume = s.width * h * (s.dim == 3 ? s.depth : 1);
    if (s.grains > 100) /* fewer have more room than asked for */
        assert_relative(volume_of(s.dim, &s, r) / volume, s.gas_fraction, 1e-12);
    sp_free(again);
    sp_free(x);
    sp_free(r);
}

TEST(grains_of_a_gas_do_not_overlap) {
    for (int dim = 2; dim <= 3; dim++) {
        const double dense = dim == 2 ? 0.45 : 0.3;
        sp_pack_spec s = sp_pack_spec_default();
        s.dim = dim;
        s.width = dim == 2 ? 24 : 8;
        check_gas(s);
        s.gas_fraction = dense;
        s.diameter_min = s.diameter_max = 1; /* equal grains leave the least room */
        s.grains = 2000;
        check_gas(s);
        s.grains = 1;
        s.width = 4;
        check_gas(s);
        s.grains = 2000;
        s.diameter_min = 0.2; /* 10:1 */
        s.diameter_max = 2;
        s.width = 8;
        s.depth = dim == 3 ? 9 : 0;
        check_gas(s);
        s.sizes = SP_SIZES_BIDISPERSE; /* 100:1 */
        s.diameter_min = 0.05;
        s.diameter_max = 5;
        s.large_fraction = 0.05;
        s.width = s.depth = 20;
        s.depth = dim == 3 ? 20 : 0;
        check_gas(s);
        s.sizes = SP_SIZES_LOGNORMAL;
        s.size_spread = 0.5;
        s.diameter_min = 0.09;
        s.diameter_max = 5;
        check_gas(s);
    }
}

/* In a gas of one size class grains are placed as they are numbered, and anywhere alike: the mean height is the middle,
 * to four standard errors of a uniform law (walls keep them away symmetrically). */
TEST(a_gas_is_even) {
    sp_pack_spec s = sp_pack_spec_default();
    s.grains = 20000;
    s.width = 100;
    s = sp_pack_spec_resolve(&s);
    const size_t n = (size_t)s.grains;
    double *r = draw(&s), *x = sp_alloc(3 * n, sizeof *x), h = 0, sum[2] = {0}, first[3];
    assert_ok(sp_gas_make(&s, r, x, &h, &err));
    for (size_t i = 0; i < n; i++)
        for (size_t k = 0; k < 2; k++)
            sum[k] += x[3 * i + k] / (double)n;
    assert_close(sum[0], 50, 4 * 100 / sqrt(12.0 * (double)n));
    assert_close(sum[1], 0.5 * h, 4 * h / sqrt(12.0 * (double)n));
    memcpy(first, x, sizeof first);
    const double before = h;
    s.grains = 1000; /* another height, the same first grain in proportion */
    assert_ok(sp_gas_make(&s, r, x, &h, &err));
    assert_true(x[0] == first[0]);
    assert_close((x[1] - r[0]) / (h - 2 * r[0]), (first[1] - r[0]) / (before - 2 * r[0]), 1e-14);
    sp_free(x);
    sp_free(r);
}

TEST(no_room_is_an_error) {
    sp_pack_spec s = sp_pack_spec_default();
    s.diameter_min = s.diameter_max = 1;
    s.width = 10;
    s.gas_fraction = 0.7;
    s.grains = 200;
    s = sp_pack_spec_resolve(&s);
    double *r = draw(&s), *x = sp_alloc(600, sizeof *x), h = -1;
    assert_fails(sp_gas_make(&s, r, x, &h, &err), SP_EFAILED, "packing.gas_fraction 0.7");
    assert_true(h == -1);
    s.gas_fraction = 0.3;
    EACH_ALLOCATION_FAILS(1, sp_gas_make(&s, r, x, &h, &err), assert_true(lacks == (h < 0)));
    sp_free(x);
    sp_free(r);
}

TEST(a_lattice_starts_apart) {
    sp_pack_spec s = sp_pack_spec_default();
    s.kind = SP_PACK_TRIANGULAR;
    s.grains = 24 * 11;
    s.diameter_min = 0.9;
    s.diameter_max = 1.1;
    assert_ok(sp_pack_spec_check(&s, &err));
    s = sp_pack_spec_resolve(&s);
    double *r = sp_alloc(264, sizeof *r), *x = sp_alloc(3 * 264, sizeof *x), sum = 0;
    sp_lattice_start start;
    assert_ok(sp_triangular_start(&s, r, x, &start, &err));
    const double box[] = {start.width, start.height, 1};
    assert_no_overlap(&s, r, x, box);
    for (int i = 0; i < 264; i++)
        sum += 2 * r[i] / 264;
    /* what it ends at: the perfect lattice of the mean diameter */
    sp_pack_spec equal = s;
    equal.diameter_min = equal.diameter_max = sum;
    equal.width = 24 * sum;
    FREED(sp_packing) p = sp_packing_none();
    assert_ok(sp_packing_make(&equal, NULL, NULL, &p, &err));
    assert_relative(start.width_end, p.box[0], 1e-14);
    assert_relative(start.height_end, p.box[1], 1e-14);
    s.pressure = 1e-2;
    s.width *= 0.02;
    s.diameter_min *= 0.02;
    s.diameter_max *= 0.02;
    r[0] = -1;
    assert_fails(sp_triangular_start(&s, r, x, &start, &err), SP_EFAILED, "packing.pressure 0.01");
    assert_true(r[0] == -1);
    sp_free(x);
    sp_free(r);
}

RUN_TESTS(NULL, NULL)
