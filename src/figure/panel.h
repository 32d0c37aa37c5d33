#ifndef SP_PANEL_H
#define SP_PANEL_H
/* One panel of a sheet: values as a figure, with places for tag, inset and legend. */

#include "figure/legend.h"
#include "figure/raster.h"

#include <sonopack/figure/figure.h>

typedef struct panel {
    sp_panel source;
    figure figure;
    series *series;
    double *memory;    /* arrays of all series */
    bool grows;        /* the y axis may be extended upwards */
    legend_box legend; /* height 0: no legend */
    int columns;       /* columns of the legend */
    rectangle tag, inset_box;
    struct panel *inset; /* NULL: no inset */
} panel;

/* k: number of the panel in its sheet; < 0: it is an inset, which has smaller letters. name: the panel in error
 * messages. Call sp_panel_free after failure too. */
sp_status sp_panel_make(panel *p, const sp_panel *source, int k, canvas *c, const char *name, sp_error *err);
void sp_panel_free(panel *p);
/* Finds places for the parts. The position and size of the axes must be set. */
sp_status sp_panel_layout(panel *p, sp_error *err);
void sp_panel_draw(panel *p);

#endif
