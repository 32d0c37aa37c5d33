#ifndef SP_FIGURE_TAPPED_VIEW_H
#define SP_FIGURE_TAPPED_VIEW_H
/* A surface over two axes in parallel projection, seen from the front right and above. */

#include "figure/figure.h"

/* y [columns][rows] over time t [rows] and label z [columns], both ascending. shade [columns][rows], in -1 .. 1 or 0 ..
 * 1, selects the colour. Cells with values that are not finite are left out. */
typedef struct surface {
    int rows, columns;
    const double *t, *z, *y, *shade;
    bool is_signed;
    const double *floor; /* y of a line at z = floor_at; NULL: none */
    double floor_at;
    int every_t, every_z; /* mesh lines at every n-th row and column */
} surface;

typedef struct scene3 {
    canvas *c;
    double left, top, width, height; /* area of the canvas [pt] */
    double letters;                  /* font size [pt] */
    axis time, label, height_axis;   /* limits and names are given; the layout chooses the ticks */
    double scale, x0, y0;            /* points per unit; position of the origin */
} scene3;

/* Chooses ticks, scale and origin for the area. */
void sp_scene3_layout(scene3 *s);
/* Draws the walls with the grid lines, the surface, and the axes in front. */
void sp_scene3_draw(const scene3 *s, const surface *f);
/* Removes the ticks that are not at whole numbers, or below low. */
void sp_axis_keep_whole_ticks(axis *a, double low);
/* Colours of a value, whose lightness tells them apart in grey too. Signed: from dark blue at -1 over grey at 0 to
 * light yellow at 1. Unsigned: from light yellow at 0 to dark blue at 1. */
colour sp_scene3_signed_colour(double part);
colour sp_scene3_colour(double part);

#endif
