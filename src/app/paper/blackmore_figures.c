/* Figs. 1 and 2: trajectories of the lattice, and the continua in comparison with it. */
#include "base/base.h"
#include "paper/blackmore.h"

#include <stdio.h>
#include <string.h>

/* Error of the lattice's positions [cm] and densities [g/cm], as tests against other solvers confirm. */
static const double lattice_error = 1e-8;

/* ---- Fig. 1 ----------------------------------------------------------------------------------------------------- */

typedef struct stack {
    tapped *p;
    sp_tapped_spec c;
    sp_table trajectory, strobe, energy;
} stack;

static double cell(const sp_table *t, int64_t row, const char *column) {
    return sp_table_number(t, row, sp_table_find_column(t, column));
}

static blackmore_row value(const char *unit, double paper, double ours, double err) {
    return (blackmore_row){
        .item = BLACKMORE_FIG_1, .equation = "Fig. 1", .unit = unit, .paper = paper, .ours = ours, .err = err};
}

static sp_status add_gamma(const stack *s, sp_error *err) {
    const sp_tapped_spec *c = &s->c;
    const double omega = 2 * 3.14159265358979323846 * c->frequency;
    blackmore_row row = value("", c->particles == 5 ? 2.4019 : 3.8476, c->amplitude * omega * omega / c->gravity, 0);
    row.equation = "Sect. 3";
    row.precision = row.paper * 0.005 / 0.53;
    snprintf(row.note, sizeof row.note, "to the precision of a/2r = 0.53");
    return sp_blackmore_add(s->p, row, err, "Gamma at f = %g Hz, N = %d", c->frequency, c->particles);
}

static sp_status add_positions(const stack *s, sp_error *err) {
    sp_status status = SP_OK;
    for (int64_t tap = 0; tap < s->strobe.rows && status == SP_OK; tap++)
        for (int32_t i = 1; i <= s->c.particles && status == SP_OK; i++) {
            char name[16];
            snprintf(name, sizeof name, "y%d", i);
            blackmore_row row = value("cm", NAN, cell(&s->strobe, tap, name), lattice_error);
            row.detail = true;
            status = sp_blackmore_add(s->p, row, err, "y%d(%lld.99T), N = %d", i, (long long)tap, s->c.particles);
        }
    return status;
}

/* Densities before the first tap and at .99T, 1.99T, ... */
static sp_status add_densities(const stack *s, sp_error *err) {
    const int32_t n = s->c.particles;
    double y[11] = {0};
    sp_tapped_rest(&s->c, y + 1);
    const double before = sp_tapped_density(&s->c, y);
    const int64_t last = s->strobe.rows - 1;
    sp_status status = sp_blackmore_add(s->p, value("g/cm", NAN, before, 1e-12), err, "density before, N = %d", n);
    for (int64_t tap = 0; tap <= last && status == SP_OK; tap++)
        status = sp_blackmore_add(s->p, value("g/cm", NAN, cell(&s->strobe, tap, "density"), lattice_error), err,
                                  "density after tap %lld, N = %d", (long long)tap + 1, n);
    const double after = cell(&s->strobe, last, "density");
    sp_blackmore_say(
        s->p, BLACKMORE_FIG_1,
        "N = %d: m N over the length of the column is %.6f g/cm before the first tap; that tap changes it by "
        "%+.2f%%, all four by %+.2f%%.",
        n, before, 100 * (cell(&s->strobe, 0, "density") / before - 1), 100 * (after / before - 1));
    return status;
}

static sp_status add_taps(const stack *s, sp_error *err) {
    const int32_t n = s->c.particles;
    double latest = 0, least = INFINITY;
    sp_status status = SP_OK;
    for (int64_t tap = 0; tap < s->energy.rows && status == SP_OK; tap++) {
        const double work = cell(&s->energy, tap, "work"), error = fabs(cell(&s->energy, tap, "residual")) * work;
        const double rest = cell(&s->energy, tap, "rest");
        blackmore_row row = value("s", NAN, rest, 1e-8);
        latest = isnan(rest) ? INFINITY : fmax(latest, rest); /* NAN: never at rest */
        least = fmin(least, cell(&s->energy, tap, "separation"));
        row.detail = tap > 0;
        status = sp_blackmore_add(s->p, row, err, "time to rest in tap %lld, N = %d", (long long)tap + 1, n);
        row = value("erg", NAN, work, error);
        row.detail = tap > 0;
        if (status == SP_OK)
            status = sp_blackmore_add(s->p, row, err, "work of the floor in tap %lld, N = %d", (long long)tap + 1, n);
        row = value("erg", NAN, cell(&s->energy, tap, "dissipated"), error);
        row.detail = tap > 0;
        if (status == SP_OK)
            status = sp_blackmore_add(s->p, row, err, "dissipated in tap %lld, N = %d", (long long)tap + 1, n);
    }
    blackmore_row row = value("s", 0.99 * s->c.period, latest, 1e-8);
    row.relation = BLACKMORE_BELOW;
    snprintf(row.note, sizeof row.note, "the particles have settled by .99T, as is meant");
    if (status == SP_OK)
        status = sp_blackmore_add(s->p, row, err, "longest time to rest, N = %d", n);
    row = value("cm", 0, least, lattice_error);
    row.equation = "(1)";
    row.relation = BLACKMORE_ABOVE;
    snprintf(row.note, sizeof row.note, "contact with the floor included");
    return status == SP_OK ? sp_blackmore_add(s->p, row, err, "smallest separation, N = %d", n) : status;
}

static sp_status show_stack(stack *s, sp_error *err) {
    const int32_t n = s->c.particles;
    const sp_table *trajectory = &s->trajectory, *strobe = &s->strobe;
    char name[40], caption[240];
    snprintf(name, sizeof name, "fig1-n%d-trajectories", n);
    snprintf(caption, sizeof caption,
             "Trajectories of %d particles, f = %g Hz, T = 1 s, four taps; the floor below, ticks where taps begin.", n,
             s->c.frequency);
    sp_status status = sp_blackmore_save(s->p, name, &s->trajectory, err);
    if (status == SP_OK)
        status = sp_blackmore_draw(s->p, BLACKMORE_FIG_1, name, 1, &trajectory, NULL, caption, err);
    snprintf(name, sizeof name, "fig1-n%d-strobe", n);
    snprintf(caption, sizeof caption, "Density and positions of %d particles at .99T, 1.99T, 2.99T, 3.99T.", n);
    if (status == SP_OK)
        status = sp_blackmore_save(s->p, name, &s->strobe, err);
    if (status == SP_OK)
        status = sp_blackmore_draw(s->p, BLACKMORE_FIG_1, name, 1, &strobe, NULL, caption, err);
    snprintf(name, sizeof name, "fig1-n%d-energy", n);
    return status == SP_OK ? sp_blackmore_save(s->p, name, &s->energy, err) : status;
}

static sp_status make_stack(stack *s, sp_error *err) {
    s->c.step = 0.0025;
    s->c.output = SP_TAPPED_TRAJECTORY;
    sp_status status = sp_tapped_table(&s->c, 1, &s->trajectory, err);
    s->c.output = SP_TAPPED_STROBE;
    if (status == SP_OK)
        status = sp_tapped_table(&s->c, 1, &s->strobe, err);
    s->c.output = SP_TAPPED_ENERGY;
    if (status == SP_OK)
        status = sp_tapped_table(&s->c, 1, &s->energy, err);
    if (status == SP_OK)
        status = add_gamma(s, err);
    if (status == SP_OK)
        status = add_densities(s, err);
    if (status == SP_OK)
        status = add_taps(s, err);
    if (status == SP_OK)
        status = add_positions(s, err);
    return status == SP_OK ? show_stack(s, err) : status;
}

sp_status sp_blackmore_make_fig1(tapped *p, sp_error *err) {
    static const int32_t particles[2] = {5, 10};
    sp_status status = SP_OK;
    for (int k = 0; k < 2 && status == SP_OK; k++) {
        stack s = {p, sp_blackmore_column(particles[k]), sp_table_none(), sp_table_none(), sp_table_none()};
        status = make_stack(&s, err);
        sp_table_free(&s.trajectory);
        sp_table_free(&s.strobe);
        sp_table_free(&s.energy);
        if (status == SP_OK)
            status = sp_blackmore_tell(p, 0.5 * (k + 1), err);
    }
    sp_blackmore_say(
        p, BLACKMORE_FIG_1,
        "That a column grows denser is no law: contacts come to rest anywhere within the band of forces that "
        "friction allows, K (1 -+ e) times the overlap. All positions are in the table of rows (fig1.tsv), with "
        "an error of 1e-8 cm at the most.");
    return status;
}

/* ---- Fig. 2 ----------------------------------------------------------------------------------------------------- */

enum { LATTICE, LONGWAVE, BSR, MODELS };

typedef struct surfaces {
    tapped *p;
    sp_tapped_spec c;
    sp_table of[MODELS], coarse[MODELS]; /* t y0 .. yN; coarse: with half as many cells */
} surfaces;

/* Mean and largest difference of positions over particles and times. */
static void distance(const sp_table *a, const sp_table *b, double *mean, double *most) {
    double sum = 0;
    *most = 0;
    for (int64_t row = 0; row < a->rows; row++)
        for (int k = 2; k < a->columns; k++) {
            const double d = fabs(sp_table_number(a, row, k) - sp_table_number(b, row, k));
            sum += d;
            *most = fmax(*most, d);
        }
    *mean = sum / (double)(a->rows * (a->columns - 2));
}

static sp_status make_surfaces(surfaces *s, sp_error *err) {
    static const sp_tapped_model models[MODELS] = {SP_TAPPED_LATTICE, SP_TAPPED_LONGWAVE, SP_TAPPED_BSR};
    static const char *const names[MODELS] = {"fig2-lattice", "fig2-longwave", "fig2-bsr"};
    sp_status status = SP_OK;
    for (int k = 0; k < MODELS && status == SP_OK; k++) {
        sp_tapped_spec c = s->c;
        c.model = models[k];
        status = sp_tapped_table(&c, 1, &s->of[k], err);
        c.cells /= 2;
        if (status == SP_OK && k > LATTICE)
            status = sp_tapped_table(&c, 1, &s->coarse[k], err);
        if (status == SP_OK)
            status = sp_blackmore_save(s->p, names[k], &s->of[k], err);
        if (status == SP_OK)
            status = sp_blackmore_tell(s->p, 0.2 * (k + 1), err);
    }
    return status;
}

static sp_status add_pair(const surfaces *s, int a, int b, const char *name, const char *note, sp_error *err) {
    double mean, most, rough_mean, rough_most;
    distance(&s->of[a], &s->of[b], &mean, &most);
    distance(a == LATTICE ? &s->of[a] : &s->coarse[a], &s->coarse[b], &rough_mean, &rough_most);
    blackmore_row row = {.item = BLACKMORE_FIG_2,
                         .equation = "Fig. 2",
                         .unit = "cm",
                         .paper = NAN,
                         .ours = mean,
                         .err = fabs(mean - rough_mean)};
    snprintf(row.note, sizeof row.note, "%s; err: the difference from half as many grid cells", note);
    sp_status status = sp_blackmore_add(s->p, row, err, "mean |y - y|, %s", name);
    row.ours = most;
    row.err = fabs(most - rough_most);
    return status == SP_OK ? sp_blackmore_add(s->p, row, err, "largest |y - y|, %s", name) : status;
}

/* Adds the greatest height of the topmost particle. */
static sp_status add_heights(const surfaces *s, sp_error *err) {
    static const char *const names[MODELS] = {"lattice", "long wave", "BSR"};
    double high[MODELS] = {0};
    sp_status status = SP_OK;
    for (int k = 0; k < MODELS && status == SP_OK; k++) {
        const sp_table *fine = &s->of[k], *rough = k == LATTICE ? fine : &s->coarse[k];
        double coarse = 0;
        for (int64_t row = 0; row < fine->rows; row++) {
            high[k] = fmax(high[k], sp_table_number(fine, row, fine->columns - 1));
            coarse = fmax(coarse, sp_table_number(rough, row, rough->columns - 1));
        }
        const blackmore_row row = {.item = BLACKMORE_FIG_2,
                                   .equation = "Fig. 2",
                                   .unit = "cm",
                                   .paper = NAN,
                                   .ours = high[k],
                                   .err = k == LATTICE ? lattice_error : fabs(high[k] - coarse)};
        status = sp_blackmore_add(s->p, row, err, "highest y%d in rows of T/100, %s", s->c.particles, names[k]);
    }
    double mean, most;
    distance(&s->of[LATTICE], &s->of[LONGWAVE], &mean, &most);
    sp_blackmore_say(
        s->p, BLACKMORE_FIG_2,
        "The long wave is a well-posed limit of the lattice, BSR a conservative model with the same contact law "
        "(neither is the printed one, see below and the errata), for the ten particles of Fig. 1: the tap that "
        "the paper calls much longer is not given. The top rises to %.2f cm in the lattice, %.2f in the long "
        "wave and %.2f in BSR; the long wave is %.3f cm off in the mean, of a column of %g cm.",
        high[LATTICE], high[LONGWAVE], high[BSR], mean, 2 * s->c.particles * sp_tapped_radius(&s->c, 1));
    return status;
}

static sp_status skip_row(double t, const double *y, const double *v, void *user, sp_error *err) {
    (void)t, (void)y, (void)v, (void)user, (void)err;
    return SP_OK;
}

/* (45) as printed and with corrected signs: the columns fall through the floor. */
static sp_status add_collapse(const surfaces *s, sp_error *err) {
    static const sp_tapped_bsr kinds[2] = {SP_TAPPED_BSR_LITERAL, SP_TAPPED_BSR_SIGNED};
    static const char *const names[2] = {"(45) as printed", "(45) with sgn(y)"};
    sp_status status = SP_OK;
    for (int k = 0; k < 2 && status == SP_OK; k++) {
        sp_tapped_spec c = s->c;
        sp_tapped_report report = {0};
        c.model = SP_TAPPED_BSR;
        c.bsr = kinds[k];
        status = sp_tapped_run(&c, 0, NULL, skip_row, NULL, &report, err);
        if (status != SP_OK)
            return status;
        blackmore_row row = {.item = BLACKMORE_FIG_2,
                             .equation = "(45)",
                             .unit = "cm",
                             .relation = BLACKMORE_ABOVE,
                             .ours = report.tap[0].separation,
                             .err = NAN};
        snprintf(row.note, sizeof row.note,
                 "collapses: (1) is violated at t = %.5f s between %s; err: after that no number means a thing",
                 report.violated_at, report.violated == 0 ? "floor and particle 1" : "two particles");
        status = sp_blackmore_add(s->p, row, err, "smallest separation in tap 1, %s", names[k]);
        sp_blackmore_say(
            s->p, BLACKMORE_FIG_2,
            "%s: its force is %.4f m g at the most%s; the column collapses, ordering (1) fails at t = %.5f s.",
            names[k], sp_tapped_bsr_force(&c, c.bsr), k == 0 ? ", downwards" : "", report.violated_at);
        sp_tapped_report_free(&report);
    }
    return status;
}

static sp_status show_surfaces(surfaces *s, sp_error *err) {
    static const char *const labels[MODELS] = {"lattice", "long wave", "BSR, conservative"};
    const sp_table *const all[MODELS] = {&s->of[LATTICE], &s->of[LONGWAVE], &s->of[BSR]};
    sp_status status = sp_blackmore_draw(
        s->p, BLACKMORE_FIG_2, "fig2-surfaces", MODELS, all, labels,
        "y over particle and time: lattice, long wave and BSR, ten particles at 9.5 Hz, T = 1 s, in one scale.", err);
    sp_tapped_spec c = s->c;
    sp_table t = sp_table_none();
    c.output = SP_TAPPED_COMPARE;
    if (status == SP_OK && s->p->opt->folder)
        status = sp_tapped_table(&c, 1, &t, err);
    const sp_table *compare = &t;
    if (status == SP_OK && s->p->opt->folder)
        status = sp_blackmore_save(s->p, "fig2-errors", &t, err);
    if (status == SP_OK)
        status = sp_blackmore_draw(
            s->p, BLACKMORE_FIG_2, "fig2-errors", 1, &compare, NULL,
            "Mean and largest difference of long wave and BSR from the lattice over the particles.", err);
    sp_table_free(&t);
    return status;
}

sp_status sp_blackmore_make_fig2(tapped *p, sp_error *err) {
    surfaces s = {.p = p, .c = sp_blackmore_column(10)};
    for (int k = 0; k < MODELS; k++)
        s.of[k] = s.coarse[k] = sp_table_none();
    sp_status status = make_surfaces(&s, err);
    if (status == SP_OK)
        status = add_pair(&s, LATTICE, LONGWAVE, "long wave and lattice", "good qualitative agreement is said", err);
    if (status == SP_OK)
        status = add_pair(&s, LATTICE, BSR, "BSR and lattice", "good qualitative agreement is said", err);
    if (status == SP_OK)
        status = add_pair(&s, LONGWAVE, BSR, "long wave and BSR", "said to be very close, without a number", err);
    if (status == SP_OK)
        status = add_heights(&s, err);
    if (status == SP_OK)
        status = add_collapse(&s, err);
    if (status == SP_OK)
        status = show_surfaces(&s, err);
    for (int k = 0; k < MODELS; k++) {
        sp_table_free(&s.of[k]);
        sp_table_free(&s.coarse[k]);
    }
    return status;
}
