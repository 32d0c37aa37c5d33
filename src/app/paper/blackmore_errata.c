/* Errors of the paper: for each the value that follows from the print, and the correct one, both computed. */
#include "base/base.h"
#include "paper/blackmore.h"

#include <stdio.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

typedef struct errata {
    tapped *p;
    sp_tapped_spec five, ten; /* of Fig. 1 */
} errata;

static blackmore_row erratum(const char *equation, const char *unit, double paper, double ours, const char *note) {
    blackmore_row row = {
        .item = BLACKMORE_ERRATA, .equation = equation, .unit = unit, .paper = paper, .ours = ours, .misprint = true};
    snprintf(row.note, sizeof row.note, "%s", note);
    return row;
}

/* ---- the lattice ------------------------------------------------------------------------------------------------ */

static double overlap(const sp_tapped_spec *c, const double *y, int32_t contact) {
    const double h = 2 * sp_tapped_radius(c, 1);
    if (contact >= c->particles)
        return 0;
    return fmax(0, contact == 0 ? 0.5 * h - y[0] : h - (y[contact] - y[contact - 1]));
}

/* Acceleration by (19) of a particle (from 1) at rest at y [N] on a resting floor, where sigma(0) = 0. */
static double acceleration(const sp_tapped_spec *c, const double *y, int32_t particle) {
    return -c->gravity +
           sp_tapped_stiffness(c) / sp_tapped_mass(c, 1) * (overlap(c, y, particle - 1) - overlap(c, y, particle));
}

/* The middle line of (24) as printed, where its two brackets are multiplied. */
static double printed_middle(const sp_tapped_spec *c, const double *y, int32_t particle) {
    return -c->gravity -
           sp_tapped_stiffness(c) / sp_tapped_mass(c, 1) * overlap(c, y, particle) * overlap(c, y, particle - 1);
}

static sp_status add_floor(const errata *e, sp_error *err) {
    const sp_tapped_spec *c = &e->five;
    const double end = 0.5 / c->frequency * (1 + 1e-12), jump = c->amplitude * 2 * pi * c->frequency;
    blackmore_row row = erratum("(3)", "cm/s", 0, sp_tapped_floor_velocity(c, 0),
                                "(3) is 0 at t = 0, but the velocity jumps by +a omega there");
    sp_status status = sp_blackmore_add(e->p, row, err, "velocity of the floor as a tap begins");
    row = erratum("(3)", "cm/s", -jump, sp_tapped_floor_velocity(c, end),
                  "(3) has both -a omega and 0 at t = pi/omega; it jumps by +a omega to 0");
    return status == SP_OK ? sp_blackmore_add(e->p, row, err, "velocity of the floor after pi/omega") : status;
}

static sp_status skip_row(double t, const double *y, const double *v, void *user, sp_error *err) {
    (void)t, (void)y, (void)v, (void)user, (void)err;
    return SP_OK;
}

static sp_status add_elastic(const errata *e, sp_error *err) {
    sp_tapped_spec c = e->five;
    sp_tapped_report report = {0};
    c.e = 0;
    c.taps = 1;
    sp_status status = sp_tapped_run(&c, 0, NULL, skip_row, NULL, &report, err);
    if (status != SP_OK)
        return status;
    const blackmore_row row = erratum("(6)", "erg", NAN, report.tap[0].dissipated,
                                      "0 < K^ is printed, but e = 0 is the Hamiltonian case of Sects. 2 to 6: 0 <= K^");
    sp_tapped_report_free(&report);
    return sp_blackmore_add(e->p, row, err, "energy lost in a tap with e = 0");
}

/* (24) to (28): the column at rest. */
static sp_status add_rest(const errata *e, sp_error *err) {
    const sp_tapped_spec *c = &e->five;
    const double n = c->particles, r = sp_tapped_radius(c, 1), m = sp_blackmore_overlap(c);
    double y[5];
    sp_tapped_rest(c, y);
    blackmore_row row = erratum("(24)", "cm/s^2", printed_middle(c, y, 3), acceleration(c, y, 3),
                                "the middle line lacks the minus sign between its brackets, which (19) has");
    row.err = 1e-9 * c->gravity;
    sp_status status = sp_blackmore_add(e->p, row, err, "acceleration of particle 3 of 5 at rest");
    row = erratum("(26)", "", n - 1, n, "the middle line is for 1 < k < N, not N - 1");
    if (status == SP_OK)
        status = sp_blackmore_add(e->p, row, err, "equations for the %d unknowns", c->particles);
    row = erratum("(27)", "cm", 2 * r - ((2 * n - 1) * r - 0.5 * ((n - 1) * n + 2) * m - y[3]), overlap(c, y, 4),
                  "y_k is right for all k; the y_N of its own leaves the top contact open (negative: a gap)");
    row.err = 1e-12;
    if (status == SP_OK)
        status = sp_blackmore_add(e->p, row, err, "overlap of particles 4 and 5 at rest");
    row = erratum("Sect. 3", "", 29, 28, "(29) is the height; (28) asks for K above N m g/r");
    if (status == SP_OK)
        status = sp_blackmore_add(e->p, row, err, "equation from which K = 2 N m g/r follows");
    return status;
}

/* omega = 2 pi Gamma mistakes the acceleration Gamma = a omega^2/g for a frequency. */
static sp_status add_gamma(const errata *e, sp_error *err) {
    static const double printed[] = {2.4019, 3.8476};
    const sp_tapped_spec *const column[] = {&e->five, &e->ten};
    sp_status status = SP_OK;
    for (int k = 0; k < 2 && status == SP_OK; k++) {
        const sp_tapped_spec *c = column[k];
        blackmore_row row =
            erratum("Sect. 3", "Hz", printed[k], sqrt(printed[k] * c->gravity / c->amplitude) / (2 * pi),
                    "omega = 2 pi Gamma cannot be: Gamma = a omega^2/g with a = 1.06 gives this");
        row.err = 0.5e-4 / printed[k] * row.ours / 2; /* the last digit of Gamma */
        status = sp_blackmore_add(e->p, row, err, "frequency of the taps, N = %d", c->particles);
    }
    if (status != SP_OK)
        return status;
    const blackmore_row row = erratum("Sect. 3", "s", 50, e->five.period,
                                      "T = 50 has no unit; T = 1 s as Sect. 2 advises, and time to settle");
    return sp_blackmore_add(e->p, row, err, "period T");
}

/* The upper contact is just open; the lower one carries three particles, as at rest. */
static sp_status add_step(const errata *e, sp_error *err) {
    const sp_tapped_spec *c = &e->five;
    blackmore_row row = erratum("(30)", "", 1, 2, "alpha_v [s/cm] for velocities, alpha_x [1/cm] for lengths");
    sp_status status = sp_blackmore_add(e->p, row, err, "parameters alpha of sigma and chi");
    row = erratum("(31)", "cm/s^2", -c->gravity,
                  -c->gravity + sp_tapped_stiffness(c) / sp_tapped_mass(c, 1) * 3 * sp_blackmore_overlap(c),
                  "the last factor is chi(2r - Dy_(i-1)): as printed the lower contact cannot push when the upper is "
                  "open");
    return status == SP_OK ? sp_blackmore_add(e->p, row, err, "acceleration when the upper contact is open") : status;
}

/* ---- the long wave ---------------------------------------------------------------------------------------------- */

/* (36) with sigma = tanh(alpha s): sigma'(0) = alpha, sigma'''(0) = -2 alpha^3, chi(0) = 1/2. */
static double a_minus(double r, double alpha) { return 3 * 0.5 + 6 * r * alpha - 8 * pow(r, 3) * -2 * pow(alpha, 3); }

static sp_status add_long_wave(const errata *e, sp_error *err) {
    const sp_tapped_spec *c = &e->ten;
    const double r = sp_tapped_radius(c, 1), h = 2 * r, unit = sp_tapped_stiffness(c) * h * h / sp_tapped_mass(c, 1);
    sp_tapped_symbol of35, of37;
    blackmore_row row = erratum("(38)", "", 13.5, a_minus(r, 1 / h), "from (36), with sigma''' = -2 alpha^3");
    row.precision = 0.05;
    sp_status status = sp_blackmore_add(e->p, row, err, "A(-) at chi(0) = 1/2, alpha = 1/h");
    if (status == SP_OK)
        status = sp_tapped_symbol_at(c, SP_TAPPED_EQ35, 1 / h, 1, 1e-6, &of35, err);
    if (status == SP_OK)
        status = sp_tapped_symbol_at(c, SP_TAPPED_EQ37, 1 / h, 1, 1e-6, &of37, err);
    if (status != SP_OK)
        return status;
    row = erratum("(37)", "K h^2/m", of37.speed2 / unit, of35.speed2 / unit,
                  "(37) has the other sign overall than (35): a square of a speed below 0 is no wave");
    status = sp_blackmore_add(e->p, row, err, "c^2 of (37) and of (35), long waves");
    row = erratum("(35)", "K h^2/m", of35.speed2 / unit, 0.5,
                  "expanded in the overlap 2r - Dy about Dy = 0, but the column is near Dy = h; there chi(0) = 1/2");
    if (status == SP_OK)
        status = sp_blackmore_add(e->p, row, err, "c^2 of (35), of the lattice at a just closed contact");
    double y[10];
    for (int i = 0; i < c->particles; i++)
        y[i] = (2 * i + 1) * r;
    row = erratum("(39)", "cm/s^2", acceleration(c, y, 1), 0,
                  "y = z is no equilibrium: all contacts just touch, and all falls; start from (27), y_t = 0");
    return status == SP_OK ? sp_blackmore_add(e->p, row, err, "acceleration as it starts") : status;
}

/* y = (1 + s t) z with mass m/h per label: the density at a label is m/(h (1 + s t)). (41) mixes rho_z at fixed places
 * with y of labels, and gives exp(-s t). */
static sp_status add_continuity(const errata *e, sp_error *err) {
    blackmore_row row =
        erratum("(41)", "m/h", exp(-1), 0.5,
                "(41) is for places, y(z, t) of labels; along a label rho = m/(h y_z): here y = (1 + s t) "
                "z at s t = 1");
    sp_status status = sp_blackmore_add(e->p, row, err, "density of a column stretched to twice its length");
    row = erratum("(48)", "", 46, 42, "rho begins with the data (42), not with (46), which is of u");
    return status == SP_OK ? sp_blackmore_add(e->p, row, err, "equation with the data of the density") : status;
}

/* ---- BSR and the scheme ----------------------------------------------------------------------------------------- */

/* Integral of Theta, (44), over all y, with the given prefactor. */
static double normalisation(double prefactor, double b, double c) {
    enum { POINTS = 4000 };
    const double step = 24 * c / POINTS; /* over 12 widths on either side the trapezoidal rule is exact */
    double sum = 0;
    for (int k = 0; k <= POINTS; k++) {
        const double x = -12 * c + k * step;
        sum += exp(-x * x / (2 * c * c)) * step;
    }
    (void)b; /* only shifts the maximum */
    return prefactor * sum / sqrt(2 * pi);
}

static sp_status add_bsr(const errata *e, sp_error *err) {
    const sp_tapped_spec *c = &e->ten;
    const double h = 2 * sp_tapped_radius(c, 1), wide = 3 * h;
    blackmore_row row =
        erratum("(43)", "cm/s^2", -INFINITY, 0,
                "its integrand depends on the particle alone, not on z: times an infinite length; discard");
    sp_status status = sp_blackmore_add(e->p, row, err, "acceleration of a particle at rest");
    row = erratum("(44)", "", normalisation(1 / (7 * h), 7 * h, wide), normalisation(1 / wide, 7 * h, wide),
                  "the prefactor is 1/(c sqrt(2 pi)), not 1/(b sqrt(2 pi))");
    row.err = 1e-12;
    if (status == SP_OK)
        status = sp_blackmore_add(e->p, row, err, "integral of Theta");
    row = erratum("(45)", "m g", -sp_tapped_bsr_force(c, SP_TAPPED_BSR_LITERAL),
                  sp_tapped_bsr_force(c, SP_TAPPED_BSR_SIGNED),
                  "lacks sgn(y) in force and sigma, and only pulls down; with it 1 is not reached: neither can carry "
                  "a particle");
    row.err = 1e-4;
    if (status == SP_OK)
        status = sp_blackmore_add(e->p, row, err, "largest force, upwards positive");
    const double speed = h * sqrt(sp_tapped_stiffness(c) / sp_tapped_mass(c, 1));
    row = erratum("Sect. 7", "s", 0.01, 0.01 / speed,
                  "dt = dz = 0.01 is printed; central differences need a CFL number below 1 (see symbols)");
    return status == SP_OK ? sp_blackmore_add(e->p, row, err, "largest time step at dz = 0.01 cm, N = 10") : status;
}

static sp_status add_ordering(const errata *e, sp_error *err) {
    sp_tapped_spec c = e->five;
    sp_tapped_report report = {0};
    c.period = 0.5;
    sp_status status = sp_tapped_run(&c, 0, NULL, skip_row, NULL, &report, err);
    if (status != SP_OK)
        return status;
    blackmore_row row = erratum("(1)", "cm", 0, report.tap[3].separation, "");
    row.relation = BLACKMORE_ABOVE;
    row.err = 1e-8;
    snprintf(row.note, sizeof row.note,
             "(28) is not enough: the overlap reached the distance at contact %d first at t = %.3f s", report.violated,
             report.violated_at);
    sp_tapped_report_free(&report);
    return sp_blackmore_add(e->p, row, err, "smallest separation in tap 4, N = 5, T = 0.5 s");
}

sp_status sp_blackmore_make_errata(tapped *p, sp_error *err) {
    static sp_status (*const part[])(const errata *, sp_error *) = {
        add_ordering, add_floor, add_elastic, add_rest, add_gamma, add_step, add_long_wave, add_continuity, add_bsr};
    const errata e = {.p = p, .five = sp_blackmore_column(5), .ten = sp_blackmore_column(10)};
    sp_status status = SP_OK;
    sp_blackmore_say(p, BLACKMORE_ERRATA,
                     "In the column of the paper stands what is printed, or what a printed equation gives when it is "
                     "evaluated; in ours the value that is right. Values are for the columns of Fig. 1.");
    for (size_t k = 0; k < sizeof part / sizeof *part && status == SP_OK; k++)
        status = part[k](&e, err);
    return status;
}
