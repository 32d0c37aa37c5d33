/* Builds tables in memory and looks values up in them. */
#include "base/base.h"
#include "table/array.h"
#include "table/metadata.h"
#include "table/quantity.h"

#include <math.h>
#include <sonopack/table.h>
#include <stdarg.h>
#include <stdio.h>
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

sp_status sp_table_add_line(sp_table *t, const char *line, sp_error *err) {
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
