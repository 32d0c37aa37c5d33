/* Converts tables to SI: columns, and the numbers in comments. */
#include "base/base.h"
#include "base/text.h"

#include <sonopack/units.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TIME  "d/sqrt(E* / rho)"
#define RATE  "sqrt(E* / rho)/d"
#define SPEED "sqrt(E* / rho)"
#define DISC  "<!d>:<!d>:<!d>:*"

/* What comments of tables have a dimension. <UNIT> is a number in this unit of ours, with all digits in SI; <~UNIT>
 * gets 6 digits, as what the program prints to readers has; <!UNIT> is written without a blank before its unit, since
 * it is part of a word; <+UNIT> is a list of numbers in square brackets. <=A B> is a number in the unit of the column
 * A, else B. * is any text. First the comments "KEY = <UNIT>", by their units; then others, of which the first that
 * fits counts. */
static const struct {
    const char *unit, *keys;
} values[] = {
    {"d", "edge_x edge_y edge_z height node distance distance_err position radius overlap packing.width packing.depth "
          "packing.height packing.diameter_min packing.diameter_max"},
    {"E*", "pressure C11 C12 C22 C33 C33_mean C33_sd K K_mean K_sd G G_mean G_sd G_pure G_pure_mean G_pure_sd C_err "
           "packing.pressure"},
    {TIME, "until step t window_low window_high"},
    {"=by_kn by_mass by_radius by_x by_p", "value value_err"},
    {"=F F1 ux", "error"},
    {RATE,
     "omega_max omega omega_error resolution zero_below ioffe_regel ioffe_regel_err band_low band_high packing.drag"},
    {"~E* / (rho d^2)", "skew balance"},
    {"=amplitude", "height_limit"},
    {"1/(E* d)", "compliance"},
    {"E* d^3", "work"},
    {"=width", "width_limit"},
    {"=width_peak", "width_peak_limit"},
    {"+E*", "packing.history"},
    {"+d", "packing.diameters"},
    {"E* / (rho d)", "packing.tolerance"},
    {"rho d", "packing.piston_mass"},
};
static const char *const forms[] = {
    "pressure = <E*>, grains = *, width = <d>, friction = *",
    "dimension = *, friction = *, width = <d>",
    "complete = <" RATE ">:<" RATE ">",
    "*: no motion grows faster than exp(<~" RATE "> t)",
    "F* = from disc:" DISC " to disc:" DISC ", error <=F F1>",
    "F* = from disc:" DISC " to plane:<!d>:*, error <=F F1>",
    "F* = from disc:" DISC " to part:<!d>:<!d>:*, error <=F F1>",
    "F* = from disc:" DISC " to *, error <=F F1>",
    "F* = from part:<!d>:<!d>:* to disc:" DISC ", error <=F F1>",
    "F* = from * to disc:" DISC ", error <=F F1>",
    "F* = from part:<!d>:<!d>:* to part:<!d>:<!d>:*, error <=F F1>",
    "F* = from part:<!d>:<!d>:* to plane:<!d>:*, error <=F F1>",
    "F* = from part:<!d>:<!d>:* to *, error <=F F1>",
    "F* = from * to part:<!d>:<!d>:*, error <=F F1>",
    "F* = from * to plane:<!d>:*, error <=F F1>",
    "F* = from * to *, error <=F F1>",
    "damping = gamma:<!E* d^2/sqrt(E* / rho)>:<!E* d^2/sqrt(E* / rho)>",
    "damping = mass:<!" RATE ">:<!" RATE ">",
    "pulse = gauss:<!" TIME ">",
    "pulse = square:<!" TIME ">",
    "pulse = ricker:<!" RATE ">",
    "pulse = sine:<!" RATE ">:*",
    "p = <~E*>: grains * and *, heights <~d> and <~d>",
    "p = <~E*>: *",
    "p = <~E*>, * grains: *",
    "speed(p=<~E*>, width=<~d>, *) = <~" SPEED ">, error <~" SPEED ">, *",
    "*(p=<~E*>, width=<~d>, *) = *",
    "published: c_tof ~ *, c_tof(<~E*>) = <~" SPEED ">..<~" SPEED "> (*",
};

enum { PLACES_MOST = 16 };

/* A number, or a list, that a form has found in a line. */
typedef struct number_at {
    const char *at;
    size_t length;
    char unit[SP_UNIT_TEXT]; /* what is between < and > */
} number_at;

typedef struct found {
    int n;
    number_at place[PLACES_MOST];
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
    number_at *p = &f->place[f->n++];
    *p = (number_at){.at = line, .length = length};
    snprintf(p->unit, sizeof p->unit, "%.*s", (int)(close - form - 1), form + 1);
    return fits(close + 1, line + length, f);
}

/* Whether the line is a number with a dimension after its key. */
static bool fits_value(const char *line, found *f) {
    const char *sign = strstr(line, " = ");
    const size_t length = sign ? (size_t)(sign - line) : 0;
    for (size_t k = 0; length > 0 && k < sizeof values / sizeof *values; k++)
        for (const char *key = values[k].keys; *key; key += strspn(key, " ")) {
            const size_t own = strcspn(key, " ");
            if (own == length && memcmp(key, line, own) == 0) {
                char form[SP_UNIT_TEXT];
                snprintf(form, sizeof form, "<%s>", values[k].unit);
                return fits(form, sign + 3, f);
            }
            key += own;
        }
    return false;
}

static bool fits_any(const char *line, found *f) {
    bool known = fits_value(line, f);
    for (size_t k = 0; k < sizeof forms / sizeof *forms && !known; k++) {
        f->n = 0;
        known = fits(forms[k], line, f);
    }
    return known;
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

static void put_place(sp_text *out, const number_at *p, const sp_table *t, const sp_material *m) {
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

/* A new text, in which numbers with a dimension are converted and have their units; NULL without memory. */
static char *comment_to_si(const char *line, const sp_table *t, const sp_material *m) {
    found f = {0};
    if (!fits_any(line, &f))
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

/* ---- comments --------------------------------------------------------------------------------------------------- */

static void free_lines(char **line, int n) {
    for (int k = 0; line && k < n; k++)
        sp_free(line[k]);
    sp_free(line);
}

/* The comments of the table in SI. NULL without memory. */
static char **converted_comments(const sp_table *t, const sp_material *m) {
    char **line = sp_alloc((size_t)t->comments + 1, sizeof *line);
    for (int k = 0; line && k < t->comments; k++) {
        line[k] = comment_to_si(t->comment[k], t, m);
        if (!line[k]) {
            free_lines(line, t->comments);
            line = NULL;
        }
    }
    return line;
}

/* Removes all comments and metadata. */
static void clear_comments(sp_table *t) {
    free_lines(t->comment, t->comments);
    for (int k = 0; k < t->values; k++) {
        sp_free(t->value[k].key);
        sp_free(t->value[k].text);
    }
    sp_free(t->value);
    t->comment = NULL;
    t->value = NULL;
    t->comments = t->values = 0;
}

static sp_status replace_comments(sp_table *t, const sp_material *m, sp_error *err) {
    const int comments = t->comments;
    char **line = converted_comments(t, m), material[SP_MATERIAL_TEXT];
    sp_status status = line ? SP_OK : sp_fail_memory(err, (size_t)comments * 80);
    if (status == SP_OK)
        clear_comments(t);
    for (int k = 0; k < comments && status == SP_OK; k++)
        status = sp_table_add_comment(t, err, "%s", line[k]);
    free_lines(line, comments);
    if (status == SP_OK && !sp_table_get_text(t, "material"))
        status = sp_table_set_text(t, "material", sp_material_text(m, material), err);
    return status;
}

/* ---- columns ---------------------------------------------------------------------------------------------------- */

/* Whether all of our units in the columns can be converted. */
static sp_status check_columns(const sp_table *t, const sp_material *m, sp_error *err) {
    char si[SP_UNIT_TEXT];
    double factor;
    sp_status status = sp_material_check(m, err);
    for (int c = 0; c < t->columns && status == SP_OK; c++) {
        const sp_column *column = &t->column[c];
        if (!sp_unit_is_ours(column->unit))
            continue;
        status = sp_unit_to_si(column->unit, m, &factor, si, err);
        if (status == SP_OK && column->kind != SP_COLUMN_NUMBER)
            status = sp_fail(err, SP_EINVAL, "column %s: has the unit %s but no numbers with a fraction", column->name,
                             column->unit);
    }
    return status;
}

static void convert_column(sp_table *t, int c, const sp_material *m) {
    char si[SP_UNIT_TEXT];
    double factor;
    if (!sp_unit_is_ours(t->column[c].unit) || sp_unit_to_si(t->column[c].unit, m, &factor, si, NULL) != SP_OK)
        return;
    for (int64_t row = 0; row < t->rows; row++)
        t->cells[row * t->columns + c].number *= factor;
    snprintf(t->column[c].unit, sizeof t->column[c].unit, "%s", si);
}

sp_status sp_table_to_si(sp_table *t, const sp_material *m, sp_error *err) {
    sp_status status = check_columns(t, m, err);
    if (status == SP_OK)
        status = replace_comments(t, m, err); /* first: forms look up the units of columns */
    for (int c = 0; c < t->columns && status == SP_OK; c++)
        convert_column(t, c, m);
    return status;
}
