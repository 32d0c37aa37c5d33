#ifndef SP_VIEW_H
#define SP_VIEW_H
/* A packing on the canvas: grains and walls. One in three dimensions is seen in three views (solid.c). */

#include "figure/figure.h"

#include <sonopack/network.h>

/* Maps the packing to the canvas. across and up are the coordinates of a grain [d]. */
typedef struct view {
    canvas *c;
    const sp_packing *p;
    double scale;              /* points per diameter d */
    double left, floor;        /* lower left corner of the frame [pt] */
    double low, width, height; /* lateral start of the frame, width and height of the box [d] */
    double slant, span;        /* how far the top of a tilted box lies to the right; width of the frame [d] */
    double diameter;           /* mean diameter of the grains [d] */
    double below;              /* height of what is below the bottom wall [pt] */
    int axis, rise;            /* the axes of the packing that run across and upwards */
    bool periodic;             /* across */
    const double *shift;       /* [p->n][3] of the grains from where the packing has them [d]; NULL: none */
    bool tiled;                /* periodic upwards too, without walls */
    bool boxed;                /* with walls at the sides */
    bool above;                /* seen from above */
} view;

#define MARGIN 3.0  /* [pt] */
#define WALL   4.0  /* thickness of a wall [pt] */
#define KEY    15.0 /* height of the key below the bottom wall, if it has one line [pt] */
#define LINE   12.5 /* of each further line [pt] */

#define RATTLER_GREY ((colour){0.72, 0.72, 0.72})
#define GRAIN_GREY   ((colour){0.96, 0.96, 0.96})
#define RIM_GREY     ((colour){0.55, 0.55, 0.55})

/* A packing in 1 or 2 dimensions, with a key of so many lines. */
view sp_view_make(const sp_packing *p, int lines);
/* Height on the canvas of a line of the key, from 0. */
double sp_view_line(const view *v, int line);
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
/* Clips the canvas to the box and its walls. cairo_restore removes the clip. */
void sp_view_clip(const view *v);
/* The shift along an axis for a step along another of the lattice vectors of a tilted cell [d]. */
double sp_view_tilt(const sp_packing *p, int across, int rise);
/* The vertical axis of the canvas on which the frame begins, with its wall [pt]. */
double sp_view_top(const view *v);
/* Calls draw for a thing that spans from (x, y) to (x + dx, y + dy) on the canvas, and for its images at the periodic
 * edges that reach into the frame. */
typedef void view_draw(const view *v, double x, double y, double dx, double dy);
void sp_view_repeat(const view *v, double x, double y, double dx, double dy, view_draw *draw);
/* Opens the canvas for the view, with height for the key. */
sp_status sp_view_open(const view *v, const char *path, const char *title, sp_error *err);
/* Clips the canvas to the box and its walls, and draws the grains, with images at the periodic edges. fill[i]: colour
 * of grain i. sp_view_end removes the clip. */
void sp_view_begin(const view *v, const colour *fill);
void sp_view_end(const view *v);
/* Draws an arrow from (x, y) to (x + dx, y + dy) [pt] in the current colour. Arrows too short to see are left out. */
void sp_view_arrow(const view *v, double x, double y, double dx, double dy);
/* The same within the frame: an arrow that would cross a wall is moved along it until it does not, and one that crosses
 * a periodic edge comes in again at the other. */
void sp_view_arrow_inside(const view *v, double x, double y, double dx, double dy);
/* Says at the right of a line of the key how many rattlers there are. */
void sp_view_count_rattlers(const view *v, int line, int32_t rattlers);
/* Draws a line of this width [pt] from centre to centre, or to the wall, along the normal of a contact of a packing in
 * 1 or 2 dimensions. A contact across a periodic edge is drawn at both sides. */
void sp_view_link(const view *v, const sp_contact *k, double width);
/* A disc of the key. */
void sp_view_disc(const view *v, double x, double y, colour ink);
colour sp_view_mix(colour a, colour b, double part);

/* ---- three dimensions (solid.c) --------------------------------------------------------------------------------- */

enum { VIEWS = 3 };

/* Three views at one scale: along y (x runs across), beside it along -x (y runs across), and below the first from above
 * (x runs across, y upwards). The last one ends lowest. */
void sp_view_make_solid(const sp_packing *p, int lines, view v[VIEWS]);

/* How a grain is drawn. */
typedef struct view_mark {
    colour fill, ink; /* of the grain and of its arrow */
    double dx, dy;    /* arrow, y downwards [pt] */
    double from;      /* where the arrow's centre is on it: 0.5 in the middle, 0 at its start */
} view_mark;
/* A line from the centre of a grain. */
typedef struct view_link {
    int32_t grain;
    double reach[3]; /* to its other end [d] */
    double width;    /* [pt] */
    colour ink;
} view_link;
/* Draws walls, grains, links and arrows, each kind from the farthest to the nearest, the far ones paler. Grains are
 * drawn smaller than they are, so that those behind them can be seen. mark: [p->n], link: [links]. */
sp_status sp_view_draw_solid(const view *v, const view_mark *mark, int32_t links, const view_link *link, sp_error *err);
/* Says at the left of a line of the key what paleness means. */
void sp_view_explain_depth(const view *v, int line);
/* The line of a contact. */
view_link sp_view_link_of(const sp_packing *p, const sp_contact *k, double width, colour ink);

/* A figure of a packing: one view, or three in three dimensions, and a key below the first. */
typedef struct view_figure {
    const char *title;
    int lines; /* of the key, without that which explains depth */
    sp_status (*draw)(const view *v, const void *user, sp_error *err);
    void (*draw_key)(const view *v, const void *user);
    const void *user;
} view_figure;
/* The views of such a figure; those that it does not have are 0. */
void sp_view_make_all(const sp_packing *p, int lines, canvas *c, view v[VIEWS]);
/* Opens the canvas of these views, draws and closes it. */
sp_status sp_view_draw_all(const view v[VIEWS], const view_figure *f, const char *path, sp_error *err);
/* Component of a vector towards the viewer: that of a rotation is positive counterclockwise. */
double sp_view_towards(const view *v, const double *vector);

#endif
