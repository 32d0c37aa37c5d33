/* Theorem 1: cycles with known multipliers, and the parameters at which the Lyapunov exponent is positive. */
#include "paper/blackmore.h"

#include <stdio.h>
#include <string.h>

static blackmore_row value(const char *unit, double paper, double ours, double err) {
    return (blackmore_row){
        .item = BLACKMORE_CHAOS, .equation = "Theorem 1", .unit = unit, .paper = paper, .ours = ours, .err = err};
}

/* ---- cycles ----------------------------------------------------------------------------------------------------- */

/* For one particle and T = 0.2 s, |multiplier| = 0.83: after this many taps only the fixed point is left. */
enum { SETTLED = 400 };

static sp_status settle(const sp_tapped_spec *c, double *y, double *v, double derivative[4], sp_error *err) {
    sp_tapped_state s;
    sp_status status = sp_tapped_state_make(c, &s, err);
    if (status != SP_OK)
        return status;
    status = sp_tapped_map(c, &s, SETTLED, NULL, err);
    if (status == SP_OK)
        status = sp_tapped_map(c, &s, 1, derivative, err);
    if (status == SP_OK)
        sp_tapped_positions(c, &s, y, v);
    sp_tapped_state_free(&s);
    return status;
}

static sp_status add_fixed_point(blackmore *p, sp_error *err) {
    sp_tapped_spec c = sp_blackmore_column(1);
    sp_tapped_exponent exponent;
    double y, v, d[4];
    c.period = 0.2;
    c.taps = 1000;
    sp_status status = settle(&c, &y, &v, d, err);
    if (status == SP_OK)
        status = sp_tapped_lyapunov(&c, &exponent, err);
    if (status != SP_OK)
        return status;
    const double trace = d[0] + d[3], det = d[0] * d[3] - d[1] * d[2], exact = 0.5 * log(det);
    sp_blackmore_add(p, value("cm", NAN, y, 1e-8), "fixed point y, N = 1, T = 0.2 s");
    sp_blackmore_add(p, value("cm/s", NAN, v, 1e-7), "fixed point v, N = 1, T = 0.2 s");
    sp_blackmore_add(p, value("", NAN, det, 1e-7), "determinant of the map there");
    sp_blackmore_add(p, value("", NAN, trace, 1e-7), "trace of the map there");
    blackmore_row row = value("1/tap", NAN, exponent.lambda, fabs(exponent.lambda - exact) + exponent.error);
    sp_blackmore_note(&row, "complex multipliers, hence lambda = log(det)/2; err: the difference from that");
    sp_blackmore_add(p, row, "lambda, N = 1, T = 0.2 s");
    return status;
}

static sp_status add_cycles(blackmore *p, sp_error *err) {
    sp_tapped_spec c = sp_blackmore_column(1);
    sp_tapped_exponent exponent;
    c.period = 0.7;
    c.taps = 1000;
    sp_status status = sp_tapped_lyapunov(&c, &exponent, err);
    if (status == SP_OK)
        sp_blackmore_add(p, value("taps", NAN, exponent.cycle, 0), "cycle, N = 1, T = 0.7 s");
    for (int32_t n = 5; n <= 10 && status == SP_OK; n += 5) {
        c = sp_blackmore_column(n);
        c.taps = 1000;
        status = sp_tapped_lyapunov(&c, &exponent, err);
        if (status != SP_OK)
            return status;
        blackmore_row row = value("1/tap", NAN, exponent.lambda, exponent.error);
        sp_blackmore_note(&row, "a cycle of %d: no chaos where the paper computes", exponent.cycle);
        sp_blackmore_add(p, row, "lambda, settings of Fig. 1, N = %d", n);
        sp_blackmore_say(p, BLACKMORE_CHAOS,
                         "At the settings of Fig. 1, N = %d, the column is a cycle of %d tap%s with lambda = %.4f: not "
                         "chaotic.",
                         n, exponent.cycle, exponent.cycle == 1 ? "" : "s", exponent.lambda);
    }
    return status;
}

/* ---- diagrams --------------------------------------------------------------------------------------------------- */

/* A scan of the period or the amplitude, with the paper's stiffness or with one for which (1) mostly holds. */
typedef struct scan {
    const char *name, *words;
    sp_tapped_parameter parameter;
    double from, to, stiffness; /* stiffness in m g/r; from 0: from the shortest period, that of a tap */
} scan;

static const scan scans[] = {{"chaos-period", "T", SP_TAPPED_BY_PERIOD, 0, 1, 2},
                             {"chaos-amplitude", "a", SP_TAPPED_BY_AMPLITUDE, 0.05, 4, 2},
                             {"chaos-period-stiff", "T", SP_TAPPED_BY_PERIOD, 0, 1, 100},
                             {"chaos-amplitude-stiff", "a", SP_TAPPED_BY_AMPLITUDE, 0.05, 2, 100}};
enum { SCANS = sizeof scans / sizeof *scans, EXPONENTS = 96, POINTS = 240, SHOWN = 40, AVERAGED = 300 };

static sp_tapped_spec scanned(const scan *s) {
    sp_tapped_spec c = sp_blackmore_column(1);
    c.stiffness = s->stiffness * sp_tapped_mass(&c, 1) * c.gravity / sp_tapped_radius(&c, 1);
    c.parameter = s->parameter;
    c.from = s->from;
    c.to = s->to;
    return c;
}

/* Chaos: no cycle, and an exponent larger than its error. */
static bool is_chaos(const sp_table *t, int64_t row) {
    return sp_table_number(t, row, 3) < 1 && sp_table_number(t, row, 1) > sp_table_number(t, row, 2);
}

typedef struct found {
    int64_t points, best; /* number of chaotic points; the one with the largest exponent, -1: none */
    double low, high;     /* range of the parameter with chaos */
} found;

static found find_chaos(const sp_table *t) {
    found f = {.best = -1, .low = INFINITY, .high = -INFINITY};
    for (int64_t k = 0; k < t->rows; k++) {
        if (!is_chaos(t, k))
            continue;
        if (f.best < 0 || sp_table_number(t, k, 1) > sp_table_number(t, f.best, 1))
            f.best = k;
        f.points++;
        f.low = fmin(f.low, sp_table_number(t, k, 0));
        f.high = fmax(f.high, sp_table_number(t, k, 0));
    }
    return f;
}

/* Adds the smallest separation over 400 taps at the point with the largest exponent. */
static sp_status add_separation(blackmore *p, const scan *s, double at, sp_error *err) {
    sp_tapped_spec c = scanned(s);
    sp_tapped_report report = {0};
    if (s->parameter == SP_TAPPED_BY_PERIOD)
        c.period = at;
    else
        c.amplitude = at;
    c.taps = 400;
    sp_status status = sp_tapped_run(&c, 0, NULL, NULL, NULL, &report, err);
    if (status != SP_OK)
        return status;
    blackmore_row row = value("cm", 0, sp_blackmore_separation(&report), NAN);
    sp_tapped_report_free(&report);
    row.equation = "(1)";
    row.relation = BLACKMORE_ABOVE;
    sp_blackmore_note(&row, "400 taps at %s = %.3f; err: chaotic, one orbit of many", s->words, at);
    sp_blackmore_add(p, row, "smallest separation there, K = %g m g/r, over %s", s->stiffness, s->words);
    return SP_OK;
}

static sp_status add_exponents(blackmore *p, const scan *s, const sp_table *t, sp_error *err) {
    const found f = find_chaos(t);
    const bool any = f.best >= 0;
    int64_t best = any ? f.best : 0;
    for (int64_t k = 0; k < t->rows && !any; k++)
        if (sp_table_number(t, k, 1) > sp_table_number(t, best, 1))
            best = k;
    blackmore_row row = value("1/tap", 0, sp_table_number(t, best, 1), sp_table_number(t, best, 2));
    row.relation = BLACKMORE_ABOVE;
    sp_blackmore_note(&row, "at %s = %.3f; chaotic at %lld of %lld values from %.3g to %g; err: an estimate", s->words,
                      sp_table_number(t, best, 0), (long long)f.points, (long long)t->rows, s->from, s->to);
    sp_blackmore_add(p, row, "largest lambda, N = 1, K = %g m g/r, over %s", s->stiffness, s->words);
    if (!any)
        return SP_OK;
    const char *unit = s->parameter == SP_TAPPED_BY_PERIOD ? "s" : "cm";
    sp_blackmore_say(
        p, BLACKMORE_CHAOS,
        "N = 1, K = %g m g/r, through %s from %.3g to %g %s: chaos at %lld of %lld values, between %.3f and %.3f "
        "%s, with lambda up to %.3f a tap.",
        s->stiffness, s->words, s->from, s->to, unit, (long long)f.points, (long long)t->rows, f.low, f.high, unit,
        sp_table_number(t, best, 1));
    if (s->parameter == SP_TAPPED_BY_AMPLITUDE) {
        row = value(unit, NAN, f.low, (s->to - s->from) / (EXPONENTS - 1));
        sp_blackmore_note(&row, "err: the step of the scan, of %lld values", (long long)t->rows);
        sp_blackmore_add(p, row, "smallest a with chaos, N = 1, K = %g m g/r", s->stiffness);
    } else {
        row = value("1/tap", 0, sp_table_number(t, 0, 1), sp_table_number(t, 0, 2));
        row.relation = BLACKMORE_ABOVE;
        sp_blackmore_note(
            &row,
            "the shortest period that (2) allows; of the orbit from rest, others may be chaotic; err: an estimate");
        sp_blackmore_add(p, row, "lambda at T = pi/omega, N = 1, K = %g m g/r", s->stiffness);
    }
    return add_separation(p, s, sp_table_number(t, best, 0), err);
}

/* The table's warning about violations of (1) at some points, up to its first comma. */
static const char *violation_text(const sp_table *t, char *text, size_t size) {
    static const char start[] = "warning: ordering (1) violated";
    text[0] = '\0';
    for (int k = 0; k < t->comments; k++)
        if (strncmp(t->comment[k], start, strlen(start)) == 0) {
            const char *words = t->comment[k] + strlen("warning: ");
            snprintf(text, size, "; %.*s, the centre below the floor", (int)strcspn(words, ",:"), words);
        }
    return text;
}

static sp_status show_scan(blackmore *p, const scan *s, sp_table *exponents, sp_error *err) {
    sp_table orbits = sp_table_none();
    sp_tapped_spec c = scanned(s);
    char name[48], text[120], caption[320];
    c.output = SP_TAPPED_BIFURCATION;
    c.points = POINTS;
    c.transient = 100;
    c.taps = SHOWN;
    sp_status status = sp_tapped_table(&c, p->opt->threads, &orbits, err);
    snprintf(name, sizeof name, "%s-lambda", s->name);
    if (status == SP_OK)
        status = sp_blackmore_save(p, name, exponents, err);
    snprintf(name, sizeof name, "%s-orbits", s->name);
    if (status == SP_OK)
        status = sp_blackmore_save(p, name, &orbits, err);
    const sp_table *const both[2] = {&orbits, exponents};
    snprintf(caption, sizeof caption,
             "One particle, K = %g m g/r: its position at .99T of %d taps over %s, and the Lyapunov exponent%s.",
             s->stiffness, SHOWN, s->parameter == SP_TAPPED_BY_PERIOD ? "the period" : "the amplitude",
             violation_text(&orbits, text, sizeof text));
    if (status == SP_OK)
        status = sp_blackmore_draw(p, BLACKMORE_CHAOS, s->name, 2, both, NULL, caption, err);
    sp_table_free(&orbits);
    return status;
}

static sp_status make_scan(blackmore *p, const scan *plan, sp_error *err) {
    scan own = *plan, *s = &own;
    if (!(s->from > 0))
        s->from = 0.5 / sp_blackmore_column(1).frequency * (1 + 1e-9);
    sp_table t = sp_table_none();
    sp_tapped_spec c = scanned(s);
    c.output = SP_TAPPED_LYAPUNOV;
    c.points = EXPONENTS;
    c.taps = AVERAGED;
    sp_status status = sp_tapped_table(&c, p->opt->threads, &t, err);
    if (status == SP_OK)
        status = add_exponents(p, s, &t, err);
    if (status == SP_OK && p->opt->folder)
        status = show_scan(p, s, &t, err);
    sp_table_free(&t);
    return status;
}

sp_status sp_blackmore_make_chaos(blackmore *p, sp_error *err) {
    sp_status status = add_fixed_point(p, err);
    if (status == SP_OK)
        status = add_cycles(p, err);
    for (int k = 0; k < SCANS && status == SP_OK; k++) {
        status = sp_blackmore_progress(p, 0.05 + 0.95 * k / SCANS, err);
        if (status == SP_OK)
            status = make_scan(p, &scans[k], err);
    }
    sp_blackmore_say(
        p, BLACKMORE_CHAOS,
        "One particle can be chaotic, as Theorem 1 has it, for large amplitudes and for short periods. With K = "
        "2 N m g/r as in Fig. 1 the floor then passes through the particle's centre, against (1), and from rest "
        "the shortest period of all, that of the tap itself, is not chaotic. With K = 100 m g/r the order holds "
        "at most points, not at short periods and the largest amplitudes, and there is chaos where it holds, as "
        "at the points of the largest lambda. Exponents of chaotic orbits are averages over %d taps, their "
        "errors the change from the first half of these.",
        AVERAGED);
    return status;
}
