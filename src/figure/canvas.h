#ifndef SP_CANVAS_H
#define SP_CANVAS_H
/* A white sheet to draw on with cairo, kept in memory until it is whole; the path's ending says PNG (300 dpi), SVG or
 * PDF. Lengths are points (1/72 inch), y downwards. */

#include <cairo.h>
#include <locale.h>
#include <sonopack/status.h>
#include <stddef.h>

/* A growing run of bytes; `failed` once memory was short. */
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
    bytes file;             /* what is written in the end */
    locale_t plain, before; /* numbers have a decimal point while the canvas is open */
    bytes words;            /* all texts of the figure, a line each: searchable in SVG, whose glyphs are outlines */
} canvas;

typedef struct colour {
    double r, g, b;
} colour;

/* Single column of Physical Review. */
#define CANVAS_COLUMN (8.6 / 2.54 * 72.0)

/* Whether a figure could be written there: a known ending, a folder that may be written to, nothing but a plain file
 * in its place. SP_EINVAL or SP_EIO before any drawing. */
sp_status sp_canvas_check(const char *path, sp_error *err);
/* path and title must outlive the canvas. sp_canvas_free is right after failure too. */
sp_status sp_canvas_open(canvas *c, const char *path, const char *title, double width, double height, sp_error *err);
/* Finishes the drawing and writes the file as a whole. Any failure of cairo's while drawing is reported here. */
sp_status sp_canvas_save(canvas *c, sp_error *err);
void sp_canvas_free(canvas *c);

void sp_canvas_colour(canvas *c, colour ink);
/* Keeps a text for SVG's description. */
void sp_canvas_word(canvas *c, const char *text);

#endif
