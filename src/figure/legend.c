/* Finds a place for the legend and draws it. */
#include "figure/legend.h"

#include <math.h>

#define LINE   11.0 /* line spacing [pt] */
#define SAMPLE 17.0 /* length of a line sample [pt] */
#define POINT  7.0  /* length of a marker sample [pt] */
#define BESIDE 5.0  /* gap between sample and text [pt] */
#define APART  10.0 /* gap between columns [pt] */

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
    sp_marker_draw_sized(c, s->marker, at, s->open, s->ink, sp_marker_radius(size));
    sp_canvas_colour(c, sp_figure_ink(0));
    sp_figure_text_draw(c, s->label, x + sample + BESIDE, y, (text_style){size, 0.0, 0.5, 0.0});
}

static int entries_of(const figure *f) {
    int entries = 0;
    for (int k = 0; k < f->n; k++)
        entries += f->series[k].label != NULL;
    return entries;
}

/* Each column is as wide as its own longest text, so that one long name does not widen the others. */
static double column_width(const figure *f, int rows, int column) {
    double width = 0;
    int entry = 0;
    for (int k = 0; k < f->n; k++)
        if (f->series[k].label && entry++ / rows == column)
            width = fmax(width, sp_figure_text_width(f->canvas, f->series[k].label, letters(f)));
    return width + sample_of(f) + BESIDE;
}

legend_box sp_legend_size(const figure *f, int columns) {
    legend_box box = {0};
    const int entries = entries_of(f), rows = (entries + columns - 1) / columns;
    if (entries == 0)
        return box;
    for (int c = 0; c * rows < entries; c++)
        box.width += column_width(f, rows, c) + (c > 0 ? APART : 0);
    box.height = rows * LINE * letters(f) / TEXT_LEGEND;
    return box;
}

void sp_legend_draw_box(const figure *f, const legend_box *box, int columns) {
    const double line = LINE * letters(f) / TEXT_LEGEND, sample = sample_of(f);
    const int rows = (entries_of(f) + columns - 1) / columns;
    double x = box->x;
    int entry = 0;
    for (int k = 0; k < f->n; k++)
        if (f->series[k].label) { /* from top to bottom, then from left to right */
            if (entry > 0 && entry % rows == 0)
                x += column_width(f, rows, entry / rows - 1) + APART;
            draw_entry(f, &f->series[k], sample, x, box->y + (entry % rows + 0.5) * line);
            entry++;
        }
}
