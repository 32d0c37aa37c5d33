/* A run of the lattice against the law itself, knowing nothing of how it was made: accelerations from velocities a
 * moment before and after give the force of every contact, which must be (18), and where it sticks within its band. */
#include "test.h"

#include "column_runs.h"
#include "numeric/random.h"

enum { MOMENTS = 400 };
static const double around = 2e-8; /* s, before and after a moment */

static int compare(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

typedef struct rows {
    int32_t width;
    int64_t n;
    double *y, *v;
} rows;

static sp_status keep(double t, const double *y, const double *v, void *user, sp_error *err) {
    rows *r = user;
    (void)t, (void)err;
    memcpy(r->y + r->n * r->width, y, (size_t)r->width * sizeof *y);
    memcpy(r->v + r->n * r->width, v, (size_t)r->width * sizeof *v);
    r->n++;
    return SP_OK;
}

static int sign(double x) { return (x > 0) - (x < 0); }

/* What a contact does at a row: whether it is closed, and the sign of w. */
static int doing(const sp_tapped_spec *c, const rows *r, int64_t row, int32_t i, double *overlap) {
    const double *y = r->y + row * r->width, *v = r->v + row * r->width;
    double distance = sp_tapped_radius(c, i + 1) + (i > 0 ? sp_tapped_radius(c, i) : 0);
    double opening = v[i + 1] - v[i];
    *overlap = distance - (y[i + 1] - y[i]);
    /* velocities are sums of openings: those of clusters agree within rounding */
    return *overlap <= 0 ? 9 : fabs(opening) < 1e-10 ? 0 : sign(opening);
}

typedef struct counts {
    int64_t moving, sticking, open;
} counts;

static void check_moment(const sp_tapped_spec *c, const rows *r, int64_t before, counts *n) {
    double force = 0, k = sp_tapped_stiffness(c), weight = 0;
    for (int32_t i = 1; i <= c->particles; i++)
        weight += sp_tapped_mass(c, i) * c->gravity;
    for (int32_t i = c->particles - 1; i >= 0;
         i--) { /* from the top: the force of the contact below carries the rest */
        const double *v = r->v + before * r->width + i + 1;
        force += sp_tapped_mass(c, i + 1) * ((v[2 * r->width] - v[0]) / (2 * around) + c->gravity);
        double overlap, other;
        int state = doing(c, r, before + 1, i, &overlap);
        if (doing(c, r, before, i, &other) != state || doing(c, r, before + 2, i, &other) != state)
            continue; /* something happened meanwhile */
        double low = k * overlap * (1 - c->e), high = k * overlap * (1 + c->e);
        if (state != 0)
            low = high = state == 9 ? 0 : state > 0 ? low : high;
        /* rounding of v over 2 around, and jumps of other contacts in between are those of other moments */
        double tolerance = 1e-6 * weight;
        if (force < low - tolerance || force > high + tolerance)
            fail_msg("N = %d, e = %g, f = %g, T = %g: contact %d, doing %d: force %.9g, law %.9g .. %.9g", c->particles,
                     c->e, c->frequency, c->period, i, state, force, low, high);
        n->moving += state != 0 && state != 9;
        n->sticking += state == 0;
        n->open += state == 9;
    }
}

/* Whether any contact of the column did something between the three rows. */
static bool eventful(const sp_tapped_spec *c, const rows *r, int64_t before) {
    double overlap;
    for (int32_t i = 0; i < c->particles; i++) {
        int state = doing(c, r, before, i, &overlap);
        if (doing(c, r, before + 1, i, &overlap) != state || doing(c, r, before + 2, i, &overlap) != state)
            return true;
    }
    return false;
}

static int64_t check_column(const sp_tapped_spec *c, sp_random *random, counts *n) {
    static double t[3 * MOMENTS];
    double moment[MOMENTS];
    for (int k = 0; k < MOMENTS; k++) {
        double tap = (double)sp_random_below(random, (uint64_t)c->taps), end = 0.5 / c->frequency;
        double s =
            sp_random_uniform(random) * sp_random_uniform(random) * c->period; /* more of them soon after a tap */
        s = fmin(fmax(s, 2 * around), c->period - 2 * around);
        s += fabs(s - end) < 2 * around ? 4 * around : 0;
        moment[k] = tap * c->period + s;
    }
    qsort(moment, MOMENTS, sizeof *moment, compare);
    for (int k = 1; k < MOMENTS; k++)
        moment[k] = fmax(moment[k], moment[k - 1] + 3 * around);
    for (int k = 0; k < 3 * MOMENTS; k++)
        t[k] = moment[k / 3] + (k % 3 - 1) * around;
    rows r = {.width = c->particles + 1};
    r.y = malloc((size_t)(3 * MOMENTS * r.width) * sizeof *r.y);
    r.v = malloc((size_t)(3 * MOMENTS * r.width) * sizeof *r.v);
    assert_true(r.y && r.v);
    assert_ok(sp_tapped_run(c, 3 * MOMENTS, t, keep, &r, NULL, &err));
    int64_t checked = 0;
    for (int k = 0; k < MOMENTS; k++)
        if (!eventful(c, &r, 3 * k)) {
            check_moment(c, &r, 3 * k, n);
            checked++;
        }
    free(r.y);
    free(r.v);
    return checked;
}

TEST(test_law) {
    const uint64_t seed = 4711;
    sp_random random = sp_random_make(seed, 1);
    const int32_t sizes[] = {1, 2, 3, 5, 10, 20, 50, 80, 130, 250};
    counts n = {0, 0, 0};
    for (int k = 0; k < 40; k++) {
        double mass[2] = {1, 1 + 2 * sp_random_uniform(&random)}, radius[2] = {1, 0.7 + sp_random_uniform(&random)};
        sp_tapped_spec c = sp_tapped_spec_default();
        c.particles = sizes[k % 10];
        c.taps = 3;
        c.e = k % 7 == 6 ? 0.7 : 0.02 + 0.2 * sp_random_uniform(&random);
        c.frequency = 5 + 15 * sp_random_uniform(&random);
        c.period = 0.5 / c.frequency + 0.8 * sp_random_uniform(&random);
        c.amplitude = 0.05 + 1.2 * sp_random_uniform(&random);
        c.drop = k % 9 == 8 ? 2 : -1;
        if (k >= 20) {
            c.masses = c.radii = 2;
            c.mass = mass;
            c.radius = radius;
        }
        assert_true(check_column(&c, &random, &n) > MOMENTS / 2);
    }
    print_message("%lld moving, %lld sticking, %lld open\n", (long long)n.moving, (long long)n.sticking,
                  (long long)n.open);
    assert_true(n.moving > 10000 && n.sticking > 10000 && n.open > 3000);
}

RUN_TESTS(NULL, NULL)
