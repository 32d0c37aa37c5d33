/* Opens the canvas of a figure and draws the reader's title. */
#include "figure/open.h"

#include "figure/look.h"
#include "figure/text.h"

#define HEAD 16.0 /* height of the title [pt] */

/* Centred above the figure: with smaller letters, then shortened, if it is long. */
static void draw_title(canvas *c, const char *title) {
    const double least = 6.0, room = c->width - 8.0;
    char text[1024];
    double size = TEXT_LABEL;
    for (int most = 200; most >= 10; most -= 2) {
        sp_figure_text_escape(text, sizeof text, title, most);
        const double width = sp_figure_text_width(c, text, TEXT_LABEL);
        size = width > room ? TEXT_LABEL * room / width : TEXT_LABEL;
        if (size >= least)
            break;
    }
    sp_figure_text_draw(c, text, 0.5 * c->width, 0.5 * HEAD + 1.0, (text_style){size, 0.5, 0.5, 0.0});
}

sp_status sp_figure_open(canvas *c, const char *path, const char *name, double width, double height, sp_error *err) {
    const char *title = sp_look()->title;
    const sp_status status = sp_canvas_open(c, path, name, width, height + (title ? HEAD : 0.0), err);
    if (status != SP_OK || !title)
        return status;
    draw_title(c, title);
    cairo_translate(c->cr, 0.0, HEAD);
    c->height = height;
    return SP_OK;
}
