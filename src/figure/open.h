#ifndef SP_FIGURE_OPEN_H
#define SP_FIGURE_OPEN_H
/* Begins a figure: a canvas with the title that the reader wants. */

#include "figure/canvas.h"

/* Opens a canvas of this size, and higher by a title. What is drawn then begins below the title. Else as
 * sp_canvas_open.
 */
sp_status sp_figure_open(canvas *c, const char *path, const char *name, double width, double height, sp_error *err);

#endif
