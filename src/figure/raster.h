#ifndef SP_RASTER_H
#define SP_RASTER_H
/* The cells of a frame that data cover, and the search for a free place for a box. */

#include "figure/figure.h"

typedef struct box {
    double x, y, width, height; /* upper left corner and size [pt] */
} box;

typedef struct raster {
    double left, top, width, height; /* frame [pt] */
    int across, up;                  /* number of cells */
    uint8_t *taken;                  /* [up][across] */
    int32_t *sum;                    /* [up + 1][across + 1] number of covered cells above and left of a corner */
} raster;

/* Allocates cells for a frame no larger than the canvas. Call sp_raster_free after failure too. */
sp_status sp_raster_open(raster *r, const canvas *c, sp_error *err);
void sp_raster_free(raster *r);
/* Marks the curves of a figure whose axes are laid out; marks one more box. */
void sp_raster_mark(raster *r, const figure *f);
void sp_raster_mark_box(raster *r, const box *b);
/* Moves b to the place where it covers the fewest cells, near a corner, with a preference for upper and left ones.
 * corners: in a corner only. Returns the number of cells that it covers, INT32_MAX if it is larger than the frame. */
int32_t sp_raster_find(raster *r, box *b, double from_frame, bool corners);

#endif
