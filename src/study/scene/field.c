/* The table of a scene's keys, and values going in and out of a scene through it. */
#include "scene/field.h"

#include "base/base.h"
#include "packing/keys.h"
#include "tapped/keys.h" /* of a library beside this one */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const sp_word pack_kinds[] = {{"piston", SP_PACK_PISTON},
                                     {"triangular", SP_PACK_TRIANGULAR},
                                     {"chain", SP_PACK_CHAIN},
                                     {"file", SP_PACK_FILE},
                                     {NULL, 0}};
static const sp_word laws[] = {{"uniform", SP_SIZES_UNIFORM},
                               {"bidisperse", SP_SIZES_BIDISPERSE},
                               {"lognormal", SP_SIZES_LOGNORMAL},
                               {"list", SP_SIZES_LIST},
                               {NULL, 0}};
static const sp_word compressions[] = {
    {"piston", SP_COMPRESSION_PISTON}, {"isotropic", SP_COMPRESSION_ISOTROPIC}, {NULL, 0}};
static const sp_word protocols[] = {
    {"default", SP_PROTOCOL_DEFAULT}, {"somfai2005", SP_PROTOCOL_SOMFAI2005}, {"quick", SP_PROTOCOL_QUICK}, {NULL, 0}};
static const sp_word methods[] = {
    {"auto", SP_SIGNAL_AUTO},     {"chebyshev", SP_SIGNAL_CHEBYSHEV},       {"dense", SP_SIGNAL_DENSE},
    {"verlet", SP_SIGNAL_VERLET}, {"lax-wendroff", SP_SIGNAL_LAX_WENDROFF}, {"faber", SP_SIGNAL_FABER},
    {"sparse", SP_SIGNAL_SPARSE}, {"dynamics", SP_SIGNAL_DYNAMICS},         {NULL, 0}};
static const sp_word sources[] = {{"impulse", SP_SOURCE_IMPULSE},
                                  {"velocity", SP_SOURCE_VELOCITY},
                                  {"displacement", SP_SOURCE_DISPLACEMENT},
                                  {NULL, 0}};
static const sp_word wants[] = {{"packings", 0},
                                {"ctof", SP_WANT_CTOF},
                                {"statics", SP_WANT_STATICS},
                                {"moduli", SP_WANT_MODULI},
                                {"signal", SP_WANT_SIGNAL},
                                {"probes", SP_WANT_PROBES},
                                {"planes", SP_WANT_PLANES},
                                {"scaling", SP_WANT_SCALING},
                                {"spectrum", SP_WANT_SPECTRUM},
                                {NULL, 0}};
static const sp_word column_models[] = {{"lattice", SP_TAPPED_LATTICE}, {"longwave", SP_TAPPED_LONGWAVE},
                                        {"bsr", SP_TAPPED_BSR},         {"eq35", SP_TAPPED_EQ35},
                                        {"eq37", SP_TAPPED_EQ37},       {NULL, 0}};
static const sp_word column_methods[] = {
    {"event", SP_TAPPED_EVENT}, {"smooth", SP_TAPPED_SMOOTH}, {"rk4", SP_TAPPED_RK4}, {NULL, 0}};
static const sp_word column_bsrs[] = {{"conservative", SP_TAPPED_BSR_CONSERVATIVE},
                                      {"literal", SP_TAPPED_BSR_LITERAL},
                                      {"signed", SP_TAPPED_BSR_SIGNED},
                                      {NULL, 0}};
static const sp_word column_outputs[] = {{"trajectory", SP_TAPPED_TRAJECTORY}, {"strobe", SP_TAPPED_STROBE},
                                         {"lyapunov", SP_TAPPED_LYAPUNOV},     {"bifurcation", SP_TAPPED_BIFURCATION},
                                         {"energy", SP_TAPPED_ENERGY},         {"density", SP_TAPPED_DENSITY},
                                         {"compare", SP_TAPPED_COMPARE},       {NULL, 0}};
static const sp_word column_parameters[] = {{"amplitude", SP_TAPPED_BY_AMPLITUDE},
                                            {"period", SP_TAPPED_BY_PERIOD},
                                            {"frequency", SP_TAPPED_BY_FREQUENCY},
                                            {"e", SP_TAPPED_BY_RESTITUTION},
                                            {NULL, 0}};

_Static_assert(sizeof(sp_pack_kind) == sizeof(unsigned) && sizeof(sp_signal_method) == sizeof(unsigned) &&
                   sizeof(sp_source) == sizeof(unsigned) && sizeof(sp_sizes) == sizeof(unsigned) &&
                   sizeof(sp_compression) == sizeof(unsigned) && sizeof(sp_protocol) == sizeof(unsigned) &&
                   sizeof(sp_tapped_model) == sizeof(unsigned) && sizeof(sp_tapped_method) == sizeof(unsigned) &&
                   sizeof(sp_tapped_bsr) == sizeof(unsigned) && sizeof(sp_tapped_output) == sizeof(unsigned) &&
                   sizeof(sp_tapped_parameter) == sizeof(unsigned) && sizeof(int) == sizeof(int32_t),
               "words are stored as unsigned, integers as 32 bits");

#define AT(member) offsetof(sp_scene, member)

/* Ranges of keys that are in no spec, or in a spec without a table of its keys. */
static const sp_key scene_keys[] = {
    {"packing.height", SP_KEY_REAL, AT(height), 0, "d", 0, 1e6, false},
    {"network.threshold", SP_KEY_REAL, AT(network.threshold), 0, "p d^2", 0, 1, false},
    {"signal.until", SP_KEY_REAL, AT(signal.until), 0, "d/sqrt(E* / rho)", 0, 1e9, false},
    {"signal.points", SP_KEY_INT, AT(signal.points), 0, "", 2, 1e7, false},
    {"signal.tolerance", SP_KEY_REAL, AT(signal.tolerance), 0, "max |F|", 1e-15, 0.1, false},
    {"signal.planes", SP_KEY_REALS, AT(plane), AT(planes), "d", 0.01, 1e6, false},
    {"study.samples", SP_KEY_INT, AT(samples), 0, "", 1, 1e7, false},
    {NULL, SP_KEY_REAL, 0, 0, "", 0, 0, false}};

const sp_field sp_fields[] = {
    {"packing.kind", SP_FIELD_WORD, AT(pack.kind), pack_kinds,
     "random grains compressed by a piston, a triangular lattice, a one-dimensional chain, or a packing from a file"},
    {"packing.file", SP_FIELD_PATH, AT(from), NULL,
     "packing to start from, with kind = \"file\"; the path is relative to the scene, in --set to the current folder"},
    {"packing.content", SP_FIELD_INT64, AT(pack.content), NULL,
     "hash of the packing in packing.file, which must have it; 0: any packing"},
    {"packing.dimension", SP_FIELD_INT, AT(pack.dim), NULL,
     "of space: 1 for a chain, 2 for a lattice, 2 or 3 under a piston"},
    {"packing.grains", SP_FIELD_INT, AT(pack.grains), NULL, "number of grains"},
    {"packing.width", SP_FIELD_REAL, AT(pack.width), NULL,
     "horizontal period; under a piston at least four of the largest diameters, in a lattice a whole number of grains"},
    {"packing.depth", SP_FIELD_REAL, AT(pack.depth), NULL,
     "second horizontal period, in dimension 3; 0: equal to the width"},
    {"packing.height", SP_FIELD_REAL, AT(height), NULL,
     "approximate height of the box under a piston, which decides packing.grains; 0: packing.grains is given"},
    {"packing.pressure", SP_FIELD_REAL, AT(pack.pressure), NULL, "confining pressure"},
    {"packing.history", SP_FIELD_REALS, AT(pack.history), NULL,
     "pressures before packing.pressure; the packing comes to equilibrium at each of them in turn"},
    {"packing.friction", SP_FIELD_REAL, AT(pack.friction), NULL,
     "Coulomb's coefficient; 0: no tangential forces and no rotations"},
    {"packing.poisson", SP_FIELD_REAL, AT(pack.poisson), NULL, "Poisson's ratio of the grain material"},
    {"packing.sizes", SP_FIELD_WORD, AT(pack.sizes), laws,
     "distribution of diameters: uniform between the limits, one of the two limits, lognormal with mean 1, or a list"},
    {"packing.diameter_min", SP_FIELD_REAL, AT(pack.diameter_min), NULL,
     "smallest diameter; both 0: set by the distribution, such as 0.8 .. 1.2 under a piston and 1 in lattice and "
     "chain"},
    {"packing.diameter_max", SP_FIELD_REAL, AT(pack.diameter_max), NULL,
     "largest diameter, at most 100 times the smallest"},
    {"packing.large_fraction", SP_FIELD_REAL, AT(pack.large_fraction), NULL,
     "of bidisperse grains: fraction of the grains that are large"},
    {"packing.size_spread", SP_FIELD_REAL, AT(pack.size_spread), NULL,
     "of lognormal grains: standard deviation of ln d"},
    {"packing.diameters", SP_FIELD_REALS, AT(pack.diameters), NULL,
     "diameters of the grains in their order, for packing.sizes = \"list\""},
    {"packing.diameter_file", SP_FIELD_FILE, 0, NULL,
     "text file of diameters, one a line; the path is relative to the scene, in --set to the current folder"},
    {"packing.compression", SP_FIELD_WORD, AT(pack.compression), compressions,
     "what moves under the pressure: the piston alone, or the sides as well"},
    {"packing.protocol", SP_FIELD_WORD, AT(pack.protocol), protocols,
     "sets damping, piston mass, gas, time step and the approach to rest, where these are not given"},
    {"packing.reference", SP_FIELD_BOOL, AT(pack.reference), NULL, "plain, slow algorithm, for comparison"},
    {"packing.seed", SP_FIELD_INT64, AT(pack.seed), NULL, "seed of the random numbers"},
    {"packing.tolerance", SP_FIELD_REAL, AT(pack.tolerance), NULL,
     "largest elastic acceleration at rest; 0: the smaller of 1e-10 and 1e-6 p"},
    {"packing.damping", SP_FIELD_REAL, AT(pack.damping), NULL,
     "viscous damping of contacts while the packing forms; 0: set by the protocol (0.8; quick: 0.5)"},
    {"packing.piston_mass", SP_FIELD_REAL, AT(pack.piston_mass), NULL,
     "mass of the piston per area of the wall; 0: set by the protocol (12.5; quick: 2)"},
    {"packing.gas_fraction", SP_FIELD_REAL, AT(pack.gas_fraction), NULL,
     "area or volume fraction of the initial gas of grains, at most 0.3 in dimension 3; 0: set by the protocol (0.3, "
     "3D 0.2; quick: 0.45, 3D 0.25)"},
    {"packing.time_step", SP_FIELD_REAL, AT(pack.time_step), NULL,
     "time step while the packing forms; up to 1.4 times as large while it comes to rest; 0: set by the protocol (0.7; "
     "quick: 0.5)"},
    {"packing.calm", SP_FIELD_REAL, AT(pack.calm), NULL,
     "global damping begins when every acceleration is below this; 0: never; below 0: set by the protocol (0.01; "
     "quick: 3)"},
    {"packing.drag", SP_FIELD_REAL, AT(pack.drag), NULL,
     "rate of the global damping at p = 1e-4; it scales as p^(1/3), and inversely with the height above 30 d; below 0: "
     "set by the protocol (0.01)"},
    {"packing.calm_damping", SP_FIELD_REAL, AT(pack.calm_damping), NULL,
     "viscous damping of contacts after the global damping has begun; 0: set by the protocol (0.2; somfai2005: 0.8)"},
    {"packing.viscous_limit", SP_FIELD_REAL, AT(pack.viscous_limit), NULL,
     "Coulomb's limit of the whole tangential force, over the limit of its elastic part, until the global damping "
     "begins; 0: set by the protocol (1e6; quick: 1)"},
    {"packing.max_steps", SP_FIELD_INT64, AT(pack.max_steps), NULL,
     "give up after this number of steps; 0: a limit that depends on pressure and height"},

    {"network.threshold", SP_FIELD_REAL, AT(network.threshold), NULL,
     "contacts with a larger normal force carry force"},
    {"network.prestress", SP_FIELD_BOOL, AT(network.prestress), NULL, "include the forces at rest in the stiffness"},
    {"network.sliding_free", SP_FIELD_BOOL, AT(network.sliding_free), NULL,
     "no tangential stiffness at contacts on the Coulomb limit"},

    {"signal.method", SP_FIELD_WORD, AT(signal.method), methods, "how the force on the top wall is computed"},
    {"signal.source", SP_FIELD_WORD, AT(signal.source), sources,
     "what is given to the bottom grains: momentum, velocity or displacement, in proportion to their stiffness to the "
     "wall"},
    {"signal.until", SP_FIELD_REAL, AT(signal.until), NULL, "last time; 0: after the first front has passed"},
    {"signal.points", SP_FIELD_INT, AT(signal.points), NULL, "number of equally spaced times, from 0"},
    {"signal.tolerance", SP_FIELD_REAL, AT(signal.tolerance), NULL, "error of the signal"},
    {"signal.planes", SP_FIELD_REALS, AT(plane), NULL,
     "heights above the bottom wall at which planes of study.want records fronts, ascending, at most 32"},

    {"study.samples", SP_FIELD_INT, AT(samples), NULL,
     "number of seeds of each combination: packing.seed and those that follow"},
    {"study.want", SP_FIELD_LIST, AT(want), wants,
     "results to compute; packings: only the packings; signal: stored signals, for `sonopack table signal' (study "
     "prints no table of these two); spectrum: every frequency, for the density of states"},
    {"study.sweep", SP_FIELD_SWEEP, AT(sweep), NULL,
     "keys to sweep, in every combination: ( { key = \"packing.pressure\"; values = [1e-7, 1e-4]; }, ... ); keys with "
     "a list or a range in place of a value are swept as well"},

    {"column.particles", SP_FIELD_INT, AT(tapped.particles), NULL,
     "number of particles, one above the other on a floor that is tapped (cm, g, s)"},
    {"column.frequency", SP_FIELD_REAL, AT(tapped.frequency), NULL,
     "of the tap: at the start of each period the floor moves up and back, as half a sine of this frequency"},
    {"column.period", SP_FIELD_REAL, AT(tapped.period), NULL,
     "from the start of one tap to the next; at least the length of a tap, 1/(2 frequency)"},
    {"column.taps", SP_FIELD_INT, AT(tapped.taps), NULL,
     "number of taps; in a diagram, of those after column.transient; 0: 4, for lyapunov 1000, for bifurcation 50"},
    {"column.amplitude", SP_FIELD_REAL, AT(tapped.amplitude), NULL, "height of the half sine; 0: the floor is at rest"},
    {"column.e", SP_FIELD_REAL, AT(tapped.e), NULL,
     "of the law of Walton and Braun, below 1: the stiffness is K(1 + e) while a contact closes and K(1 - e) while it "
     "opens"},
    {"column.stiffness", SP_FIELD_REAL, AT(tapped.stiffness), NULL,
     "K of the contacts, above N m g/r, where the column collapses; 0: 2 N m g/r, with the mean mass m and the "
     "smallest radius r"},
    {"column.gravity", SP_FIELD_REAL, AT(tapped.gravity), NULL, "acceleration of gravity"},
    {"column.drop", SP_FIELD_REAL, AT(tapped.drop), NULL,
     "height from which the column, its particles just touching, falls onto the floor; -1: it starts at rest"},
    {"column.mass", SP_FIELD_REALS, AT(tapped.mass), NULL,
     "masses of the particles: one number, or several, which repeat from the floor upwards"},
    {"column.radius", SP_FIELD_REALS, AT(tapped.radius), NULL,
     "radii of the particles: one number, or several, which repeat from the floor upwards"},
    {"column.model", SP_FIELD_WORD, AT(tapped.model), column_models,
     "lattice: the particles; longwave, bsr: continuum models; eq35, eq37: long-wave equations as printed, refused "
     "with the reason"},
    {"column.method", SP_FIELD_WORD, AT(tapped.method), column_methods,
     "of the lattice; event: exact; smooth: tanh in place of the sign; rk4: fixed steps, of first order, creeps at "
     "rest"},
    {"column.bsr", SP_FIELD_WORD, AT(tapped.bsr), column_bsrs,
     "form of bsr: conservative, which supports a column; as printed; or as printed with corrected signs (both "
     "collapse)"},
    {"column.output", SP_FIELD_WORD, AT(tapped.output), column_outputs, "table to make: see `sonopack help column'"},
    {"column.step", SP_FIELD_REAL, AT(tapped.step), NULL,
     "time between rows of trajectory, density and compare; 0: period/100"},
    {"column.alpha_v", SP_FIELD_REAL, AT(tapped.alpha_v), NULL,
     "slope of tanh in place of the sign of velocities, of longwave, bsr and method smooth"},
    {"column.alpha_x", SP_FIELD_REAL, AT(tapped.alpha_x), NULL,
     "slope of tanh in place of the step at touching, of method smooth; 0: the step itself"},
    {"column.time_step", SP_FIELD_REAL, AT(tapped.time_step), NULL,
     "of longwave, bsr and rk4, at most the largest stable one; 0: chosen automatically"},
    {"column.tolerance", SP_FIELD_REAL, AT(tapped.tolerance), NULL, "relative error of a step of method smooth"},
    {"column.cells", SP_FIELD_INT, AT(tapped.cells), NULL, "grid cells of longwave and bsr for each particle"},
    {"column.parameter", SP_FIELD_WORD, AT(tapped.parameter), column_parameters,
     "what the diagrams lyapunov and bifurcation vary, from column.from to column.to"},
    {"column.from", SP_FIELD_REAL, AT(tapped.from), NULL,
     "first value of the parameter; 0 with one point: the value in the scene"},
    {"column.to", SP_FIELD_REAL, AT(tapped.to), NULL, "last value of the parameter"},
    {"column.points", SP_FIELD_INT, AT(tapped.points), NULL, "number of equally spaced values of the parameter"},
    {"column.transient", SP_FIELD_INT, AT(tapped.transient), NULL,
     "taps before those that count, at each point of a diagram"},
};

_Static_assert(sizeof sp_fields / sizeof *sp_fields == SP_FIELDS, "the table is complete");

const char *const sp_groups[SP_GROUPS] = {"packing", "network", "signal", "study", "column"};

int sp_field_index(const sp_field *f) { return (int)(f - sp_fields); }

const char *sp_field_name(const sp_field *f) { return strchr(f->key, '.') + 1; }

bool sp_field_in_group(const sp_field *f, const char *group) {
    const size_t length = strlen(group);
    return strncmp(f->key, group, length) == 0 && f->key[length] == '.';
}

const sp_field *sp_field_find(const char *key) {
    for (int k = 0; k < SP_FIELDS; k++)
        if (strcmp(key, sp_fields[k].key) == 0)
            return &sp_fields[k];
    return NULL;
}

/* The specs within a scene, and the tables of their keys. */
static const struct {
    size_t offset, size;
    const sp_key *keys;
} specs[] = {{AT(pack), sizeof(sp_pack_spec), sp_pack_keys},
             {AT(tapped), sizeof(sp_tapped_spec), sp_tapped_keys},
             {0, sizeof(sp_scene), scene_keys}};

const sp_key *sp_field_limits(const sp_field *f) {
    if (!sp_field_is_number(f) && f->type != SP_FIELD_REALS)
        return NULL;
    int k = 0;
    while (f->offset < specs[k].offset || f->offset - specs[k].offset >= specs[k].size)
        k++;
    const sp_key *key = specs[k].keys;
    while (key->name && key->offset != f->offset - specs[k].offset)
        key++;
    return key->name ? key : NULL;
}

const sp_field *sp_field_nearest(const char *group, const char *name) {
    const sp_field *nearest = NULL;
    int least = 1000;
    for (int k = 0; k < SP_FIELDS; k++) {
        const sp_field *f = &sp_fields[k];
        /* a right name in the wrong group is nearer than any wrong name in the right group */
        const int names = sp_edit_distance(name, sp_field_name(f));
        const int distance = 2 * names + !sp_field_in_group(f, group);
        if (distance < least && sp_is_near(name, names)) {
            least = distance;
            nearest = f;
        }
    }
    return nearest;
}

bool sp_field_is_number(const sp_field *f) {
    return f->type == SP_FIELD_REAL || f->type == SP_FIELD_INT || f->type == SP_FIELD_INT64;
}

bool sp_field_is_planes(const sp_field *f) { return f->offset == AT(plane); }

bool sp_field_is_tapped(const sp_field *f) { return sp_field_in_group(f, "column"); }

int sp_field_list_max(const sp_field *f) {
    return sp_field_is_planes(f) ? SP_PLANES_MAX : f->offset == AT(pack.history) ? SP_HISTORY_MAX : SP_DIAMETERS_MAX;
}

/* Where the scene counts the values of a list. */
static size_t count_offset(const sp_field *f) {
    const sp_key *key = sp_field_limits(f);
    return f->offset - key->offset + key->count;
}

const double *sp_field_list(const sp_scene *s, const sp_field *f, int32_t *count) {
    const double *values;
    memcpy(count, (const char *)s + count_offset(f), sizeof *count);
    memcpy(&values, (const char *)s + f->offset, sizeof values);
    return sp_field_is_planes(f) ? s->plane : values;
}

void sp_field_set_list(sp_scene *s, const sp_field *f, const double *values, int32_t count) {
    memcpy((char *)s + count_offset(f), &count, sizeof count);
    memcpy((char *)s + f->offset, &values, sizeof values);
}

bool sp_field_is_scalar(const sp_field *f) {
    return sp_field_is_number(f) || f->type == SP_FIELD_BOOL || f->type == SP_FIELD_WORD;
}

const char *sp_field_not_swept(const sp_field *f) {
    if (sp_field_is_tapped(f))
        return "its diagrams vary column.parameter, from column.from to column.to";
    if (f->type == SP_FIELD_PATH)
        return "all samples of a study start from the same packing";
    if (f->type == SP_FIELD_FILE)
        return "sweep packing.diameters instead";
    if (f->offset == AT(pack.content) && f->type == SP_FIELD_INT64)
        return "it follows from packing.file";
    if (sp_field_in_group(f, "packing") || sp_field_in_group(f, "network") || f->offset == AT(signal.source))
        return NULL;
    return "it does not change the sample, which is stored with one value of it";
}

static void words_text(const sp_word *words, char *buf, size_t size) {
    size_t used = 0;
    for (int k = 0; words[k].word && used < size; k++) {
        const char *comma = k == 0 ? "" : words[k + 1].word ? ", " : " or ";
        used += (size_t)snprintf(buf + used, size - used, "%s%s", comma, words[k].word);
    }
}

const char *sp_field_right(const sp_field *f, char *buf, size_t size) {
    char text[200];
    switch (f->type) {
    case SP_FIELD_REAL:
    case SP_FIELD_INT:
    case SP_FIELD_INT64: return sp_key_range(sp_field_limits(f), buf, size);
    case SP_FIELD_BOOL: snprintf(buf, size, "true or false"); break;
    case SP_FIELD_WORD: words_text(f->words, buf, size); break;
    case SP_FIELD_LIST:
        words_text(f->words, text, sizeof text);
        snprintf(buf, size, "a list [\"...\", ...] of %s", text);
        break;
    case SP_FIELD_SWEEP:
        snprintf(buf, size, "a list ( { key = \"packing.pressure\"; values = [1e-7, 1e-4]; }, ... )");
        break;
    case SP_FIELD_REALS:
        snprintf(buf, size, "%sa list [%s, ...] of numbers %s", sp_field_is_tapped(f) ? "one number or " : "",
                 f->offset == AT(pack.history) ? "1e-3, 1e-5"
                 : sp_field_is_planes(f)       ? "12.5, 25"
                                               : "0.9, 1.1",
                 sp_key_range(sp_field_limits(f), text, sizeof text));
        break;
    case SP_FIELD_PATH:
    case SP_FIELD_FILE: snprintf(buf, size, "the name of a file in quotes"); break;
    }
    return buf;
}

/* The value of a number as an integer; false for fractions and for numbers of more than 64 bits. */
static bool to_integer(const sp_number *number, int64_t *out) {
    if (number->integral) {
        *out = number->integer;
        return true;
    }
    if (!(fabs(number->real) < 0x1p63) || number->real != floor(number->real))
        return false;
    *out = (int64_t)number->real;
    return true;
}

sp_status sp_field_check(const sp_field *f, const sp_number *number, sp_error *err) {
    char value[32], right[200];
    int64_t integer = 0;
    bool good = sp_key_allows(sp_field_limits(f), number->real);
    if (f->type != SP_FIELD_REAL && f->type != SP_FIELD_REALS)
        good = good && to_integer(number, &integer);
    if (good)
        return SP_OK;
    if (number->integral)
        snprintf(value, sizeof value, "%lld", (long long)number->integer);
    else
        sp_number_text(number->real, value);
    return sp_fail_key(err, SP_EINVAL, f->key, " = %s: must be %s", value, sp_field_right(f, right, sizeof right));
}

sp_status sp_field_store(sp_scene *s, const sp_field *f, const sp_number *number, sp_error *err) {
    sp_status status = sp_field_check(f, number, err);
    if (status != SP_OK)
        return status;
    char *place = (char *)s + f->offset;
    if (f->type == SP_FIELD_REAL) {
        const double real = number->real + 0.0; /* a negative zero would be written as the integer 0 */
        memcpy(place, &real, sizeof real);
        return SP_OK;
    }
    int64_t wide = 0;
    to_integer(number, &wide);
    const int32_t narrow = (int32_t)wide;
    if (f->type == SP_FIELD_INT)
        memcpy(place, &narrow, sizeof narrow);
    else
        memcpy(place, &wide, sizeof wide);
    return SP_OK;
}

sp_number sp_field_load(const sp_scene *s, const sp_field *f) {
    const char *place = (const char *)s + f->offset;
    sp_number number = {.integral = f->type != SP_FIELD_REAL};
    int32_t narrow;
    if (f->type == SP_FIELD_REAL) {
        memcpy(&number.real, place, sizeof number.real);
        return number;
    }
    if (f->type == SP_FIELD_INT) {
        memcpy(&narrow, place, sizeof narrow);
        number.integer = narrow;
    } else {
        memcpy(&number.integer, place, sizeof number.integer);
    }
    number.real = (double)number.integer;
    return number;
}
