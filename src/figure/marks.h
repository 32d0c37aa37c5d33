#ifndef SP_MARKS_H
#define SP_MARKS_H
/* Inks, dashes and markers of curves. The colours are those of Okabe and Ito (2008), which colour-blind readers can
 * distinguish. Markers and dashes differ as well, so that a figure can be read in grey. */

#include "figure/canvas.h"

#include <stdbool.h>

typedef enum marker {
    MARKER_NONE = 0,
    MARKER_CIRCLE,
    MARKER_SQUARE,
    MARKER_TRIANGLE,
    MARKER_DIAMOND,
    MARKER_DOT
} marker;
enum { DASH_NONE = -1, DASH_SOLID = 0, DASH_DASHED, DASH_DOTTED, DASH_DASH_DOT, DASHES };
enum { INKS = 7 };

/* Ink k modulo INKS; 0 is black. */
colour sp_figure_ink(int k);
/* Sets the dash pattern of the lines that follow. */
void sp_figure_dash(canvas *c, int dash);

/* Radius of a circle marker beside letters of a size [pt]. */
double sp_marker_radius(double letters);
/* The same with a given radius. */
void sp_marker_draw_sized(canvas *c, marker shape, const double at[2], bool open, colour ink, double radius);

#endif
