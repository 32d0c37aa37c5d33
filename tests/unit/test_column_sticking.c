/* The pieces of the event-driven lattice: the taut string (which contacts stick) against its conditions, and first
 * zeros of polynomials against fine sampling. */
#include "test.h"

#include "numeric/random.h"
#include "tapped/lattice.h"

enum { NODES = 1000 };

typedef struct tube {
    int32_t n;
    double x[NODES], lo[NODES], hi[NODES], f[NODES], bend[NODES];
    taut_ends ends;
} tube;

static void make_tube(tube *t, sp_random *r, int32_t n, bool free_end, bool column) {
    t->n = n;
    double x = 0;
    for (int32_t k = 0; k < n; k++) {
        x += 0.2 + sp_random_uniform(r);
        double middle = column ? x : 10 * sp_random_uniform(r), half = 0.09 * middle * sp_random_uniform(r);
        t->x[k] = x;
        t->lo[k] = middle - half;
        t->hi[k] = sp_random_uniform(r) < 0.1 ? t->lo[k] : middle + half;
    }
    t->ends =
        (taut_ends){0, sp_random_uniform(r), free_end, x + 0.7, 11 * sp_random_uniform(r), 2 * sp_random_uniform(r)};
}

/* Inside of the tube it is straight; where it bends it touches the edge that holds it; and slopes between nodes are
 * those of f. These are the conditions of a convex problem with one solution. */
static void check_tube(const tube *t) {
    double x0 = t->ends.x0, f0 = t->ends.f0, last = 0;
    for (int32_t k = 0; k <= t->n; k++) {
        bool end = k == t->n;
        double x = end ? t->ends.x_end : t->x[k], f = end ? t->ends.f_end : t->f[k];
        double slope = end && t->ends.free ? t->ends.slope_end : (f - f0) / (x - x0);
        if (k > 0) {
            assert_close(t->bend[k - 1], last - slope, 1e-10 * (1 + fabs(last) + fabs(slope)));
            if (t->bend[k - 1] > 0)
                assert_true(t->f[k - 1] == t->lo[k - 1]);
            if (t->bend[k - 1] < 0)
                assert_true(t->f[k - 1] == t->hi[k - 1]);
        }
        if (!end) {
            assert_true(f >= t->lo[k] - 1e-12 && f <= t->hi[k] + 1e-12);
            x0 = x, f0 = f, last = slope;
        }
    }
}

TEST(test_taut_string) {
    sp_random r = sp_random_make(20110101, 1);
    static tube t;
    for (int k = 0; k < 3000; k++) {
        make_tube(&t, &r, 1 + (int32_t)sp_random_below(&r, k % 100 == 0 ? NODES : 12), k % 2, k % 3 == 0);
        sp_taut_string(t.n, t.x, t.lo, t.hi, &t.ends, t.f, t.bend);
        check_tube(&t);
    }
}

/* Unbounded nodes, as rates have them, and fixed ones in between. */
TEST(test_taut_string_unbounded) {
    const double x[] = {1, 2, 3, 4}, lo[] = {-INFINITY, 0, -INFINITY, 0}, hi[] = {0, INFINITY, INFINITY, 0};
    const taut_ends ends = {0, 0, false, 5, 4, 0};
    double f[4], bend[4];
    sp_taut_string(4, x, lo, hi, &ends, f, bend);
    for (int k = 0; k < 4; k++)
        assert_true(f[k] == 0);
    assert_true(bend[0] == 0 && bend[1] == 0 && bend[2] == 0 && bend[3] == -4);
}

static double value(const double *f, int n, double x) {
    double sum = 0;
    for (int k = n; k >= 0; k--)
        sum = sum * x + f[k];
    return sum;
}

TEST(test_first_root) {
    sp_random r = sp_random_make(7, 1);
    int found = 0;
    for (int k = 0; k < 4000; k++) {
        double f[25], h = 0.3 + 3 * sp_random_uniform(&r), factorial = 1;
        int n = 3 + (int)sp_random_below(&r, 21);
        for (int p = 0; p <= n; p++, factorial *= p)
            f[p] = (2 * sp_random_uniform(&r) - 1) / factorial;
        f[0] = -fabs(f[0]);
        double root = sp_first_root(f, n, h);
        double until = fmin(root, h);
        for (int q = 0; q < 400; q++) /* nothing above zero before it */
            assert_true(value(f, n, until * q / 400) <= 1e-14);
        if (isfinite(root)) {
            assert_true(root >= 0 && root <= h);
            assert_close(value(f, n, root), 0, 2e-15 * exp(root));
            found++;
        }
    }
    assert_true(found > 1000 && found < 3500);
}

/* Two zeros near each other, a double one, and none by a hair: the place where Newton's method from the other side, or
 * a look at the ends of the step, goes wrong. */
TEST(test_grazing_roots) {
    for (double gap = 1e-3; gap > 1e-7; gap /= 10) {
        const double twice[] = {-(0.25 - gap * gap), 1, -1}; /* -(x - 1/2)^2 + gap^2 */
        assert_close(sp_first_root(twice, 2, 1), 0.5 - gap, 1e-16 / gap + 1e-15);
        const double none[] = {-(0.25 + gap * gap), 1, -1};
        assert_true(gap * gap < 1e-15 || isinf(sp_first_root(none, 2, 1)));
    }
    const double late[] = {-1, 0, 0, 1}, exact[] = {0, 0, -1, 1}, up[] = {0, 1}, zero[] = {0, 0, 0};
    assert_close(sp_first_root(late, 3, 1), 1, 1e-15);
    assert_true(isinf(sp_first_root(late, 3, 0.999)));
    assert_close(sp_first_root(exact, 3, 2), 1, 1e-15);
    assert_true(sp_first_root(up, 1, 1) == 0);
    assert_true(isinf(sp_first_root(zero, 2, 1)));
}

RUN_TESTS(NULL, NULL)
