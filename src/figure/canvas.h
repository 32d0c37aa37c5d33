#ifndef SP_CANVAS_H
#define SP_CANVAS_H
/* A white canvas for cairo, held in memory until it is complete. The ending of the path selects PNG (300 dpi), SVG or
 * PDF. Lengths are points (1/72 inch), y points downwards. */

#include <cairo.h>
#include <locale.h>
#include <sonopack/status.h>
#include <stddef.h>

/* A growing buffer; `failed` is set when memory runs out. */
typedef struct bytes {
    char *data;
    size_t size, capacity;
    int failed;
} bytes;

typedef enum canvas_kind { CANVAS_PNG = 0, CANVAS_SVG, CANVAS_PDF } canvas_kind;

typedef struct canvas {
    canvas_kind kind;
    const char *path, *title;
    double width, height; /* pt */
    cairo_surface_t *surface;
    cairo_t *cr;
    bytes file;             /* content of the file */
    locale_t plain, before; /* locale with a decimal point while the canvas is open */
    bytes
        words; /* all texts of the figure, one per line: SVG draws glyphs as outlines, so this makes them searchable */
} canvas;

typedef struct colour {
    double r, g, b;
} colour;

/* Column width of Physical Review [pt]. */
#define CANVAS_COLUMN (8.6 / 2.54 * 72.0)

/* Checks that a figure can be written to path: a known ending, a writable folder, and no folder or device in its place.
 * SP_EINVAL or SP_EIO. */
sp_status sp_canvas_check(const char *path, sp_error *err);
/* path and title must outlive the canvas. Call sp_canvas_free after failure too. */
sp_status sp_canvas_open(canvas *c, const char *path, const char *title, double width, double height, sp_error *err);
/* Finishes the drawing and writes the file at once. Reports any error of cairo during drawing. */
sp_status sp_canvas_save(canvas *c, sp_error *err);
/* Ends the use of a canvas: writes the file if status is SP_OK, and frees the canvas. Returns the status. */
sp_status sp_canvas_close(canvas *c, sp_status status, sp_error *err);
void sp_canvas_free(canvas *c);

void sp_canvas_colour(canvas *c, colour ink);
/* Adds a text to the description of an SVG file. */
void sp_canvas_word(canvas *c, const char *text);

#endif
