/* The table of a scene's keys, and values going in and out of a scene through it. */
#include "scene/field.h"

#include "base/base.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const sp_word pack_kinds[] = {{"piston", SP_PACK_PISTON},   {"triangular", SP_PACK_TRIANGULAR},
                                     {"chain", SP_PACK_CHAIN},     {"file", SP_PACK_FILE},
                                     {"minimum", SP_PACK_MINIMUM}, {NULL, 0}};
static const sp_word pack_cells[] = {
    {"piston", SP_CELL_PISTON}, {"periodic", SP_CELL_PERIODIC}, {"box", SP_CELL_BOX}, {NULL, 0}};
static const sp_word laws[] = {{"uniform", SP_SIZES_UNIFORM},     {"bidisperse", SP_SIZES_BIDISPERSE},
                               {"lognormal", SP_SIZES_LOGNORMAL}, {"list", SP_SIZES_LIST},
                               {"types", SP_SIZES_TYPES},         {NULL, 0}};
static const sp_word shapes[] = {{"sphere", SP_SHAPE_SPHERE}, {"disk", SP_SHAPE_DISK}, {NULL, 0}};
static const sp_word compressions[] = {
    {"piston", SP_COMPRESSION_PISTON}, {"isotropic", SP_COMPRESSION_ISOTROPIC}, {NULL, 0}};
static const sp_word tangentials[] = {
    {"constant", SP_TANGENTIAL_CONSTANT}, {"history", SP_TANGENTIAL_HISTORY}, {NULL, 0}};
static const sp_word laterals[] = {{"fixed", SP_LATERAL_FIXED}, {"stress", SP_LATERAL_STRESS}, {NULL, 0}};
static const sp_word springs[] = {
    {"constant", SP_SPRINGS_CONSTANT}, {"loading", SP_SPRINGS_LOADING}, {"lowest", SP_SPRINGS_LOWEST}, {NULL, 0}};
static const sp_word protocols[] = {{"default", SP_PROTOCOL_DEFAULT},
                                    {"somfai2005", SP_PROTOCOL_SOMFAI2005},
                                    {"quick", SP_PROTOCOL_QUICK},
                                    {"affine", SP_PROTOCOL_AFFINE},
                                    {NULL, 0}};
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

#define LIMITS(name, type, member, count, unit, low, high, zero)                                                       \
    { name, SP_KEY_##type, AT(member), count, unit, low, high, zero }

const sp_field sp_fields[] = {
#define KEY(name, type, member, value, unit, low, high, zero, words, meaning)                                          \
    {"packing." name,                                                                                                  \
     SP_FIELD_##type,                                                                                                  \
     AT(pack.member),                                                                                                  \
     words,                                                                                                            \
     LIMITS("packing." name, type, pack.member, 0, unit, low, high, zero),                                             \
     meaning},
#define LIST(name, member, value, count, values, unit, low, high, meaning)                                             \
    {"packing." name,                                                                                                  \
     SP_FIELD_REALS,                                                                                                   \
     AT(pack.member),                                                                                                  \
     NULL,                                                                                                             \
     LIMITS("packing." name, REALS, pack.member, AT(pack.count), unit, low, high, false),                              \
     meaning},
#define SCENE_KEY(name, type, member, unit, low, high, zero, words, meaning)                                           \
    {"packing." name,                                                                                                  \
     SP_FIELD_##type,                                                                                                  \
     AT(member),                                                                                                       \
     words,                                                                                                            \
     LIMITS("packing." name, REAL, member, 0, unit, low, high, zero),                                                  \
     meaning},
#include "packing/keys.inc"
#undef KEY
#undef LIST

#define ROW(key, type, member, unit, low, high, zero, words, meaning)                                                  \
    { key, SP_FIELD_##type, AT(member), words, LIMITS(key, type, member, 0, unit, low, high, zero), meaning }
#define CHOICE(key, type, member, words, meaning)                                                                      \
    { key, SP_FIELD_##type, AT(member), words, {0}, meaning }
    ROW("material.E", REAL, material.young, "Pa", 1, 1e15, true, NULL,
        "Young's modulus of the grains; the material turns numbers into SI units, and changes no packing; 0: not "
        "known"),
    ROW("material.nu", REAL, material.poisson, "", 0, 0.5, false, NULL,
        "Poisson's ratio of the grains, which packing.poisson has too where it is not given"),
    ROW("material.rho", REAL, material.density, "kg/m^3", 1e-3, 1e6, true, NULL, "density of the grains"),
    ROW("material.d", REAL, material.diameter, "m", 1e-10, 1e3, true, NULL, "mean diameter of the grains"),
    ROW("network.threshold", REAL, network.threshold, "p d^2", 0, 1, false, NULL,
        "contacts with a larger normal force carry force"),
    CHOICE("network.prestress", BOOL, network.prestress, NULL, "include the forces at rest in the stiffness"),
    CHOICE("network.sliding_free", BOOL, network.sliding_free, NULL,
           "no tangential stiffness at contacts on the Coulomb limit"),
    CHOICE(
        "network.tangential", WORD, network.tangential, springs,
        "tangential stiffness: of full stick; as Mindlin's law has it for further first loading; or the lowest after "
        "any history"),
    CHOICE("signal.method", WORD, signal.method, methods, "how the force on the top wall is computed"),
    CHOICE(
        "signal.source", WORD, signal.source, sources,
        "what is given to the bottom grains: momentum, velocity or displacement, in proportion to their stiffness to "
        "the wall"),
    ROW("signal.until", REAL, signal.until, "d/sqrt(E* / rho)", 0, 1e9, false, NULL,
        "last time; 0: after the first front has passed"),
    ROW("signal.points", INT, signal.points, "", 2, 1e7, false, NULL, "number of equally spaced times, from 0"),
    ROW("signal.tolerance", REAL, signal.tolerance, "max |F|", 1e-15, 0.1, false, NULL, "error of the signal"),
    {"signal.planes", SP_FIELD_REALS, AT(plane), NULL,
     LIMITS("signal.planes", REALS, plane, AT(planes), "d", 0.01, 1e6, false),
     "heights above the bottom wall at which planes of study.want records fronts, ascending, at most 32"},
    ROW("study.samples", INT, samples, "", 1, 1e7, false, NULL,
        "number of seeds of each combination: packing.seed and those that follow"),
    CHOICE(
        "study.want", LIST, want, wants,
        "results to compute; packings: only the packings; signal: stored signals, for `sonopack table signal' (study "
        "prints no table of these two); spectrum: every frequency, for the density of states"),
    CHOICE("study.sweep", SWEEP, sweep, NULL,
           "keys to sweep, in every combination: ( { key = \"packing.pressure\"; values = [1e-7, 1e-4]; }, ... ); keys "
           "with a list or a range in place of a value are swept as well"),

#define KEY(name, type, member, value, unit, low, high, zero, words, meaning)                                          \
    {"column." name,                                                                                                   \
     SP_FIELD_##type,                                                                                                  \
     AT(tapped.member),                                                                                                \
     words,                                                                                                            \
     LIMITS("column." name, type, tapped.member, 0, unit, low, high, zero),                                            \
     meaning},
#define LIST(name, member, value, count, values, unit, low, high, meaning)                                             \
    {"column." name,                                                                                                   \
     SP_FIELD_REALS,                                                                                                   \
     AT(tapped.member),                                                                                                \
     NULL,                                                                                                             \
     LIMITS("column." name, REALS, tapped.member, AT(tapped.count), unit, low, high, false),                           \
     meaning},
#include "tapped/column_keys.inc"
#undef KEY
#undef LIST
};

_Static_assert(sizeof sp_fields / sizeof *sp_fields == SP_FIELDS, "the table is complete");

const char *const sp_groups[SP_GROUPS] = {"packing", "material", "network", "signal", "study", "column"};

int sp_field_index(const sp_field *f) { return (int)(f - sp_fields); }

const char *sp_field_name(const sp_field *f) { return strchr(f->key, '.') + 1; }

bool sp_field_in_group(const sp_field *f, const char *group) {
    const size_t length = strlen(group);
    return strncmp(f->key, group, length) == 0 && f->key[length] == '.';
}

const sp_field *sp_field_first(const char *group) {
    for (int k = 0; k < SP_FIELDS; k++)
        if (sp_field_in_group(&sp_fields[k], group))
            return &sp_fields[k];
    return NULL;
}

const sp_field *sp_field_find(const char *key) {
    for (int k = 0; k < SP_FIELDS; k++)
        if (strcmp(key, sp_fields[k].key) == 0)
            return &sp_fields[k];
    return NULL;
}

const sp_key *sp_field_limits(const sp_field *f) {
    return sp_field_is_number(f) || f->type == SP_FIELD_REALS ? &f->limits : NULL;
}

const sp_field *sp_field_nearest(const char *group, const char *name) {
    const sp_field *nearest = NULL;
    int least = 1000;
    char inner[128];
    snprintf(inner, sizeof inner, "%s.%s", group, name);
    nearest = sp_field_first(strchr(group, '.') ? group : inner);
    if (nearest) /* a group in a group has one key, which it is then */
        return nearest;
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

bool sp_field_is_material(const sp_field *f) { return sp_field_in_group(f, "material"); }

bool sp_field_is_planes(const sp_field *f) { return f->offset == AT(plane); }

bool sp_field_is_tapped(const sp_field *f) { return sp_field_in_group(f, "column"); }

int sp_field_list_max(const sp_field *f) {
    if ((f->offset == AT(pack.stress) || f->offset == AT(pack.strain)) && f->type == SP_FIELD_REALS)
        return 6;
    if (f->offset == AT(pack.turns) && f->type == SP_FIELD_REALS)
        return SP_HISTORY_MAX;
    return sp_field_is_planes(f) ? SP_PLANES_MAX : f->offset == AT(pack.history) ? SP_HISTORY_MAX : SP_DIAMETERS_MAX;
}

const double *sp_field_list(const sp_scene *s, const sp_field *f, int32_t *count) {
    const double *values;
    memcpy(count, (const char *)s + f->limits.count, sizeof *count);
    memcpy(&values, (const char *)s + f->offset, sizeof values);
    return sp_field_is_planes(f) ? s->plane : values;
}

void sp_field_set_list(sp_scene *s, const sp_field *f, const double *values, int32_t count) {
    memcpy((char *)s + f->limits.count, &count, sizeof count);
    memcpy((char *)s + f->offset, &values, sizeof values);
}

bool sp_field_is_scalar(const sp_field *f) {
    return sp_field_is_number(f) || f->type == SP_FIELD_BOOL || f->type == SP_FIELD_WORD;
}

const char *sp_field_not_swept(const sp_field *f) {
    if (sp_field_is_tapped(f))
        return "its diagrams vary column.parameter, from column.from to column.to";
    if (sp_field_is_material(f))
        return "it changes no sample, only the units of tables";
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
                 f->offset == AT(pack.history)  ? "1e-3, 1e-5"
                 : f->offset == AT(pack.stress) ? "1e-4, 1e-4, 1e-5"
                 : f->offset == AT(pack.strain) ? "0, 0, 0.1"
                 : f->offset == AT(pack.turns)  ? "1, -1, 0"
                 : sp_field_is_planes(f)        ? "12.5, 25"
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
