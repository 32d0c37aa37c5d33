/* Places and draws tag, inset and legend of a panel. */
#include "figure/panel.h"

#include "base/base.h"

#include <math.h>

#define FROM_FRAME 5.0 /* distance of tag, legend and inset from the frame [pt] */
#define INSET_SIZE 7.0 /* letter size in an inset [pt] */
#define GROW       0.05
#define GROW_STEPS 14
#define LEAST_WIDE 72.0 /* least size of an inset [pt] */
#define LEAST_HIGH 50.0
#define ROOMY      1.18 /* that size is larger by this where it is no large part of the frame */
#define LARGE      0.55

/* Sizes of an inset relative to the frame. The largest that hides nothing is used. */
static const double inset_sizes[][2] = {{0.52, 0.52}, {0.48, 0.48}, {0.44, 0.46}, {0.40, 0.42}};
enum { INSET_SIZES = sizeof inset_sizes / sizeof *inset_sizes };

static double letters(const panel *p) { return p->figure.axes.x.size > 0 ? p->figure.axes.x.size : TEXT_LABEL; }

/* ---- places ----------------------------------------------------------------------------------------------------- */

/* In a free corner, or else in the margin left of the frame. */
static void place_tag(panel *p, raster *r) {
    const axes *a = &p->figure.axes;
    if (!p->source.tag || !*p->source.tag)
        return;
    p->tag = (rectangle){.width = sp_figure_text_width(p->figure.canvas, p->source.tag, letters(p)),
                         .height = 0.8 * letters(p)};
    if (sp_raster_find(r, &p->tag, FROM_FRAME, true) == 0) {
        sp_raster_mark_box(r, &p->tag);
        return;
    }
    p->tag.x = a->left + 1;
    p->tag.y = a->top + 2 + a->head;
}

static double least_side(double least, double frame) { return fmax(least, fmin(ROOMY * least, LARGE * frame)); }

/* Returns how much it hides. */
static int32_t place_inset(panel *p, raster *r) {
    int32_t least = INT32_MAX;
    if (!p->inset)
        return 0;
    for (int k = 0; k < INSET_SIZES && least > 0; k++) {
        rectangle b = {.width = fmax(inset_sizes[k][0] * r->width, least_side(LEAST_WIDE, r->width)),
                       .height = fmax(inset_sizes[k][1] * r->height, least_side(LEAST_HIGH, r->height))};
        const int32_t covers = sp_raster_find(r, &b, 3.0, false);
        if (covers < least) {
            least = covers;
            p->inset_box = b;
        }
    }
    sp_raster_mark_box(r, &p->inset_box);
    return least;
}

/* In one column, or in two if only that is free. Returns how much it hides. */
static int32_t place_legend(panel *p, raster *r) {
    enum { COLUMNS_MOST = 2 };
    int32_t least = INT32_MAX;
    for (int columns = 1; columns <= COLUMNS_MOST && least > 0; columns++) {
        const legend_box box = sp_legend_size(&p->figure, columns);
        rectangle b = {.width = box.width, .height = box.height};
        const int32_t covers = box.height == 0 ? 0 : sp_raster_find(r, &b, FROM_FRAME, false);
        if (covers >= least)
            continue;
        least = covers;
        p->columns = columns;
        p->legend = box;
        p->legend.x = b.x;
        p->legend.y = b.y;
    }
    return least;
}

/* Smaller letters, if two columns fit with them: one column above the frame takes its height. */
static void narrow_legend(panel *p, double room) {
    const double least = 6.0, size = p->figure.legend;
    for (double smaller = size; smaller >= least; smaller -= 0.25) {
        p->figure.legend = smaller;
        if (sp_legend_size(&p->figure, 2).width <= room) {
            p->columns = 2;
            return;
        }
    }
    p->figure.legend = size;
}

/* Puts the legend above the frame, where it hides nothing, in as many columns as fit. */
static void legend_above(panel *p) {
    axes *a = &p->figure.axes;
    const double room = a->width - 2 * FROM_FRAME; /* of the panel: beside the frame there is space too */
    p->columns = 1;
    while (p->columns < 4 && sp_legend_size(&p->figure, p->columns + 1).width <= room)
        p->columns++;
    if (p->columns == 1)
        narrow_legend(p, room);
    p->legend = sp_legend_size(&p->figure, p->columns);
    a->head = p->legend.height + 2;
    sp_axes_layout(a, p->figure.canvas);
    const double centred = 0.5 * (a->x.from + a->x.to - p->legend.width);
    p->legend.x = fmax(a->left + FROM_FRAME, fmin(centred, a->left + FROM_FRAME + room - p->legend.width));
    p->legend.y = a->y.to - p->legend.height - 2;
}

/* Places all parts on the present axes. Returns how much they hide. */
static int32_t place_parts(panel *p, raster *r, bool above) {
    sp_axes_layout(&p->figure.axes, p->figure.canvas);
    if (above)
        legend_above(p);
    sp_raster_mark(r, &p->figure);
    place_tag(p, r);
    const int32_t inset = place_inset(p, r);
    if (inset > 0 && p->inset && above)
        return inset;
    const int32_t legend = above ? 0 : place_legend(p, r);
    return inset > legend ? inset : legend;
}

/* Chooses a letter size with which the legend fits into the frame. */
static void size_legend(panel *p) {
    const double size = letters(p) >= TEXT_LABEL ? TEXT_LEGEND : letters(p) - 0.5, least = 6.0;
    p->figure.legend = size;
    const double wide = sp_legend_size(&p->figure, 1).width, most = p->figure.axes.x.to - p->figure.axes.x.from - 12;
    if (wide > most && wide > 0)
        p->figure.legend = fmin(size, fmax(least, size * most / wide));
}

/* Extends the y axis upwards until the parts hide nothing. If that fails, the legend goes above the frame. */
static void place_all(panel *p, raster *r) {
    axis *y = &p->figure.axes.y;
    const double high = y->high, step = GROW * (y->high - y->low);
    const int most = !p->grows ? 0 : p->inset ? 2 * GROW_STEPS : GROW_STEPS;
    for (int above = 0; above < 2; above++)
        for (int k = 0; k <= most; k++) {
            y->high = high + k * step;
            if (place_parts(p, r, above) == 0)
                return;
        }
    y->high = high;
    place_parts(p, r, true);
}

sp_status sp_panel_layout(panel *p, sp_error *err) {
    raster r = {0};
    sp_status status = sp_raster_open(&r, p->figure.canvas, err);
    if (status == SP_OK) {
        p->figure.axes.head = 0;
        sp_axes_layout(&p->figure.axes, p->figure.canvas);
        size_legend(p);
        place_all(p, &r);
    }
    sp_raster_free(&r);
    if (status != SP_OK || !p->inset)
        return status;
    if (!(p->inset_box.width > 0) || p->figure.axes.width < 1.8 * LEAST_WIDE ||
        p->figure.axes.height < 1.8 * LEAST_HIGH)
        return sp_fail(err, SP_EINVAL, "a panel of %.0f x %.0f pt has no room for an inset, must be larger",
                       p->figure.axes.width, p->figure.axes.height);
    axes *a = &p->inset->figure.axes;
    a->left = p->inset_box.x;
    a->top = p->inset_box.y;
    a->width = p->inset_box.width;
    a->height = p->inset_box.height;
    a->x.size = a->y.size = INSET_SIZE;
    return sp_panel_layout(p->inset, err);
}

/* ---- drawing ---------------------------------------------------------------------------------------------------- */

void sp_panel_draw(panel *p) {
    canvas *c = p->figure.canvas;
    sp_figure_paint(&p->figure);
    if (p->inset) {
        sp_canvas_colour(c, (colour){1, 1, 1});
        cairo_rectangle(c->cr, p->inset_box.x, p->inset_box.y, p->inset_box.width, p->inset_box.height);
        cairo_fill(c->cr);
        sp_panel_draw(p->inset);
    }
    if (p->legend.height > 0)
        sp_legend_draw_box(&p->figure, &p->legend, p->columns);
    sp_canvas_colour(c, (colour){0, 0, 0});
    if (p->source.tag && *p->source.tag)
        sp_figure_text_draw(c, p->source.tag, p->tag.x, p->tag.y, (text_style){letters(p), 0.0, 1.0, 0.0});
}
