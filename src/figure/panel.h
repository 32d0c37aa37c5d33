#ifndef SP_PANEL_H
#define SP_PANEL_H
/* One panel of a sheet: from values to a figure, with room for its tag, inset and legend. */

#include "figure/legend.h"
#include "figure/raster.h"

#include <sonopack/figure/figure.h>

typedef struct panel {
    sp_panel source;
    figure figure;
    series *series;
    double *memory;    /* all arrays of the series */
    bool grows;        /* the upper end of y may move to make room */
    legend_box legend; /* height 0: none */
    int columns;       /* of the legend */
    box tag, inset_box;
    struct panel *inset; /* NULL: none */
} panel;

/* name: of the panel in errors. inset: smaller letters. sp_panel_free is right after failure too. */
sp_status sp_panel_make(panel *p, const sp_panel *source, canvas *c, bool inset, const char *name, sp_error *err);
void sp_panel_free(panel *p);
/* Finds places for the parts on axes whose part of the canvas is set. */
sp_status sp_panel_layout(panel *p, sp_error *err);
void sp_panel_draw(panel *p);

#endif
