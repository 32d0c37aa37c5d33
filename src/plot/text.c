#include "plot/text.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Helvetica's own heights, near enough for every grotesque that fontconfig puts in its place. */
static const char family[] = "Helvetica";
#define CAPITAL 0.73 /* height of a capital, in sizes */
#define TIMES   "\xc3\x97"

/* ---- markup --------------------------------------------------------------------------------------------------- */

typedef struct run {
    char text[256];
    bool italic;
    int level; /* -1 subscript, 0, 1 superscript */
} run;

/* Next run of equal style; *at moves on. italic and level carry the state between runs. */
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
        /* a sign of several bytes is not cut in two */
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

static double run_size(const run *r, double size) { return r->level == 0 ? size : fmin(size, TEXT_SCRIPT); }

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

double text_width(canvas *c, const char *markup, double size) {
    double width = 0.0;
    bool italic = false;
    int level = 0;
    run r;
    while (next_run(&markup, &italic, &level, &r))
        width += run_width(c, &r, size);
    return width;
}

/* The markup in one line of plain text: c_tof, 10^-4. */
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
        if (r.level != 0 && before == 0)
            line[n++] = r.level > 0 ? '^' : '_';
        memcpy(line + n, r.text, length);
        n += length;
        before = r.level;
    }
    line[n] = '\0';
    canvas_word(c, line);
}

void text_draw(canvas *c, const char *markup, double x, double y, text_style style) {
    double start = -style.across * text_width(c, markup, style.size), drop = style.up * CAPITAL * style.size;
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

/* ---- users' texts --------------------------------------------------------------------------------------------- */

/* Bytes of the character at s: 0 at the end, 1 also for what is no valid UTF-8 (*valid = false). Not valid are, as for
 * cairo and XML, overlong forms, surrogates and noncharacters. */
static int character(const char *s, bool *valid) {
    static const uint32_t least[] = {0, 0, 0x80, 0x800, 0x10000};
    const unsigned char *u = (const unsigned char *)s;
    *valid = true;
    if (u[0] < 0x80)
        return u[0] != 0;
    int length = u[0] >= 0xf0 ? 4 : u[0] >= 0xe0 ? 3 : u[0] >= 0xc2 ? 2 : 0;
    uint32_t code = length == 4 ? u[0] & 0x07u : length == 3 ? u[0] & 0x0fu : u[0] & 0x1fu;
    for (int k = 1; k < length; k++) {
        if ((u[k] & 0xc0) != 0x80)
            length = 0;
        code = code << 6 | (u[k] & 0x3fu);
    }
    *valid = length > 0 && code >= least[length] && code < 0x110000 && (code & 0xfffff800u) != 0xd800 &&
             (code < 0xfdd0 || code > 0xfdef) && (code & 0xfffe) != 0xfffe;
    return *valid ? length : 1;
}

void text_escape(char *out, size_t size, const char *raw, int most) {
    int characters = 0;
    bool valid;
    for (const char *s = raw; *s; s += character(s, &valid))
        characters++;
    int head = characters > most ? most / 2 : characters, tail = characters > most ? most - head - 1 : 0;
    size_t n = 0;
    int k = 0;
    for (const char *s = raw; *s && n + 8 < size; k++) {
        int length = character(s, &valid);
        if (k == head && characters > most) {
            memcpy(out + n, "\xe2\x80\xa6", 3);
            n += 3;
        }
        if (k < head || k >= characters - tail) {
            unsigned char first = (unsigned char)*s;
            if (strchr("|_^{}\\", *s))
                out[n++] = '\\';
            if (!valid || first < ' ' || first == 127)
                out[n++] = valid ? ' ' : '?';
            else
                for (int b = 0; b < length; b++)
                    out[n++] = s[b];
        }
        s += length;
    }
    out[n] = '\0';
}

/* ---- numbers -------------------------------------------------------------------------------------------------- */

/* Copies a printed number, with the sign that a minus has in print. */
static void typeset(char *out, size_t size, const char *number) {
    size_t n = 0;
    for (; *number && n + 4 < size; number++) {
        if (*number == '-') {
            memcpy(out + n, MINUS, 3);
            n += 3;
        } else {
            out[n++] = *number;
        }
    }
    out[n] = '\0';
}

void text_number(char *out, size_t size, double value, int digits) {
    char plain[64], exponent[32], mantissa[64], power[64];
    double magnitude = fabs(value);
    if (!isfinite(value) || value == 0.0 || (magnitude >= 1e-3 && magnitude < 1e5)) {
        snprintf(plain, sizeof plain, "%.*g", digits < 5 && magnitude >= 1e3 ? 5 : digits, value);
        typeset(out, size, plain);
        return;
    }
    snprintf(plain, sizeof plain, "%.*e", digits - 1, value);
    char *e = strchr(plain, 'e');
    *e = '\0';
    snprintf(exponent, sizeof exponent, "%d", atoi(e + 1)); /* without its leading zero */
    for (char *last = e - 1; strchr(plain, '.') && (*last == '0' || *last == '.'); last--) {
        bool point = *last == '.';
        *last = '\0';
        if (point)
            break;
    }
    typeset(mantissa, sizeof mantissa, plain);
    typeset(power, sizeof power, exponent);
    if (strcmp(plain, "1") == 0)
        snprintf(out, size, "10^{%s}", power);
    else
        snprintf(out, size, "%s" TIMES "10^{%s}", mantissa, power);
}

void text_measured(char *out, size_t size, double value, double error) {
    char plain[64];
    if (!(error >= 1e-9) || error >= 1.0) {
        snprintf(plain, sizeof plain, fabs(value) < 1e3 ? "%.3f" : "%.3g", value);
    } else {
        int decimals = (int)ceil(-log10(error) - 1e-9);
        double shift = pow(10.0, decimals);
        if (error * shift < 1.95) { /* two digits for an error that begins with 1 */
            decimals++;
            shift *= 10.0;
        }
        snprintf(plain, sizeof plain, "%.*f(%.0f)", decimals, value, error * shift);
    }
    typeset(out, size, plain);
}
