/* Finds a place for the legend and draws it. */
#include "figure/legend.h"
#include "figure/raster.h"

#include <math.h>

#define LINE   11.0 /* line spacing [pt] */
#define SAMPLE 17.0 /* length of a line sample [pt] */
#define POINT  7.0  /* length of a marker sample [pt] */
#define BESIDE 5.0  /* gap between sample and text [pt] */
#define APART  10.0 /* gap between columns [pt] */
#define INSET  6.0  /* distance from the frame [pt] */

static bool listed(const series *s, int group) { return s->label && s->group == group; }

static legend_box size_of(const figure *f, int group) {
    legend_box box = {0};
    for (int k = 0; k < f->n; k++) {
        const series *s = &f->series[k];
        if (!listed(s, group))
            continue;
        box.height += LINE;
        box.width = fmax(box.width, SAMPLE + BESIDE + sp_figure_text_width(f->canvas, s->label, TEXT_LEGEND));
    }
    return box;
}

static bool overlap(const legend_box *a, const legend_box *b) {
    return a->height > 0.0 && b->height > 0.0 && a->x < b->x + b->width && b->x < a->x + a->width &&
           a->y < b->y + b->height && b->y < a->y + a->height;
}

static bool meets(const legend_box *box, double ax, double ay, double bx, double by) {
    const double delta[2] = {bx - ax, by - ay}, start[2] = {ax, ay};
    const double low[2] = {box->x, box->y}, high[2] = {box->x + box->width, box->y + box->height};
    double from, to;
    return sp_clip_segment(low, high, start, delta, &from, &to);
}

/* Number of points, segments, error bars and band sections of a series that the box would cover. */
static int64_t covered_by(const figure *f, const series *s, const legend_box *box) {
    int64_t count = 0;
    bool before = false;
    double last_x = 0.0, last_y = 0.0;
    for (int64_t k = 0; k < s->n; k++) {
        bool here = isfinite(s->x[k]) && isfinite(s->y[k]);
        double x = here ? sp_axis_place(&f->axes.x, s->x[k]) : 0.0, y = here ? sp_axis_place(&f->axes.y, s->y[k]) : 0.0;
        if (here) {
            bool joined = before && s->dash != DASH_NONE;
            count += joined ? meets(box, last_x, last_y, x, y) : meets(box, x, y, x, y);
            if (s->low && isfinite(s->low[k]) && isfinite(s->high[k]))
                count += meets(box, x, sp_axis_place(&f->axes.y, s->low[k]), x, sp_axis_place(&f->axes.y, s->high[k]));
            if (s->fill_low && isfinite(s->fill_low[k]) && isfinite(s->fill_high[k]))
                count += meets(box, x, sp_axis_place(&f->axes.y, s->fill_low[k]), x,
                               sp_axis_place(&f->axes.y, s->fill_high[k]));
        }
        before = here;
        last_x = x;
        last_y = y;
    }
    return count;
}

static int64_t covered(const figure *f, legend_box box) {
    const double margin = 3.0;
    box.x -= margin;
    box.y -= margin;
    box.width += 2.0 * margin;
    box.height += 2.0 * margin;
    int64_t count = 0;
    for (int k = 0; k < f->n; k++)
        count += covered_by(f, &f->series[k], &box);
    if (f->zero_line) {
        double y = sp_axis_place(&f->axes.y, 0.0);
        count += meets(&box, f->axes.x.from, y, f->axes.x.to, y);
    }
    return count;
}

/* The best of the four corners, upper ones first. The box must not overlap `other`, which may be NULL. */
static legend_box best_corner(const figure *f, legend_box box, const legend_box *other) {
    const axis *x = &f->axes.x, *y = &f->axes.y;
    const double left = x->from + INSET, right = x->to - INSET - box.width;
    const double top = y->to + INSET, bottom = y->from - INSET - box.height;
    const double corner[4][2] = {{left, top}, {right, top}, {left, bottom}, {right, bottom}};
    legend_box best = box;
    best.x = left;
    best.y = top;
    best.covers = INT64_MAX;
    for (int k = 0; k < 4; k++) {
        box.x = corner[k][0];
        box.y = corner[k][1];
        box.covers = covered(f, box);
        if (box.covers < best.covers && !(other && overlap(&box, other)))
            best = box;
    }
    return best;
}

/* Places each group in its own corner. Returns how much they hide. */
static int64_t place_apart(const figure *f, legend_box box[LEGEND_GROUPS]) {
    int64_t covers = 0;
    for (int g = 0; g < LEGEND_GROUPS; g++) {
        if (box[g].height == 0.0)
            continue;
        box[g] = best_corner(f, box[g], g > 0 ? &box[g - 1] : NULL);
        covers = box[g].covers > covers ? box[g].covers : covers;
    }
    return covers;
}

/* Stacks the groups in one corner. Returns how much they hide. */
static int64_t place_together(const figure *f, legend_box box[LEGEND_GROUPS]) {
    legend_box all = {0};
    for (int g = 0; g < LEGEND_GROUPS; g++) {
        all.width = fmax(all.width, box[g].width);
        all.height += box[g].height;
    }
    all = best_corner(f, all, NULL);
    double y = all.y;
    for (int g = 0; g < LEGEND_GROUPS; g++) {
        box[g].x = all.x;
        box[g].y = y;
        box[g].covers = all.covers;
        y += box[g].height;
    }
    return all.covers;
}

void sp_legend_place(figure *f, legend_box box[LEGEND_GROUPS]) {
    const double step = 0.04 * (f->axes.y.high - f->axes.y.low);
    bool empty = true;
    for (int g = 0; g < LEGEND_GROUPS; g++) {
        box[g] = size_of(f, g);
        empty = empty && box[g].height == 0.0;
    }
    for (int k = 0; k < 40 && !empty; k++) {
        if (place_together(f, box) == 0 || place_apart(f, box) == 0)
            return;
        f->axes.y.high += step;
        sp_axes_layout(&f->axes, f->canvas);
    }
}

static double letters(const figure *f) { return f->legend > 0.0 ? f->legend : TEXT_LEGEND; }

/* Length of the samples: that of a marker if no entry has a line or a band. */
static double sample_of(const figure *f) {
    double length = POINT;
    for (int k = 0; k < f->n; k++)
        if (f->series[k].label && (f->series[k].dash != DASH_NONE || f->series[k].fill_low))
            length = SAMPLE;
    return length * letters(f) / TEXT_LEGEND;
}

static void draw_entry(const figure *f, const series *s, double sample, double x, double y) {
    canvas *c = f->canvas;
    const double size = letters(f), at[2] = {x + 0.5 * sample, y};
    if (s->fill_low) {
        cairo_set_source_rgba(c->cr, s->ink.r, s->ink.g, s->ink.b, 0.22);
        cairo_rectangle(c->cr, x, y - 0.4 * size, sample, 0.8 * size);
        cairo_fill(c->cr);
    }
    if (s->dash != DASH_NONE) {
        sp_canvas_colour(c, s->ink);
        cairo_set_line_width(c->cr, s->width);
        sp_figure_dash(c, s->dash);
        cairo_move_to(c->cr, x, y);
        cairo_line_to(c->cr, x + sample, y);
        cairo_stroke(c->cr);
        sp_figure_dash(c, DASH_SOLID);
    }
    sp_marker_draw_sized(c, s->marker != MARKER_NONE ? s->marker : s->key, at, s->open, s->ink, sp_marker_radius(size));
    sp_canvas_colour(c, sp_figure_ink(0));
    sp_figure_text_draw(c, s->label, x + sample + BESIDE, y, (text_style){size, 0.0, 0.5, 0.0});
}

legend_box sp_legend_size(const figure *f, int columns) {
    legend_box box = {0};
    int entries = 0;
    for (int k = 0; k < f->n; k++)
        if (f->series[k].label) {
            entries++;
            box.width = fmax(box.width, sp_figure_text_width(f->canvas, f->series[k].label, letters(f)));
        }
    if (entries == 0)
        return box;
    box.width = columns * (box.width + sample_of(f) + BESIDE) + (columns - 1) * APART;
    box.height = (entries + columns - 1) / columns * LINE * letters(f) / TEXT_LEGEND;
    return box;
}

void sp_legend_draw_box(const figure *f, const legend_box *box, int columns) {
    const double line = LINE * letters(f) / TEXT_LEGEND, step = (box->width + APART) / columns;
    const double sample = sample_of(f);
    int entry = 0;
    for (int k = 0; k < f->n; k++)
        if (f->series[k].label) {
            draw_entry(f, &f->series[k], sample, box->x + entry % columns * step,
                       box->y + (entry / columns + 0.5) * line);
            entry++;
        }
}

void sp_legend_draw(const figure *f, const legend_box box[LEGEND_GROUPS]) {
    canvas *c = f->canvas;
    for (int g = 0; g < LEGEND_GROUPS; g++) {
        const legend_box *b = &box[g];
        if (b->height > 0.0 && b->covers > 0) {
            sp_canvas_colour(c, (colour){1, 1, 1});
            cairo_rectangle(c->cr, b->x - 2.0, b->y - 2.0, b->width + 4.0, b->height + 4.0);
            cairo_fill(c->cr);
        }
        double y = b->y + 0.5 * LINE;
        for (int k = 0; k < f->n; k++)
            if (listed(&f->series[k], g)) {
                draw_entry(f, &f->series[k], SAMPLE, b->x, y);
                y += LINE;
            }
    }
}
