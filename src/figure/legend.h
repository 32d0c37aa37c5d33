#ifndef SP_LEGEND_H
#define SP_LEGEND_H
/* The legend of a figure, placed where it covers no data. */

#include "figure/figure.h"

typedef struct legend_box {
    double x, y, width, height; /* upper left corner and size [pt]; height 0: empty */
    int64_t covers;             /* number of data elements that it hides; 0: it is in a free place */
} legend_box;

/* Finds free corners for the groups. If there are none, the y axis is extended upwards. */
void sp_legend_place(figure *f, legend_box box[LEGEND_GROUPS]);
/* Size of a legend with all groups in one box of so many columns, and the drawing of it. */
legend_box sp_legend_size(const figure *f, int columns);
void sp_legend_draw_box(const figure *f, const legend_box *box, int columns);
void sp_legend_draw(const figure *f, const legend_box box[LEGEND_GROUPS]);

#endif
