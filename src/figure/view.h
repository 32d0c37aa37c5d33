#ifndef SP_VIEW_H
#define SP_VIEW_H
/* A 1D or 2D packing on the canvas: its grains and walls. */

#include "figure/figure.h"

#include <sonopack/network.h>

/* Where packing and canvas meet. across and up are a grain's coordinates, in diameters d. */
typedef struct view {
    canvas *c;
    const sp_packing *p;
    double scale;              /* pt a diameter */
    double left, floor;        /* of the box's lower left corner [pt] */
    double low, width, height; /* lateral start and width, and height of the box [d] */
    double diameter;           /* mean of the grains [d] */
    bool periodic;
} view;

#define MARGIN 3.0  /* [pt] */
#define WALL   4.0  /* thickness of a wall [pt] */
#define KEY    15.0 /* line of text below the bottom wall [pt] */

#define RATTLER_GREY ((colour){0.72, 0.72, 0.72})
#define GRAIN_GREY   ((colour){0.96, 0.96, 0.96})
#define RIM_GREY     ((colour){0.55, 0.55, 0.55})

view sp_view_make(const sp_packing *p);
/* Whether a packing can be drawn in that file. */
sp_status sp_view_check(const sp_packing *p, const char *path, sp_error *err);
/* Whether displacements u of a network can be drawn on this packing, in that file; `of' them is said where they are not
 * finite. */
sp_status sp_view_check_field(const sp_packing *p, const sp_network *net, const double *u, const char *of,
                              const char *path, sp_error *err);
/* A grain's coordinates within the box [d]. */
double sp_view_across(const view *v, int32_t i);
double sp_view_up(const view *v, int32_t i);
/* The same on the canvas. */
double sp_view_x(const view *v, double across);
double sp_view_y(const view *v, double up);
/* Grains with their images at the periodic edges, each of its colour. */
void sp_view_grains(const view *v, const colour *fill);
void sp_view_walls(const view *v);
/* From (x, y) to (x + dx, y + dy) [pt], in the colour that is set; one too short to be seen is not drawn. */
void sp_view_arrow(const view *v, double x, double y, double dx, double dy);

#endif
