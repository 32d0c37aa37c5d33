/* LDL' factors of sparse symmetric matrices: the inertia against the eigenvalues of LAPACK, the bound of the error
 * against the factor multiplied out in long double, and solutions against their residuals. */
#include "linalg/complex_ldl.h"
#include "linalg/eigen.h"
#include "linalg/ldl.c" /* this test reads the factor, which is private */
#include "reference.h"

/* ---- matrices, whole: [n][n] ----------------------------------------------------------------------------------- */

typedef struct whole {
    int n;
    double *x;
} whole;

static double *at(const whole *a, int r, int c) { return a->x + (size_t)r * (size_t)a->n + c; }

static whole zero_matrix(int n) { return (whole){n, calloc((size_t)n * (size_t)n, sizeof(double))}; }

static double any(void) { return 2.0 * rand() / RAND_MAX - 1; }

static void set(const whole *a, int r, int c, double x) { *at(a, r, c) = *at(a, c, r) = x; }

/* Each entry is there with this probability. */
static whole random_matrix(int n, double density, unsigned seed) {
    const whole a = zero_matrix(n);
    srand(seed);
    for (int r = 0; r < n; r++)
        for (int c = 0; c <= r; c++)
            if (r == c || rand() < density * RAND_MAX)
                set(&a, r, c, any());
    return a;
}

static whole diagonal_matrix(int n) {
    const whole a = zero_matrix(n);
    for (int k = 0; k < n; k++)
        set(&a, k, k, k - 0.3 * n);
    return a;
}

/* A diagonal, and one row that is full. */
static whole arrow_matrix(int n, int row) {
    const whole a = diagonal_matrix(n);
    for (int k = 0; k < n; k++)
        if (k != row)
            set(&a, row, k, 1 + 0.01 * k);
    return a;
}

/* Three random matrices without entries between them, and rows that have a diagonal entry alone. */
static whole disconnected_matrix(int n) {
    const whole a = random_matrix(n, 0.3, 5);
    for (int r = 0; r < n; r++)
        for (int c = 0; c < r; c++)
            if (r % 4 != c % 4 || r % 4 == 3)
                set(&a, r, c, 0);
    return a;
}

static whole stiffness_of(sp_packing p) {
    FREED(sp_network) net = default_network(&p);
    FREED(sp_sparse) k = {0};
    assert_ok(sp_network_assemble(&net, &k, &err));
    const whole a = zero_matrix((int)k.n);
    for (int c = 0; c < a.n; c++)
        for (int64_t q = k.p[c]; q < k.p[c + 1]; q++)
            set(&a, (int)k.i[q], c, k.x[q]);
    sp_packing_free(&p);
    return a;
}

/* The lower triangle of what is not zero, and the diagonal. */
static sp_sparse sparse_of(const whole *a) {
    const size_t n = (size_t)a->n, most = n * (n + 1) / 2;
    sp_sparse s = {a->n, sp_alloc(n + 1, sizeof *s.p), sp_alloc(most, sizeof *s.i), sp_alloc(most, sizeof *s.x)};
    int64_t k = 0;
    for (int c = 0; c < a->n; c++) {
        for (int r = c; r < a->n; r++)
            if (r == c || *at(a, r, c) != 0) {
                s.i[k] = r;
                s.x[k++] = *at(a, r, c);
            }
        s.p[c + 1] = k;
    }
    return s;
}

static sp_ldl *ldl_of(const whole *a) {
    FREED(sp_sparse) s = sparse_of(a);
    sp_ldl *f = NULL;
    assert_ok(sp_ldl_make(&s, NULL, &f, &err));
    return f;
}

/* ---- checks ---------------------------------------------------------------------------------------------------- */

static double largest(int64_t n, const double *x) {
    double most = 0;
    for (int64_t k = 0; k < n; k++)
        most = fmax(most, fabs(x[k]));
    return most;
}

static double *values_of(const whole *a) {
    const size_t n = (size_t)a->n;
    double *copy = malloc(n * n * sizeof *copy), *w = malloc(n * sizeof *w);
    memcpy(copy, a->x, n * n * sizeof *copy);
    assert_ok(sp_eigen_all(a->n, copy, w, &err));
    free(copy);
    return w;
}

static int64_t below(int n, const double *w, double limit) {
    int64_t count = 0;
    while (count < n && w[count] < limit)
        count++;
    return count;
}

/* The factor as a whole matrix, by rows, with D on the diagonal. */
static double *whole_factor(const sp_ldl *f) {
    const int64_t n = f->s.n;
    double *l = calloc((size_t)(n * n), sizeof *l);
    for (int64_t k = 0; k < f->s.count; k++) {
        const int width = sp_supernode_width(&f->s, k), many = sp_supernode_rows(&f->s, k);
        const double *x = f->value + f->s.value_at[k];
        const int32_t *row = f->s.rows + f->s.rows_at[k];
        for (int r = 0; r < many; r++)
            for (int c = 0; c < width && c < r; c++)
                l[row[r] * n + f->s.first[k] + c] = x[(int64_t)r * width + c];
    }
    for (int64_t k = 0; k < n; k++)
        l[k * n + k] = f->pivot[k];
    return l;
}

/* The largest row sum of |A - sigma - P' L D L' P|, in long double. */
static double true_error(const whole *a, const sp_ldl *f) {
    const int64_t n = a->n;
    RELEASED double *l = whole_factor(f), *sum = calloc((size_t)n, sizeof *sum);
    RELEASED long double *scaled = calloc((size_t)n, sizeof *scaled);
    for (int64_t r = 0; r < n; r++) {
        for (int64_t k = 0; k < r; k++)
            scaled[k] = (long double)l[r * n + k] * l[k * n + k];
        scaled[r] = l[r * n + r];
        for (int64_t c = 0; c <= r; c++) {
            long double left = *at(a, f->s.order[r], f->s.order[c]) - (r == c ? (long double)f->sigma : 0);
            for (int64_t k = 0; k < c; k++)
                left -= scaled[k] * l[c * n + k];
            left -= scaled[c];
            sum[r] += fabs((double)left);
            sum[c] += r == c ? 0 : fabs((double)left);
        }
    }
    const double most = largest(n, sum);
    return most;
}

/* Largest |b - (A - sigma) x|. */
static double residual(const whole *a, double sigma, const double *b, const double *x) {
    double most = 0;
    for (int r = 0; r < a->n; r++) {
        long double left = b[r] + (long double)sigma * x[r];
        for (int c = 0; c < a->n; c++)
            left -= (long double)*at(a, r, c) * x[c];
        most = fmax(most, fabs((double)left));
    }
    return most;
}

/* The rounding of a solution is that of a few factors: it solves the equations of a matrix within some errors of A. */
static void check_solves(const whole *a, const double *w, sp_ldl *f) {
    const int n = a->n;
    const double sigma = sp_ldl_sigma(f), error = 3 * sp_ldl_error(f);
    double *b = malloc((size_t)(8 * n) * sizeof *b), *x = malloc((size_t)(8 * n) * sizeof *x),
           *one = malloc((size_t)n * sizeof *one), nearest = HUGE_VAL;
    for (int k = 0; k < n; k++)
        nearest = fmin(nearest, fabs(w[k] - sigma));
    for (int k = 0; k < 8 * n; k++)
        b[k] = any() * (k / n == 3 ? 1e-200 : 1); /* one of them is small */
    sp_ldl_solve(f, b, x);
    for (int q = 0; q < 8; q++) {
        const double size = largest(n, x + q * n);
        assert_true(residual(a, sigma, b + q * n, x + q * n) <= error * size);
        sp_ldl_solve_one(f, b + q * n, one);
        assert_true(residual(a, sigma, b + q * n, one) <= error * size);
        for (int k = 0; k < n; k++)
            assert_close(one[k], x[q * n + k], 2 * error * sqrt(n) / nearest * size);
    }
    memcpy(one, b, (size_t)n * sizeof *b);
    sp_ldl_solve_one(f, one, one);
    sp_ldl_solve(f, b, b);
    assert_memory_equal(b, x, (size_t)(8 * n) * sizeof *b);
    for (int k = 0; k < n; k++)
        assert_close(one[k], x[k], 2 * error * sqrt(n) / nearest * largest(n, x));
    free(one);
    free(x);
    free(b);
}

/* One shift; returns whether the count is beyond doubt. */
static bool check_shift(const whole *a, const double *w, sp_ldl *f, double sigma) {
    sp_error reason;
    const sp_status status = sp_ldl_factor(f, sigma, &reason);
    if (status == SP_EREFUSED) {
        assert_true(isinf(sp_ldl_error(f)));
        return false;
    }
    assert_int_equal(status, SP_OK);
    assert_true(sp_ldl_sigma(f) == sigma);
    const double size = fmax(fabs(w[0]), fabs(w[a->n - 1])), error = sp_ldl_error(f), truth = true_error(a, f),
                 doubt = error + 4 * a->n * DBL_EPSILON * size; /* and LAPACK's */
    if (!(truth <= error))
        fail_msg("n = %d, shift %.17g: error %g, bound %g", a->n, sigma, truth, error);
    const int64_t least = below(a->n, w, sigma - doubt), most = below(a->n, w, sigma + doubt);
    if (sp_ldl_negative(f) < least || sp_ldl_negative(f) > most)
        fail_msg("n = %d, shift %.17g: %d eigenvalues below, expected %d .. %d", a->n, sigma, (int)sp_ldl_negative(f),
                 (int)least, (int)most);
    if (error > 1e-6 * (size + fabs(sigma))) /* spoilt by a small pivot, and says so */
        return false;
    check_solves(a, w, f);
    return least == most;
}

/* Shifts below, inside and above the spectrum, and halfway between eigenvalues or 1e-6 away from them. */
static void check_matrix(whole a, int shifts) {
    RELEASED double *w = values_of(&a);
    sp_ldl *f = ldl_of(&a);
    const double size = fmax(fabs(w[0]), fabs(w[a.n - 1])) + 1e-3;
    int certain = check_shift(&a, w, f, w[0] - 0.01 * size) + check_shift(&a, w, f, w[a.n - 1] + 0.01 * size);
    for (int k = 0; k < shifts; k++) {
        const int64_t some = rand() % a.n;
        const double step = some + 1 < a.n ? 0.5 * (w[some + 1] - w[some]) : size;
        certain += check_shift(&a, w, f, w[some] + (k % 2 ? fmax(step, 1e-6 * size) : 1e-6 * size));
    }
    if (certain < 2 + shifts / 4)
        fail_msg("n = %d: only %d of %d counts are certain", a.n, certain, shifts + 2);
    sp_ldl_free(f);
    free(a.x);
}

/* ---- tests ----------------------------------------------------------------------------------------------------- */

TEST(test_random) {
    const int sizes[] = {1, 2, 3, 5, 8, 9, 31, 64, 150};
    for (unsigned k = 0; k < sizeof sizes / sizeof *sizes; k++) {
        check_matrix(random_matrix(sizes[k], 0.03, 100 + k), 8);
        check_matrix(random_matrix(sizes[k], 0.15, 200 + k), 8);
        check_matrix(random_matrix(sizes[k], 1, 300 + k), 8);
    }
}

TEST(test_shapes) {
    check_matrix(diagonal_matrix(1), 4);
    check_matrix(diagonal_matrix(77), 12);
    check_matrix(arrow_matrix(60, 0), 12);
    check_matrix(arrow_matrix(60, 59), 12);
    check_matrix(arrow_matrix(60, 31), 12);
    check_matrix(disconnected_matrix(90), 12);
}

TEST(test_stiffness) {
    check_matrix(stiffness_of(chain_packing(200, 1e-4)), 8);
    check_matrix(stiffness_of(chains_packing(7, 11, 1e-4)), 8);
    check_matrix(stiffness_of(scattered_packing(2, 9, 0.5, 1)), 8);
    check_matrix(stiffness_of(scattered_packing(2, 12, 0, 2)), 8);
    check_matrix(stiffness_of(scattered_packing(3, 4, 0.5, 3)), 8);
    check_matrix(stiffness_of(scattered_packing(3, 4, 0, 4)), 8);
}

/* One supernode, wider than the blocks of its factor and of its solves; and two that share rows below. */
TEST(test_wide) {
    check_matrix(random_matrix(97, 1, 7), 2);
    check_matrix(random_matrix(255, 1, 8), 2);
    check_matrix(random_matrix(257, 1, 9), 2);
    check_matrix(random_matrix(700, 1, 10), 2);
    const whole a = random_matrix(500, 1, 11);
    for (int r = 280; r < 500; r++)
        for (int c = 0; c < 280 && r < 430; c++)
            set(&a, r, c, 0);
    sp_ldl *f = ldl_of(&a);
    assert_true(f->s.count >= 2 && f->s.largest_panel < 500L * 500);
    sp_ldl_free(f);
    check_matrix(a, 4);
}

/* A pivot of 1e-20 swallows the 2 below it: the factor is that of a matrix far away, and its bound says so. */
TEST(test_small_pivot) {
    const whole a = zero_matrix(2);
    set(&a, 0, 0, 1e-20);
    set(&a, 0, 1, 1);
    set(&a, 1, 1, 1e-20);
    sp_ldl *f = ldl_of(&a);
    assert_ok(sp_ldl_factor(f, 0, &err));
    assert_true(sp_ldl_error(f) > 1);
    assert_true(true_error(&a, f) <= sp_ldl_error(f));
    assert_ok(sp_ldl_factor(f, 0.5, &err)); /* eigenvalues -1 and 1 */
    assert_int_equal(sp_ldl_negative(f), 1);
    assert_true(sp_ldl_error(f) < 1e-13);
    sp_ldl_free(f);
    set(&a, 0, 0, 1e-308);
    set(&a, 0, 1, 100); /* its entry of L overflows */
    set(&a, 1, 1, 1e-308);
    f = ldl_of(&a);
    assert_fails(sp_ldl_factor(f, 0, &err), SP_EREFUSED, "");
    sp_ldl_free(f);
    free(a.x);
}

TEST(test_zero_pivots) {
    const whole a = zero_matrix(2), d = diagonal_matrix(10);
    double b[8 * 10], x[8 * 10];
    set(&a, 0, 1, 1);
    sp_ldl *f = ldl_of(&a), *g = ldl_of(&d);
    assert_true(isinf(sp_ldl_error(f)));
    assert_fails(sp_ldl_factor(f, 0, &err), SP_EREFUSED, "0 2");
    assert_true(isinf(sp_ldl_error(f)));
    assert_ok(sp_ldl_factor(f, 0.25, &err));
    assert_int_equal(sp_ldl_negative(f), 1);
    assert_fails(sp_ldl_factor(g, 4, &err), SP_EREFUSED, "4"); /* an eigenvalue */
    assert_ok(sp_ldl_factor(g, 4.5, &err));
    assert_int_equal(sp_ldl_negative(g), 8);
    for (int k = 0; k < 80; k++)
        b[k] = k;
    sp_ldl_solve(g, b, x);
    for (int k = 0; k < 80; k++)
        assert_close(x[k], k / (k % 10 - 7.5), 1e-14 * k); /* k - 0.3 n - 4.5 */
    sp_ldl_free(f);
    sp_ldl_free(g);
    sp_ldl_free(NULL);
    free(a.x);
    free(d.x);
}

TEST(test_not_finite) {
    const double bad[] = {NAN, INFINITY, -INFINITY};
    const whole a = random_matrix(6, 1, 3);
    sp_ldl *f = ldl_of(&a), *g = NULL;
    FREED(sp_sparse) s = sparse_of(&a);
    for (int k = 0; k < 3; k++) {
        assert_fails(sp_ldl_factor(f, bad[k], &err), SP_EINVAL, "shift");
        assert_true(isinf(sp_ldl_error(f)));
        for (int q = 0; q < 21; q += 5) {
            const double kept = s.x[q];
            s.x[q] = bad[k];
            assert_fails(sp_ldl_make(&s, NULL, &g, &err), SP_EINVAL, "");
            s.x[q] = kept;
        }
    }
    s.x[0] = s.x[6] = 1e308; /* their sum overflows */
    s.x[1] = 1e308;
    assert_fails(sp_ldl_make(&s, NULL, &g, &err), SP_EINVAL, "");
    assert_null(g);
    s.n = 0;
    assert_fails(sp_ldl_make(&s, NULL, &g, &err), SP_EREFUSED, "0");
    s.n = 6;
    sp_ldl_free(f);
    free(a.x);
}

TEST(test_no_memory) {
    const whole a = random_matrix(40, 0.2, 4);
    FREED(sp_sparse) s = sparse_of(&a);
    sp_ldl *f = NULL;
    EACH_ALLOCATION_FAILS(8, sp_ldl_make(&s, NULL, &f, &err), assert_true(!lacks || !f));
    sp_alloc_fail_after(0); /* a factor needs no more */
    assert_ok(sp_ldl_factor(f, -20, &err));
    sp_alloc_fail_after(-1);
    sp_ldl_free(f);
    free(a.x);
}

/* ---- complex --------------------------------------------------------------------------------------------------- */

typedef long double _Complex wide;

/* Largest |b - A x| over the largest row sum of |A| times the largest |x|; x: (real, imaginary). */
static double complex_residual(const whole *re, const whole *im, const double *b, const double *x) {
    double most = 0, norm = 0, size = 0;
    for (int r = 0; r < re->n; r++) {
        wide left = b[2 * r] + (wide)1i * b[2 * r + 1];
        double sum = 0;
        for (int c = 0; c < re->n; c++) {
            left -= (*at(re, r, c) + (wide)1i * *at(im, r, c)) * (x[2 * c] + (wide)1i * x[2 * c + 1]);
            sum += hypot(*at(re, r, c), *at(im, r, c));
        }
        most = fmax(most, hypot((double)__real__ left, (double)__imag__ left));
        norm = fmax(norm, sum);
        size = fmax(size, hypot(x[2 * r], x[2 * r + 1]));
    }
    return most / (norm * size);
}

static sp_complex_ldl *complex_ldl_of(const whole *re, const whole *im, double **values) {
    const whole both = zero_matrix(re->n);
    sp_complex_ldl *f = NULL;
    for (int k = 0; k < re->n * re->n; k++)
        both.x[k] = re->x[k] != 0 || im->x[k] != 0;
    FREED(sp_sparse) s = sparse_of(&both);
    *values = malloc(2 * (size_t)s.p[s.n] * sizeof **values);
    for (int c = 0; c < re->n; c++)
        for (int64_t q = s.p[c]; q < s.p[c + 1]; q++) {
            (*values)[2 * q] = *at(re, (int)s.i[q], c);
            (*values)[2 * q + 1] = *at(im, (int)s.i[q], c);
        }
    assert_ok(sp_complex_ldl_make(&s, NULL, &f, &err));
    free(both.x);
    return f;
}

/* A with the imaginary part `damping` on the diagonal: no pivot is then smaller than it. */
static void check_complex(whole re, whole im, double damping) {
    const int counts[] = {1, 7, 40, 7, 1}, n = re.n;
    double *values, *b = malloc(2 * 40 * (size_t)n * sizeof *b), *x = malloc(2 * 40 * (size_t)n * sizeof *x);
    for (int k = 0; k < n; k++)
        *at(&im, k, k) += damping;
    sp_complex_ldl *f = complex_ldl_of(&re, &im, &values);
    assert_ok(sp_complex_ldl_factor(f, values, &err));
    for (size_t q = 0; q < sizeof counts / sizeof *counts; q++) {
        for (int k = 0; k < 2 * counts[q] * n; k++)
            b[k] = any();
        assert_ok(sp_complex_ldl_solve(f, counts[q], b, x, &err));
        for (int k = 0; k < counts[q]; k++)
            assert_close(complex_residual(&re, &im, b + 2 * k * n, x + 2 * k * n), 0, 1e-13);
        assert_ok(sp_complex_ldl_solve(f, counts[q], b, b, &err));
        assert_memory_equal(b, x, 2 * (size_t)(counts[q] * n) * sizeof *b);
    }
    sp_complex_ldl_free(f);
    free(values);
    free(x);
    free(b);
    free(re.x);
    free(im.x);
}

TEST(test_complex) {
    check_complex(random_matrix(1, 1, 1), zero_matrix(1), 1);
    check_complex(random_matrix(12, 1, 2), random_matrix(12, 0.3, 3), 5);
    check_complex(random_matrix(90, 0.1, 4), random_matrix(90, 0.05, 5), 5);
    check_complex(diagonal_matrix(30), zero_matrix(30), 1);
    check_complex(arrow_matrix(50, 20), zero_matrix(50), -1);
    check_complex(disconnected_matrix(80), random_matrix(80, 0, 6), 3);
    check_complex(stiffness_of(scattered_packing(2, 8, 0.5, 6)), zero_matrix(3 * 64), 0.05);
    check_complex(stiffness_of(scattered_packing(3, 4, 0.5, 7)), zero_matrix(6 * 64), -0.05);
    check_complex(random_matrix(300, 1, 8), random_matrix(300, 1, 9), 40); /* one wide supernode */
}

/* Real numbers give the real solution; the factor is not that of a Hermitian matrix. */
TEST(test_complex_is_symmetric) {
    const whole re = zero_matrix(2), im = zero_matrix(2);
    double *values, x[4] = {1, 0, 0, 0};
    set(&re, 0, 0, 2);
    set(&re, 1, 1, 1);
    set(&im, 0, 1, 1); /* (2, i; i, 1), with the determinant 3 */
    sp_complex_ldl *f = complex_ldl_of(&re, &im, &values);
    assert_ok(sp_complex_ldl_factor(f, values, &err));
    assert_ok(sp_complex_ldl_solve(f, 1, x, x, &err));
    assert_close(x[0], 1.0 / 3, 1e-15);
    assert_close(x[1], 0, 1e-15);
    assert_close(x[2], 0, 1e-15);
    assert_close(x[3], -1.0 / 3, 1e-15);
    memset(values, 0, 6 * sizeof *values);
    assert_fails(sp_complex_ldl_factor(f, values, &err), SP_EREFUSED, "");
    values[0] = values[4] = NAN;
    assert_fails(sp_complex_ldl_factor(f, values, &err), SP_EREFUSED, "");
    values[0] = values[4] = INFINITY;
    assert_fails(sp_complex_ldl_factor(f, values, &err), SP_EREFUSED, "");
    sp_complex_ldl_free(f);
    sp_complex_ldl_free(NULL);
    free(values);
    free(re.x);
    free(im.x);
}

TEST(test_complex_without_memory) {
    enum { ROWS = 40 };
    const whole a = random_matrix(ROWS, 0.2, 4), nothing = zero_matrix(ROWS);
    double *values, b[2 * 3 * ROWS] = {1}, x[2 * 3 * ROWS];
    sp_complex_ldl *f = complex_ldl_of(&a, &nothing, &values), *g = NULL;
    FREED(sp_sparse) s = sparse_of(&a);
    EACH_ALLOCATION_FAILS(8, sp_complex_ldl_make(&s, NULL, &g, &err), assert_true(!lacks || !g));
    sp_complex_ldl_free(g);
    assert_ok(sp_complex_ldl_factor(f, values, &err));
    EACH_ALLOCATION_FAILS(0, sp_complex_ldl_solve(f, 3, b, x, &err), ); /* what failed can be done again */
    assert_close(complex_residual(&a, &nothing, b, x), 0, 1e-10);
    sp_complex_ldl_free(f);
    free(values);
    free(nothing.x);
    free(a.x);
}

RUN_TESTS(NULL, NULL)
