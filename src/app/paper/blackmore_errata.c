/* Errors of the paper: for each the value that follows from the print, and the correct one, both computed. */
#include "paper/blackmore.h"

typedef struct errata {
    blackmore *p;
    sp_tapped_spec five, ten; /* of Fig. 1 */
} errata;

/* Adds an erratum; err: of our value. */
static void add(const errata *e, const char *equation, const char *unit, double paper, double ours, double err,
                const char *quantity, const char *note) {
    blackmore_row row = {.item = BLACKMORE_ERRATA, .equation = equation, .unit = unit, .paper = paper, .ours = ours};
    row.err = err;
    row.misprint = true;
    sp_blackmore_note(&row, "%s", note);
    sp_blackmore_add(e->p, row, "%s", quantity);
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
    (void)err;
    const sp_tapped_spec *c = &e->five;
    const double end = 0.5 / c->frequency * (1 + 1e-12), jump = c->amplitude * 2 * blackmore_pi * c->frequency;
    add(e, "(3)", "cm/s", 0, sp_tapped_floor_velocity(c, 0), 0, "velocity of the floor as a tap begins",
        "(3) is 0 at t = 0, but the velocity jumps by +a omega there");
    add(e, "(3)", "cm/s", -jump, sp_tapped_floor_velocity(c, end), 0, "velocity of the floor after pi/omega",
        "(3) has both -a omega and 0 at t = pi/omega; it jumps by +a omega to 0");
    return SP_OK;
}

static sp_status add_elastic(const errata *e, sp_error *err) {
    sp_tapped_spec c = e->five;
    sp_tapped_report report = {0};
    c.e = 0;
    c.taps = 1;
    sp_status status = sp_tapped_run(&c, 0, NULL, NULL, NULL, &report, err);
    if (status == SP_OK)
        add(e, "(6)", "erg", NAN, report.tap[0].dissipated, 0, "energy lost in a tap with e = 0",
            "0 < K^ is printed, but e = 0 is the Hamiltonian case of Sects. 2 to 6: 0 <= K^");
    sp_tapped_report_free(&report);
    return status;
}

/* (24) to (28): the column at rest. */
static sp_status add_rest(const errata *e, sp_error *err) {
    (void)err;
    const sp_tapped_spec *c = &e->five;
    const double n = c->particles, r = sp_tapped_radius(c, 1), m = sp_blackmore_overlap(c);
    double y[5];
    sp_tapped_rest(c, y);
    add(e, "(24)", "cm/s^2", printed_middle(c, y, 3), acceleration(c, y, 3), 1e-9 * c->gravity,
        "acceleration of particle 3 of 5 at rest",
        "the middle line lacks the minus sign between its brackets, which (19) has");
    add(e, "(26)", "", n - 1, n, 0, "equations for the 5 unknowns", "the middle line is for 1 < k < N, not N - 1");
    add(e, "(27)", "cm", 2 * r - ((2 * n - 1) * r - 0.5 * ((n - 1) * n + 2) * m - y[3]), overlap(c, y, 4), 1e-12,
        "overlap of particles 4 and 5 at rest",
        "y_k is right for all k; the y_N of its own leaves the top contact open (negative: a gap)");
    add(e, "Sect. 3", "", 29, 28, 0, "equation from which K = 2 N m g/r follows",
        "(29) is the height; (28) asks for K above N m g/r");
    return SP_OK;
}

/* omega = 2 pi Gamma mistakes the acceleration Gamma = a omega^2/g for a frequency. */
static sp_status add_gamma(const errata *e, sp_error *err) {
    (void)err;
    static const double printed[] = {2.4019, 3.8476};
    static const char *const quantity[] = {"frequency of the taps, N = 5", "frequency of the taps, N = 10"};
    for (int k = 0; k < 2; k++) {
        const sp_tapped_spec *c = k == 0 ? &e->five : &e->ten;
        const double ours = sqrt(printed[k] * c->gravity / c->amplitude) / (2 * blackmore_pi);
        const double digit = 0.5e-4 / printed[k] * ours / 2; /* half of the last digit of Gamma */
        add(e, "Sect. 3", "Hz", printed[k], ours, digit, quantity[k],
            "omega = 2 pi Gamma cannot be: Gamma = a omega^2/g with a = 1.06 gives this");
    }
    add(e, "Sect. 3", "s", 50, e->five.period, 0, "period T",
        "T = 50 has no unit; T = 1 s as Sect. 2 advises, and time to settle");
    return SP_OK;
}

/* The upper contact is just open; the lower one carries three particles, as at rest. */
static sp_status add_step(const errata *e, sp_error *err) {
    (void)err;
    const sp_tapped_spec *c = &e->five;
    add(e, "(30)", "", 1, 2, 0, "parameters alpha of sigma and chi",
        "alpha_v [s/cm] for velocities, alpha_x [1/cm] for lengths");
    add(e, "(31)", "cm/s^2", -c->gravity,
        -c->gravity + sp_tapped_stiffness(c) / sp_tapped_mass(c, 1) * 3 * sp_blackmore_overlap(c), 0,
        "acceleration when the upper contact is open",
        "the last factor is chi(2r - Dy_(i-1)): as printed the lower contact cannot push when the upper is open");
    return SP_OK;
}

/* ---- the long wave ---------------------------------------------------------------------------------------------- */

static sp_status add_long_wave(const errata *e, sp_error *err) {
    const sp_tapped_spec *c = &e->ten;
    const double r = sp_tapped_radius(c, 1), h = 2 * r, unit = sp_blackmore_speed2(c);
    sp_tapped_symbol of35, of37;
    blackmore_row row = {.item = BLACKMORE_ERRATA, .equation = "(38)", .paper = 13.5, .precision = 0.05};
    row.ours = sp_blackmore_coefficients(r, 1 / h).minus;
    row.misprint = true;
    sp_blackmore_note(&row, "from (36), with sigma''' = -2 alpha^3");
    sp_blackmore_add(e->p, row, "A(-) at chi(0) = 1/2, alpha = 1/h");
    sp_status status = sp_tapped_symbol_at(c, SP_TAPPED_EQ35, 1 / h, 1, 1e-6, &of35, err);
    if (status == SP_OK)
        status = sp_tapped_symbol_at(c, SP_TAPPED_EQ37, 1 / h, 1, 1e-6, &of37, err);
    if (status != SP_OK)
        return status;
    add(e, "(37)", "K h^2/m", of37.speed2 / unit, of35.speed2 / unit, 0, "c^2 of (37) and of (35), long waves",
        "(37) has the other sign overall than (35): a square of a speed below 0 is no wave");
    add(e, "(35)", "K h^2/m", of35.speed2 / unit, 0.5, 0, "c^2 of (35), of the lattice at a just closed contact",
        "expanded in the overlap 2r - Dy about Dy = 0, but the column is near Dy = h; there chi(0) = 1/2");
    double y[10];
    for (int i = 0; i < c->particles; i++)
        y[i] = (2 * i + 1) * r;
    add(e, "(39)", "cm/s^2", acceleration(c, y, 1), 0, 0, "acceleration as it starts",
        "y = z is no equilibrium: all contacts just touch, and all falls; start from (27), y_t = 0");
    return SP_OK;
}

/* y = (1 + s t) z with mass m/h per label: the density at a label is m/(h (1 + s t)). (41) mixes rho_z at fixed places
 * with y of labels, and gives exp(-s t). */
static sp_status add_continuity(const errata *e, sp_error *err) {
    (void)err;
    add(e, "(41)", "m/h", exp(-1), 0.5, 0, "density of a column stretched to twice its length",
        "(41) is for places, y(z, t) of labels; along a label rho = m/(h y_z): here y = (1 + s t) z at s t = 1");
    add(e, "(48)", "", 46, 42, 0, "equation with the data of the density",
        "rho begins with the data (42), not with (46), which is of u");
    return SP_OK;
}

/* ---- BSR and the scheme ----------------------------------------------------------------------------------------- */

/* Integral of Theta, (44), over all y, with the given prefactor; b only shifts the maximum. */
static double normalisation(double prefactor, double c) {
    enum { POINTS = 4000 };
    const double step = 24 * c / POINTS; /* over 12 widths on either side the trapezoidal rule is exact */
    double sum = 0;
    for (int k = 0; k <= POINTS; k++) {
        const double x = -12 * c + k * step;
        sum += exp(-x * x / (2 * c * c)) * step;
    }
    return prefactor * sum / sqrt(2 * blackmore_pi);
}

static sp_status add_bsr(const errata *e, sp_error *err) {
    (void)err;
    const sp_tapped_spec *c = &e->ten;
    const double h = 2 * sp_tapped_radius(c, 1), wide = 3 * h;
    add(e, "(43)", "cm/s^2", -INFINITY, 0, 0, "acceleration of a particle at rest",
        "its integrand depends on the particle alone, not on z: times an infinite length; discard");
    add(e, "(44)", "", normalisation(1 / (7 * h), wide), normalisation(1 / wide, wide), 1e-12, "integral of Theta",
        "the prefactor is 1/(c sqrt(2 pi)), not 1/(b sqrt(2 pi))");
    add(e, "(45)", "m g", -sp_tapped_bsr_force(c, SP_TAPPED_BSR_LITERAL), sp_tapped_bsr_force(c, SP_TAPPED_BSR_SIGNED),
        1e-4, "largest force, upwards positive",
        "lacks sgn(y) in force and sigma, and only pulls down; with it 1 is not reached: neither can carry a particle");
    const double speed = h * sqrt(sp_tapped_stiffness(c) / sp_tapped_mass(c, 1));
    add(e, "Sect. 7", "s", 0.01, 0.01 / speed, 0, "largest time step at dz = 0.01 cm, N = 10",
        "dt = dz = 0.01 is printed; central differences need a CFL number below 1 (see symbols)");
    return SP_OK;
}

static sp_status add_ordering(const errata *e, sp_error *err) {
    sp_tapped_spec c = e->five;
    sp_tapped_report report = {0};
    c.period = 0.5;
    sp_status status = sp_tapped_run(&c, 0, NULL, NULL, NULL, &report, err);
    if (status != SP_OK)
        return status;
    blackmore_row row = {.item = BLACKMORE_ERRATA, .equation = "(1)", .unit = "cm", .relation = BLACKMORE_ABOVE};
    row.ours = report.tap[3].separation;
    row.err = 1e-8;
    row.misprint = true;
    sp_blackmore_note(&row, "(28) is not enough: the overlap reached the distance at contact %d first at t = %.3f s",
                      report.violated, report.violated_at);
    sp_tapped_report_free(&report);
    sp_blackmore_add(e->p, row, "smallest separation in tap 4, N = 5, T = 0.5 s");
    return SP_OK;
}

sp_status sp_blackmore_make_errata(blackmore *p, sp_error *err) {
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
