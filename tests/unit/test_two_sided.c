/* The lowest eigenvalues of nonsymmetric matrices against LAPACK's: each in a disc, none missing below the limit, which
 * is refused where one is left out; and discs that stay true when the pairs are spoilt. */
#include "base/base.h"
#include "linalg/eigen.h"
#include "linalg/two_sided.h"
#include "test.h"

enum { N = 300, WANTED = 8, MORE = 8 };

static double any(void) { return 2.0 * rand() / RAND_MAX - 1; }

typedef struct problem {
    sp_sparse whole, lower; /* A, and the lower triangle of its symmetric part */
    double *a;              /* [N][N] by columns */
    double re[N], im[N];    /* LAPACK's */
    sp_ldl *factor;
    sp_two_sided_spec spec;
} problem;

static sp_sparse sparse_of(const double *a, bool lower) {
    sp_sparse s = {N, sp_alloc(N + 1, sizeof *s.p), sp_alloc(N * N, sizeof *s.i), sp_alloc(N * N, sizeof *s.x)};
    int64_t k = 0;
    for (int c = 0; c < N; c++) {
        for (int r = lower ? c : 0; r < N; r++)
            if (r == c || a[c * N + r] != 0) {
                s.i[k] = r;
                s.x[k++] = lower ? 0.5 * (a[c * N + r] + a[r * N + c]) : a[c * N + r];
            }
        s.p[c + 1] = k;
    }
    return s;
}

/* Eigenvalues -2, 1, 1.001, 4, ... of a diagonal matrix to which a sparse one is added, symmetric and skew: the two
 * that are close become a pair. */
static problem problem_of(unsigned seed, double skew) {
    problem p = {.a = calloc(N * N, sizeof(double)), .spec = {WANTED, MORE, 1e-11 * N, 1e-15 * N}};
    RELEASED double *copy = malloc(N * N * sizeof *copy), *vectors = malloc(N * N * sizeof *vectors);
    srand(seed);
    for (int c = 0; c < N; c++)
        for (int r = 0; r <= c; r++)
            if (r == c || rand() % 40 == 0) {
                const double even = r == c ? c - 2 : 0.1 * any(), odd = r == c ? 0 : skew * any();
                p.a[c * N + r] = even + odd;
                p.a[r * N + c] = even - odd;
            }
    p.a[3 * N + 3] = 4.001;
    p.a[4 * N + 4] = 4;
    p.a[4 * N + 3] = skew;
    p.a[3 * N + 4] = -skew;
    memcpy(copy, p.a, N * N * sizeof *copy);
    assert_ok(sp_eigen_general(N, copy, p.re, p.im, vectors, &err));
    p.whole = sparse_of(p.a, false);
    p.lower = sparse_of(p.a, true);
    assert_ok(sp_ldl_make(&p.lower, NULL, &p.factor, &err));
    assert_ok(sp_ldl_factor(p.factor, -3, &err));
    return p;
}

static void problem_free(problem *p) {
    sp_sparse_free(&p->whole);
    sp_sparse_free(&p->lower);
    sp_ldl_free(p->factor);
    free(p->a);
}

static sp_two_sided pairs_of(problem *p) {
    sp_two_sided t = {0};
    assert_ok(sp_ldl_factor(p->factor, -3, &err));
    assert_ok(sp_two_sided_make(p->factor, &p->whole, &p->spec, &t, &err));
    return t;
}

/* LAPACK's errors are some 1e-13; returns the largest radius of the wanted ones. */
static double check_discs(problem *p, const sp_two_sided *t) {
    FREED(sp_discs) d = {0};
    double complete, most = 0;
    int64_t below = 0, discs = 0;
    assert_ok(sp_two_sided_enclose(t, p->factor, &p->whole, &p->spec, &complete, &d, &err));
    assert_true(complete > t->re[t->wanted - 1]);
    for (int k = 0; k < N; k++) {
        bool inside = p->re[k] > complete;
        below += !inside;
        for (int64_t q = 0; q < d.n; q++)
            inside = inside || hypot(p->re[k] - d.re[q], p->im[k] - d.im[q]) <= d.radius[q] + 1e-12;
        assert_true(inside);
    }
    for (int64_t q = 0; q < d.n; q++) {
        discs += d.re[q] < complete;
        most = q < t->wanted ? fmax(most, d.radius[q]) : most;
    }
    assert_int_equal(below, discs);
    return most;
}

TEST(test_discs_of_the_lowest) {
    for (unsigned seed = 1; seed <= 3; seed++) {
        problem p = problem_of(seed, 0.05 * seed);
        FREED(sp_two_sided) t = pairs_of(&p);
        int64_t pairs = 0;
        for (int64_t k = 0; k < t.wanted; k++)
            pairs += t.im[k] > 0;
        assert_int_equal(pairs, 1);
        assert_true(t.count > WANTED && check_discs(&p, &t) < 1e-9);
        t.re[1] += 1e-5; /* a wrong value, and a wrong vector: the discs grow */
        t.right[7] += 1e-5;
        assert_true(check_discs(&p, &t) > 1e-5);
        problem_free(&p);
    }
}

/* Without row k. */
static void leave_out(sp_two_sided *t, int64_t k) {
    const size_t after = (size_t)(t->count - k - 1);
    memmove(t->re + k, t->re + k + 1, after * sizeof *t->re);
    memmove(t->im + k, t->im + k + 1, after * sizeof *t->im);
    memmove(t->right + k * N, t->right + (k + 1) * N, after * N * sizeof *t->re);
    memmove(t->left + k * N, t->left + (k + 1) * N, after * N * sizeof *t->re);
    t->count--;
    t->wanted--;
}

TEST(test_none_may_be_missing) {
    problem p = problem_of(4, 0.1);
    for (int k = 0; k < WANTED - 1; k++) { /* without the last one the limit may lie below it */
        FREED(sp_two_sided) t = pairs_of(&p);
        double complete;
        sp_discs d = {0};
        if (t.im[k] == 0) {
            leave_out(&t, k);
            assert_fails(sp_two_sided_enclose(&t, p.factor, &p.whole, &p.spec, &complete, &d, &err), SP_EREFUSED,
                         "missing");
        }
    }
    problem_free(&p);
}

TEST(test_without_memory) {
    problem p = problem_of(5, 0.1);
    FREED(sp_two_sided) t = {0};
    FREED(sp_discs) d = {0};
    double complete;
    EACH_ALLOCATION_FAILS(4, sp_two_sided_make(p.factor, &p.whole, &p.spec, &t, &err), assert_true(!lacks || !t.re));
    EACH_ALLOCATION_FAILS(2, sp_two_sided_enclose(&t, p.factor, &p.whole, &p.spec, &complete, &d, &err),
                          assert_true(!lacks || !d.re));
    problem_free(&p);
}

RUN_TESTS(NULL, NULL)
