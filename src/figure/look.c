/* Keeps the look that a thread asks for, and applies it to panels. */
#include "figure/look.h"

#include "base/base.h"

#include <math.h>

static const sp_plot_look plain = {.x = {NAN, NAN}, .y = {NAN, NAN}};
/* Passing a look through every function that draws would add an argument to each, which nearly all callers leave out.
 */
static _Thread_local sp_plot_look wanted = {.x = {NAN, NAN}, .y = {NAN, NAN}};

sp_plot_look sp_plot_look_default(void) { return plain; }

void sp_plot_set_look(const sp_plot_look *look) { wanted = look ? *look : plain; }

const sp_plot_look *sp_look(void) { return &wanted; }

static sp_status apply(sp_axis *a, const double limits[2], sp_plot_scale scale, char which, sp_error *err) {
    const bool given[2] = {!isnan(limits[0]), !isnan(limits[1])};
    if ((given[0] && given[1] && limits[0] >= limits[1]) || isinf(limits[0]) || isinf(limits[1]))
        return sp_fail(err, SP_EINVAL, "look.%c %g:%g: must be finite, and the first below the second", which,
                       limits[0], limits[1]);
    if (scale != SP_PLOT_SCALE_OWN)
        a->log = scale == SP_PLOT_SCALE_LOG;
    if ((given[0] || given[1]) && a->low == 0 && a->high == 0)
        a->low = a->high = NAN;
    if (given[0])
        a->low = limits[0];
    if (given[1])
        a->high = limits[1];
    for (int k = 0; k < 2 && a->log; k++)
        if (given[k] && limits[k] <= 0)
            return sp_fail(err, SP_EINVAL, "look.%c %g: must be above 0 on a logarithmic axis", which, limits[k]);
    /* a limit of the figure's own gives way: it was chosen for the other scale, or lies beyond that of the reader */
    const bool turned = scale == SP_PLOT_SCALE_LOG;
    if (!given[0] && ((turned && a->low <= 0) || (given[1] && a->low >= a->high)))
        a->low = NAN;
    if (!given[1] && ((turned && a->high <= 0) || (given[0] && a->low >= a->high)))
        a->high = NAN;
    return SP_OK;
}

sp_status sp_look_apply(sp_panel *panel, int k, sp_error *err) {
    sp_status status = apply(&panel->x, wanted.x, wanted.x_scale, 'x', err);
    if (status == SP_OK && k == 0)
        status = apply(&panel->y, wanted.y, wanted.y_scale, 'y', err);
    return status;
}

bool sp_look_has_axes(void) {
    bool any = wanted.x_scale != SP_PLOT_SCALE_OWN || wanted.y_scale != SP_PLOT_SCALE_OWN;
    for (int k = 0; k < 2; k++)
        any = any || !isnan(wanted.x[k]) || !isnan(wanted.y[k]);
    return any;
}

bool sp_look_is_log(char which, int k) {
    return which == 'x' ? wanted.x_scale == SP_PLOT_SCALE_LOG : k == 0 && wanted.y_scale == SP_PLOT_SCALE_LOG;
}
