#ifndef SP_LEGEND_H
#define SP_LEGEND_H
/* The legend of a figure. */

#include "figure/figure.h"

typedef struct legend_box {
    double x, y, width, height; /* upper left corner and size [pt]; height 0: empty */
} legend_box;

/* Size of a legend of so many columns, and the drawing of it. */
legend_box sp_legend_size(const figure *f, int columns);
void sp_legend_draw_box(const figure *f, const legend_box *box, int columns);

#endif
