/* Completes a spec from the packing that its compression starts from. */
#include "packing/prepare.h"

#include "base/base.h"

#include <math.h>

typedef struct taken {
    const char *name;
    double given, usual, own; /* value in the spec, its default, value of the packing */
} taken;

static sp_status check_start(const sp_packing *from, sp_error *err) {
    if (!from || from->n == 0)
        return sp_fail(err, SP_EINVAL, "packing.file = \"\": must name a packing for packing.kind = \"file\"");
    sp_status status = sp_packing_check(from, err);
    if (status != SP_OK)
        return status;
    if (from->dim == 1)
        return sp_fail(err, SP_EINVAL,
                       "packing.file: a chain (dimension 1): must have 2 or 3 dimensions; for a chain under another "
                       "pressure use packing.kind = \"chain\"");
    if (from->wall != SP_WALL_RIGID)
        return sp_fail(err, SP_EINVAL,
                       "packing.file: its walls are no rigid planes, which they must be to be compressed by a piston");
    if (!sp_packing_hertzian(from))
        return sp_fail(err, SP_EINVAL,
                       "packing.file: has masses or stiffnesses of its own; must be Hertzian spheres to be compressed");
    if (!(from->pressure >= 1e-10 && from->pressure <= 1e-2))
        return sp_fail(err, SP_EINVAL, "packing.file: its pressure = %g: must be 1e-10 .. 1e-2 E*", from->pressure);
    return SP_OK;
}

static sp_status check_sizes(const sp_pack_spec *spec, sp_error *err) {
    if (spec->sizes != SP_SIZES_UNIFORM || spec->diameter_count > 0)
        return sp_fail(err, SP_EINVAL,
                       "packing.sizes: must not be given for packing.kind = \"file\", whose grains already have sizes");
    return SP_OK;
}

sp_status sp_pack_spec_from(sp_pack_spec *spec, const sp_packing *from, sp_error *err) {
    sp_status status = check_start(from, err);
    if (status == SP_OK)
        status = check_sizes(spec, err);
    if (status != SP_OK)
        return status;
    const sp_pack_spec usual = sp_pack_spec_default();
    double low = INFINITY, high = 0;
    for (int32_t i = 0; i < from->n; i++) {
        low = fmin(low, 2 * from->r[i]);
        high = fmax(high, 2 * from->r[i]);
    }
    const taken all[] = {{"dimension", spec->dim, usual.dim, from->dim},
                         {"grains", spec->grains, usual.grains, from->n},
                         {"width", spec->width, usual.width, from->box[0]},
                         {"cell", (double)spec->cell, (double)usual.cell, (double)from->cell},
                         {"gravity", spec->gravity, usual.gravity, from->gravity},
                         {"depth", spec->depth, usual.depth, from->dim == 3 ? from->box[1] : 0},
                         {"diameter_min", spec->diameter_min, usual.diameter_min, low},
                         {"diameter_max", spec->diameter_max, usual.diameter_max, high}};
    for (size_t k = 0; k < sizeof all / sizeof *all; k++)
        if (all[k].given != all[k].usual && all[k].given != all[k].own)
            return sp_fail(err, SP_EINVAL, "packing.%s = %.10g: must be that of packing.file, %.10g, or not given",
                           all[k].name, all[k].given, all[k].own);
    const uint64_t content = sp_packing_hash(from);
    if (spec->content && spec->content != content)
        return sp_fail(err, SP_EINVAL,
                       "packing.content = %llu: packing.file has changed, its number is %llu: must be this number, "
                       "or 0 for any",
                       (unsigned long long)spec->content, (unsigned long long)content);
    spec->cell = from->cell;
    spec->gravity = from->gravity;
    spec->dim = from->dim;
    spec->grains = from->n;
    spec->width = from->box[0];
    spec->depth = from->dim == 3 ? from->box[1] : 0;
    spec->diameter_min = low;
    spec->diameter_max = high;
    spec->content = content;
    return SP_OK;
}
