#include "base/base.h"
#include "packing/making.h"

#include <math.h>
#include <sonopack/packing.h>

sp_pack_spec sp_pack_spec_default(void) {
    return (sp_pack_spec){.kind = SP_PACK_PISTON,
                          .dim = 2,
                          .grains = 600,
                          .width = 24,
                          .pressure = 1e-4,
                          .friction = 0.5,
                          .poisson = 0,
                          .diameter_min = 0,
                          .diameter_max = 0,
                          .seed = 1,
                          .tolerance = 0,
                          .damping = 0.8,
                          .piston_mass = 12.5,
                          .gas_fraction = 0.3,
                          .time_step = 0.1,
                          .calm = 0.01,
                          .drag = 0.01,
                          .max_steps = 0};
}

typedef struct range {
    const char *name;
    double value, low, high;
    const char *right;
} range;

static sp_status check_ranges(const sp_pack_spec *s, sp_error *err) {
    const range ranges[] = {
        {"packing.dimension", s->dim, 1, 3, "1, 2 or 3"},
        {"packing.grains", s->grains, 1, 1e8, "1 .. 1e8"},
        {"packing.width", s->width, 0x1p-1022, 1e6, "above 0, at most 1e6 d"},
        {"packing.pressure", s->pressure, 1e-10, 1e-2, "1e-10 .. 1e-2 E*"},
        {"packing.friction", s->friction, 0, 1e6, "0 .. 1e6"},
        {"packing.poisson", s->poisson, 0, 0.5, "0 .. 0.5"},
        {"packing.diameter_min", s->diameter_min, 0.01, 100, "0.01 .. 100 d"},
        {"packing.diameter_max", s->diameter_max, 0.01, 100, "0.01 .. 100 d"},
        {"packing.tolerance", s->tolerance, 0, 1, "0 (the default rule) .. 1"},
        {"packing.damping", s->damping, 1e-3, 2, "0.001 .. 2 of critical"},
        {"packing.piston_mass", s->piston_mass, 1e-2, 1e6, "0.01 .. 1e6"},
        {"packing.gas_fraction", s->gas_fraction, 0.01, 0.45, "0.01 .. 0.45"},
        {"packing.time_step", s->time_step, 1e-3, 0.15, "0.001 .. 0.15 (0.2 is unstable with contact damping)"},
        {"packing.calm", s->calm, 0, 1, "0 .. 1"},
        {"packing.drag", s->drag, 0, 0.1, "0 .. 0.1"},
        {"packing.max_steps", (double)s->max_steps, 0, 1e15, "0 (a bound of its own) .. 1e15"},
    };
    for (size_t k = 0; k < sizeof ranges / sizeof *ranges; k++)
        if (!(ranges[k].value >= ranges[k].low && ranges[k].value <= ranges[k].high))
            return sp_fail(err, SP_EINVAL, "%s = %g: must be %s", ranges[k].name, ranges[k].value, ranges[k].right);
    if (s->diameter_min > s->diameter_max)
        return sp_fail(err, SP_EINVAL, "packing.diameter_min = %g: must not be above packing.diameter_max = %g",
                       s->diameter_min, s->diameter_max);
    return SP_OK;
}

static sp_status check_ordered(const sp_pack_spec *s, sp_error *err) {
    int dim = s->kind == SP_PACK_CHAIN ? 1 : 2;
    const char *name = s->kind == SP_PACK_CHAIN ? "chain" : "triangular";
    if (s->dim != dim)
        return sp_fail(err, SP_EINVAL, "packing.dimension = %d: must be %d for packing.kind = \"%s\"", s->dim, dim,
                       name);
    if (s->kind == SP_PACK_TRIANGULAR) {
        if (s->diameter_min != s->diameter_max)
            return sp_fail(err, SP_EINVAL,
                           "packing.diameter_max = %g: a triangular lattice needs equal diameters, diameter_min = %g",
                           s->diameter_max, s->diameter_min);
        double row = floor(s->width / s->diameter_max + 1e-9);
        if (row < 3 || fmod(s->grains, row) != 0)
            return sp_fail(err, SP_EINVAL,
                           "packing.grains = %d: must be a multiple of the %g grains of a row (packing.width = %g), "
                           "at least 3 a row",
                           s->grains, row, s->width);
    }
    return SP_OK;
}

sp_pack_spec sp_pack_spec_resolve(const sp_pack_spec *given) {
    sp_pack_spec s = *given;
    if (s.diameter_min == 0 && s.diameter_max == 0) {
        bool ordered = s.kind == SP_PACK_CHAIN || s.kind == SP_PACK_TRIANGULAR;
        s.diameter_min = ordered ? 1.0 : 0.8;
        s.diameter_max = ordered ? 1.0 : 1.2;
    }
    if (s.tolerance == 0)
        s.tolerance = fmin(1e-10, 1e-6 * s.pressure);
    return s;
}

/* What a piston's grains would never come to rest with, or not where they should. */
static sp_status check_piston(const sp_pack_spec *s, sp_error *err) {
    const double slack = 1 + 1e-9, mean = 0.5 * (s->diameter_min + s->diameter_max);
    if (s->dim != 2)
        return sp_fail(err, SP_EINVAL, "packing.dimension = %d: packing.kind = \"piston\" makes 2D packings only",
                       s->dim);
    if (s->width < 4 * s->diameter_max)
        return sp_fail(err, SP_EINVAL,
                       "packing.width = %g: a box narrower than four of the largest grains (%g) would see itself "
                       "through the periodic sides",
                       s->width, 4 * s->diameter_max);
    if (mean < 0.1 || mean > 10)
        return sp_fail(err, SP_EINVAL,
                       "packing.diameter_min = %g, packing.diameter_max = %g: must be 0.1 .. 10 in the mean, which is "
                       "the unit of length",
                       s->diameter_min, s->diameter_max);
    if (s->diameter_max > 100 * slack * s->diameter_min)
        return sp_fail(err, SP_EINVAL, "packing.diameter_max = %g: must be at most 100 times packing.diameter_min = %g",
                       s->diameter_max, s->diameter_min);
    if (s->damping * s->time_step > 0.12 * slack)
        return sp_fail(err, SP_EINVAL,
                       "packing.damping = %g: must be at most %.3g with packing.time_step = %g, or the viscous forces "
                       "are unstable",
                       s->damping, 0.12 / s->time_step, s->time_step);
    if (s->tolerance > 0.1 * slack * s->pressure)
        return sp_fail(err, SP_EINVAL,
                       "packing.tolerance = %g: must be at most 0.1 of packing.pressure = %g, no packing is at rest "
                       "above that",
                       s->tolerance, s->pressure);
    return SP_OK;
}

sp_status sp_pack_spec_check(const sp_pack_spec *given, sp_error *err) {
    const sp_pack_spec resolved = sp_pack_spec_resolve(given), *s = &resolved;
    sp_status status = check_ranges(s, err);
    if (status != SP_OK)
        return status;
    if (s->kind == SP_PACK_CHAIN || s->kind == SP_PACK_TRIANGULAR)
        return check_ordered(s, err);
    if (s->kind != SP_PACK_PISTON)
        return sp_fail(err, SP_EINVAL, "packing.kind = %d: must be piston, chain or triangular", (int)s->kind);
    return check_piston(s, err);
}
