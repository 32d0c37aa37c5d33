/* Chooses ticks and draws axes. */
#include "figure/axes.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#define MAJOR        4.0 /* length of major ticks [pt] */
#define MINOR        2.2
#define GAP          3.0  /* between frame and tick labels [pt] */
#define LEAST_DECADE 26.0 /* shorter ones have no minor ticks, which would run together [pt] */

/* ---- ranges --------------------------------------------------------------------------------------------------- */

void sp_axis_linear(axis *a, double low, double high) {
    double largest = fmax(fabs(low), fabs(high));
    a->log = false;
    a->power = 0;
    if (largest > 0.0 && (largest >= 2e4 || largest < 0.05)) /* with -307, 10^power is still a normal number */
        a->power = (int)fmax(floor(log10(largest) + 1e-12), -307.0);
    a->low = sp_axis_unit(a, low);
    a->high = sp_axis_unit(a, high);
    double size = fmax(fabs(a->low), fabs(a->high)), least = size > 0.0 ? 1e-9 * size : 2.0;
    if (a->high - a->low < least) {
        double middle = 0.5 * (a->low + a->high);
        a->low = middle - fmax(0.5 * size, 0.5 * least);
        a->high = middle + fmax(0.5 * size, 0.5 * least);
    }
}

void sp_axis_log(axis *a, double low, double high, double least) {
    double missing = fmax(0.0, least - (high - low));
    a->log = true;
    a->power = 0;
    a->low = low - 0.5 * missing;
    a->high = high + 0.5 * missing;
}

double sp_axis_unit(const axis *a, double value) {
    if (a->log)
        return log10(value);
    return a->power == 0 ? value : value / pow(10.0, a->power);
}

double sp_axis_place(const axis *a, double unit) {
    return a->from + (unit - a->low) / (a->high - a->low) * (a->to - a->from);
}

void sp_axis_name(axis *a, const char *name, const char *unit) {
    char number[32] = "", ten[48] = "";
    if (a->power != 0) {
        sp_figure_text_number(number, sizeof number, a->power, 4);
        snprintf(ten, sizeof ten, "10^{%s}%s", number, *unit ? " " : "");
    }
    if (*ten || *unit)
        snprintf(a->label, sizeof a->label, "%s  [%s%s]", name, ten, unit);
    else
        snprintf(a->label, sizeof a->label, "%s", name);
}

/* ---- ticks ---------------------------------------------------------------------------------------------------- */

static void add_tick(axis *a, double at, bool major, const char *label) {
    const double slack = 1e-9 * (a->high - a->low);
    if (a->ticks == TICKS_MAX || at < a->low - slack || at > a->high + slack)
        return;
    tick *t = &a->tick[a->ticks++];
    *t = (tick){.at = at, .major = major};
    snprintf(t->label, sizeof t->label, "%s", label);
}

/* A decimal number with a typographic minus. */
static void decimal(char *out, size_t size, double value, int decimals) {
    char plain[28];
    snprintf(plain, sizeof plain, "%.*f", decimals, fabs(value));
    bool zero = strspn(plain, "0.") == strlen(plain);
    snprintf(out, size, "%s%s", value < 0.0 && !zero ? MINUS : "", plain);
}

/* A step of 1, 2 or 5 x 10^k that divides `range` into about `count` steps. *minor: number of minor intervals in a
 * step. */
static double nice_step(double range, int count, int *minor) {
    double rough = range / count, ten = pow(10.0, floor(log10(rough)));
    double digit = rough / ten;
    double nice = digit < 1.5 ? 1.0 : digit < 3.5 ? 2.0 : digit < 7.5 ? 5.0 : 10.0;
    *minor = nice == 2.0 ? 4 : 5;
    return nice * ten;
}

static void linear_ticks(axis *a, int count) {
    int parts;
    double step = nice_step(a->high - a->low, count, &parts);
    double part = step / parts;
    int decimals = (int)fmin(15.0, fmax(0.0, ceil(-log10(step) - 1e-9)));
    double first = ceil(a->low / part - 1e-9), last = floor(a->high / part + 1e-9);
    a->ticks = 0;
    for (double k = first; k <= last && a->ticks < TICKS_MAX; k += 1.0) {
        char label[48] = "";
        bool major = fmod(k, parts) == 0.0;
        if (major)
            decimal(label, sizeof label, k * part, decimals);
        add_tick(a, k * part, major, label);
    }
}

/* Ticks at decades. Every `stride`-th has a label. The values 2 to 9 between them are minor ticks if there is space, on
 * an axis of this length [pt]. */
static void decade_ticks(axis *a, int stride, double length) {
    double first = floor(a->low), last = ceil(a->high);
    int thin = (int)ceil((last - first) / 60.0);
    const bool fine = stride == 1 && last - first <= 12.0 && length / (a->high - a->low) >= LEAST_DECADE;
    a->ticks = 0;
    for (double d = first; d <= last; d += 1.0) {
        char label[48], number[32];
        decimal(number, sizeof number, d, 0);
        snprintf(label, sizeof label, "10^{%s}", number);
        bool major = fmod(d, stride) == 0.0;
        if (major || fmod(d, thin) == 0.0)
            add_tick(a, d, major, major ? label : "");
        for (int m = 2; m < 10 && fine; m++)
            add_tick(a, d + log10(m), false, "");
    }
}

/* Ticks at 1 to 9 times each power of ten, for one or two decades. The digits in `labelled` have labels. */
static void digit_ticks(axis *a, const char *labelled) {
    a->ticks = 0;
    for (double d = floor(a->low); d <= ceil(a->high); d += 1.0)
        for (int m = 1; m < 10; m++) {
            char label[48] = "";
            bool major = strchr(labelled, '0' + m) != NULL;
            if (major && d >= -3.0 && d <= 3.0)
                decimal(label, sizeof label, m * pow(10.0, d), (int)fmax(0.0, -d));
            else if (major)
                sp_figure_text_number(label, sizeof label, m * pow(10.0, d), 1);
            add_tick(a, d + log10(m), major, label);
        }
}

/* Ticks for a range below a factor of about two: evenly spaced values on the logarithmic axis. */
static void narrow_ticks(axis *a) {
    axis plain = {.log = false, .low = pow(10.0, a->low), .high = pow(10.0, a->high)};
    linear_ticks(&plain, 4);
    a->ticks = 0;
    for (int k = 0; k < plain.ticks; k++) {
        char label[48] = "";
        const tick *t = &plain.tick[k];
        if (t->major)
            sp_figure_text_number(label, sizeof label, t->at, 6);
        if (t->at > 0.0)
            add_tick(a, log10(t->at), t->major, label);
    }
}

static int labels(const axis *a) {
    int count = 0;
    for (int k = 0; k < a->ticks; k++)
        count += a->tick[k].label[0] != '\0';
    return count;
}

static double letters(const axis *a) { return a->size > 0.0 ? a->size : TEXT_LABEL; }

static double widest(const axis *a, canvas *c) {
    double width = 0.0;
    for (int k = 0; k < a->ticks; k++)
        width = fmax(width, sp_figure_text_width(c, a->tick[k].label, letters(a)));
    return width;
}

/* Length of the labels along the axis, gaps included. */
static double crowd(const axis *a, canvas *c, bool across) {
    return labels(a) * (across ? widest(a, c) + 8.0 * letters(a) / TEXT_LABEL : 2.0 * letters(a));
}

/* Evenly spaced values crowd together towards the end of a logarithmic axis. This leaves out labels that would touch
 * the last label kept. */
static void thin_labels(axis *a, canvas *c, double length, bool across) {
    const double scale = length / (a->high - a->low), size = letters(a);
    double end = -INFINITY; /* of the last label kept */
    for (int k = 0; k < a->ticks; k++) {
        tick *t = &a->tick[k];
        if (!t->label[0])
            continue;
        const double half = across ? 0.5 * sp_figure_text_width(c, t->label, size) : 0.5 * size, at = t->at * scale;
        if (at - half < end + 0.5 * size)
            t->label[0] = '\0';
        else
            end = at + half;
    }
}

static void log_ticks(axis *a, canvas *c, double length, bool across) {
    static const int strides[] = {1, 2, 3, 5, 10, 20, 50, 100, 200};
    const double decades = floor(a->high + 1e-9) - ceil(a->low - 1e-9) + 1.0;
    if (decades >= 2.0) {
        for (int k = 0; k < 9; k++) {
            decade_ticks(a, strides[k], length);
            if (crowd(a, c, across) <= length)
                break;
        }
        if (labels(a) < 2) { /* one label does not show the scale: closer labels, as long as they do not touch */
            decade_ticks(a, 1, length);
            thin_labels(a, c, length, across);
        }
        return;
    }
    static const char *const digits[] = {"125", "15", "13", "1"};
    for (int k = 0; k < 4; k++) {
        digit_ticks(a, digits[k]);
        if (labels(a) < 2)
            break;
        if (crowd(a, c, across) <= length)
            return;
    }
    narrow_ticks(a);
    thin_labels(a, c, length, across);
}

static void choose_ticks(axis *a, canvas *c, double length, bool across) {
    if (a->log) {
        log_ticks(a, c, length, across);
        return;
    }
    for (int count = 7; count > 1; count--) {
        linear_ticks(a, count);
        if (crowd(a, c, across) <= length)
            return;
    }
}

/* ---- frame ---------------------------------------------------------------------------------------------------- */

void sp_axes_layout(axes *a, canvas *c) {
    const bool whole = !(a->width > 0.0);
    const double width = whole ? c->width : a->width, height = whole ? c->height : a->height;
    const double size = letters(&a->x), pad = 2.0, line = 1.25 * size;
    const double right = a->left + width, bottom = a->top + height;
    a->y.from = bottom - pad - (a->x.label[0] ? line : 0.0) - GAP - line;
    a->y.to = a->top + 0.55 * size + a->head;
    choose_ticks(&a->y, c, a->y.from - a->y.to, false);
    a->x.from = a->left + pad + (a->y.label[0] ? line + 2.0 : 0.0) + widest(&a->y, c) + GAP;
    a->x.from = fmax(a->x.from, a->left + a->margin[0]);
    choose_ticks(&a->x, c, right - a->x.from, true);
    /* the last label may extend beyond the axis */
    a->x.to = right - fmax(5.0, a->margin[1]);
    for (int k = 0; k < a->x.ticks; k++) {
        const tick *t = &a->x.tick[k];
        double half = 0.5 * sp_figure_text_width(c, t->label, size), part = (t->at - a->x.low) / (a->x.high - a->x.low);
        if (t->label[0] && part > 0.5)
            a->x.to = fmin(a->x.to, a->x.from + (right - 2.0 - half - a->x.from) / part);
    }
}

static void draw_ticks(const axes *a, canvas *c) {
    const double small = letters(&a->x) / TEXT_LABEL;
    cairo_set_line_width(c->cr, 0.6 * small);
    for (int k = 0; k < a->x.ticks; k++) {
        const tick *t = &a->x.tick[k];
        double x = sp_axis_place(&a->x, t->at), length = (t->major ? MAJOR : MINOR) * small;
        cairo_move_to(c->cr, x, a->y.from);
        cairo_rel_line_to(c->cr, 0.0, -length);
        cairo_move_to(c->cr, x, a->y.to);
        cairo_rel_line_to(c->cr, 0.0, length);
    }
    for (int k = 0; k < a->y.ticks; k++) {
        const tick *t = &a->y.tick[k];
        double y = sp_axis_place(&a->y, t->at), length = (t->major ? MAJOR : MINOR) * small;
        cairo_move_to(c->cr, a->x.from, y);
        cairo_rel_line_to(c->cr, length, 0.0);
        cairo_move_to(c->cr, a->x.to, y);
        cairo_rel_line_to(c->cr, -length, 0.0);
    }
    cairo_stroke(c->cr);
}

/* The place on a line from `low' to `high' of the middle of a label: as near to `wish' as the label fits. */
static double middle_of(double wish, double width, double low, double high) {
    return high - low < width ? 0.5 * (low + high) : fmax(low + 0.5 * width, fmin(high - 0.5 * width, wish));
}

/* Size of the letters with which an axis label fits into `room': down to a readable size. */
static double fitting(canvas *c, const axis *a, double size, double room) {
    const double least = size < TEXT_LEGEND ? 5.0 : 6.0, width = sp_figure_text_width(c, a->label, size);
    return width > room ? fmax(least, size * room / width) : size;
}

static void draw_labels(const axes *a, canvas *c, double left, double right, double bottom) {
    const double size = letters(&a->x);
    if (a->x.label[0]) {
        const double own = fitting(c, &a->x, size, right - left - 4), width = sp_figure_text_width(c, a->x.label, own);
        sp_figure_text_draw(c, a->x.label, middle_of(0.5 * (a->x.from + a->x.to), width, left + 2, right - 2),
                            bottom - 0.55 * size, (text_style){own, 0.5, 0.0, 0.0});
    }
    if (a->y.label[0]) {
        const double own = fitting(c, &a->y, size, bottom - a->top - 4),
                     width = sp_figure_text_width(c, a->y.label, own);
        sp_figure_text_draw(c, a->y.label, left + 3.0,
                            middle_of(0.5 * (a->y.from + a->y.to), width, a->top + 2, bottom - 2),
                            (text_style){own, 0.5, 1.0, 1.5707963267948966});
    }
}

void sp_axes_draw(const axes *a, canvas *c) {
    const double size = letters(&a->x), bottom = a->width > 0.0 ? a->top + a->height : c->height;
    const double left = a->left, right = a->width > 0.0 ? a->left + a->width : c->width;
    sp_canvas_colour(c, (colour){0, 0, 0});
    draw_ticks(a, c);
    cairo_set_line_width(c->cr, 0.8 * size / TEXT_LABEL);
    cairo_rectangle(c->cr, a->x.from, a->y.to, a->x.to - a->x.from, a->y.from - a->y.to);
    cairo_stroke(c->cr);
    for (int k = 0; k < a->x.ticks; k++)
        if (a->x.tick[k].label[0])
            sp_figure_text_draw(c, a->x.tick[k].label, sp_axis_place(&a->x, a->x.tick[k].at), a->y.from + GAP + 1.0,
                                (text_style){size, 0.5, 1.0, 0.0});
    for (int k = 0; k < a->y.ticks; k++)
        if (a->y.tick[k].label[0])
            sp_figure_text_draw(c, a->y.tick[k].label, a->x.from - GAP, sp_axis_place(&a->y, a->y.tick[k].at),
                                (text_style){size, 1.0, 0.5, 0.0});
    draw_labels(a, c, left, right, bottom);
}
