#include "base/base.h"
#include "base/vector.h"
#include "linalg/eigen.h"
#include "linalg/krylov.h"
#include "linalg/ldl.h"
#include "test.h"

#include <float.h>

/* Symmetric with entries in -1 .. 1; the upper triangle is spoiled, for only the lower may be read. */
static double *random_matrix(int n, unsigned seed) {
    double *a = calloc((size_t)(n * n), sizeof *a);
    srand(seed);
    for (int c = 0; c < n; c++)
        for (int r = 0; r < n; r++)
            a[c * n + r] = r >= c ? 2.0 * rand() / RAND_MAX - 1 : 1e30;
    return a;
}

static double lower(const double *a, int n, int r, int c) { return r >= c ? a[c * n + r] : a[r * n + c]; }

static void check_vectors(int n, int count, const double *a, const double *w, const double *v) {
    double orthogonality;
    for (int m = 0; m < count; m++)
        for (int r = 0; r < n; r++) {
            double sum = 0;
            for (int c = 0; c < n; c++)
                sum += lower(a, n, r, c) * v[m * n + c];
            assert_close(sum, w[m] * v[m * n + r], 60 * DBL_EPSILON * sqrt(n));
        }
    assert_ok(sp_orthogonality(n, count, v, &orthogonality, &err));
    /* a small multiple of n eps (Dhillon, Parlett and Voemel, ACM Trans. Math. Softw. 32, 533, 2006); 1.0e-13 with the
     * kernels that BLAS has for some processors, less with others */
    assert_close(orthogonality, 0, 20 * n * DBL_EPSILON);
}

TEST(test_dense) {
    const int sizes[] = {1, 2, 3, 17, 90};
    for (size_t q = 0; q < sizeof sizes / sizeof *sizes; q++) {
        const int n = sizes[q];
        double *a = random_matrix(n, 1), *copy = random_matrix(n, 1), w[90], values[90], v[90 * 90];
        FREED(sp_tridiagonal) t;
        assert_ok(sp_eigen_all(n, a, w, &err));
        for (int m = 1; m < n; m++)
            assert_true(w[m] >= w[m - 1]);
        check_vectors(n, n, copy, w, a);
        memcpy(a, copy, (size_t)(n * n) * sizeof *a);
        assert_ok(sp_tridiagonal_make(n, a, &t, &err));
        assert_ok(sp_tridiagonal_values(&t, values, &err));
        for (int m = 0; m < n; m++)
            assert_close(values[m], w[m], 60 * DBL_EPSILON * sqrt(n));
        for (int count = 1; count <= n; count += 1 + n / 3) {
            assert_ok(sp_tridiagonal_vectors(&t, count, v, &err));
            check_vectors(n, count, copy, w, v);
        }
        assert_fails(sp_tridiagonal_vectors(&t, n + 1, v, &err), SP_EINVAL, "");
        assert_fails(sp_tridiagonal_vectors(&t, 0, v, &err), SP_EINVAL, "0");
        free(copy);
        free(a);
    }
}

TEST(test_refusals) {
    double a[4] = {1, 0, 0, 1}, w[2];
    sp_tridiagonal t;
    const double bad[] = {NAN, INFINITY};
    assert_fails(sp_eigen_all(0, a, w, &err), SP_EINVAL, "0");
    assert_fails(sp_eigen_all(40000, a, w, &err), SP_EINVAL, "40000");
    for (int k = 0; k < 2; k++) {
        a[1] = bad[k];
        assert_fails(sp_eigen_all(2, a, w, &err), SP_EINVAL, "");
        assert_fails(sp_tridiagonal_make(2, a, &t, &err), SP_EINVAL, "");
    }
}

TEST(test_orthogonality_sees) {
    enum { N = 200 };
    double *v = calloc(N * N, sizeof *v), largest;
    for (int k = 0; k < N; k++)
        v[k * N + k] = 1;
    assert_ok(sp_orthogonality(N, N, v, &largest, &err));
    assert_true(largest == 0);
    v[150 * N + 3] = 1e-5; /* vectors of different blocks */
    assert_ok(sp_orthogonality(N, N, v, &largest, &err));
    assert_close(largest, 1e-5, 1e-15);
    v[199 * N + 199] = 1.5;
    assert_ok(sp_orthogonality(N, N, v, &largest, &err));
    assert_close(largest, 1.25, 1e-15);
    free(v);
}

/* The chain matrix 2, -1 with `middle` on the diagonal of row n/2. Its inverse is known. */
enum { N = 50 };
typedef struct chain_matrix {
    int64_t p[N + 1], i[2 * N];
    double x[2 * N];
    sp_sparse a;
} chain_matrix;

static void fill_chain(chain_matrix *m, double middle) {
    int64_t at = 0;
    for (int c = 0; c < N; c++) {
        m->p[c] = at;
        m->i[at] = c;
        m->x[at++] = c == N / 2 ? middle : 2;
        if (c + 1 < N) {
            m->i[at] = c + 1;
            m->x[at++] = -1;
        }
    }
    m->p[N] = at;
    m->a = (sp_sparse){N, m->p, m->i, m->x};
}

static sp_ldl *factor_chain(const chain_matrix *m) {
    sp_ldl *f = NULL;
    assert_ok(sp_ldl_make(&m->a, NULL, &f, &err));
    assert_ok(sp_ldl_factor(f, 0, &err));
    return f;
}

TEST(test_solves) {
    chain_matrix m;
    double b[N] = {0}, x[N];
    fill_chain(&m, 2);
    sp_ldl *f = factor_chain(&m);
    b[7] = 1;
    sp_ldl_solve_one(f, b, x);
    for (int k = 0; k < N; k++) /* (A^-1)_kl = min(k,l) (N + 1 - max(k,l))/(N + 1), counted from 1 */
        assert_relative(x[k], (k < 7 ? k + 1.0 : 8.0) * (N - (k < 7 ? 7.0 : k)) / (N + 1), 1e-13);
    assert_int_equal(sp_ldl_negative(f), 0);
    sp_ldl_free(f);
    fill_chain(&m, -2);
    f = factor_chain(&m);
    assert_int_equal(sp_ldl_negative(f), 1);
    sp_ldl_free(f);
}

/* A times soft and stiff units: row and column k in units of 1e-3 to 1e3. */
static double unit_of(int k) { return pow(10, k % 7 - 3); }

static void scale_chain(chain_matrix *m) {
    for (int c = 0; c < N; c++)
        for (int64_t q = m->p[c]; q < m->p[c + 1]; q++)
            m->x[q] *= unit_of(c) * unit_of((int)m->i[q]);
}

/* How much was cancelled at the smallest pivot does not depend on units: a chain with free ends is singular in any, by
 * rounding perhaps not quite, and one that is held by 1e-9 of a spring is not. */
TEST(test_least_ratio) {
    chain_matrix m;
    for (int held = 0; held < 2; held++)
        for (int scaled = 0; scaled < 2; scaled++) {
            fill_chain(&m, 2);
            m.x[0] = m.x[m.p[N - 1]] = 1 + held * 1e-9;
            if (scaled)
                scale_chain(&m);
            sp_ldl *f = NULL;
            assert_ok(sp_ldl_make(&m.a, NULL, &f, &err));
            if (sp_ldl_factor(f, 0, NULL) == SP_OK)
                assert_true((sp_ldl_least_ratio(f, &m.a) > 1e-13) == held);
            else
                assert_false(held);
            sp_ldl_free(f);
        }
}

/* The chain with free ends and a fixed shift of its diagonal. */
typedef struct free_chain {
    chain_matrix m;
    sp_ldl *factor;
    int solves;
} free_chain;

static void apply_chain(void *with, const double *in, double *out) {
    (void)with;
    for (int k = 0; k < N; k++)
        out[k] = (k > 0 ? in[k] - in[k - 1] : 0) + (k < N - 1 ? in[k] - in[k + 1] : 0);
}

static void solve_shifted(void *with, const double *in, double *out) {
    free_chain *f = with;
    f->solves++;
    sp_ldl_solve_one(f->factor, in, out);
}

/* A singular matrix: what is in its range is solved in a few steps, and of what is in its null space nothing is made.
 */
TEST(test_cg) {
    free_chain f = {.factor = NULL};
    double b[N], x[N], back[N], zero[N];
    fill_chain(&f.m, 2);
    f.m.x[0] = f.m.x[f.m.p[N - 1]] = 1;
    for (int k = 0; k < N; k++) {
        f.m.x[f.m.p[k]] += 1e-9;
        zero[k] = 1e-14;
        b[k] = sin(k);
    }
    f.factor = factor_chain(&f.m);
    double mean = 0;
    for (int k = 0; k < N; k++)
        mean += b[k] / N;
    const krylov_problem p = {N, apply_chain, solve_shifted, &f, 1e-13, 60};
    for (int k = 0; k < N; k++)
        b[k] -= mean;
    assert_ok(sp_cg(&p, zero, b, x, &err));
    assert_true(f.solves <= 4);
    apply_chain(NULL, x, back);
    for (int k = 0; k < N; k++)
        assert_close(b[k], back[k], 1e-13);
    for (int k = 0; k < N; k++)
        b[k] = 0.01; /* a force on the chain as a whole, which nothing resists */
    assert_ok(sp_cg(&p, zero, b, x, &err));
    for (int k = 0; k < N; k++)
        assert_true(x[k] == 0);
    sp_ldl_free(f.factor);
}

static sp_status all_dense(double *w, sp_error *reason) {
    double *a = random_matrix(5, 2), v[25];
    FREED(sp_tridiagonal) t = {0};
    sp_status status = sp_eigen_all(5, a, w, reason);
    free(a);
    a = random_matrix(5, 2);
    if (status == SP_OK)
        status = sp_tridiagonal_make(5, a, &t, reason);
    if (status == SP_OK)
        status = sp_tridiagonal_values(&t, w, reason);
    if (status == SP_OK)
        status = sp_tridiagonal_vectors(&t, 3, v, reason);
    if (status == SP_OK)
        status = sp_orthogonality(5, 3, v, w, reason);
    free(a);
    return status;
}

TEST(test_no_memory) {
    double w[5];
    EACH_ALLOCATION_FAILS(5, all_dense(w, &err));
}

/* A = D + p q^T with a diagonal D, not symmetric, and D^-1 as the preconditioner: rank one away from it, so that two
 * steps are enough, and one is not. */
enum { ORDER = 50 };
static double diagonal(int64_t k) { return 1 + 0.1 * (double)k; }

static void apply_rank_one(void *with, const double *in, double *out) {
    double sum = 0;
    ++*(int *)with;
    for (int64_t k = 0; k < ORDER; k++)
        sum += sin((double)k) * in[k];
    for (int64_t k = 0; k < ORDER; k++)
        out[k] = diagonal(k) * in[k] + 0.3 * cos(3 * (double)k) * sum;
}

static void divide(void *with, const double *in, double *out) {
    (void)with;
    for (int64_t k = 0; k < ORDER; k++)
        out[k] = in[k] / diagonal(k);
}

TEST(test_gmres) {
    int applied = 0;
    double right[ORDER], x[ORDER], back[ORDER], residual;
    for (int k = 0; k < ORDER; k++)
        right[k] = 1 + k % 7;
    krylov_problem p = {ORDER, apply_rank_one, divide, &applied, 1e-12 * sp_norm(ORDER, right), 10};
    assert_ok(sp_gmres(&p, right, x, &residual, &err));
    assert_int_equal(applied, 2);
    assert_true(residual < 1e-12);
    apply_rank_one(&applied, x, back);
    for (int k = 0; k < ORDER; k++)
        assert_close(back[k], right[k], 1e-11);
    p.steps_max = 1; /* the least residual of one direction is told, and is no solution */
    assert_ok(sp_gmres(&p, right, x, &residual, &err));
    apply_rank_one(&applied, x, back);
    double left = 0, all = 0;
    for (int k = 0; k < ORDER; k++) {
        left += (right[k] - back[k]) * (right[k] - back[k]);
        all += right[k] * right[k];
    }
    assert_true(residual > 1e-6 && residual < 1);
    assert_relative(sqrt(left / all), residual, 1e-10);
    memset(right, 0, sizeof right);
    assert_ok(sp_gmres(&p, right, x, &residual, &err));
    assert_true(residual == 0 && x[3] == 0);
}

RUN_TESTS(NULL, NULL)
