/* Inks, dashes and markers of curves. */
#include "figure/marks.h"

#include "figure/text.h"

#include <math.h>

colour sp_figure_ink(int k) {
    static const unsigned char okabe_ito[INKS][3] = {
        {0, 0, 0},       /* black */
        {0, 114, 178},   /* blue */
        {213, 94, 0},    /* vermilion */
        {0, 158, 115},   /* bluish green */
        {204, 121, 167}, /* reddish purple */
        {230, 159, 0},   /* orange */
        {86, 180, 233},  /* sky blue */
    };
    const unsigned char *rgb = okabe_ito[k % INKS];
    return (colour){rgb[0] / 255.0, rgb[1] / 255.0, rgb[2] / 255.0};
}

void sp_figure_dash(canvas *c, int dash) {
    static const double pattern[DASHES][4] = {{0}, {4.0, 2.0}, {1.2, 1.4}, {5.0, 1.6, 1.2, 1.6}};
    static const int parts[DASHES] = {0, 2, 2, 4};
    cairo_set_dash(c->cr, pattern[dash], parts[dash], 0.0);
}

double sp_marker_radius(double letters) { return 2.4 * fmin(1.0, letters / TEXT_LEGEND); }

/* The other shapes have about the circle's area. */
void sp_marker_draw_sized(canvas *c, marker shape, const double at[2], bool open, colour ink, double r) {
    const double x = at[0], y = at[1];
    cairo_t *cr = c->cr;
    cairo_new_path(cr);
    switch (shape) {
    case MARKER_NONE: return;
    case MARKER_DOT: cairo_arc(cr, x, y, 0.5 * r, 0.0, 6.283185307179586); break;
    case MARKER_CIRCLE: cairo_arc(cr, x, y, r, 0.0, 6.283185307179586); break;
    case MARKER_SQUARE: cairo_rectangle(cr, x - 0.89 * r, y - 0.89 * r, 1.78 * r, 1.78 * r); break;
    case MARKER_TRIANGLE:
        cairo_move_to(cr, x, y - 1.30 * r);
        cairo_line_to(cr, x + 1.13 * r, y + 0.75 * r);
        cairo_line_to(cr, x - 1.13 * r, y + 0.75 * r);
        break;
    case MARKER_DIAMOND:
        cairo_move_to(cr, x, y - 1.3 * r);
        cairo_line_to(cr, x + 1.1 * r, y);
        cairo_line_to(cr, x, y + 1.3 * r);
        cairo_line_to(cr, x - 1.1 * r, y);
        break;
    }
    cairo_close_path(cr);
    sp_canvas_colour(c, open ? (colour){1, 1, 1} : ink);
    cairo_fill_preserve(cr);
    sp_canvas_colour(c, ink);
    cairo_set_line_width(cr, 0.375 * r);
    cairo_stroke(cr);
}
