/* Draws markup on the canvas. */
#include "figure/text.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

/* Metrics of Helvetica. They are close enough for the fonts that fontconfig substitutes. */
static const char family[] = "Helvetica";
#define CAPITAL 0.73 /* height of a capital relative to the font size */

/* ---- markup --------------------------------------------------------------------------------------------------- */

typedef struct run {
    char text[256];
    bool italic;
    int level; /* -1: subscript, 0: normal, 1: superscript */
} run;

/* Reads the next run of equal style and advances *at. italic and level keep the state between runs. */
static bool next_run(const char **at, bool *italic, int *level, run *out) {
    const char *s = *at;
    size_t n = 0;
    for (;; s++) {
        bool opens = (*s == '_' || *s == '^') && s[1] == '{';
        bool closes = *s == '}' && *level != 0;
        if (*s == '\0' || opens || closes || *s == '|') {
            if (n > 0 || *s == '\0')
                break;
            if (opens)
                *level = *s++ == '^' ? 1 : -1;
            else if (closes)
                *level = 0;
            else
                *italic = !*italic;
            continue;
        }
        /* do not split a multi-byte character */
        if (n >= sizeof out->text - 8 && ((unsigned char)*s & 0xc0) != 0x80)
            break;
        if (*s == '\\' && s[1])
            s++;
        out->text[n++] = *s;
    }
    out->text[n] = '\0';
    out->italic = *italic;
    out->level = *level;
    *at = s;
    return n > 0;
}

static double run_size(const run *r, double size) {
    if (r->level == 0)
        return size;
    return size < TEXT_LEGEND ? fmin(size, TEXT_SMALL) : fmin(size, TEXT_SCRIPT);
}

static void set_font(canvas *c, const run *r, double size) {
    cairo_select_font_face(c->cr, family, r->italic ? CAIRO_FONT_SLANT_ITALIC : CAIRO_FONT_SLANT_NORMAL,
                           CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(c->cr, run_size(r, size));
}

static double run_width(canvas *c, const run *r, double size) {
    cairo_text_extents_t extents;
    set_font(c, r, size);
    cairo_text_extents(c->cr, r->text, &extents);
    return extents.x_advance;
}

double sp_figure_text_width(canvas *c, const char *markup, double size) {
    double width = 0.0;
    bool italic = false;
    int level = 0;
    run r;
    while (next_run(&markup, &italic, &level, &r))
        width += run_width(c, &r, size);
    return width;
}

/* Adds the markup as plain text, such as c_tof or 10^-4, to the SVG description. */
static void keep_word(canvas *c, const char *markup) {
    char line[1024];
    size_t n = 0;
    bool italic = false;
    int level = 0, before = 0;
    run r;
    while (next_run(&markup, &italic, &level, &r)) {
        size_t length = strlen(r.text);
        if (n + length + 2 > sizeof line)
            break;
        if (r.level != 0 && r.level != before)
            line[n++] = r.level > 0 ? '^' : '_';
        memcpy(line + n, r.text, length);
        n += length;
        before = r.level;
    }
    line[n] = '\0';
    sp_canvas_word(c, line);
}

void sp_figure_text_draw(canvas *c, const char *markup, double x, double y, text_style style) {
    double start = -style.across * sp_figure_text_width(c, markup, style.size), drop = style.up * CAPITAL * style.size;
    keep_word(c, markup);
    cairo_save(c->cr);
    cairo_translate(c->cr, x, y);
    cairo_rotate(c->cr, -style.angle);
    bool italic = false;
    int level = 0;
    run r;
    while (next_run(&markup, &italic, &level, &r)) {
        double raised = r.level > 0 ? 0.40 * style.size : r.level < 0 ? -0.20 * style.size : 0.0;
        double advance = run_width(c, &r, style.size);
        cairo_move_to(c->cr, start, drop - raised);
        cairo_show_text(c->cr, r.text);
        start += advance;
    }
    cairo_new_path(c->cr);
    cairo_restore(c->cr);
}
