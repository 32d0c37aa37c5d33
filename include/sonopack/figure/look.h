#ifndef SONOPACK_LOOK_H
#define SONOPACK_LOOK_H
/* How a reader wants figures to look: title, limits and scales of the axes, published lines. A look holds for all
 * figures that the calling thread draws, whichever function draws them, until it sets another. */

#include <sonopack/status.h>
#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum sp_plot_scale { SP_PLOT_SCALE_OWN = 0, SP_PLOT_SCALE_LINEAR, SP_PLOT_SCALE_LOG } sp_plot_scale;
/* SP_PLOT_PUBLISHED_WHERE_IT_APPLIES: over data that say that they have the dimension and the units of the paper. */
typedef enum sp_plot_published {
    SP_PLOT_PUBLISHED_WHERE_IT_APPLIES = 0,
    SP_PLOT_PUBLISHED_ALWAYS,
    SP_PLOT_PUBLISHED_NEVER
} sp_plot_published;

typedef struct sp_plot_look {
    const char *title;              /* plain text above the figure; NULL: none */
    double x[2], y[2];              /* limits of the axes, in their units; NAN: from the data */
    sp_plot_scale x_scale, y_scale; /* SP_PLOT_SCALE_OWN: as the kind of figure has it */
    sp_plot_published published;
} sp_plot_look;

/* No title, limits from the data, scales and published lines as each kind of figure has them. */
SP_API sp_plot_look sp_plot_look_default(void);
/* Sets the look of the figures that this thread draws from now on; NULL: the default. The title must outlive it. Limits
 * and scale of x apply to all panels of a figure, those of y to the first; insets keep their own. What draws a figure
 * returns SP_EINVAL, with a reason that begins with "look.", if the look does not suit the data: limits not in rising
 * order, or negative numbers on a logarithmic axis. */
SP_API void sp_plot_set_look(const sp_plot_look *look);

#ifdef __cplusplus
}
#endif
#endif
