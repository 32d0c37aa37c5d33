#ifndef SP_RASTER_H
#define SP_RASTER_H
/* The cells of a frame that data cover, and the search for a free place for a rectangle. */

#include "figure/figure.h"

typedef struct rectangle {
    double x, y, width, height; /* upper left corner and size [pt] */
} rectangle;

typedef struct raster {
    double left, top, width, height; /* frame [pt] */
    int across, up;                  /* number of cells */
    uint8_t *taken;                  /* [up][across] */
    int32_t *sum;                    /* [up + 1][across + 1] number of covered cells above and left of a corner */
} raster;

/* The part of the segment start + s delta, 0 <= s <= 1, inside a rectangle (Liang-Barsky): *from <= s <= *to. False if
 * it is outside. */
bool sp_clip_segment(const double low[2], const double high[2], const double start[2], const double delta[2],
                     double *from, double *to);

/* Allocates cells for a frame no larger than the canvas. Call sp_raster_free after failure too. */
sp_status sp_raster_open(raster *r, const canvas *c, sp_error *err);
void sp_raster_free(raster *r);
/* Marks the curves of a figure whose axes are laid out; marks one more rectangle. */
void sp_raster_mark(raster *r, const figure *f);
void sp_raster_mark_box(raster *r, const rectangle *b);
/* Moves b to the place where it covers the fewest cells, near a corner, with a preference for upper and left ones.
 * corners: in a corner only. Returns the number of cells that it covers, INT32_MAX if it is larger than the frame. */
int32_t sp_raster_find(raster *r, rectangle *b, double from_frame, bool corners);

#endif
