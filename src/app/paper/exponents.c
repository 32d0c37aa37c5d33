/* Makes Table III and Fig. 7: exponents of amplitude and width, for boxes and chains. */
#include "paper/fronts.h"

#include <math.h>
#include <sonopack/chain.h>
#include <stdio.h>

/* ---- Table III -------------------------------------------------------------------------------------------------- */

static paper_line negative(paper_line line) {
    line.slope = -line.slope;
    return line;
}

/* Exponents gamma of the amplitude and alpha of the width, and the precision of the wording. */
typedef struct exponents {
    double gamma, alpha, precision;
} exponents;

static sp_status add_exponents(paper *p, const char *system, exponents stated, paper_scatter scatter,
                               const paper_line *gamma, const paper_line *alpha, sp_error *err) {
    const double value[2][2] = {{stated.gamma, stated.precision}, {stated.alpha, stated.precision}},
                 ours[2][2] = {{gamma->slope, gamma->err}, {alpha->slope, alpha->err}};
    sp_status status = sp_paper_add_stated(p, PAPER_TABLE_3, NAN, scatter, value[0], ours[0], err, "gamma, %s", system);
    if (status == SP_OK)
        status = sp_paper_add_stated(p, PAPER_TABLE_3, NAN, scatter, value[1], ours[1], err, "alpha, %s", system);
    return status;
}

/* Local exponents between chains of 500,000 and 1,000,000 balls. */
static sp_status add_uniform_chain(paper *p, sp_chain_source source, sp_error *err) {
    const bool velocity = source == SP_CHAIN_VELOCITY;
    const int64_t balls = 1000000;
    sp_front half, whole;
    sp_status status = sp_chain_front(balls / 2, source, &half, err);
    if (status == SP_OK)
        status = sp_chain_front(balls, source, &whole, err);
    if (status != SP_OK)
        return status;
    const paper_line gamma = {.slope = log(half.amplitude / whole.amplitude) / log(2.0), .err = 0},
                     alpha = {.slope = log(whole.width / half.width) / log(2.0), .err = 0};
    return add_exponents(p, velocity ? "equal chain A" : "equal chain B",
                         (exponents){velocity ? 2.0 / 3 : 1, 1.0 / 3, 0.001}, PAPER_SCATTER_STATED, &gamma, &alpha,
                         err);
}

/* Exponents of fits through the fronts at several distances. */
static sp_status add_fits(paper *p, const char *system, exponents stated, paper_scatter scatter, int n,
                          const paper_distance *d, sp_error *err) {
    const paper_line gamma = negative(sp_paper_power(n, d, sp_paper_amplitude)),
                     alpha = sp_paper_power(n, d, sp_paper_width);
    return add_exponents(p, system, stated, scatter, &gamma, &alpha, err);
}

static sp_status add_unequal_chain(paper *p, paper_ensemble e, sp_error *err) {
    paper_distance d[PAPER_DISTANCES];
    int n = 0;
    char name[40];
    sp_status status = sp_paper_chains(p, e, &n, d, err);
    snprintf(name, sizeof name, "chain 1+-%.1f A", sp_paper_chain_spread(e));
    return status == SP_OK ? add_fits(p, name, (exponents){2.0 / 3, 1.0 / 3, 0.01}, PAPER_SCATTER_BOUND, n, d, err)
                           : status;
}

/* "about 1.5" and "close to linear" are taken as +- 0.25. */
static sp_status add_boxes(paper *p, int n, const paper_distance *d, const char *range, sp_error *err) {
    char name[40];
    snprintf(name, sizeof name, "2D packings A, %s", range);
    return add_fits(p, name, (exponents){1.5, 1, 0.25}, PAPER_SCATTER_STATED, n, d, err);
}

static void say_local(paper *p, int item, int n, const paper_distance *d) {
    for (int k = 0; k + 1 < n; k++) {
        const paper_line gamma = negative(sp_paper_power(2, d + k, sp_paper_amplitude)),
                         alpha = sp_paper_power(2, d + k, sp_paper_width);
        sp_paper_say(p, item, "Between L = %.3g and %.3g: gamma = %.2f +- %.2f, alpha = %.2f +- %.2f.", d[k].distance,
                     d[k + 1].distance, gamma.slope, gamma.err, alpha.slope, alpha.err);
    }
}

sp_status sp_paper_make_exponents(paper *p, int item, sp_error *err) {
    static const paper_ensemble chains[] = {PAPER_CHAIN_1, PAPER_CHAIN_2, PAPER_CHAIN_4};
    paper_distance d[PAPER_DISTANCES];
    int n = 0;
    sp_status status = sp_paper_heights(p, &n, d, err);
    if (status == SP_OK)
        status = add_uniform_chain(p, SP_CHAIN_VELOCITY, err);
    if (status == SP_OK)
        status = add_uniform_chain(p, SP_CHAIN_DISPLACEMENT, err);
    for (size_t k = 0; k < sizeof chains / sizeof *chains && status == SP_OK; k++)
        status = add_unequal_chain(p, chains[k], err);
    for (int all = 0; all < 2 && status == SP_OK; all++) {
        const paper_range r = sp_paper_fitted(n, d, all);
        status = add_boxes(p, r.end - r.first, d + r.first, all ? "L 8 to 100" : "L 8 to 50", err);
    }
    if (status != SP_OK)
        return status;
    sp_paper_say(
        p, item,
        "Equal chains: slopes between half a million and a million balls. Unequal chains and packings: straight "
        "lines, log against log, through all lengths of chains and through the boxes of the range, with the "
        "standard errors of the means.");
    say_local(p, item, n, d);
    return SP_OK;
}

/* ---- Fig. 7 ----------------------------------------------------------------------------------------------------- */

enum {
    SYSTEMS = 5, /* boxes, chains of equal balls, three ensembles of chains of unequal balls */
    EXACT = 24   /* number of lengths of chains of equal balls */
};

/* One system: values against distance, and local exponents between neighbouring distances. */
typedef struct scaling {
    int n;
    double distance[EXACT], value[EXACT], value_err[EXACT];
    double middle[EXACT], local[EXACT], local_err[EXACT]; /* [n - 1] */
} scaling;

static void local_exponents(scaling *s, double sign) {
    for (int k = 0; k + 1 < s->n; k++) {
        const double step = log(s->distance[k + 1] / s->distance[k]);
        s->middle[k] = sqrt(s->distance[k] * s->distance[k + 1]);
        s->local[k] = sign * log(s->value[k + 1] / s->value[k]) / step;
        s->local_err[k] = hypot(s->value_err[k] / s->value[k], s->value_err[k + 1] / s->value[k + 1]) / step;
    }
}

static void from_distances(int n, const paper_distance *d, const paper_mean *(*of)(const paper_distance *d),
                           double sign, scaling *out) {
    out->n = n;
    for (int k = 0; k < n; k++) {
        const paper_mean *m = of(&d[k]);
        out->distance[k] = d[k].distance;
        out->value[k] = m->mean;
        out->value_err[k] = m->err;
    }
    local_exponents(out, sign);
}

static sp_status equal_chains(scaling *amplitude, scaling *width, sp_error *err) {
    sp_status status = SP_OK;
    amplitude->n = width->n = EXACT;
    for (int k = 0; k < EXACT && status == SP_OK; k++) {
        const int64_t balls = llround(4 * pow(1000.0 / 4, (double)k / (EXACT - 1)));
        sp_front front = {0};
        status = sp_chain_front(balls, SP_CHAIN_VELOCITY, &front, err);
        amplitude->distance[k] = width->distance[k] = (double)balls;
        amplitude->value[k] = front.amplitude;
        width->value[k] = front.width;
    }
    local_exponents(amplitude, -1);
    local_exponents(width, 1);
    return status;
}

/* Divides the values by that at the first distance. */
static void over_first(scaling *s) {
    const double first = s->value[0];
    for (int k = 0; k < s->n; k++) {
        s->value[k] /= first;
        s->value_err[k] /= first;
    }
}

static void system_curve(int system, const scaling *s, bool local, sp_curve *out) {
    static const struct {
        const char *label;
        sp_mark mark;
        int ink;
        bool open;
        sp_dash dash;
    } look[SYSTEMS] = {{"2D packings", SP_MARK_CIRCLE, 0, false, SP_DASH_SOLID},
                       {"chain, equal balls", SP_MARK_NONE, 0, true, SP_DASH_DASHED},
                       {"chain, 1 ± 0.1", SP_MARK_SQUARE, 1, true, SP_DASH_SOLID},
                       {"chain, 1 ± 0.2", SP_MARK_TRIANGLE, 2, true, SP_DASH_SOLID},
                       {"chain, 1 ± 0.4", SP_MARK_DIAMOND, 3, true, SP_DASH_SOLID}};
    *out = (sp_curve){.label = local ? look[system].label : NULL,
                      .n = local ? s->n - 1 : s->n,
                      .x = local ? s->middle : s->distance,
                      .y = local ? s->local : s->value,
                      .error = system == 1 ? NULL
                               : local     ? s->local_err
                                           : s->value_err,
                      .ink = look[system].ink,
                      .dash = look[system].dash,
                      .mark = look[system].mark,
                      .open = look[system].open,
                      .width = 0.8};
}

static sp_status draw(paper *p, int item, scaling part[2][SYSTEMS], sp_error *err) {
    sp_curve main[2][SYSTEMS], small[2][SYSTEMS];
    sp_panel inset[2], panel[2];
    for (int k = 0; k < 2; k++) {
        for (int s = 0; s < SYSTEMS; s++) {
            over_first(&part[k][s]);
            system_curve(s, &part[k][s], true, &main[k][s]);
            if (k > 0)
                main[k][s].label = NULL; /* the panel above has the legend */
            system_curve(s, &part[k][s], false, &small[k][s]);
        }
        inset[k] = (sp_panel){.x = {"|L| [|d|]", true, NAN, NAN},
                              .y = {k == 0 ? "|A|/|A|_{1}" : "|W|/|W|_{1}", true, NAN, NAN},
                              .curves = SYSTEMS,
                              .curve = small[k]};
        panel[k] = (sp_panel){
            .tag = k == 0 ? "(a)" : "(b)",
            .x = {"distance |L| [|d|]", true, 3, 1000},
            .y = {k == 0 ? "|γ|_{eff} = −d log |A| / d log |L|" : "|α|_{eff} = d log |W| / d log |L|", false, 0, NAN},
            .curves = SYSTEMS,
            .curve = main[k],
            .inset = &inset[k]};
    }
    const sp_sheet sheet = {.title = "Effective exponents", .rows = 2, .columns = 1, .panel = panel, .aspect = 0.95};
    return sp_paper_draw(
        p, item, "fig7", &sheet,
        "Local exponents of (a) the height A of the first peak and (b) its width W = t_zero - t10; insets: "
        "A and W over those of the shortest distance.",
        err);
}

sp_status sp_paper_make_fig7(paper *p, int item, sp_error *err) {
    static const paper_ensemble chains[] = {PAPER_CHAIN_1, PAPER_CHAIN_2, PAPER_CHAIN_4};
    static const double sign[2] = {-1, 1};
    scaling part[2][SYSTEMS] = {0};
    paper_distance d[PAPER_DISTANCES];
    int n = 0;
    sp_status status = equal_chains(&part[0][1], &part[1][1], err);
    for (int s = 0; s < SYSTEMS && status == SP_OK; s++) {
        if (s == 1)
            continue;
        status = s == 0 ? sp_paper_heights(p, &n, d, err) : sp_paper_chains(p, chains[s - 2], &n, d, err);
        for (int k = 0; k < 2 && status == SP_OK; k++)
            from_distances(n, d, k == 0 ? sp_paper_amplitude : sp_paper_width, sign[k], &part[k][s]);
    }
    if (status == SP_OK)
        status = draw(p, item, part, err);
    if (status != SP_OK)
        return status;
    const scaling *a = &part[0][0], *w = &part[1][0];
    if (a->n > 1)
        sp_paper_say(
            p, item,
            "In boxes 24 wide gamma goes from %.2f +- %.2f at L = %.3g to %.2f +- %.2f at L = %.3g, alpha from %.2f "
            "+- %.2f to %.2f +- %.2f.",
            a->local[0], a->local_err[0], a->middle[0], a->local[a->n - 2], a->local_err[a->n - 2], a->middle[a->n - 2],
            w->local[0], w->local_err[0], w->local[w->n - 2], w->local_err[w->n - 2]);
    sp_paper_say(
        p, item,
        "The equal chain is exact (%.3f and %.3f at L = %.0f; 2/3 and 1/3 far away). The paper does not say how "
        "wide its distributions of balls are; here diameters are uniform in 1 +- 0.1, 0.2 and 0.4.",
        part[0][1].local[EXACT - 2], part[1][1].local[EXACT - 2], part[0][1].middle[EXACT - 2]);
    return SP_OK;
}
