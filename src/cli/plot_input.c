#include "cli/plot_input.h"

#include "base/base.h"
#include "cli/output.h"
#include "store/file.h"
#include "store/packing_text.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* ---- CSV -------------------------------------------------------------------------------------------------------- */

enum { CSV_COLUMNS = sizeof((sp_table *)0)->column / sizeof *((sp_table *)0)->column };

/* Next cell of a line, in place; quotes as in RFC 4180. NULL behind the last. */
static char *csv_cell(char **at) {
    char *from = *at, *to = *at, *cell = *at;
    if (!from)
        return NULL;
    bool quoted = *from == '"';
    for (from += quoted; *from && (quoted || *from != ','); from++) {
        if (quoted && *from == '"') {
            if (from[1] != '"') {
                quoted = false;
                continue;
            }
            from++;
        }
        *to++ = *from;
    }
    *at = *from == ',' ? from + 1 : NULL;
    *to = '\0';
    return cell;
}

/* An empty cell is NAN. */
static bool csv_number(const char *cell, double *out) {
    char *end;
    *out = *cell ? strtod(cell, &end) : NAN;
    return !*cell || (end > cell && end[strspn(end, " ")] == '\0');
}

/* A row of as many numbers as there are columns; cells behind them stay empty. */
static sp_status csv_row(const char *path, int64_t line, char *text, sp_table *t, sp_error *err) {
    double value[CSV_COLUMNS];
    int count = 0;
    for (char *cell; (cell = csv_cell(&text)) != NULL; count++) {
        if (count == t->columns)
            return sp_fail(err, SP_EFORMAT, "%s:%lld: more cells than the %d columns", path, (long long)line,
                           t->columns);
        if (!csv_number(cell, &value[count]))
            return sp_fail(err, SP_EFORMAT, "%s:%lld: %s = \"%.40s\": must be a number or empty", path, (long long)line,
                           t->column[count].name, cell);
    }
    if (count != t->columns)
        return sp_fail(err, SP_EFORMAT, "%s:%lld: %d cells where there are %d columns", path, (long long)line, count,
                       t->columns);
    /* the variadic call reads one cell for each column and ignores the others */
    sp_table row = *t;
    row.rows = row.capacity = 0;
    if (t->rows == t->capacity) {
        const int64_t capacity = t->capacity ? 2 * t->capacity : 64;
        sp_cell *cells = sp_alloc((size_t)capacity * (size_t)t->columns, sizeof *cells);
        if (!cells)
            return sp_fail_memory(err, (size_t)capacity * (size_t)t->columns * sizeof *cells);
        if (t->rows > 0)
            memcpy(cells, t->cells, (size_t)(t->rows * t->columns) * sizeof *cells);
        sp_free(t->cells);
        t->cells = cells;
        t->capacity = capacity;
    }
    for (int c = 0; c < t->columns; c++)
        t->cells[t->rows * t->columns + c].number = value[c];
    t->rows++;
    return SP_OK;
}
