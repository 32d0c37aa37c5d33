/* Figures of curves in panels, from plain structs. */
#include "figure/open.h"
#include "figure/panel.h"

#include "base/base.h"
#include "figure/look.h"

#include <math.h>
#include <stdio.h>

enum { PANELS_MOST = 64 };
#define NARROW 170.0 /* panels below this width [pt] have smaller letters */

typedef struct sheet {
    const sp_sheet *source;
    canvas canvas;
    double width, height; /* of a panel [pt] */
    panel *panel;
} sheet;

static sp_status check(const sp_sheet *s, sp_error *err) {
    if (s->rows < 1 || s->columns < 1 || s->rows > PANELS_MOST || s->columns > PANELS_MOST ||
        s->rows * s->columns > PANELS_MOST || !s->panel)
        return sp_fail(err, SP_EINVAL, "%d rows and %d columns of panels%s: must be 1 to %d panels", s->rows,
                       s->columns, s->panel ? "" : ", NULL", PANELS_MOST);
    if (!(s->width >= 0) || s->width > 14400 || !(s->aspect >= 0) || s->aspect > 20)
        return sp_fail(err, SP_EINVAL, "width %g pt and aspect %g: must be 0 (the default) or 72 to 14400, and to 20",
                       s->width, s->aspect);
    return SP_OK;
}

static sp_status measure(sheet *s, sp_error *err) {
    const double width = s->source->width > 0 ? s->source->width : s->source->columns * CANVAS_COLUMN;
    s->width = width / s->source->columns;
    s->height = s->width * (s->source->aspect > 0 ? s->source->aspect : 0.75);
    if (s->width < 72 || s->height < 50)
        return sp_fail(err, SP_EINVAL, "panels of %.0f x %.0f pt: must be 72 x 50 pt at least", s->width, s->height);
    return SP_OK;
}

static void name_panel(const sheet *s, int k, char *out, size_t size) {
    const char *tag = s->source->panel[k].tag;
    if (tag && *tag)
        snprintf(out, size, "panel %.40s", tag);
    else
        snprintf(out, size, "panel %d", k + 1);
}

static sp_status make_panels(sheet *s, sp_error *err) {
    const int n = s->source->rows * s->source->columns;
    sp_status status = SP_OK;
    for (int k = 0; k < n && status == SP_OK; k++) {
        char name[64];
        sp_panel one = s->source->panel[k];
        name_panel(s, k, name, sizeof name);
        status = sp_look_apply(&one, k, err);
        if (status == SP_OK)
            status = sp_panel_make(&s->panel[k], &one, k, &s->canvas, name, err);
        axes *a = &s->panel[k].figure.axes;
        a->left = k % s->source->columns * s->width;
        a->top = (double)(k / s->source->columns) * s->height;
        a->width = s->width;
        a->height = s->height;
        a->x.size = a->y.size = s->width < NARROW ? TEXT_LEGEND : TEXT_LABEL;
    }
    return status;
}

/* Frames one below the other begin and end at the same x. */
static sp_status layout(sheet *s, sp_error *err) {
    const int columns = s->source->columns, n = s->source->rows * columns;
    sp_status status = SP_OK;
    for (int pass = 0; pass < 2; pass++)
        for (int c = 0; c < columns; c++) {
            double left = 0, right = 0;
            for (int k = c; k < n && status == SP_OK; k += columns) {
                const axes *a = &s->panel[k].figure.axes;
                status = sp_panel_layout(&s->panel[k], err);
                left = fmax(left, a->x.from - a->left);
                right = fmax(right, a->left + a->width - a->x.to);
            }
            for (int k = c; k < n; k += columns) {
                s->panel[k].figure.axes.margin[0] = left;
                s->panel[k].figure.axes.margin[1] = right;
            }
        }
    return status;
}

static sp_status draw(sheet *s, const char *path, sp_error *err) {
    const int n = s->source->rows * s->source->columns;
    const char *title = s->source->title ? s->source->title : "Figure";
    sp_status status =
        sp_figure_open(&s->canvas, path, title, s->width * s->source->columns, s->height * s->source->rows, err);
    if (status == SP_OK)
        status = make_panels(s, err);
    if (status == SP_OK)
        status = layout(s, err);
    for (int k = 0; k < n && status == SP_OK; k++)
        sp_panel_draw(&s->panel[k]);
    return status == SP_OK ? sp_canvas_save(&s->canvas, err) : status;
}

sp_status sp_plot_sheet(const sp_sheet *source, const char *path, sp_error *err) {
    sheet s = {.source = source};
    sp_status status = sp_canvas_check(path, err);
    if (status == SP_OK)
        status = check(source, err);
    if (status == SP_OK)
        status = measure(&s, err);
    if (status != SP_OK)
        return status;
    const int n = source->rows * source->columns;
    s.panel = sp_alloc((size_t)n, sizeof *s.panel);
    if (!s.panel)
        return sp_fail_memory(err, (size_t)n * sizeof *s.panel);
    status = draw(&s, path, err);
    for (int k = 0; k < n; k++)
        sp_panel_free(&s.panel[k]);
    sp_canvas_free(&s.canvas);
    sp_free(s.panel);
    return status;
}
