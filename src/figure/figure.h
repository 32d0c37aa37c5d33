#ifndef SP_FIGURE_H
#define SP_FIGURE_H
/* Series on axes, with a legend where it hides nothing. Colours are those of Okabe and Ito (2008), which the
 * colour-blind tell apart; markers and dashes differ too, so that the figure reads in grey. */

#include "figure/axes.h"

#include <stdint.h>

typedef enum marker {
    MARKER_NONE = 0,
    MARKER_CIRCLE,
    MARKER_SQUARE,
    MARKER_TRIANGLE,
    MARKER_DIAMOND,
    MARKER_DOT
} marker;
enum { DASH_NONE = -1, DASH_SOLID = 0, DASH_DASHED, DASH_DOTTED, DASH_DASH_DOT, DASHES };
enum { INKS = 7, LEGEND_GROUPS = 2 }; /* sp_figure_ink(0) is black */

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

colour sp_figure_ink(int k);
/* Lays out (the y axis grows upwards if the legend finds no free corner) and draws everything. */
void sp_figure_draw(figure *f);

/* Everything but the legend, on axes that are laid out. */
void sp_figure_paint(const figure *f);

/* The points of a series as a cloud of dots, by their number the smaller and the lighter; an image in every format. */
void sp_figure_dots(const figure *f, const series *s);

/* Parts that other drawings use. */
void sp_figure_dash(canvas *c, int dash);
/* Half the size of a marker beside letters of a size. */
double sp_marker_radius(double letters);
void sp_marker_draw(canvas *c, marker shape, double x, double y, bool open, colour ink);
void sp_marker_draw_sized(canvas *c, marker shape, const double at[2], bool open, colour ink, double radius);

#endif
