/* Builds tables in memory, with metadata as comment lines "key = value", and looks values up in them. */
#include "base/base.h"
#include "base/text.h"
#include "table/quantity.h"

#include <math.h>
#include <sonopack/table.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

sp_table sp_table_none(void) { return (sp_table){0}; }

void sp_table_free(sp_table *t) {
    for (int64_t k = 0; k < t->rows * t->columns; k++)
        if (t->column[k % t->columns].kind == SP_COLUMN_TEXT)
            sp_free(t->cells[k].text);
    for (int c = 0; c < t->comments; c++)
        sp_free(t->comment[c]);
    for (int k = 0; k < t->values; k++) {
        sp_free(t->value[k].key);
        sp_free(t->value[k].text);
    }
    sp_free(t->value);
    sp_free(t->comment);
    sp_free(t->cells);
    sp_free(t->column);
    *t = sp_table_none();
}

sp_status sp_table_add_column(sp_table *t, const char *name, const char *unit, sp_column_kind kind, sp_error *err) {
    if (t->rows > 0 || t->columns >= SP_COLUMNS_MAX)
        return sp_fail(err, SP_EINVAL, "column %s: columns come before rows, %d at the most", name, SP_COLUMNS_MAX);
    sp_column *larger = sp_array_reserve(t->column, (size_t)t->columns, sizeof *larger);
    if (!larger)
        return sp_fail_memory(err, (size_t)t->columns * sizeof *larger);
    t->column = larger;
    sp_column *c = &t->column[t->columns++];
    snprintf(c->name, sizeof c->name, "%s", name);
    snprintf(c->unit, sizeof c->unit, "%s", unit);
    c->kind = kind;
    return SP_OK;
}

/* Doubles the capacity for rows. */
static sp_status grow(sp_table *t, sp_error *err) {
    int64_t capacity = t->capacity ? 2 * t->capacity : 64;
    size_t columns = (size_t)t->columns;
    sp_entry *cells = sp_alloc((size_t)capacity * columns, sizeof *cells);
    if (!cells)
        return sp_fail_memory(err, (size_t)capacity * columns * sizeof *cells);
    if (t->rows > 0)
        memcpy(cells, t->cells, (size_t)t->rows * columns * sizeof *cells);
    sp_free(t->cells);
    t->cells = cells;
    t->capacity = capacity;
    return SP_OK;
}

sp_status sp_table_add_numbers(sp_table *t, const double *values, sp_error *err) {
    sp_status status = t->rows == t->capacity ? grow(t, err) : SP_OK;
    for (int c = 0; c < t->columns && status == SP_OK; c++) {
        sp_entry *cell = &t->cells[t->rows * t->columns + c];
        switch (t->column[c].kind) {
        case SP_COLUMN_NUMBER: cell->number = values[c]; break;
        case SP_COLUMN_INTEGER: cell->integer = (int64_t)values[c]; break;
        case SP_COLUMN_TEXT: return sp_fail(err, SP_EINVAL, "column %s is not one of numbers", t->column[c].name);
        }
    }
    t->rows += status == SP_OK;
    return status;
}

sp_status sp_table_add_cells(sp_table *t, const sp_entry *cells, sp_error *err) {
    sp_status status = t->rows == t->capacity ? grow(t, err) : SP_OK;
    for (int c = 0; c < t->columns && status == SP_OK; c++) {
        sp_entry *cell = &t->cells[t->rows * t->columns + c];
        *cell = cells[c];
        if (t->column[c].kind != SP_COLUMN_TEXT || (cell->text = sp_strdup(cells[c].text)))
            continue;
        status = sp_fail_memory(err, strlen(cells[c].text));
        while (c-- > 0)
            if (t->column[c].kind == SP_COLUMN_TEXT)
                sp_free(t->cells[t->rows * t->columns + c].text);
        break;
    }
    t->rows += status == SP_OK; /* no row without its texts */
    return status;
}

sp_status sp_table_add_row(sp_table *t, sp_error *err, ...) {
    if (t->rows == t->capacity) {
        sp_status status = grow(t, err);
        if (status != SP_OK)
            return status;
    }
    sp_entry *row = t->cells + t->rows * t->columns;
    sp_status status = SP_OK;
    va_list args;
    va_start(args, err);
    for (int c = 0; c < t->columns; c++) {
        switch (t->column[c].kind) {
        case SP_COLUMN_NUMBER: row[c].number = va_arg(args, double); break;
        case SP_COLUMN_INTEGER: row[c].integer = va_arg(args, int64_t); break;
        case SP_COLUMN_TEXT:
            row[c].text = sp_strdup(va_arg(args, const char *));
            if (!row[c].text)
                status = sp_fail_memory(err, 1);
            break;
        }
    }
    va_end(args);
    for (int c = 0; status != SP_OK && c < t->columns; c++)
        if (t->column[c].kind == SP_COLUMN_TEXT)
            sp_free(row[c].text);
    t->rows += status == SP_OK; /* no row without its texts */
    return status;
}

static sp_status add_line(sp_table *t, const char *line, sp_error *err) {
    char **larger = sp_array_reserve(t->comment, (size_t)t->comments, sizeof *larger);
    if (!larger)
        return sp_fail_memory(err, (size_t)t->comments * sizeof *larger);
    t->comment = larger;
    t->comment[t->comments] = sp_strdup(line);
    if (!t->comment[t->comments])
        return sp_fail_memory(err, strlen(line));
    t->comments++;
    return SP_OK;
}

int sp_table_find_column(const sp_table *t, const char *name) {
    for (int c = 0; c < t->columns; c++)
        if (strcmp(t->column[c].name, name) == 0)
            return c;
    return -1;
}

double sp_table_number(const sp_table *t, int64_t row, int column) {
    const sp_entry *cell = &t->cells[row * t->columns + column];
    switch (t->column[column].kind) {
    case SP_COLUMN_NUMBER: return cell->number;
    case SP_COLUMN_INTEGER: return (double)cell->integer;
    case SP_COLUMN_TEXT: break;
    }
    return NAN;
}

/* ---- metadata ---------------------------------------------------------------------------------------------------- */

static const char *skip_blanks(const char *text) { return text + strspn(text, " \t"); }

/* A new string without the blanks at the end. */
static char *copy_trimmed(const char *text, size_t length) {
    while (length > 0 && (text[length - 1] == ' ' || text[length - 1] == '\t'))
        length--;
    char *copy = sp_alloc(length + 1, 1);
    if (copy)
        memcpy(copy, text, length);
    return copy;
}

/* The number that a text begins with; NAN without one. *whole: nothing follows it. */
static double leading_number(const char *text, bool *whole) {
    char *end;
    sp_locale locale = sp_locale_enter();
    const double value = strtod(text, &end);
    sp_locale_leave(&locale);
    *whole = end > text && *end == '\0';
    return end > text ? value : NAN;
}

/* ---- reading ---------------------------------------------------------------------------------------------------- */

/* Where the key ends: at the first " = ", since a key itself may have an equals sign, as in "gamma(p=1e-6)"; in a line
 * without blanks around it, at the first equals sign. NULL: no metadata. */
static const char *equals_sign(const char *line) {
    const char *blanks = strstr(line, " = ");
    return blanks ? blanks + 1 : strchr(line, '=');
}

static sp_status add_value(sp_table *t, const char *key, size_t key_length, const char *text, size_t length,
                           sp_error *err) {
    sp_table_value *larger = sp_array_reserve(t->value, (size_t)t->values, sizeof *larger);
    if (!larger)
        return sp_fail_memory(err, (size_t)t->values * sizeof *larger);
    t->value = larger;
    sp_table_value *v = &t->value[t->values];
    *v = (sp_table_value){.key = copy_trimmed(key, key_length), .text = copy_trimmed(text, length)};
    if (!v->key || !v->text) {
        sp_free(v->key);
        sp_free(v->text);
        return sp_fail_memory(err, key_length + length);
    }
    int64_t integer;
    bool whole;
    v->comment = t->comments - 1;
    v->number = leading_number(v->text, &whole);
    v->kind = sp_word_integer(v->text, &integer) ? SP_COLUMN_INTEGER : whole ? SP_COLUMN_NUMBER : SP_COLUMN_TEXT;
    t->values++;
    return SP_OK;
}

/* Tables of means say in a sentence what their intervals are: "..., its interval at level 0.95, ...". */
static sp_status index_sentence(sp_table *t, const char *line, sp_error *err) {
    static const char words[] = "interval at level ", key[] = "interval_level";
    const char *level = strstr(line, words);
    if (!level)
        return SP_OK;
    level += strlen(words);
    return add_value(t, key, strlen(key), level, strcspn(level, ",; \n"), err);
}

/* Records the metadata in the last comment line, if there is any. */
static sp_status index_comment(sp_table *t, sp_error *err) {
    const char *line = t->comment[t->comments - 1], *key = skip_blanks(line), *sign;
    /* "pressure = 1e-4, grains = 1024, ..." and "dimension = 2, friction = 0.5, ..." */
    const bool list = strncmp(key, "pressure = ", 11) == 0 || strncmp(key, "dimension = ", 12) == 0;
    sp_status status = index_sentence(t, line, err);
    while (status == SP_OK && key && (sign = equals_sign(key)) != NULL && sign > key) {
        const char *text = skip_blanks(sign + 1), *comma = list ? strstr(text, ", ") : NULL;
        const size_t length = comma ? (size_t)(comma - text) : strcspn(text, "\n");
        status = add_value(t, key, (size_t)(sign - key), text, length, err);
        key = comma ? skip_blanks(comma + 1) : NULL;
    }
    return status;
}

sp_status sp_table_add_comment(sp_table *t, sp_error *err, const char *format, ...) {
    char line[2048];
    va_list args;
    sp_locale locale = sp_locale_enter();
    va_start(args, format);
    vsnprintf(line, sizeof line, format, args);
    va_end(args);
    sp_locale_leave(&locale);
    sp_status status = add_line(t, line, err);
    return status == SP_OK ? index_comment(t, err) : status;
}

static const sp_table_value *find(const sp_table *t, const char *key) {
    for (int k = 0; k < t->values; k++)
        if (strcmp(t->value[k].key, key) == 0)
            return &t->value[k];
    return NULL;
}

bool sp_table_get_number(const sp_table *t, const char *key, double *value) {
    const sp_table_value *v = find(t, key);
    if (!v || !isfinite(v->number))
        return false;
    *value = v->number;
    return true;
}

const char *sp_table_get_text(const sp_table *t, const char *key) {
    const sp_table_value *v = find(t, key);
    return v ? v->text : NULL;
}

/* ---- writing ---------------------------------------------------------------------------------------------------- */

sp_status sp_table_set_text(sp_table *t, const char *key, const char *value, sp_error *err) {
    if (find(t, key))
        return sp_fail(err, SP_EINVAL, "%s: the table already has this metadata", key);
    char line[2048];
    snprintf(line, sizeof line, "%s = %s", key, value);
    sp_status status = add_line(t, line, err);
    return status == SP_OK ? add_value(t, key, strlen(key), value, strlen(value), err) : status;
}

sp_status sp_table_set_integer(sp_table *t, const char *key, int64_t value, sp_error *err) {
    char text[24];
    snprintf(text, sizeof text, "%lld", (long long)value);
    return sp_table_set_text(t, key, text, err);
}

sp_status sp_table_set_number(sp_table *t, const char *key, double value, int digits, sp_error *err) {
    char text[SP_NUMBER_TEXT];
    if (digits < 0 || digits > 17)
        return sp_fail(err, SP_EINVAL, "%s: %d digits: must be 0 to 17", key, digits);
    sp_number_text(value, text);
    if (digits > 0 && isfinite(value)) {
        sp_locale locale = sp_locale_enter();
        snprintf(text, sizeof text, "%.*g", digits, value);
        sp_locale_leave(&locale);
    }
    return sp_table_set_text(t, key, text, err);
}
