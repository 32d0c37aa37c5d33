#ifndef SP_FIGURE_H
#define SP_FIGURE_H
/* Series of points on axes, with a legend where it hides no data. */

#include "figure/axes.h"
#include "figure/marks.h"

#include <stdint.h>

enum { LEGEND_GROUPS = 2 };

typedef struct series {
    int64_t n;
    const double *x, *y;                /* [n] axis units; not finite: a gap */
    const double *low, *high;           /* [n] ends of error bars, axis units; NULL: none */
    const double *fill_low, *fill_high; /* [n] ends of a light band, axis units; NULL: none */
    colour ink;
    int dash; /* DASH_NONE: no line */
    double width;
    marker marker;
    marker key;        /* in the legend, of a series without marks */
    bool open;         /* a marker filled with white */
    const char *label; /* markup for the legend; NULL: not in it */
    int group;         /* 0 .. LEGEND_GROUPS-1: each group of labels finds its own corner */
} series;

typedef struct figure {
    canvas *canvas;
    axes axes;
    int n;
    const series *series;
    bool zero_line; /* a thin line at y = 0 */
    double legend;  /* size of the legend's letters [pt]; 0: TEXT_LEGEND */
} figure;

/* Lays out (the y axis grows upwards if the legend finds no free corner) and draws everything. */
void sp_figure_draw(figure *f);

/* Everything but the legend, on axes that are laid out. */
void sp_figure_paint(const figure *f);

/* The points of a series as a cloud of dots, by their number the smaller and the lighter; an image in every format. */
void sp_figure_dots(const figure *f, const series *s);

#endif
