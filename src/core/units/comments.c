/* Converts the numbers in comments of tables, whose forms are in comments.inc. */
#include "units/unit.h"

#include "base/base.h"
#include "base/text.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TIME  "d/sqrt(E* / rho)"
#define RATE  "sqrt(E* / rho)/d"
#define SPEED "sqrt(E* / rho)"

static const char *const forms[] = {
#define FORM(text) text,
#include "units/comments.inc"
#undef FORM
};

enum { PLACES_MOST = 16 };

/* A number, or a list, that a form has found in a line. */
typedef struct place {
    const char *at;
    size_t length;
    char unit[SP_UNIT_TEXT]; /* what is between < and > */
} place;

typedef struct found {
    int n;
    place place[PLACES_MOST];
} found;

/* ---- finding numbers -------------------------------------------------------------------------------------------- */

static size_t digits(const char *text) { return strspn(text, "0123456789"); }

/* Length of the decimal number that a text begins with; "nan" and "inf" are numbers too. */
static size_t number_length(const char *text) {
    const size_t sign = text[0] == '-' || text[0] == '+';
    if (strncmp(text + sign, "nan", 3) == 0 || strncmp(text + sign, "inf", 3) == 0)
        return sign + 3;
    size_t n = sign + digits(text + sign);
    if (n == sign)
        return 0;
    if (text[n] == '.' && digits(text + n + 1) > 0)
        n += 1 + digits(text + n + 1);
    if (text[n] == 'e' || text[n] == 'E') {
        const size_t power = n + 1 + (text[n + 1] == '-' || text[n + 1] == '+');
        n = digits(text + power) > 0 ? power + digits(text + power) : n;
    }
    return n;
}

/* Length of the list in brackets, or of nothing. */
static size_t list_length(const char *text) {
    const size_t inside = *text == '[' ? strspn(text + 1, "0123456789+-.eE, ") : 0;
    return *text == '[' && text[1 + inside] == ']' ? inside + 2 : 0;
}

/* Whether the line has the form, from these letters on. */
static bool fits(const char *form, const char *line, found *f) {
    for (; *form && *form != '*' && *form != '<'; form++, line++)
        if (*form != *line)
            return false;
    if (*form == '*') {
        for (const int n = f->n; *line; line++, f->n = n)
            if (fits(form + 1, line, f))
                return true;
        return form[1] == '\0';
    }
    if (*form == '\0')
        return *line == '\0';
    const char *close = strchr(form, '>');
    const size_t length = form[1] == '+' ? list_length(line) : number_length(line);
    if (length == 0 || f->n == PLACES_MOST)
        return false;
    place *p = &f->place[f->n++];
    *p = (place){.at = line, .length = length};
    snprintf(p->unit, sizeof p->unit, "%.*s", (int)(close - form - 1), form + 1);
    return fits(close + 1, line + length, f);
}

/* ---- converting ------------------------------------------------------------------------------------------------- */

/* The unit of the first of these columns that the table has. */
static const char *unit_of_column(const sp_table *t, const char *names) {
    while (*names) {
        char name[sizeof t->column->name];
        const size_t length = strcspn(names, " ");
        snprintf(name, sizeof name, "%.*s", (int)length, names);
        const int column = sp_table_find_column(t, name);
        if (column >= 0)
            return t->column[column].unit;
        names += length + strspn(names + length, " ");
    }
    return "";
}

static void put_number(sp_text *out, const char *text, size_t length, double factor, bool few) {
    char word[400], number[SP_NUMBER_TEXT];
    snprintf(word, sizeof word, "%.*s", (int)(length < sizeof word ? length : sizeof word - 1), text);
    const double value = strtod(word, NULL) * factor;
    if (few)
        snprintf(number, sizeof number, "%.6g", value);
    else
        sp_number_text(value, number);
    sp_text_add(out, "%s", number);
}

static void put_list(sp_text *out, const char *text, size_t length, double factor) {
    for (const char *at = text; at < text + length;) {
        const size_t n = number_length(at);
        if (n > 0)
            put_number(out, at, n, factor, false);
        else
            sp_text_bytes(out, at, 1);
        at += n > 0 ? n : 1;
    }
}

static void put_place(sp_text *out, const place *p, const sp_table *t, const sp_material *m) {
    const char mark = p->unit[0], *unit = mark && strchr("~!+=", mark) ? p->unit + 1 : p->unit;
    char si[SP_UNIT_TEXT] = "";
    double factor = 1;
    if (mark == '=')
        unit = unit_of_column(t, unit);
    if (sp_unit_to_si(unit, m, &factor, si, NULL) != SP_OK) { /* a column in another unit */
        sp_text_bytes(out, p->at, p->length);
        return;
    }
    if (mark == '+')
        put_list(out, p->at, p->length, factor);
    else
        put_number(out, p->at, p->length, factor, mark == '~');
    sp_text_add(out, "%s%s", mark == '!' ? "" : " ", si);
}

char *sp_comment_to_si(const char *line, const sp_table *t, const sp_material *m, bool *known) {
    found f = {0};
    *known = false;
    for (size_t k = 0; k < sizeof forms / sizeof *forms && !*known; k++) {
        f.n = 0;
        *known = fits(forms[k], line, &f);
    }
    if (!*known)
        return sp_strdup(line);
    sp_text out = {0};
    const char *at = line;
    sp_locale locale = sp_locale_enter();
    for (int k = 0; k < f.n; k++) {
        sp_text_bytes(&out, at, (size_t)(f.place[k].at - at));
        put_place(&out, &f.place[k], t, m);
        at = f.place[k].at + f.place[k].length;
    }
    sp_text_add(&out, "%s", at);
    sp_locale_leave(&locale);
    if (out.failed)
        sp_text_free(&out);
    return out.data;
}
