/* Warns of boxes so low that walls decide everything, and of packings in which most grains carry nothing. */
#include "cli/low_box.h"

#include <math.h>
#include <sonopack/cost.h>

static const double lowest = 6, usual = 12; /* heights [d] */

void cli_warn_low_box(const cli_common *common, const sp_pack_spec *spec) {
    const sp_machine machine = sp_machine_reference();
    const double height = sp_packing_expect(spec, 1, &machine).height;
    if (spec->kind != SP_PACK_PISTON || spec->dim < 2 || height >= lowest)
        return;
    const double depth = spec->depth > 0 ? spec->depth : spec->width, area = spec->width * (spec->dim == 3 ? depth : 1);
    const double narrow = spec->dim == 3 ? sqrt(area * height / usual) : area * height / usual;
    const double grains = ceil(spec->grains * usual / height / 100) * 100;
    if (narrow >= 4 * fmax(1, spec->diameter_max))
        cli_note(common,
                 "warning: the box will be about %.1f d high, less than %g: sound has no room between the walls; %g d "
                 "need packing.grains = %.0f, or packing.width = %.2g",
                 height, lowest, usual, grains, narrow);
    else
        cli_note(common,
                 "warning: the box will be about %.1f d high, less than %g: sound has no room between the walls; %g d "
                 "need packing.grains = %.0f",
                 height, lowest, usual, grains);
}

static double mean_diameter(const sp_packing *p) {
    double sum = 0;
    for (int32_t i = 0; i < p->n; i++)
        sum += 2 * p->r[i];
    return sum / p->n;
}

void cli_warn_packing(const cli_common *common, const char *path, const sp_packing *p, const sp_network *net) {
    const double height = sp_packing_height(p) / mean_diameter(p);
    if (p->dim < 2)
        return;
    if (2 * net->n < net->n_all)
        cli_note(common, "%s: warning: %d of %d grains are rattlers, which carry nothing: results are those of a few",
                 path, net->rattlers, net->n_all);
    else if (height < lowest && p->cell != SP_CELL_PERIODIC) /* which has no walls that could decide */
        cli_note(common, "%s: warning: the box is %.3g diameters high, less than %g: results are those of the walls",
                 path, height, lowest);
}
