/* Figs. 1 and 2: trajectories of the lattice, and the continua in comparison with it. */
#include "base/base.h"
#include "paper/blackmore.h"

#include <stdio.h>
#include <string.h>

/* Error of the lattice's positions [cm] and densities [g/cm], as tests against other solvers confirm. */
static const double lattice_error = 1e-8;

/* ---- Fig. 1 ----------------------------------------------------------------------------------------------------- */

typedef struct fig1 {
    blackmore *p;
    sp_tapped_spec c;
    sp_table trajectory, strobe, energy;
} fig1;

static double cell(const sp_table *t, int64_t row, const char *column) {
    return sp_table_number(t, row, sp_table_find_column(t, column));
}

static blackmore_row value(int item, const char *unit, double paper, double ours, double err) {
    return (blackmore_row){.item = item,
                           .equation = item == BLACKMORE_FIG_1 ? "Fig. 1" : "Fig. 2",
                           .unit = unit,
                           .paper = paper,
                           .ours = ours,
                           .err = err};
}

static void add_gamma(const fig1 *s) {
    const sp_tapped_spec *c = &s->c;
    const double omega = 2 * blackmore_pi * c->frequency;
    blackmore_row row =
        value(BLACKMORE_FIG_1, "", c->particles == 5 ? 2.4019 : 3.8476, c->amplitude * omega * omega / c->gravity, 0);
    row.equation = "Sect. 3";
    row.precision = row.paper * 0.005 / 0.53;
    sp_blackmore_note(&row, "to the precision of a/2r = 0.53");
    sp_blackmore_add(s->p, row, "Gamma at f = %g Hz, N = %d", c->frequency, c->particles);
}

static void add_positions(const fig1 *s) {
    for (int64_t tap = 0; tap < s->strobe.rows; tap++)
        for (int32_t i = 1; i <= s->c.particles; i++) {
            char name[16];
            snprintf(name, sizeof name, "y%d", i);
            blackmore_row row = value(BLACKMORE_FIG_1, "cm", NAN, cell(&s->strobe, tap, name), lattice_error);
            row.detail = true;
            sp_blackmore_add(s->p, row, "y%d(%lld.99T), N = %d", i, (long long)tap, s->c.particles);
        }
}

/* Densities before the first tap and at .99T, 1.99T, ... */
static void add_densities(const fig1 *s) {
    const int32_t n = s->c.particles;
    double y[11] = {0};
    sp_tapped_rest(&s->c, y + 1);
    const double before = sp_tapped_density(&s->c, y);
    const int64_t last = s->strobe.rows - 1;
    sp_blackmore_add(s->p, value(BLACKMORE_FIG_1, "g/cm", NAN, before, 1e-12), "density before, N = %d", n);
    for (int64_t tap = 0; tap <= last; tap++)
        sp_blackmore_add(s->p, value(BLACKMORE_FIG_1, "g/cm", NAN, cell(&s->strobe, tap, "density"), lattice_error),
                         "density after tap %lld, N = %d", (long long)tap + 1, n);
    const double after = cell(&s->strobe, last, "density");
    sp_blackmore_say(
        s->p, BLACKMORE_FIG_1,
        "N = %d: m N over the length of the column is %.6f g/cm before the first tap; that tap changes it by "
        "%+.2f%%, all four by %+.2f%%.",
        n, before, 100 * (cell(&s->strobe, 0, "density") / before - 1), 100 * (after / before - 1));
}

static void add_taps(const fig1 *s) {
    const int32_t n = s->c.particles;
    double latest = 0, least = INFINITY;
    for (int64_t tap = 0; tap < s->energy.rows; tap++) {
        const double work = cell(&s->energy, tap, "work"), error = fabs(cell(&s->energy, tap, "residual")) * work;
        const double rest = cell(&s->energy, tap, "rest"), dissipated = cell(&s->energy, tap, "dissipated");
        const long long number = (long long)tap + 1;
        blackmore_row row[] = {value(BLACKMORE_FIG_1, "s", NAN, rest, 1e-8),
                               value(BLACKMORE_FIG_1, "erg", NAN, work, error),
                               value(BLACKMORE_FIG_1, "erg", NAN, dissipated, error)};
        row[0].detail = row[1].detail = row[2].detail = tap > 0;
        sp_blackmore_add(s->p, row[0], "time to rest in tap %lld, N = %d", number, n);
        sp_blackmore_add(s->p, row[1], "work of the floor in tap %lld, N = %d", number, n);
        sp_blackmore_add(s->p, row[2], "dissipated in tap %lld, N = %d", number, n);
        latest = isnan(rest) ? INFINITY : fmax(latest, rest); /* NAN: never at rest */
        least = fmin(least, cell(&s->energy, tap, "separation"));
    }
    blackmore_row row = value(BLACKMORE_FIG_1, "s", 0.99 * s->c.period, latest, 1e-8);
    row.relation = BLACKMORE_BELOW;
    sp_blackmore_note(&row, "the particles have settled by .99T, as is meant");
    sp_blackmore_add(s->p, row, "longest time to rest, N = %d", n);
    row = value(BLACKMORE_FIG_1, "cm", 0, least, lattice_error);
    row.equation = "(1)";
    row.relation = BLACKMORE_ABOVE;
    sp_blackmore_note(&row, "contact with the floor included");
    sp_blackmore_add(s->p, row, "smallest separation, N = %d", n);
}

static sp_status show_fig1(fig1 *s, sp_error *err) {
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

static sp_status make_column(fig1 *s, sp_error *err) {
    const sp_tapped_output outputs[] = {SP_TAPPED_TRAJECTORY, SP_TAPPED_STROBE, SP_TAPPED_ENERGY};
    sp_table *const tables[] = {&s->trajectory, &s->strobe, &s->energy};
    sp_status status = SP_OK;
    s->c.step = 0.0025;
    for (int k = 0; k < 3 && status == SP_OK; k++) {
        s->c.output = outputs[k];
        status = sp_tapped_table(&s->c, 1, tables[k], err);
    }
    if (status != SP_OK)
        return status;
    add_gamma(s);
    add_densities(s);
    add_taps(s);
    add_positions(s);
    return show_fig1(s, err);
}

sp_status sp_blackmore_make_fig1(blackmore *p, sp_error *err) {
    static const int32_t particles[2] = {5, 10};
    sp_status status = SP_OK;
    for (int k = 0; k < 2 && status == SP_OK; k++) {
        fig1 s = {p, sp_blackmore_column(particles[k]), sp_table_none(), sp_table_none(), sp_table_none()};
        status = make_column(&s, err);
        sp_table_free(&s.trajectory);
        sp_table_free(&s.strobe);
        sp_table_free(&s.energy);
        if (status == SP_OK)
            status = sp_blackmore_progress(p, 0.5 * (k + 1), err);
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
    blackmore *p;
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
            status = sp_blackmore_progress(s->p, 0.2 * (k + 1), err);
    }
    return status;
}

static void add_pair(const surfaces *s, int a, int b, const char *name, const char *note) {
    double mean, most, rough_mean, rough_most;
    distance(&s->of[a], &s->of[b], &mean, &most);
    distance(a == LATTICE ? &s->of[a] : &s->coarse[a], &s->coarse[b], &rough_mean, &rough_most);
    blackmore_row row = value(BLACKMORE_FIG_2, "cm", NAN, mean, fabs(mean - rough_mean));
    sp_blackmore_note(&row, "%s; err: the difference from half as many grid cells", note);
    sp_blackmore_add(s->p, row, "mean |y - y|, %s", name);
    row.ours = most;
    row.err = fabs(most - rough_most);
    sp_blackmore_add(s->p, row, "largest |y - y|, %s", name);
}

/* Adds the greatest height of the topmost particle. */
static void add_heights(const surfaces *s) {
    static const char *const names[MODELS] = {"lattice", "long wave", "BSR"};
    double high[MODELS] = {0};
    for (int k = 0; k < MODELS; k++) {
        const sp_table *fine = &s->of[k], *rough = k == LATTICE ? fine : &s->coarse[k];
        double coarse = 0;
        for (int64_t row = 0; row < fine->rows; row++) {
            high[k] = fmax(high[k], sp_table_number(fine, row, fine->columns - 1));
            coarse = fmax(coarse, sp_table_number(rough, row, rough->columns - 1));
        }
        blackmore_row row =
            value(BLACKMORE_FIG_2, "cm", NAN, high[k], k == LATTICE ? lattice_error : fabs(high[k] - coarse));
        sp_blackmore_add(s->p, row, "highest y%d in rows of T/100, %s", s->c.particles, names[k]);
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
        status = sp_tapped_run(&c, 0, NULL, NULL, NULL, &report, err);
        if (status != SP_OK)
            return status;
        blackmore_row row = value(BLACKMORE_FIG_2, "cm", 0, report.tap[0].separation, NAN);
        row.equation = "(45)";
        row.relation = BLACKMORE_ABOVE;
        sp_blackmore_note(
            &row, "collapses: (1) is violated at t = %.5f s between %s; err: after that no number means a thing",
            report.violated_at, report.violated == 0 ? "floor and particle 1" : "two particles");
        sp_blackmore_add(s->p, row, "smallest separation in tap 1, %s", names[k]);
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

sp_status sp_blackmore_make_fig2(blackmore *p, sp_error *err) {
    surfaces s = {.p = p, .c = sp_blackmore_column(10)};
    for (int k = 0; k < MODELS; k++)
        s.of[k] = s.coarse[k] = sp_table_none();
    sp_status status = make_surfaces(&s, err);
    if (status == SP_OK) {
        add_pair(&s, LATTICE, LONGWAVE, "long wave and lattice", "good qualitative agreement is said");
        add_pair(&s, LATTICE, BSR, "BSR and lattice", "good qualitative agreement is said");
        add_pair(&s, LONGWAVE, BSR, "long wave and BSR", "said to be very close, without a number");
        add_heights(&s);
        status = add_collapse(&s, err);
    }
    if (status == SP_OK)
        status = show_surfaces(&s, err);
    for (int k = 0; k < MODELS; k++) {
        sp_table_free(&s.of[k]);
        sp_table_free(&s.coarse[k]);
    }
    return status;
}
