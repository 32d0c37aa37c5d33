#ifndef SP_VIEW_H
#define SP_VIEW_H
/* A 1D or 2D packing on the canvas: grains and walls. */

#include "figure/figure.h"

#include <sonopack/network.h>

/* Maps the packing to the canvas. across and up are the coordinates of a grain [d]. */
typedef struct view {
    canvas *c;
    const sp_packing *p;
    double scale;              /* points per diameter d */
    double left, floor;        /* lower left corner of the box [pt] */
    double low, width, height; /* lateral start and width, and height of the box [d] */
    double diameter;           /* mean diameter of the grains [d] */
    bool periodic;
} view;

#define MARGIN 3.0  /* [pt] */
#define WALL   4.0  /* thickness of a wall [pt] */
#define KEY    15.0 /* height of the key below the bottom wall [pt] */

#define RATTLER_GREY ((colour){0.72, 0.72, 0.72})
#define GRAIN_GREY   ((colour){0.96, 0.96, 0.96})
#define RIM_GREY     ((colour){0.55, 0.55, 0.55})

view sp_view_make(const sp_packing *p);
/* Checks that a packing can be drawn in the file path. */
sp_status sp_view_check(const sp_packing *p, const char *path, sp_error *err);
/* Checks that displacements u of a network can be drawn on a packing. `of' names them in the message. */
sp_status sp_view_check_field(const sp_packing *p, const sp_network *net, const double *u, const char *of,
                              const char *path, sp_error *err);
/* Coordinates of a grain within the box [d]. */
double sp_view_across(const view *v, int32_t i);
double sp_view_up(const view *v, int32_t i);
/* Positions on the canvas [pt]. */
double sp_view_x(const view *v, double across);
double sp_view_y(const view *v, double up);
void sp_view_walls(const view *v);
/* Opens the canvas for the view, with height for the key. */
sp_status sp_view_open(const view *v, const char *path, const char *title, sp_error *err);
/* Clips the canvas to the box and its walls, and draws the grains, with images at the periodic edges. fill[i]: colour
 * of grain i. sp_view_end removes the clip. */
void sp_view_begin(const view *v, const colour *fill);
void sp_view_end(const view *v);
/* Draws an arrow from (x, y) to (x + dx, y + dy) [pt] in the current colour. Arrows too short to see are left out. */
void sp_view_arrow(const view *v, double x, double y, double dx, double dy);

#endif
