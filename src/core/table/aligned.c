/* Tables for readers: columns aligned, numbers rounded. */
#include "base/base.h"
#include "base/text.h"

#include <math.h>
#include <sonopack/table.h>
#include <stdio.h>
#include <string.h>

enum { USUAL = 6, OF_ERRORS = 2, SEARCHED = 1000 };

/* How one column is written. */
typedef struct layout {
    size_t width;
    bool is_error;
    int error; /* the column X_err of X; -1 without */
} layout;

typedef struct aligner {
    const sp_table *t;
    int digits;
    layout *column; /* [t->columns] */
    sp_text *out;   /* NULL: widths are measured */
} aligner;

static bool is_error(const char *name) {
    const size_t length = strlen(name);
    return strcmp(name, "error") == 0 || strcmp(name, "residual") == 0 ||
           (length > 4 && strcmp(name + length - 4, "_err") == 0);
}

static layout layout_of(const sp_table *t, int column) {
    char name[sizeof t->column->name + 4];
    snprintf(name, sizeof name, "%s_err", t->column[column].name);
    return (layout){.is_error = is_error(t->column[column].name),
                    .error = t->columns <= SEARCHED ? sp_table_find_column(t, name) : -1};
}

/* So many digits that the last one is the second of the error, but at most the usual ones. */
static void round_to_error(double value, double error, char text[SP_NUMBER_TEXT]) {
    const bool known = error > 0 && isfinite(error) && isfinite(value) && fabs(value) > 0;
    const double digits = known ? floor(log10(fabs(value))) - floor(log10(error)) + OF_ERRORS : USUAL;
    const bool usual = digits >= USUAL;
    snprintf(text, SP_NUMBER_TEXT, usual ? "%.*g" : "%#.*g", usual ? USUAL : (int)fmax(digits, 1), value);
    const size_t length = strlen(text);
    if (text[length - 1] == '.') /* # leaves it behind 12 */
        text[length - 1] = '\0';
}

static void number_text(const aligner *a, int64_t row, int column, char text[SP_NUMBER_TEXT]) {
    const double value = sp_table_number(a->t, row, column);
    const layout *l = &a->column[column];
    if (!isfinite(value))
        sp_number_text(value, text); /* which knows no -nan */
    else if (a->digits > 0 || l->is_error)
        snprintf(text, SP_NUMBER_TEXT, "%.*g", a->digits > 0 ? a->digits : OF_ERRORS, value);
    else
        round_to_error(value, l->error < 0 ? NAN : sp_table_number(a->t, row, l->error), text);
}

/* Characters of a text in UTF-8. */
static size_t width_of(const char *text, size_t size) {
    size_t n = 0;
    for (size_t k = 0; k < size; k++)
        n += ((unsigned char)text[k] & 0xc0) != 0x80;
    return n;
}

static void add_blanks(sp_text *out, size_t n) {
    for (; n > 0; n--)
        sp_text_bytes(out, " ", 1);
}

/* One cell. Numbers stand at the right of their column, texts at the left. */
static void put_cell(const aligner *a, int column, const char *cell, size_t size) {
    layout *l = &a->column[column];
    const size_t width = width_of(cell, size);
    if (!a->out) {
        l->width = width > l->width ? width : l->width;
        return;
    }
    const bool text = a->t->column[column].kind == SP_COLUMN_TEXT, last = column == a->t->columns - 1;
    add_blanks(a->out, text ? 0 : l->width - width);
    sp_text_bytes(a->out, cell, size);
    add_blanks(a->out, last ? 0 : 2 + (text ? l->width - width : 0));
}

/* One line of cells, the header (row -1) or a row. Returns its end. */
static const char *put_line(const aligner *a, const char *tsv, int64_t row) {
    char number[SP_NUMBER_TEXT];
    for (int c = 0; c < a->t->columns; c++) {
        const size_t size = strcspn(tsv, "\t\n");
        const bool rounded = row >= 0 && a->digits >= 0 && a->t->column[c].kind == SP_COLUMN_NUMBER;
        if (rounded)
            number_text(a, row, c, number);
        put_cell(a, c, rounded ? number : tsv, rounded ? strlen(number) : size);
        tsv += size + (c < a->t->columns - 1);
    }
    return tsv;
}

static void put_lines(const aligner *a, const char *tsv) {
    for (int64_t row = -1; *tsv; tsv++) {
        const size_t comment = *tsv == '#' ? strcspn(tsv, "\n") : 0;
        if (comment > 0 && a->out)
            sp_text_bytes(a->out, tsv, comment);
        tsv = comment > 0 ? tsv + comment : put_line(a, tsv, row++);
        if (a->out)
            sp_text_bytes(a->out, "\n", 1);
    }
}

char *sp_table_aligned(const sp_table *t, int digits) {
    sp_text out = {0};
    char *tsv = sp_table_text(t, SP_TSV);
    aligner a = {.t = t, .digits = digits, .column = sp_alloc((size_t)t->columns + 1, sizeof *a.column)};
    const bool room = tsv && a.column;
    sp_locale locale = sp_locale_enter();
    for (int c = 0; room && c < t->columns; c++)
        a.column[c] = layout_of(t, c);
    for (int pass = 0; room && pass < 2; pass++) {
        a.out = pass ? &out : NULL;
        put_lines(&a, tsv);
    }
    sp_locale_leave(&locale);
    sp_free(a.column);
    sp_free(tsv);
    if (out.failed)
        sp_text_free(&out);
    return out.data;
}
