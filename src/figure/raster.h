#ifndef SP_RASTER_H
#define SP_RASTER_H
/* Which parts of a frame the data take, and where a box finds room among them. */

#include "figure/figure.h"

typedef struct box {
    double x, y, width, height; /* upper left corner and size [pt] */
} box;

typedef struct raster {
    double left, top, width, height; /* of the frame [pt] */
    int across, up;                  /* cells */
    uint8_t *taken;                  /* [up][across] */
    int32_t *sum;                    /* [up + 1][across + 1] taken cells above and left of a corner */
} raster;

/* A frame of the size of the canvas at the most; sp_raster_free is right after failure too. */
sp_status sp_raster_open(raster *r, const canvas *c, sp_error *err);
void sp_raster_free(raster *r);
/* The curves of a figure that is laid out, and further boxes. */
void sp_raster_mark(raster *r, const figure *f);
void sp_raster_mark_box(raster *r, const box *b);
/* Moves b to where it covers least, near a corner (upper ones and left ones first), and gives how many cells it
 * covers there; corners: nowhere else. INT32_MAX: it is larger than the frame. */
int32_t sp_raster_find(raster *r, box *b, double from_frame, bool corners);

#endif
