/* The specification of a column: defaults, checks, and quantities that follow from it directly. */
#include "base/base.h"
#include "base/key.h"
#include "tapped/column.h"

#include <math.h>

static const double one = 1;

#define KEY(name, type, member, value, unit, low, high, zero, words, meaning)                                          \
    {"column." name, SP_KEY_##type, offsetof(sp_tapped_spec, member), 0, unit, low, high, zero},
#define LIST(name, member, value, count, values, unit, low, high, meaning)                                             \
    {"column." name, SP_KEY_REALS, offsetof(sp_tapped_spec, member), offsetof(sp_tapped_spec, count), unit, low,       \
     high,           false},

/* Every member of sp_tapped_spec that a scene may give, with its range. */
static const sp_key keys[] = {
#include "tapped/column_keys.inc"
    {NULL, SP_KEY_REAL, 0, 0, "", 0, 0, false}};
#undef KEY
#undef LIST

sp_tapped_spec sp_tapped_spec_default(void) {
#define KEY(name, type, member, value, ...)           .member = value,
#define LIST(name, member, value, count, values, ...) .member = value, .count = values,
    return (sp_tapped_spec){
#include "tapped/column_keys.inc"
    };
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
    double omega = 2 * M_PI * c->frequency, s = phase(c, t);
    return omega * s < M_PI ? c->amplitude * sin(omega * s) : 0;
}

double sp_tapped_floor_velocity(const sp_tapped_spec *c, double t) {
    double omega = 2 * M_PI * c->frequency, s = phase(c, t);
    return omega * s < M_PI ? c->amplitude * omega * cos(omega * s) : 0;
}

double sp_tapped_density(const sp_tapped_spec *c, const double *y) {
    return mass_of_all(c) / (y[c->particles] + sp_tapped_radius(c, c->particles) - y[0]);
}

/* ---- checks ----------------------------------------------------------------------------------------------------- */

static const double least_e = 1e-9;

static sp_status check_list(const char *key, int32_t n, sp_error *err) {
    return n < 1 ? sp_fail_key(err, SP_EINVAL, key, ": must have one value or more") : SP_OK;
}

static sp_status check_ranges(const sp_tapped_spec *c, sp_error *err) {
    sp_status status = sp_keys_check(keys, c, err);
    if (status == SP_OK)
        status = check_list("column.mass", c->masses, err);
    return status == SP_OK ? check_list("column.radius", c->radii, err) : status;
}

sp_status sp_tapped_check(const sp_tapped_spec *c, sp_error *err) {
    char value[SP_NUMBER_TEXT], other[SP_NUMBER_TEXT], limit[SP_NUMBER_TEXT];
    sp_status status = check_ranges(c, err);
    if (status != SP_OK)
        return status;
    double tap = 0.5 / c->frequency, bound = sp_tapped_stiffness_bound(c), stiffness = sp_tapped_stiffness(c);
    if (c->e == 1)
        return sp_fail_key(err, SP_EINVAL, "column.e", " = 1: must be at least 0 and below 1");
    if (c->e > 0 && c->e < least_e)
        return sp_fail_key(err, SP_EINVAL, "column.e",
                           " = %s: must be 0, or at least 1e-9: narrower friction bands are lost in rounding",
                           sp_number_text(c->e, value));
    if (c->drop < 0 && c->drop != -1)
        return sp_fail_key(err, SP_EINVAL, "column.drop", " = %s: must be 0 .. 1e6 cm, or -1 to start at rest",
                           sp_number_text(c->drop, value));
    if (c->amplitude > 0 && tap > c->period * (1 + 1e-12))
        return sp_fail_key(err, SP_EINVAL, "column.period",
                           " = %s s: must be at least the length of a tap, half a period of "
                           "column.frequency: 1/(2 * %s Hz) = %s s",
                           sp_number_text(c->period, value), sp_number_text(c->frequency, other),
                           sp_number_text(tap, limit));
    if (!(stiffness > bound * (1 + 1e-12))) /* equality within rounding is refused, too */
        return sp_fail_key(err, SP_EINVAL, "column.stiffness",
                           " = %s g/s^2: the column collapses under its own weight; must be above "
                           "%.10g g/s^2 (condition (28), for equal particles N m g/r)",
                           sp_number_text(stiffness, value), bound);
    return SP_OK;
}

sp_status sp_tapped_check_steps(const sp_tapped_spec *c, int64_t steps, int64_t most, double t, sp_error *err) {
    enum { INTERVAL = 256 }; /* steps between two calls of the user */
    if (steps % INTERVAL != 0)
        return SP_OK;
    if (c->stopped && c->stopped(c->user))
        return sp_fail(err, SP_EINTERRUPTED, "stopped at t = %.6g s: nothing is written", t);
    if (most > 0 && steps > most)
        return sp_fail(err, SP_EFAILED,
                       "t = %.6g s: more than %lld steps per tap; change column.time_step, column.stiffness or "
                       "column.amplitude to allow longer steps",
                       t, (long long)(most / sp_tapped_taps(c)));
    return SP_OK;
}
