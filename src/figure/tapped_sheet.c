/* Draws panels below each other, with two features that sp_plot_sheet lacks: ticks at whole numbers only, and a note.
 */
#include "figure/open.h"
#include "figure/panel.h"
#include "figure/tapped_table.h"
#include "figure/tapped_view.h"

#include "base/base.h"
#include "figure/look.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { PANELS_MOST = 4 };
#define NOTE 10.0 /* height of a line of the note [pt] */
#define EDGE 3.0  /* around the note [pt] */

typedef struct sheet {
    const tapped_sheet *source;
    canvas canvas;
    panel panel[PANELS_MOST];
} sheet;

static sp_status make_panels(sheet *s, double height, sp_error *err) {
    sp_status status = SP_OK;
    for (int k = 0; k < s->source->panels && status == SP_OK; k++) {
        char name[64];
        snprintf(name, sizeof name, "panel %d", k + 1);
        sp_panel one = s->source->panel[k];
        status = sp_look_apply(&one, k, err);
        if (status == SP_OK)
            status = sp_panel_make(&s->panel[k], &one, k, &s->canvas, name, err);
        axes *a = &s->panel[k].figure.axes;
        a->top = k * height;
        a->width = CANVAS_COLUMN;
        a->height = height;
        a->x.size = a->y.size = TEXT_LABEL;
    }
    return status;
}

/* Lays out the panels so that all frames have the same left and right edges. */
static sp_status layout(sheet *s, sp_error *err) {
    sp_status status = SP_OK;
    for (int pass = 0; pass < 2; pass++) {
        double left = 0, right = 0;
        for (int k = 0; k < s->source->panels && status == SP_OK; k++) {
            const axes *a = &s->panel[k].figure.axes;
            status = sp_panel_layout(&s->panel[k], err);
            left = fmax(left, a->x.from);
            right = fmax(right, a->width - a->x.to);
        }
        for (int k = 0; k < s->source->panels; k++) {
            s->panel[k].figure.axes.margin[0] = left;
            s->panel[k].figure.axes.margin[1] = right;
        }
    }
    for (int k = 0; k < s->source->panels && s->source->whole; k++) {
        axis *x = &s->panel[k].figure.axes.x;
        if (x->power == 0)
            sp_axis_keep_whole_ticks(x, -INFINITY); /* there is nothing between one tap and the next */
    }
    return status;
}

static double note_height(const char *note) {
    double height = *note ? NOTE + EDGE : 0;
    for (; *note; note++)
        height += *note == '\n' ? NOTE : 0;
    return height;
}

/* Draws the lines of a note below each other, from the left edge; a line longer than the figure is wide gets smaller
 * letters. */
static void draw_note(canvas *c, const char *note, double top) {
    sp_canvas_colour(c, (colour){0, 0, 0});
    for (double y = top + NOTE - 2; *note; y += NOTE) {
        char line[2 * TAPPED_LABEL];
        const size_t length = strcspn(note, "\n");
        snprintf(line, sizeof line, "%.*s", (int)length, note);
        const double width = sp_figure_text_width(c, line, TEXT_SCRIPT), room = c->width - 2 * EDGE;
        const double size = width > room ? TEXT_SCRIPT * room / width : TEXT_SCRIPT;
        sp_figure_text_draw(c, line, EDGE, y, (text_style){size, 0.0, 0.0, 0.0});
        note += length + (note[length] == '\n');
    }
}

static sp_status draw(sheet *s, const char *path, sp_error *err) {
    const char *note = s->source->note ? s->source->note : "";
    const double height = s->source->aspect * CANVAS_COLUMN, all = s->source->panels * height;
    canvas *c = &s->canvas;
    sp_status status = sp_figure_open(c, path, s->source->title, CANVAS_COLUMN, all + note_height(note), err);
    if (status == SP_OK)
        status = make_panels(s, height, err);
    if (status == SP_OK)
        status = layout(s, err);
    if (status != SP_OK)
        return status;
    for (int k = 0; k < s->source->panels; k++)
        sp_panel_draw(&s->panel[k]);
    draw_note(c, note, all);
    return sp_canvas_save(c, err);
}

sp_status sp_tapped_draw_sheet(const tapped_sheet *source, const char *path, sp_error *err) {
    sheet *s = sp_alloc(1, sizeof *s);
    if (!s)
        return sp_fail_memory(err, sizeof *s);
    *s = (sheet){.source = source};
    const sp_status status = draw(s, path, err);
    for (int k = 0; k < source->panels; k++)
        sp_panel_free(&s->panel[k]);
    sp_canvas_free(&s->canvas);
    sp_free(s);
    return status;
}
