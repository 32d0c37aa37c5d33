#ifndef SP_FIGURE_LOOK_H
#define SP_FIGURE_LOOK_H
/* Applies the look of the calling thread to the figures that it draws. */

#include <sonopack/figure/figure.h>
#include <sonopack/figure/look.h>

const sp_plot_look *sp_look(void);

/* Gives panel k of a sheet the limits and scales of the look. */
sp_status sp_look_apply(sp_panel *panel, int k, sp_error *err);
/* Whether the look has limits or scales of axes. */
bool sp_look_has_axes(void);
/* Whether the look sets the scale of an axis of panel k to logarithmic: which is 'x' or 'y'. */
bool sp_look_is_log(char which, int k);

#endif
