#ifndef SP_PLOT_COLUMN_VIEW_H
#define SP_PLOT_COLUMN_VIEW_H
/* A surface over two axes, seen from the front, the right and above, without perspective. */

#include "figure/figure.h"

/* y [columns][rows] over time t [rows] and label z [columns], both rising; shade [columns][rows] in -1 .. 1 or 0 .. 1
 * picks the colour. Not finite: a hole. */
typedef struct surface {
    int rows, columns;
    const double *t, *z, *y, *shade;
    bool is_signed;
    const double *floor; /* y of a line at z = floor_at; NULL: none */
    double floor_at;
    int every_t, every_z; /* lines of the mesh */
} surface;

typedef struct scene3 {
    canvas *c;
    double left, top, width, height; /* the part of the canvas [pt] */
    double letters;                  /* size [pt] */
    axis time, label, height_axis;   /* limits and names; ticks are chosen */
    double scale, x0, y0;            /* canvas of the origin, and points a unit */
} scene3;

/* Ticks, scale and origin for the part of the canvas. */
void sp_scene3_layout(scene3 *s);
/* Walls with the lines of the ticks behind the surface, the surface, and ticks and names in front. */
void sp_scene3_draw(const scene3 *s, const surface *f);
/* Light grey at 0, towards red at 1 and blue at -1; or light yellow at 0 to dark blue at 1. */
colour sp_scene3_signed_colour(double part);
colour sp_scene3_colour(double part);

#endif
