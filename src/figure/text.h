#ifndef SP_PLOT_TEXT_H
#define SP_PLOT_TEXT_H
/* Texts on the canvas. The smallest letters have 7 pt, in insets 6 pt. */

#include "figure/canvas.h"
#include "figure/markup.h"

/* Font sizes [pt]: tick and axis labels, legends, subscripts and superscripts. */
#define TEXT_LABEL  9.0
#define TEXT_LEGEND 8.0
#define TEXT_SCRIPT 7.0
#define TEXT_SMALL  6.0 /* subscripts and superscripts in an inset */

typedef struct text_style {
    double size;   /* pt */
    double across; /* 0: x is the left end, 0.5: the middle, 1: the right end */
    double up;     /* 0: y is the baseline, 0.5: the middle of a capital, 1: its top */
    double angle;  /* anticlockwise, radians */
} text_style;

double sp_figure_text_width(canvas *c, const char *markup, double size);
void sp_figure_text_draw(canvas *c, const char *markup, double x, double y, text_style style);

#endif
