/* Makes Fig. 8: speeds against pressure. */
#include "base/base.h"
#include "paper/lattice.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { POINTS = 8 };

typedef struct speeds {
    int n;
    double p[POINTS], c[POINTS], err[POINTS];
} speeds;

static void add_speed(speeds *s, double p, double c, double err) {
    if (!isfinite(c) || s->n == POINTS)
        return;
    s->p[s->n] = p;
    s->c[s->n] = c;
    s->err[s->n++] = err;
}

/* ---- packings --------------------------------------------------------------------------------------------------- */

static sp_status front_speeds(const paper *p, speeds *out, sp_error *err) {
    const paper_set *low = &p->set[PAPER_LOW], *high = &p->set[PAPER_SQUARE];
    const int64_t n = low->n + high->n;
    sp_table t = sp_table_none();
    sp_sample *all = sp_alloc((size_t)n, sizeof *all);
    if (!all)
        return sp_fail_memory(err, (size_t)n * sizeof *all);
    if (low->n > 0)
        memcpy(all, low->sample, (size_t)low->n * sizeof *all);
    if (high->n > 0)
        memcpy(all + low->n, high->sample, (size_t)high->n * sizeof *all);
    sp_status status = n > 0 ? sp_study_table("ctof", n, all, NULL, &t, err) : SP_OK;
    sp_free(all);
    if (status != SP_OK)
        return status;
    for (int64_t k = 0; k < t.rows; k++)
        add_speed(out, sp_table_number(&t, k, sp_table_find_column(&t, "p")),
                  sp_table_number(&t, k, sp_table_find_column(&t, "c_tof")),
                  sp_table_number(&t, k, sp_table_find_column(&t, "c_tof_err")));
    sp_table_free(&t);
    return SP_OK;
}

static double c_l(const sp_sample *s) { return s->moduli.c_l; }
static double c_t(const sp_sample *s) { return s->moduli.c_t; }

static sp_status wave_speeds(const paper *p, double (*of)(const sp_sample *s), speeds *out, sp_error *err) {
    sp_status status = SP_OK;
    for (int k = 0; k < PAPER_PRESSURES && status == SP_OK; k++) {
        double *values = NULL;
        int64_t n = 0;
        paper_row mean = {0};
        status = sp_paper_values(p, PAPER_SQUARE, sp_paper_pressure[k], 0, SP_WANT_MODULI, of, &n, &values, err);
        if (status != SP_OK)
            break;
        sp_paper_row_mean(&mean, n, values);
        sp_free(values);
        add_speed(out, sp_paper_pressure[k], mean.ours, mean.err);
    }
    return status;
}

/* ---- lattices --------------------------------------------------------------------------------------------------- */

static double eta_of(double poisson) { return 1 - poisson / (2 - poisson); } /* Eq. (A4) */

static void small_lattices(const paper *p, bool friction, speeds *out) {
    static const double pressure[] = {1e-7, 5e-7, 1e-6, 1e-5, 1e-4};
    for (size_t k = 0; k < sizeof pressure / sizeof *pressure; k++)
        add_speed(out, pressure[k], sp_paper_lattice_small(p, friction, pressure[k]), NAN);
}

/* ---- rows ------------------------------------------------------------------------------------------------------- */

static sp_status add_stated(paper *p, int item, double pressure, const char *quantity, double number, double precision,
                            const double ours[2], sp_error *err) {
    const double value[2] = {number, precision};
    return sp_paper_add_stated(p, item, pressure, PAPER_SCATTER_STATED, value, ours, err, "%s", quantity);
}

/* Exponent of p and its standard error. */
static void exponent_of(const speeds *s, double out[2]) {
    double prefactor;
    bool errors = true;
    for (int k = 0; k < s->n; k++)
        errors = errors && s->err[k] > 0;
    out[0] = out[1] = NAN;
    if (s->n >= 3)
        sp_fit_power(s->n, s->p, s->c, errors ? s->err : NULL, &out[0], &out[1], &prefactor, NULL);
}

/* Value at the largest pressure. */
static void last_of(const speeds *s, double out[2]) {
    out[0] = s->n > 0 ? s->c[s->n - 1] : NAN;
    out[1] = s->n > 0 ? s->err[s->n - 1] : NAN;
}

static sp_status add_rows(paper *p, int item, const speeds part[3], sp_error *err) {
    static const struct {
        const char *name;
        double value, precision;
    } exponents[3] = {
        {"exponent of c_tof", 1.0 / 6, 0.005}, {"exponent of c_l", 0.18, 0.02}, {"exponent of c_t", 0.23, 0.02}};
    double tof[2], longitudinal[2], ours[2];
    last_of(&part[0], tof);
    last_of(&part[1], longitudinal);
    sp_status status = add_stated(p, item, 1e-4, "c_tof, between L of 8 and 25", 0.26, 0.005, tof, err);
    for (int k = 0; k < 3 && status == SP_OK; k++) {
        exponent_of(&part[k], ours);
        status = add_stated(p, item, NAN, exponents[k].name, exponents[k].value, exponents[k].precision, ours, err);
    }
    ours[0] = tof[0] / longitudinal[0];
    ours[1] = ours[0] * hypot(tof[1] / tof[0], longitudinal[1] / longitudinal[0]);
    if (status == SP_OK)
        status = add_stated(p, item, 1e-4, "c_tof / c_l", 1.4, 0.1, ours, err);
    for (int friction = 0; friction < 2 && status == SP_OK; friction++) {
        const double theory = sp_paper_lattice_speed(5e-7, friction ? 1 : 0);
        double between;
        ours[0] = sp_paper_lattice_long(p, friction, &between);
        ours[1] = 0;
        status = add_stated(p, item, 5e-7, friction ? "c of frictional lattice, Eq. (19)" : "c of lattice, Eq. (18)",
                            theory, 0.002 * theory, ours, err);
    }
    return status;
}

/* ---- figure ----------------------------------------------------------------------------------------------------- */

enum { CURVES = 11 };

/* A short line of given slope through a point, as a guide to the eye. */
typedef struct guide {
    double x[2], y[2];
} guide;

static guide guide_make(double slope, double y) {
    const double low = 2e-7, high = 6e-6;
    return (guide){{low, high}, {y, y * pow(high / low, slope)}};
}

static sp_curve marks(const char *label, const speeds *s, int ink, sp_mark mark, bool open) {
    return (sp_curve){.label = label,
                      .n = s->n,
                      .x = s->p,
                      .y = s->c,
                      .error = open ? NULL : s->err,
                      .ink = ink,
                      .dash = SP_DASH_NONE,
                      .mark = mark,
                      .open = open};
}

static sp_status draw(paper *p, int item, const speeds part[3], sp_error *err) {
    double range[2] = {4e-8, 2.5e-4}, plain[2], low[2], high[2];
    for (int k = 0; k < 2; k++) {
        plain[k] = sp_paper_lattice_speed(range[k], 0);
        low[k] = sp_paper_lattice_speed(range[k], eta_of(0.5));
        high[k] = sp_paper_lattice_speed(range[k], eta_of(0));
    }
    speeds twice = part[2], lattice[2] = {0}, wide[2] = {0};
    for (int k = 0; k < twice.n; k++) {
        twice.c[k] *= 2;
        twice.err[k] *= 2;
    }
    for (int friction = 0; friction < 2; friction++) {
        double between;
        small_lattices(p, friction, &lattice[friction]);
        sp_paper_lattice_long(p, friction, &between);
        add_speed(&wide[friction], 5e-7, between, NAN);
    }
    const guide sixth = guide_make(1.0 / 6, 0.036), fourth = guide_make(0.25, 0.026);
    const sp_curve curve[CURVES] = {
        {.label = "lattice, friction, (19)",
         .n = 2,
         .x = range,
         .y = high,
         .lower = low,
         .upper = high,
         .ink = -1,
         .width = 0.6},
        {.label = "lattice, (18)", .n = 2, .x = range, .y = plain, .ink = 0, .dash = SP_DASH_DASHED, .width = 0.8},
        marks("lattice, |L| = 24", &lattice[0], 3, SP_MARK_DIAMOND, true),
        marks("lattice, friction, |L| = 24", &lattice[1], 4, SP_MARK_SQUARE, true),
        marks("lattice, |L| = 160", &wide[0], 3, SP_MARK_TRIANGLE, true),
        marks("lattice, friction, |L| = 160", &wide[1], 4, SP_MARK_CIRCLE, true),
        marks("2 |c|_{|t|}", &twice, 2, SP_MARK_TRIANGLE, false),
        marks("|c|_{|ℓ|}", &part[1], 1, SP_MARK_SQUARE, false),
        marks("|c|_{tof}", &part[0], 0, SP_MARK_CIRCLE, false), /* the main data, drawn on top */
        {.label = "slope 1/6", .n = 2, .x = sixth.x, .y = sixth.y, .ink = 0, .width = 0.6},
        {.label = "slope 1/4", .n = 2, .x = fourth.x, .y = fourth.y, .ink = 0, .dash = SP_DASH_DOTTED, .width = 0.8}};
    const sp_panel panel = {.x = {"pressure |p| / |E|*", true, range[0], range[1]},
                            .y = {"speed / (|E|*/|ρ|)^{1/2}", true, 0.025, 0.4},
                            .curves = CURVES,
                            .curve = curve};
    const sp_sheet sheet = {.title = "Speeds", .rows = 1, .columns = 1, .panel = &panel, .width = 300, .aspect = 0.85};
    return sp_paper_draw(
        p, item, "fig8", &sheet,
        "Speed of the front and of long waves against pressure: packings of 600 grains, and triangular "
        "lattices, measured and by Eqs. (18) and (19), the band for 0 <= nu <= 0.5.",
        err);
}

sp_status sp_paper_make_fig8(paper *p, int item, sp_error *err) {
    speeds part[3] = {0};
    sp_status status = front_speeds(p, &part[0], err);
    if (status == SP_OK)
        status = wave_speeds(p, c_l, &part[1], err);
    if (status == SP_OK)
        status = wave_speeds(p, c_t, &part[2], err);
    if (status == SP_OK)
        status = add_rows(p, item, part, err);
    if (status == SP_OK && p->opt->folder)
        status = draw(p, item, part, err);
    if (status != SP_OK)
        return status;
    for (int k = 0; k < part[0].n; k++)
        sp_paper_say(p, item, "p = %g: c_tof = %.4f +- %.4f.", part[0].p[k], part[0].c[k], part[0].err[k]);
    for (int friction = 0; friction < 2; friction++) {
        double between, limit = sp_paper_lattice_long(p, friction, &between);
        sp_paper_say(
            p, item,
            "Lattice %s friction at 5e-7: %.4f between heights of 80 and 160, %.4f once the front's spreading is "
            "allowed for; %s gives %.4f.",
            friction ? "with" : "without", between, limit, friction ? "Eq. (19)" : "Eq. (18)",
            sp_paper_lattice_speed(5e-7, friction ? 1 : 0));
    }
    sp_paper_say(p, item, "The points of the three experiments in the paper's figure are not available.");
    return SP_OK;
}
