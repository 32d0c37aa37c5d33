/* Reads units, and converts between those of one dimension. */
#include "base/base.h"
#include "base/text.h"

#include <ctype.h>
#include <math.h>
#include <sonopack/units.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* ---- reading ---------------------------------------------------------------------------------------------------- */

/* A unit as powers of its symbols. All powers are twice what they are, because of square roots. */
typedef struct powers {
    int length, mass, time;         /* of m, kg and s */
    int ten;                        /* of ten: the prefixes */
    int modulus, density, diameter; /* of E*, rho and d */
    bool modes;                     /* counts modes: "modes d/sqrt(E* / rho)" */
} powers;

static const struct symbol {
    const char *name;
    bool prefixed; /* takes prefixes */
    powers unit;
} symbols[] = {
    {"E*", false, {.modulus = 2}},
    {"rho", false, {.density = 2}},
    {"d", false, {.diameter = 2}},
    {"modes", false, {.modes = true}},
    {"rad", true, {0}},
    {"m", true, {.length = 2}},
    {"g", true, {.mass = 2, .ten = -6}},
    {"s", true, {.time = 2}},
    {"N", true, {.length = 2, .mass = 2, .time = -4}},
    {"Pa", true, {.length = -2, .mass = 2, .time = -4}},
    {"bar", true, {.length = -2, .mass = 2, .time = -4, .ten = 10}},
};
enum { SYMBOLS = sizeof symbols / sizeof *symbols };

static const struct prefix {
    char letter;
    int ten;
} prefixes[] = {{'n', -18}, {'u', -12}, {'m', -6}, {'c', -4}, {'k', 6}, {'M', 12}, {'G', 18}};
enum { PREFIXES = sizeof prefixes / sizeof *prefixes };

enum { POWER_MOST = 8, DEPTH_MOST = 8 };

typedef struct unit_reader {
    const char *at;
    int depth;
} unit_reader;

static bool read_product(unit_reader *r, powers *out);

/* Multiplies *to with the power half/2 of a unit. False for half powers of square roots. */
static bool multiply(powers *to, const powers *by, int half) {
    const int from[] = {by->length, by->mass, by->time, by->ten, by->modulus, by->density, by->diameter};
    int *const into[] = {&to->length, &to->mass, &to->time, &to->ten, &to->modulus, &to->density, &to->diameter};
    for (size_t k = 0; k < sizeof from / sizeof *from; k++) {
        if (from[k] * half % 2 != 0)
            return false;
        *into[k] += from[k] * half / 2;
    }
    to->modes = to->modes || by->modes;
    return true;
}

static const struct symbol *find_symbol(const char *name, size_t length) {
    for (int k = 0; k < SYMBOLS; k++)
        if (strlen(symbols[k].name) == length && memcmp(symbols[k].name, name, length) == 0)
            return &symbols[k];
    return NULL;
}

static bool read_symbol(unit_reader *r, powers *out) {
    size_t length = 0;
    while (isalpha((unsigned char)r->at[length]) || r->at[length] == '*')
        length++;
    const struct symbol *s = find_symbol(r->at, length);
    int ten = 0;
    for (int k = 0; !s && length > 1 && k < PREFIXES; k++) {
        if (prefixes[k].letter != r->at[0])
            continue;
        s = find_symbol(r->at + 1, length - 1);
        s = s && s->prefixed ? s : NULL;
        ten = prefixes[k].ten;
    }
    if (!s)
        return false;
    r->at += length;
    *out = s->unit;
    out->ten += ten;
    return true;
}

/* A symbol, (...) or sqrt(...). */
static bool read_base(unit_reader *r, powers *out) {
    const bool root = strncmp(r->at, "sqrt(", 5) == 0;
    if (!root && *r->at != '(')
        return read_symbol(r, out);
    powers inside = {0};
    r->at += root ? 5 : 1;
    if (++r->depth > DEPTH_MOST || !read_product(r, &inside) || *r->at != ')')
        return false;
    r->at++;
    r->depth--;
    *out = (powers){0};
    return multiply(out, &inside, root ? 1 : 2);
}

/* A base with a power. */
static bool read_factor(unit_reader *r, powers *product, int sign) {
    powers base;
    long power = 1;
    if (!read_base(r, &base))
        return false;
    if (*r->at == '^') {
        char *end;
        power = strtol(r->at + 1, &end, 10);
        if (end == r->at + 1 || power == 0 || labs(power) > POWER_MOST)
            return false;
        r->at = end;
    }
    return multiply(product, &base, 2 * sign * (int)power);
}

static void skip_blanks(unit_reader *r) { r->at += strspn(r->at, " "); }

/* "a b / c": a divisor is one factor. A 1 may stand before the first division. */
static bool read_product(unit_reader *r, powers *out) {
    skip_blanks(r);
    if (r->at[0] == '1' && (r->at[1] == '/' || r->at[1] == ' '))
        r->at++;
    else if (!read_factor(r, out, 1))
        return false;
    for (;;) {
        skip_blanks(r);
        const bool divide = *r->at == '/';
        if (*r->at == '\0' || *r->at == ')')
            return true;
        if (divide) {
            r->at++;
            skip_blanks(r);
        }
        if (!read_factor(r, out, divide ? -1 : 1))
            return false;
    }
}

/* False if the text is no unit. */
static bool read_unit(const char *text, powers *out) {
    unit_reader r = {.at = text};
    *out = (powers){0};
    return read_product(&r, out) && *r.at == '\0';
}

/* ---- converting ------------------------------------------------------------------------------------------------- */

static bool needs_material(const powers *u) { return u->modulus != 0 || u->density != 0 || u->diameter != 0; }

bool sp_unit_is_ours(const char *unit) {
    powers u;
    return read_unit(unit, &u) && needs_material(&u);
}

/* E* is kg/(m s^2), rho kg/m^3, d m. */
static void dimension_of(const powers *u, int out[3]) {
    out[0] = u->length - u->modulus - 3 * u->density + u->diameter;
    out[1] = u->mass + u->modulus + u->density;
    out[2] = u->time - 2 * u->modulus;
}

static bool same_dimension(const powers *a, const powers *b) {
    int x[3], y[3];
    dimension_of(a, x);
    dimension_of(b, y);
    return memcmp(x, y, sizeof x) == 0;
}

/* A product of powers as a fraction, and as a fraction under one root: products, quotients and roots round the same on
 * every machine, and round values stay round. */
typedef struct fraction {
    double above, below, root_above, root_below;
} fraction;

/* Multiplies with x^(half/2). */
static void times_power(fraction *f, double x, int half) {
    for (int k = 0; k < abs(half) / 2; k++)
        *(half > 0 ? &f->above : &f->below) *= x;
    if (half % 2 != 0)
        *(half > 0 ? &f->root_above : &f->root_below) *= x;
}

/* A value in the unit a in the unit b, of the same dimension. */
static double convert(double value, const powers *a, const powers *b, const sp_material *m) {
    fraction f = {value, 1, 1, 1};
    if (needs_material(a) || needs_material(b)) {
        times_power(&f, sp_material_modulus(m), a->modulus - b->modulus);
        times_power(&f, m->density, a->density - b->density);
        times_power(&f, m->diameter, a->diameter - b->diameter);
    }
    times_power(&f, 10, a->ten - b->ten);
    return f.above / f.below * sqrt(f.root_above / f.root_below);
}

/* The units of tables in SI, one for each dimension that they have. */
static const char *const si_units[] = {"mm",          "us",
                                       "m/s",         "rad/s",
                                       "N",           "kPa",
                                       "mg",          "1/mm",
                                       "m/s^2",       "rad^2/s^2",
                                       "N/m",         "N us",
                                       "mg mm^2",     "mg/mm^2",
                                       "1/sqrt(mg)",  "1/(sqrt(mg) mm)",
                                       "mm sqrt(mg)", "N/(m sqrt(mg))",
                                       "N s/m",       "m^2/s",
                                       "mm/N",        "1/N",
                                       "N mm",        "mm^3",
                                       "mm^2"};

static const char *si_of(const powers *u) {
    powers si;
    for (size_t k = 0; k < sizeof si_units / sizeof *si_units; k++)
        if (read_unit(si_units[k], &si) && same_dimension(u, &si))
            return si_units[k];
    return NULL;
}

sp_status sp_unit_to_si(const char *unit, const sp_material *m, double *factor, char si[SP_UNIT_TEXT], sp_error *err) {
    powers ours, theirs;
    const char *name = read_unit(unit, &ours) && needs_material(&ours) ? si_of(&ours) : NULL;
    if (!name || !read_unit(name, &theirs))
        return sp_fail(err, SP_EINVAL, "unit %.60s: must be one of E*, rho and d", unit);
    sp_status status = sp_material_check(m, err);
    if (status != SP_OK)
        return status;
    *factor = convert(1, &ours, &theirs, m);
    snprintf(si, SP_UNIT_TEXT, "%s%s", ours.modes ? "modes " : "", name);
    return SP_OK;
}

/* ---- quantities ------------------------------------------------------------------------------------------------- */

/* What a number with this unit may look like. */
static const char *example_of(const powers *u) {
    static const struct {
        const char *unit, *text;
    } examples[] = {{"E*", "\"100 kPa\""},           {"d", "\"20 mm\""},         {"d/sqrt(E* / rho)", "\"50 us\""},
                    {"E* / (rho d)", "\"1 m/s^2\""}, {"rho d", "\"30 kg/m^2\""}, {"sqrt(E* / rho)/d", "\"1e5 rad/s\""}};
    powers unit;
    for (size_t k = 0; k < sizeof examples / sizeof *examples; k++)
        if (read_unit(examples[k].unit, &unit) && same_dimension(u, &unit))
            return examples[k].text;
    return "a number";
}

/* The unit that was meant, if only its capital letters are wrong. */
static const char *misspelt(const char *unit) {
    static const char *const usual[] = {"Pa", "kPa", "MPa", "GPa", "bar", "mm", "um", "us", "ms", "N", "rad/s"};
    for (size_t k = 0; k < sizeof usual / sizeof *usual; k++)
        if (strcasecmp(unit, usual[k]) == 0)
            return usual[k];
    return NULL;
}

sp_status sp_quantity_read(const char *text, const char *unit, const sp_material *m, double *out, sp_error *err) {
    const sp_material none = {1, 0, 1, 1}; /* cancels */
    powers ours, given;
    char number[64];
    double value;
    const size_t length = strspn(text, "0123456789+-.eE");
    const char *rest = text + length + strspn(text + length, " ");
    if (!read_unit(unit, &ours))
        return sp_fail(err, SP_EINVAL, "\"%.40s\": must be a number without quotes%s%s", text, *unit ? ", in " : "",
                       unit);
    const char *example = example_of(&ours);
    snprintf(number, sizeof number, "%.*s", (int)(length < 63 ? length : 63), text);
    if (length > 63 || !sp_word_number(number, &value) || !isfinite(value))
        return sp_fail(err, SP_EINVAL, "\"%.40s\": must be a number with a unit, as in %s", text, example);
    if (!read_unit(rest, &given)) {
        const char *meant = misspelt(rest);
        return sp_fail(err, SP_EINVAL, "\"%.40s\": unknown unit %.20s%s%s%s: must be as in %s", text,
                       *rest ? rest : "\"\"", meant ? " (did you mean " : "", meant ? meant : "", meant ? "?)" : "",
                       example);
    }
    if (!same_dimension(&given, &ours))
        return sp_fail(err, SP_EINVAL, "\"%.40s\": has the wrong dimension: must be as in %s", text, example);
    if (!m || !(m->young > 0)) {
        if (given.modulus != ours.modulus || given.density != ours.density || given.diameter != ours.diameter)
            return sp_fail(err, SP_EINVAL,
                           "\"%.40s\": a unit needs a material: material = { E = 70e9; nu = 0.22; rho = 2500; d = "
                           "1e-3; }; in the scene, or --material E=70e9,nu=0.22,rho=2500,d=1e-3",
                           text);
        m = &none;
    }
    value = convert(value, &given, &ours, m);
    if (!isfinite(value))
        return sp_fail(err, SP_EINVAL, "\"%.40s\": is too large: must be as in %s", text, example);
    *out = value;
    return SP_OK;
}
