/* Specs of packings without a piston: their shape, their stress, and what cannot be. */
#include "base/base.h"
#include "packing/geometry.h"
#include "packing/prepare.h"

#include <math.h>

/* Typical fractions of packings, to estimate their size before they exist. */
static const double DISKS = 0.83, SPHERES = 0.62;

/* The defaults, which count as not given. */
#define KEY(name, type, member, value, ...)           .member = value,
#define LIST(name, member, value, count, values, ...) .member = value, .count = values,
#define SCENE_KEY(...)
static const sp_pack_spec usual = {
#include "packing/keys.inc"
};

static double solid_volume(const sp_pack_spec *s) {
    return s->grains * (s->dim == 2 ? sp_sizes_mean_area(s) / DISKS : sp_sizes_mean_volume(s) / SPHERES);
}

/* Of packing.stress. */
static int components_of(int dim) { return dim == 2 ? 3 : 6; }

sp_status sp_tensor_check(const char *key, int dim, int32_t count, const double *list, sp_error *err) {
    if (count == components_of(dim) && list)
        return SP_OK;
    return sp_fail_key(err, SP_EINVAL, key, " = (%d numbers): must be %s in packing.dimension = %d, or no numbers",
                       count, dim == 2 ? "xx, yy, xy" : "xx, yy, zz, yz, xz, xy", dim);
}

bool sp_tensor_has(int dim, int component) { return component < 3 ? component < dim : dim == 3 || component == 5; }

void sp_tensor_fill(int dim, int32_t count, const double *list, double tensor[6]) {
    static const int plane[3] = {0, 1, 5}; /* xx, yy, xy */
    for (int c = 0; c < count; c++)
        tensor[dim == 2 ? plane[c] : c] = list[c];
}

void sp_stress_target(const sp_pack_spec *s, double target[6]) {
    for (int c = 0; c < 6; c++)
        target[c] = s->stress_count == 0 && c < s->dim ? s->pressure : 0;
    sp_tensor_fill(s->dim, s->stress_count, s->stress, target);
}

static double mean_stress(const sp_pack_spec *s) {
    double sum = 0;
    for (int a = 0; a < s->dim; a++)
        sum += s->stress[a];
    return sum / s->dim;
}

void sp_cell_spec_resolve(sp_pack_spec *s) {
    if (s->cell == SP_CELL_PISTON || (s->dim != 2 && s->dim != 3) || s->grains < 1)
        return;
    if (s->stress_count == components_of(s->dim) && s->stress && mean_stress(s) > 0)
        s->pressure = mean_stress(s);
    if (s->kind != SP_PACK_FILE && s->width == usual.width)
        s->width = s->dim == 2    ? sqrt(solid_volume(s))
                   : s->depth > 0 ? sqrt(solid_volume(s) / s->depth)
                                  : cbrt(solid_volume(s));
}

double sp_cell_spec_height(const sp_pack_spec *s) {
    return solid_volume(s) / (s->width * (s->dim == 3 ? s->depth : 1));
}

sp_pack_spec sp_cell_spec_gas(const sp_pack_spec *s) {
    sp_pack_spec gas = *s;
    const double grow = pow((s->dim == 2 ? DISKS : SPHERES) / s->gas_fraction, 1.0 / s->dim);
    if (s->cell != SP_CELL_PISTON) {
        gas.width *= grow;
        gas.depth *= grow;
    }
    return gas;
}

/* Whether a symmetric matrix has only positive eigenvalues (Sylvester). */
static bool positive(const double t[6]) {
    const double xx = t[0], yy = t[1], zz = t[2], yz = t[3], xz = t[4], xy = t[5];
    return xx > 0 && xx * yy - xy * xy > 0 &&
           xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz) > 0;
}

static sp_status check_stress(const sp_pack_spec *given, sp_error *err) {
    const sp_status listed = sp_tensor_check("packing.stress", given->dim, given->stress_count, given->stress, err);
    double t[6];
    if (listed != SP_OK)
        return listed;
    const double mean = mean_stress(given), p = given->pressure;
    sp_stress_target(given, t);
    if (given->dim == 2)
        t[2] = 1;
    if (!positive(t))
        return sp_fail_key(err, SP_EINVAL, "packing.stress",
                           " = (%g, %g, ...): must be compressive along every direction, grains without cohesion "
                           "hold no other (all eigenvalues of the tensor positive)",
                           t[0], t[1]);
    if (mean < 1e-10)
        return sp_fail_key(err, SP_EINVAL, "packing.stress", ": its mean normal stress = %g: must be at least 1e-10 E*",
                           mean);
    if (p != usual.pressure && fabs(p / mean - 1) > 1e-9)
        return sp_fail_key(err, SP_EINVAL, "packing.pressure",
                           " = %g: must be the mean normal stress of packing.stress, %g, or not given", p, mean);
    if (given->cell == SP_CELL_BOX && (t[3] != 0 || t[4] != 0 || t[5] != 0))
        return sp_fail_key(err, SP_EINVAL, "packing.stress",
                           ": its shear stress must be 0 for packing.cell = \"box\", whose walls do not tilt");
    return SP_OK;
}

static sp_status check_edges(const sp_pack_spec *given, const sp_pack_spec *s, sp_error *err) {
    const bool equal = given->width == usual.width;
    const double least = 4 * s->diameter_max, up = sp_cell_spec_height(s);
    if (!equal && s->width < least)
        return sp_fail_key(err, SP_EINVAL, "packing.width",
                           " = %g: must be at least four of the largest diameters (%g)", s->width, least);
    if (s->dim == 3 && given->depth > 0 && s->depth < least)
        return sp_fail_key(err, SP_EINVAL, "packing.depth",
                           " = %g: must be at least four of the largest diameters (%g)", s->depth, least);
    const double shortest = fmin(up, fmin(s->width, s->dim == 3 ? s->depth : s->width));
    if (shortest < least)
        return sp_fail_key(err, SP_EINVAL, "packing.grains",
                           " = %d: too few for this cell, whose shortest edge would be about %.3g: must be at least "
                           "four of the largest diameters (%g), or grains would touch their own images",
                           s->grains, shortest, least);
    return SP_OK;
}

/* What only cells without a piston have. */
static sp_status check_piston_cell(const sp_pack_spec *s, sp_error *err) {
    const bool compressed = s->kind == SP_PACK_PISTON || s->kind == SP_PACK_FILE;
    if (s->stress_count > 0)
        return sp_fail_key(err, SP_EINVAL, "packing.stress",
                           " = (%d numbers): must be empty for packing.cell = \"piston\", whose pressure is "
                           "packing.pressure",
                           s->stress_count);
    if (s->strain_rate != 0)
        return sp_fail_key(err, SP_EINVAL, "packing.strain_rate",
                           " = %g: must be 0 unless packing.cell is \"periodic\" or \"box\"", s->strain_rate);
    if (s->gravity != 0 && (!compressed || s->compression != SP_COMPRESSION_PISTON))
        return sp_fail_key(err, SP_EINVAL, "packing.gravity",
                           " = %g: must be 0 except for random grains under a piston whose sides do not move",
                           s->gravity);
    return SP_OK;
}

sp_status sp_cell_spec_check(const sp_pack_spec *given, const sp_pack_spec *s, sp_error *err) {
    if (given->cell == SP_CELL_PISTON)
        return check_piston_cell(given, err);
    if (given->kind != SP_PACK_PISTON && given->kind != SP_PACK_FILE && given->kind != SP_PACK_MINIMUM)
        return sp_fail_key(err, SP_EINVAL, "packing.cell", " = \"%s\": must be \"piston\" for ordered packings",
                           sp_cell_names[given->cell]);
    if (given->dim != 2 && given->dim != 3)
        return sp_fail_key(err, SP_EINVAL, "packing.dimension", " = %d: must be 2 or 3 for packing.cell = \"%s\"",
                           given->dim, sp_cell_names[given->cell]);
    if (given->compression != SP_COMPRESSION_PISTON)
        return sp_fail_key(err, SP_EINVAL, "packing.compression",
                           " = \"isotropic\": must not be given for packing.cell = \"%s\", whose edges all move",
                           sp_cell_names[given->cell]);
    if (given->gravity != 0)
        return sp_fail_key(err, SP_EINVAL, "packing.gravity", " = %g: must be 0 for packing.cell = \"%s\"",
                           given->gravity, sp_cell_names[given->cell]);
    sp_status status = given->stress_count != 0 ? check_stress(given, err) : SP_OK;
    return status == SP_OK && given->kind != SP_PACK_FILE && given->content == 0 ? check_edges(given, s, err) : status;
}
