#ifndef SP_FIGURE_H
#define SP_FIGURE_H
/* Series of points on axes. */

#include "figure/axes.h"
#include "figure/marks.h"

#include <stdint.h>

typedef struct series {
    int64_t n;
    const double *x, *y;                /* [n] axis units; a value that is not finite makes a gap */
    const double *low, *high;           /* [n] ends of error bars, axis units; NULL: none */
    const double *fill_low, *fill_high; /* [n] ends of a light band, axis units; NULL: none */
    colour ink;
    int dash; /* DASH_NONE: no line */
    double width;
    marker marker;
    bool open;         /* markers are filled with white */
    const char *label; /* legend entry, markup; NULL: none */
} series;

typedef struct figure {
    canvas *canvas;
    axes axes;
    int n;
    const series *series;
    bool zero_line; /* draw a thin line at y = 0 */
    double legend;  /* letter size of the legend [pt]; 0: TEXT_LEGEND */
} figure;

/* Draws everything but the legend. The axes must be laid out. */
void sp_figure_paint(const figure *f);

/* Draws the points of a series as a cloud of dots, as an image in every format. The more points, the smaller and
 * lighter the dots. */
void sp_figure_dots(const figure *f, const series *s);

#endif
