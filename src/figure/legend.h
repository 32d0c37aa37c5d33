#ifndef SP_LEGEND_H
#define SP_LEGEND_H
/* The legend of a figure and the search for a place where it covers no data. */

#include "figure/figure.h"

typedef struct legend_box {
    double x, y, width, height; /* upper left corner and size [pt]; height 0: empty */
    int64_t covers;             /* parts of the data that it hides; 0 where a free place was found */
} legend_box;

/* Free corners for the groups; if there are none, the y axis grows upwards until there are. */
void sp_legend_place(figure *f, legend_box box[LEGEND_GROUPS]);
/* Rows of entries in so many columns, as the sheet places them: their size, and all groups drawn as one. */
legend_box sp_legend_size(const figure *f, int columns);
void sp_legend_draw_box(const figure *f, const legend_box *box, int columns);
void sp_legend_draw(const figure *f, const legend_box box[LEGEND_GROUPS]);

#endif
