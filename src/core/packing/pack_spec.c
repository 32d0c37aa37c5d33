/* The table of a packing's keys; defaults, checks and resolved values of its spec. */
#include "base/base.h"
#include "packing/contact.h"
#include "packing/prepare.h"
#include "packing/types.h"

#include <math.h>
#include <sonopack/packing.h>

#define KEY(name, type, member, value, unit, low, high, zero, words, meaning)                                          \
    {"packing." name, SP_KEY_##type, offsetof(sp_pack_spec, member), 0, unit, low, high, zero},
#define LIST(name, member, value, count, values, unit, low, high, meaning)                                             \
    {"packing." name,                                                                                                  \
     SP_KEY_REALS,                                                                                                     \
     offsetof(sp_pack_spec, member),                                                                                   \
     offsetof(sp_pack_spec, count),                                                                                    \
     unit,                                                                                                             \
     low,                                                                                                              \
     high,                                                                                                             \
     false},
#define SCENE_KEY(...)

const sp_key sp_pack_keys[] = {
#include "packing/keys.inc"
    {NULL, SP_KEY_REAL, 0, 0, "", 0, 0, false}};
#undef KEY
#undef LIST
#undef SCENE_KEY

/* Values that a protocol sets if the spec leaves them open. */
typedef struct protocol {
    double damping, piston_mass;
    double gas_fraction[4]; /* by dimension */
    double time_step, lag;
    double calm, drag, viscous_limit, calm_damping;
} protocol;

/* DEFAULT is the motion of SOMFAI2005 in steps three times as long: a different motion would give a different material.
 */
static const protocol protocols[] = {
    [SP_PROTOCOL_DEFAULT] = {0.8, 12.5, {0.3, 0.3, 0.3, 0.2}, 0.75, 0.6, 0.01, 0.01, 1e6, 0.8},
    [SP_PROTOCOL_SOMFAI2005] = {0.8, 12.5, {0.3, 0.3, 0.3, 0.2}, 0.7, 0, 0.01, 0.01, 1e6, 0.8},
    [SP_PROTOCOL_QUICK] = {0.5, 2, {0.45, 0.45, 0.45, 0.25}, 0.5, 0, 3, 0.01, 1, 0.2},
    [SP_PROTOCOL_AFFINE] = {0.8, 12.5, {0.3, 0.3, 0.3, 0.2}, 0.7, 0.6, 3, 0.01, 1e6, 0.5},
};
enum { PROTOCOLS = sizeof protocols / sizeof *protocols };
_Static_assert(PROTOCOLS == SP_PROTOCOL_AFFINE + 1, "the range of packing.protocol covers all protocols");

sp_pack_spec sp_pack_spec_default(void) {
#define KEY(name, type, member, value, ...)           .member = value,
#define LIST(name, member, value, count, values, ...) .member = value, .count = values,
#define SCENE_KEY(...)
    return (sp_pack_spec){
#include "packing/keys.inc"
    };
}

/* Checks the lengths of the lists, before their values are read. */
static sp_status check_lists(const sp_pack_spec *s, sp_error *err) {
    if (s->diameter_count < 0 || s->diameter_count > SP_DIAMETERS_MAX)
        return sp_fail_key(err, SP_EINVAL, "packing.diameters", " = (%d numbers): must be at most %d",
                           s->diameter_count, SP_DIAMETERS_MAX);
    if (s->history_count < 0 || s->history_count > SP_HISTORY_MAX || (s->history_count > 0 && !s->history))
        return sp_fail_key(err, SP_EINVAL, "packing.history", " = (%d pressures): must be at most %d", s->history_count,
                           SP_HISTORY_MAX);
    if (s->turn_count < 0 || s->turn_count > SP_HISTORY_MAX || s->strain_count < 0 || s->strain_count > 6)
        return sp_fail_key(err, SP_EINVAL, "packing.path", ": %d strains and %d turns: must be at most 6 and %d",
                           s->strain_count, s->turn_count, SP_HISTORY_MAX);
    if (s->stress_count < 0 || s->stress_count > 6)
        return sp_fail_key(err, SP_EINVAL, "packing.stress", " = (%d numbers): must be at most 6", s->stress_count);
    return sp_types_check_counts(s, err);
}

/* ---- sizes ----------------------------------------------------------------------------------------------------- */

static const char *const laws[] = {"uniform", "bidisperse", "lognormal", "list", "types"};

/* The grains have these diameters, and no others may be given. */
static sp_status check_given_limits(const sp_pack_spec *given, sp_error *err) {
    double low, high;
    sp_sizes_limits(given, &low, &high);
    if ((given->diameter_min != 0 && given->diameter_min != low) ||
        (given->diameter_max != 0 && given->diameter_max != high))
        return sp_fail_key(err, SP_EINVAL, given->diameter_min != 0 ? "packing.diameter_min" : "packing.diameter_max",
                           " = %g: must be 0 (not given) with packing.sizes = \"%s\", whose own limits are %g .. %g",
                           given->diameter_min != 0 ? given->diameter_min : given->diameter_max, laws[given->sizes],
                           low, high);
    return SP_OK;
}

static sp_status check_list(const sp_pack_spec *given, sp_error *err) {
    const int32_t count = given->diameters ? given->diameter_count : 0;
    if (count < given->grains)
        return sp_fail_key(err, SP_EINVAL, "packing.diameters",
                           " = (%d numbers): must be one for each of packing.grains = %d, packing.sizes = "
                           "\"list\" takes them from there or from packing.diameter_file",
                           count, given->grains);
    return check_given_limits(given, err);
}

/* Limits that exclude nearly all grains are a mistake: all grains would be as large as the nearer limit. */
static sp_status check_lognormal(const sp_pack_spec *s, sp_error *err) {
    const double within = sp_sizes_within(s);
    if (within >= 0.01)
        return SP_OK;
    if (s->size_spread == 0)
        return sp_fail_key(err, SP_EINVAL, "packing.size_spread",
                           " = 0: all grains then have diameter 1, which must lie within "
                           "packing.diameter_min = %g .. packing.diameter_max = %g",
                           s->diameter_min, s->diameter_max);
    return sp_fail_key(err, SP_EINVAL, "packing.size_spread",
                       " = %g: a lognormal distribution of this spread has a fraction %.2g of its grains within "
                       "packing.diameter_min = %g .. packing.diameter_max = %g: must be at least 0.01",
                       s->size_spread, within, s->diameter_min, s->diameter_max);
}

/* Checks the distribution and its limits. s is `given`, resolved. */
static sp_status check_sizes(const sp_pack_spec *given, const sp_pack_spec *s, sp_error *err) {
    if (s->sizes == SP_SIZES_LIST)
        return check_list(given, err);
    if (s->diameters && s->diameter_count > 0)
        return sp_fail_key(err, SP_EINVAL, "packing.sizes",
                           " = \"%s\": must be \"list\" where packing.diameters or packing.diameter_file is given",
                           laws[s->sizes]);
    if (s->sizes == SP_SIZES_TYPES)
        return check_given_limits(given, err);
    if ((given->diameter_min == 0) != (given->diameter_max == 0))
        return sp_fail_key(err, SP_EINVAL, given->diameter_min == 0 ? "packing.diameter_min" : "packing.diameter_max",
                           " = 0: must be given if packing.diameter_%s is, or neither",
                           given->diameter_min == 0 ? "max" : "min");
    sp_status status = sp_keys_check(sp_pack_keys, s, err); /* the limits that the law itself decides */
    if (status != SP_OK)
        return status;
    if (s->diameter_min > s->diameter_max)
        return sp_fail_key(err, SP_EINVAL, "packing.diameter_min", " = %g: must not be above packing.diameter_max = %g",
                           s->diameter_min, s->diameter_max);
    return s->sizes == SP_SIZES_LOGNORMAL ? check_lognormal(s, err) : SP_OK;
}

/* For compressed packings: the mean diameter must be near 1, and grains of all sizes must be visible to each other. */
static sp_status check_scale(const sp_pack_spec *s, sp_error *err) {
    const double slack = 1 + 1e-9, mean = sp_sizes_moment(s, 1);
    if (!(mean * slack >= 0.1 && mean <= 10 * slack))
        return sp_fail_key(err, SP_EINVAL, "packing.diameter_min",
                           " = %g, packing.diameter_max = %g: their mean is %g: must be 0.1 .. 10, "
                           "because it is the unit of length",
                           s->diameter_min, s->diameter_max, mean);
    if (s->diameter_max > 100 * slack * s->diameter_min)
        return sp_fail_key(err, SP_EINVAL, "packing.diameter_max",
                           " = %g: must be at most 100 times packing.diameter_min = %g", s->diameter_max,
                           s->diameter_min);
    const double sides[] = {s->width, s->depth};
    for (int k = 0; k < s->dim - 1 && s->cell == SP_CELL_PISTON; k++)
        if (sides[k] < 4 * s->diameter_max)
            return sp_fail_key(
                err, SP_EINVAL, k == 0 ? "packing.width" : "packing.depth",
                " = %g: must be at least four of the largest diameters (%g): in a narrower box grains would "
                "touch their own periodic images",
                sides[k], 4 * s->diameter_max);
    return SP_OK;
}

/* ---- kinds ----------------------------------------------------------------------------------------------------- */

/* Heavy grains have small accelerations even under large forces. This factor lowers the tolerance if all grains, or the
 * largest among smaller ones, are so heavy that forces would be off by more than 1e-5 of typical ones. It is 1 for
 * diameters up to 2.6. */
static double heaviness(const sp_pack_spec *s) {
    const double mean = sp_sizes_moment(s, 1);
    return fmax(fmax(1, s->diameter_min), grain_mass(0.5 * s->diameter_max) / (10 * mean * mean)) *
           fmax(1, sp_types_limits(s).densest);
}

double sp_rounding_acceleration(double pressure, double exponent) {
    return 1e-13 * (exponent == 1.5 ? cbrt(pressure) : pow(pressure, 1 - 1 / exponent));
}

/* A tolerance of 2e-15 was reached at p = 1e-4. */
static double least_tolerance(const sp_pack_spec *s) {
    const double area = s->dim == 3 ? s->width * s->depth : s->width;
    const sp_types_range all = sp_types_limits(s);
    return fmax(1, all.stiffest / all.lightest) * sp_rounding_acceleration(s->pressure, s->law_exponent) *
           fmax(1, fmax(s->width, s->grains / area) / 25);
}

static sp_status check_motion(const sp_pack_spec *s, sp_error *err) {
    const double slack = 1 + 1e-9;
    if (s->tolerance > 0.1 * slack * s->pressure)
        return sp_fail_key(err, SP_EINVAL, "packing.tolerance",
                           " = %g: must be at most 0.1 of packing.pressure = %g, above which no packing is at rest",
                           s->tolerance, s->pressure);
    const double least = least_tolerance(s);
    if (s->tolerance < least)
        return sp_fail_key(err, SP_EINVAL, "packing.tolerance",
                           " = %g: must be at least %.2g, or 0 (the default rule): accelerations below that "
                           "are rounding",
                           s->tolerance, least);
    if (s->calm > 0 && s->calm < 1e-6)
        return sp_fail_key(err, SP_EINVAL, "packing.calm",
                           " = %g: must be at least 1e-6, or 0 (never), or below 0 (set by the protocol)", s->calm);
    return SP_OK;
}

static sp_status check_triangular(const sp_pack_spec *s, sp_error *err) {
    const double mean = sp_sizes_moment(s, 1), row = floor(s->width / mean + 1e-9);
    if (row < 3 || fmod(s->grains, row) != 0)
        return sp_fail_key(err, SP_EINVAL, "packing.grains",
                           " = %d: must be a multiple of the %g grains of a row (packing.width = %g%s), at "
                           "least 3 a row",
                           s->grains, row, s->width,
                           s->diameter_min < s->diameter_max ? " over their mean diameter" : "");
    if (s->diameter_min == s->diameter_max)
        return SP_OK;
    sp_status status = check_scale(s, err);
    return status == SP_OK ? check_motion(s, err) : status;
}

static sp_status check_ordered(const sp_pack_spec *s, sp_error *err) {
    const bool chain = s->kind == SP_PACK_CHAIN;
    if (s->history_count > 0 && (chain || s->diameter_min == s->diameter_max))
        return sp_fail_key(err, SP_EINVAL, "packing.history",
                           " = (%d pressures): must be empty for packing.kind = \"%s\"%s, which depends on "
                           "packing.pressure alone",
                           s->history_count, chain ? "chain" : "triangular", chain ? "" : " of equal grains");
    if (s->dim != (chain ? 1 : 2))
        return sp_fail_key(err, SP_EINVAL, "packing.dimension", " = %d: must be %d for packing.kind = \"%s\"", s->dim,
                           chain ? 1 : 2, chain ? "chain" : "triangular");
    if (chain && s->compression == SP_COMPRESSION_ISOTROPIC)
        return sp_fail_key(err, SP_EINVAL, "packing.compression",
                           " = \"isotropic\": must be \"piston\" for packing.kind = \"chain\", which has no sides");
    return chain ? SP_OK : check_triangular(s, err);
}

/* If the grains do not fill a layer, the periods shrink to nothing, or the grains are pushed on top of each other. */
static sp_status check_layer(const sp_pack_spec *s, sp_error *err) {
    if (s->compression != SP_COMPRESSION_ISOTROPIC)
        return SP_OK;
    const double solid = s->dim == 2 ? sp_sizes_mean_area(s) / 0.8 : sp_sizes_mean_volume(s) / 0.6;
    const double layer = s->width * (s->dim == 2 ? 1 : s->depth) * s->diameter_max, least = ceil(layer / solid);
    if (s->grains >= least)
        return SP_OK;
    return sp_fail_key(err, SP_EINVAL, "packing.grains",
                       " = %d: must be at least %g for packing.compression = \"isotropic\", a layer as high "
                       "as the largest grain in a box this wide",
                       s->grains, least);
}

/* Largest pressure that a layer of the largest grains carries before the overlaps reach 0.8 radii (Hertz). */
static sp_status check_load(const sp_pack_spec *s, sp_error *err) {
    const double r = 0.5 * s->diameter_max, area = s->width * (s->dim == 2 ? 1 : s->depth);
    const double most = 4.0 / 3.0 * sqrt(r) * pow(0.8 * r, 1.5) * s->grains / area;
    if (s->pressure <= most)
        return SP_OK;
    return sp_fail_key(err, SP_EINVAL, "packing.pressure",
                       " = %g: must be at most %.3g, packing.grains = %d cannot carry more in a box of "
                       "packing.width = %g",
                       s->pressure, most, s->grains, s->width);
}

static sp_status check_piston(const sp_pack_spec *s, sp_error *err) {
    if (s->dim != 2 && s->dim != 3)
        return sp_fail_key(err, SP_EINVAL, "packing.dimension", " = %d: must be 2 or 3 for packing.kind = \"piston\"",
                           s->dim);
    sp_status status = check_scale(s, err);
    if (status != SP_OK)
        return status;
    /* random sequential addition stops at an area fraction of 0.547 for disks and a volume fraction of 0.38 for
     * spheres, and slows down long before; equal grains are the worst case */
    const double densest = s->dim == 2 ? 0.45 : 0.3;
    if (s->gas_fraction > densest)
        return sp_fail_key(err, SP_EINVAL, "packing.gas_fraction",
                           " = %g: must be at most %g in %d dimensions, grains placed at random jam at %g",
                           s->gas_fraction, densest, s->dim, s->dim == 2 ? 0.547 : 0.38);
    status = check_layer(s, err);
    if (status == SP_OK && s->cell == SP_CELL_PISTON)
        status = check_load(s, err);
    return status == SP_OK ? check_motion(s, err) : status;
}

/* The packing itself may not be known yet. */
static sp_status check_file(const sp_pack_spec *s, sp_error *err) {
    sp_status status = s->content ? check_scale(s, err) : SP_OK;
    return status == SP_OK ? check_motion(s, err) : status;
}

/* In a lattice of equal disks, rotation of all disks in the same sense has 1.6 times the largest viscous rate of other
 * packings. It grows above 0.65 of their stable step. */
static const double LATTICE_STEP = 0.5;

static bool may_order(const sp_pack_spec *s) { return s->dim == 2 && sp_sizes_alike(s); }

static double own_step(const protocol *own, const sp_pack_spec *s) {
    const bool sticks = own->lag > 0 && s->friction > 2; /* few grains that roll and cannot slide may swing for ever */
    return sticks || may_order(s) ? fmin(own->time_step, LATTICE_STEP) : own->time_step;
}

/* A lag makes other packings of disks that differ by 0.1%: s1/s2 of a lattice at 1e-4 is 0.786, without it 0.907. */
static double own_lag(const protocol *own, const sp_pack_spec *s) { return may_order(s) ? 0 : own->lag; }

/* Keys of a compression, which a minimum does without: they must not be given, or a sweep of one would make copies. */
static sp_status check_idle(const sp_pack_spec *given, sp_error *err) {
    const sp_pack_spec usual = sp_pack_spec_default();
    const struct {
        const char *key;
        double value, usual;
    } idle[] = {{"packing.protocol", given->protocol, usual.protocol},
                {"packing.reference", given->reference, usual.reference},
                {"packing.tangential", given->tangential, usual.tangential},
                {"packing.gas_fraction", given->gas_fraction, usual.gas_fraction},
                {"packing.strain_rate", given->strain_rate, usual.strain_rate},
                {"packing.damping", given->damping, usual.damping},
                {"packing.time_step", given->time_step, usual.time_step},
                {"packing.drag", given->drag, usual.drag},
                {"packing.piston_mass", given->piston_mass, usual.piston_mass},
                {"packing.lag", given->lag, usual.lag},
                {"packing.calm", given->calm, usual.calm},
                {"packing.calm_damping", given->calm_damping, usual.calm_damping},
                {"packing.viscous_limit", given->viscous_limit, usual.viscous_limit},
                {"packing.pressure", given->fraction > 0 ? given->pressure : usual.pressure, usual.pressure}};
    for (size_t k = 0; k < sizeof idle / sizeof *idle; k++)
        if (idle[k].value != idle[k].usual)
            return sp_fail_key(err, SP_EINVAL, idle[k].key,
                               " = %g: must not be given for packing.kind = \"minimum\"%s, which does without",
                               idle[k].value, given->fraction > 0 ? " at a packing.fraction" : "");
    return SP_OK;
}

static sp_status check_minimum(const sp_pack_spec *given, const sp_pack_spec *s, sp_error *err) {
    if (s->cell != SP_CELL_PERIODIC)
        return sp_fail_key(err, SP_EINVAL, "packing.cell", ": must be \"periodic\" for packing.kind = \"minimum\"");
    if (s->friction != 0)
        return sp_fail_key(err, SP_EINVAL, "packing.friction",
                           " = %g: must be 0 for packing.kind = \"minimum\", whose grains are smooth", s->friction);
    if (s->fraction > 0 && (s->stress_count > 0 || s->history_count > 0))
        return sp_fail_key(err, SP_EINVAL, s->stress_count > 0 ? "packing.stress" : "packing.history",
                           ": must be empty for packing.kind = \"minimum\" at a packing.fraction");
    sp_status status = check_scale(s, err);
    if (status == SP_OK)
        status = check_idle(given, err);
    if (status == SP_OK && s->fraction == 0 && least_tolerance(s) > 1e-5 * s->pressure)
        return sp_fail_key(err, SP_EINVAL, "packing.pressure",
                           " = %g: is too small for packing.law.exponent = %g: its accelerations are below rounding",
                           s->pressure, s->law_exponent);
    return status == SP_OK ? check_motion(s, err) : status;
}

sp_pack_spec sp_pack_spec_resolve(const sp_pack_spec *given) {
    sp_pack_spec s = *given;
    sp_sizes_limits(given, &s.diameter_min, &s.diameter_max);
    sp_cell_spec_resolve(&s);
    if (s.dim == 3 && s.depth == 0)
        s.depth = s.width;
    if (s.tolerance == 0)
        s.tolerance = fmax(fmin(1e-10, 1e-6 * s.pressure) / heaviness(&s), least_tolerance(&s));
    if (s.dim < 1 || s.dim > 3 || (unsigned)s.protocol >= PROTOCOLS)
        return s; /* such a spec fails every check */
    const protocol *own = &protocols[s.protocol];
    if (s.damping == 0)
        s.damping = own->damping;
    if (s.piston_mass == 0)
        s.piston_mass = own->piston_mass;
    if (s.gas_fraction == 0)
        s.gas_fraction = own->gas_fraction[s.dim];
    if (s.time_step == 0)
        s.time_step = own_step(own, &s);
    if (s.lag < 0)
        s.lag = own_lag(own, &s);
    if (s.calm < 0)
        s.calm = own->calm;
    if (s.drag < 0)
        s.drag = own->drag;
    if (s.calm_damping == 0)
        s.calm_damping = own->calm_damping;
    if (s.viscous_limit == 0)
        s.viscous_limit = own->viscous_limit;
    return s;
}

sp_status sp_pack_spec_check(const sp_pack_spec *given, sp_error *err) {
    sp_status status = check_lists(given, err);
    if (status == SP_OK)
        status = sp_keys_check(sp_pack_keys, given, err);
    if (status != SP_OK)
        return status;
    const sp_pack_spec resolved = sp_pack_spec_resolve(given), *s = &resolved;
    status = sp_types_check(s, err);
    if (status == SP_OK)
        status = check_sizes(given, s, err);
    if (status != SP_OK)
        return status;
    status = sp_cell_spec_check(given, s, err);
    if (status == SP_OK)
        status = sp_path_check(s, err);
    if (status != SP_OK)
        return status;
    if (s->dim != 3 && s->depth != 0)
        return sp_fail_key(err, SP_EINVAL, "packing.depth", " = %g: must be 0 (not given) in packing.dimension = %d",
                           s->depth, s->dim);
    if (s->tangential == SP_TANGENTIAL_HISTORY && s->dim != 2)
        return sp_fail_key(err, SP_EINVAL, "packing.tangential",
                           " = \"history\": must be \"constant\" in packing.dimension = %d, since the law of loading "
                           "history is for a force along one line",
                           s->dim);
    if (s->kind != SP_PACK_MINIMUM && s->fraction != 0)
        return sp_fail_key(err, SP_EINVAL, "packing.fraction", " = %g: must be 0 except for packing.kind = \"minimum\"",
                           s->fraction);
    if (s->law_exponent != 1.5 && (s->cell != SP_CELL_PERIODIC || s->reference || s->kind == SP_PACK_FILE ||
                                   s->tangential != SP_TANGENTIAL_CONSTANT))
        return sp_fail_key(err, SP_EINVAL, "packing.law.exponent",
                           " = %g: must be 1.5 except for random grains in a packing.cell = \"periodic\", without "
                           "packing.reference and loading history",
                           s->law_exponent);
    switch (s->kind) {
    case SP_PACK_MINIMUM: return check_minimum(given, s, err);
    case SP_PACK_CHAIN:
    case SP_PACK_TRIANGULAR: return check_ordered(s, err);
    case SP_PACK_PISTON: return check_piston(s, err);
    case SP_PACK_FILE: break;
    }
    return check_file(s, err);
}

sp_status sp_pack_spec_fill(const sp_pack_spec *given, double height, int32_t *grains, sp_error *err) {
    /* measured: 0.795 .. 0.822 over whole boxes 24 wide and 8 .. 400 d high at p = 1e-4, largest in the highest */
    const double disks = 0.815, spheres = 0.6;
    if (given->kind != SP_PACK_PISTON || given->compression != SP_COMPRESSION_PISTON || given->dim < 2 ||
        given->cell != SP_CELL_PISTON)
        return sp_fail_key(err, SP_EINVAL, "packing.height",
                           " = %g: must be 0 (packing.grains determines it) except for packing.kind = \"piston\" with "
                           "packing.compression = \"piston\"",
                           height);
    sp_pack_spec s = *given;
    if (s.sizes == SP_SIZES_LIST)
        s.grains = s.diameter_count; /* mean of the whole list */
    s = sp_pack_spec_resolve(&s);
    const double number = s.dim == 2 ? height * s.width * disks / sp_sizes_mean_area(&s)
                                     : height * s.width * s.depth * spheres / sp_sizes_mean_volume(&s);
    if (!(number <= 1e8))
        return sp_fail_key(err, SP_EINVAL, "packing.height",
                           " = %g: must be lower: it takes %.3g grains, and at most 1e8 are possible", height, number);
    *grains = number > 1 ? (int32_t)floor(number + 0.5) : 1;
    return SP_OK;
}
