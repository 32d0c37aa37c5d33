/* The specification of a column: defaults, checks, and quantities that follow from it directly. */
#include "base/base.h"
#include "tapped/column.h"

#include <math.h>
#include <stddef.h>

static const double one = 1;

sp_tapped_spec sp_tapped_spec_default(void) {
    return (sp_tapped_spec){.model = SP_TAPPED_LATTICE,
                            .method = SP_TAPPED_EVENT,
                            .bsr = SP_TAPPED_BSR_CONSERVATIVE,
                            .output = SP_TAPPED_TRAJECTORY,
                            .particles = 5,
                            .taps = 0,
                            .frequency = 7.5,
                            .period = 1,
                            .amplitude = 1.06,
                            .e = 0.09,
                            .gravity = 980.67,
                            .drop = -1,
                            .masses = 1,
                            .radii = 1,
                            .mass = &one,
                            .radius = &one,
                            .alpha_v = 1,
                            .tolerance = 1e-9,
                            .cells = 8,
                            .from = 0,
                            .to = 0,
                            .points = 1,
                            .transient = 200};
}

int32_t sp_tapped_taps(const sp_tapped_spec *c) {
    return c->taps > 0 ? c->taps : c->output == SP_TAPPED_LYAPUNOV ? 1000 : c->output == SP_TAPPED_BIFURCATION ? 50 : 4;
}

double sp_tapped_mass(const sp_tapped_spec *c, int32_t particle) { return c->mass[(particle - 1) % c->masses]; }
double sp_tapped_radius(const sp_tapped_spec *c, int32_t particle) { return c->radius[(particle - 1) % c->radii]; }

static double mass_of_all(const sp_tapped_spec *c) {
    double sum = 0;
    for (int32_t i = 1; i <= c->particles; i++)
        sum += sp_tapped_mass(c, i);
    return sum;
}

double sp_tapped_stiffness(const sp_tapped_spec *c) {
    if (c->stiffness > 0)
        return c->stiffness;
    double smallest = INFINITY;
    for (int32_t i = 1; i <= c->particles; i++)
        smallest = fmin(smallest, sp_tapped_radius(c, i));
    return 2 * mass_of_all(c) * c->gravity / smallest;
}

double sp_tapped_stiffness_bound(const sp_tapped_spec *c) {
    double above = mass_of_all(c), bound = 0;
    for (int32_t i = 0; i < c->particles; i++) {
        bound = fmax(bound, above * c->gravity / sp_tapped_distance(c, i));
        above -= sp_tapped_mass(c, i + 1);
    }
    return bound;
}

void sp_tapped_rest(const sp_tapped_spec *c, double *y) {
    double above = mass_of_all(c), stiffness = sp_tapped_stiffness(c), height = 0;
    for (int32_t i = 0; i < c->particles; i++) {
        height += sp_tapped_distance(c, i) - above * c->gravity / stiffness;
        above -= sp_tapped_mass(c, i + 1);
        y[i] = height;
    }
}

/* Time since the start of the tap. A time that is below k T by rounding alone counts as k T. */
static double phase(const sp_tapped_spec *c, double t) {
    double taps = floor(t / c->period * (1 + 4e-16));
    return fmax(0, t - taps * c->period);
}

double sp_tapped_floor(const sp_tapped_spec *c, double t) {
    double omega = 2 * sp_tapped_pi * c->frequency, s = phase(c, t);
    return omega * s < sp_tapped_pi ? c->amplitude * sin(omega * s) : 0;
}

double sp_tapped_floor_velocity(const sp_tapped_spec *c, double t) {
    double omega = 2 * sp_tapped_pi * c->frequency, s = phase(c, t);
    return omega * s < sp_tapped_pi ? c->amplitude * omega * cos(omega * s) : 0;
}

double sp_tapped_density(const sp_tapped_spec *c, const double *y) {
    return mass_of_all(c) / (y[c->particles] + sp_tapped_radius(c, c->particles) - y[0]);
}

/* ---- checks ----------------------------------------------------------------------------------------------------- */

static const double least_e = 1e-9;

typedef struct range {
    const char *key;
    size_t at;
    double low, high; /* inclusive */
    const char *should;
} range;

#define AT(member) offsetof(sp_tapped_spec, member)
static const range reals[] = {
    {"frequency", AT(frequency), 1e-6, 1e9, "1e-6 .. 1e9 Hz"},
    {"period", AT(period), 1e-9, 1e9, "1e-9 .. 1e9 s"},
    {"amplitude", AT(amplitude), 0, 1e6, "0 .. 1e6 cm"},
    {"e", AT(e), 0, 0x1.fffffffffffffp-1, "at least 0 and below 1"},
    {"stiffness", AT(stiffness), 0, 1e30, "0 (2 N m g/r) .. 1e30 g/s^2"},
    {"gravity", AT(gravity), 1e-9, 1e9, "1e-9 .. 1e9 cm/s^2"},
    {"drop", AT(drop), -1, 1e6, "0 .. 1e6 cm, or -1 to start at rest"},
    {"step", AT(step), 0, 1e9, "0 (period/100) .. 1e9 s"},
    {"alpha_v", AT(alpha_v), 1e-9, 1e9, "1e-9 .. 1e9 s/cm"},
    {"alpha_x", AT(alpha_x), 0, 1e12, "0 (the sharp step) .. 1e12 /cm"},
    {"time_step", AT(time_step), 0, 1e9, "0 (chosen) .. 1e9 s"},
    {"tolerance", AT(tolerance), 1e-14, 0.1, "1e-14 .. 0.1"},
    {"from", AT(from), 0, 1e9, "0 .. 1e9"},
    {"to", AT(to), 0, 1e9, "0 .. 1e9"},
};
static const range integers[] = {
    {"particles", AT(particles), 1, 1e6, "1 .. 1000000"},
    {"taps", AT(taps), 0, 1e8, "0 (chosen) .. 100000000"},
    {"cells", AT(cells), 1, 1000, "1 .. 1000"},
    {"points", AT(points), 1, 1e8, "1 .. 100000000"},
    {"transient", AT(transient), 0, 1e8, "0 .. 100000000"},
};

static sp_status check_list(const char *key, int32_t n, const double *list, sp_error *err) {
    char text[SP_NUMBER_TEXT];
    if (n < 1)
        return sp_fail(err, SP_EINVAL, "column.%s: must have one value or more", key);
    for (int32_t i = 0; i < n; i++)
        if (!(list[i] >= 1e-12 && list[i] <= 1e12))
            return sp_fail(err, SP_EINVAL, "column.%s = %s (value %d): must be in 1e-12 .. 1e12", key,
                           sp_number_text(list[i], text), i + 1);
    return SP_OK;
}

static sp_status check_ranges(const sp_tapped_spec *c, sp_error *err) {
    char text[SP_NUMBER_TEXT];
    for (size_t k = 0; k < sizeof reals / sizeof *reals; k++) {
        double value = *(const double *)(const void *)((const char *)c + reals[k].at);
        if (!(value >= reals[k].low && value <= reals[k].high))
            return sp_fail(err, SP_EINVAL, "column.%s = %s: must be %s", reals[k].key, sp_number_text(value, text),
                           reals[k].should);
    }
    for (size_t k = 0; k < sizeof integers / sizeof *integers; k++) {
        int32_t value = *(const int32_t *)(const void *)((const char *)c + integers[k].at);
        if (value < integers[k].low || value > integers[k].high)
            return sp_fail(err, SP_EINVAL, "column.%s = %d: must be %s", integers[k].key, value, integers[k].should);
    }
    sp_status status = check_list("mass", c->masses, c->mass, err);
    return status == SP_OK ? check_list("radius", c->radii, c->radius, err) : status;
}

sp_status sp_tapped_check(const sp_tapped_spec *c, sp_error *err) {
    char value[SP_NUMBER_TEXT], other[SP_NUMBER_TEXT], limit[SP_NUMBER_TEXT];
    sp_status status = check_ranges(c, err);
    if (status != SP_OK)
        return status;
    double tap = 0.5 / c->frequency, bound = sp_tapped_stiffness_bound(c), stiffness = sp_tapped_stiffness(c);
    if (c->e > 0 && c->e < least_e)
        return sp_fail(err, SP_EINVAL,
                       "column.e = %s: must be 0, or at least 1e-9: narrower friction bands are lost in rounding",
                       sp_number_text(c->e, value));
    if (c->drop < 0 && c->drop != -1)
        return sp_fail(err, SP_EINVAL, "column.drop = %s: must be 0 .. 1e6 cm, or -1 to start at rest",
                       sp_number_text(c->drop, value));
    if (c->amplitude > 0 && tap > c->period * (1 + 1e-12))
        return sp_fail(err, SP_EINVAL,
                       "column.period = %s s: must be at least the length of a tap, half a period of "
                       "column.frequency: 1/(2 * %s Hz) = %s s",
                       sp_number_text(c->period, value), sp_number_text(c->frequency, other),
                       sp_number_text(tap, limit));
    if (!(stiffness > bound * (1 + 1e-12))) /* equality within rounding is refused, too */
        return sp_fail(err, SP_EINVAL,
                       "column.stiffness = %s g/s^2: the column collapses under its own weight; must be above "
                       "%.10g g/s^2 (condition (28), for equal particles N m g/r)",
                       sp_number_text(stiffness, value), bound);
    return SP_OK;
}
