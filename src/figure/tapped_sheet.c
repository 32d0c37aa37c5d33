/* Draws panels below each other, with two features that sp_plot_sheet lacks: ticks at whole numbers only, and a note.
 */
#include "figure/panel.h"
#include "figure/tapped_table.h"
#include "figure/tapped_view.h"

#include "base/base.h"

#include <math.h>
#include <stdio.h>

enum { PANELS_MOST = 4 };
#define NOTE 12.0 /* height of the note [pt] */

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
        status = sp_panel_make(&s->panel[k], &s->source->panel[k], &s->canvas, false, name, err);
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

static sp_status draw(sheet *s, const char *path, sp_error *err) {
    const bool note = s->source->note && *s->source->note;
    const double height = s->source->aspect * CANVAS_COLUMN, all = s->source->panels * height;
    canvas *c = &s->canvas;
    sp_status status = sp_canvas_open(c, path, s->source->title, CANVAS_COLUMN, all + (note ? NOTE : 0), err);
    if (status == SP_OK)
        status = make_panels(s, height, err);
    if (status == SP_OK)
        status = layout(s, err);
    if (status != SP_OK)
        return status;
    for (int k = 0; k < s->source->panels; k++)
        sp_panel_draw(&s->panel[k]);
    if (note) {
        const axis *x = &s->panel[0].figure.axes.x;
        sp_canvas_colour(c, (colour){0, 0, 0});
        sp_figure_text_draw(c, s->source->note, x->to, all + NOTE - 4, (text_style){TEXT_SCRIPT, 1.0, 0.0, 0.0});
    }
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
