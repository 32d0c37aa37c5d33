/* Reads tables, and the signals and detectors in them. */
#include "cli/trace.h"

#include "base/base.h"
#include "base/file.h"
#include "base/text.h"
#include "cli/output.h"
#include "store/packing_text.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* ---- CSV -------------------------------------------------------------------------------------------------------- */

/* The next cell of a line, unquoted in place as in RFC 4180; NULL after the last. */
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

/* Adds the columns, and allocates a row. */
static sp_status csv_header(const char *path, char *text, double **row, sp_table *t, sp_error *err) {
    for (char *cell; (cell = csv_cell(&text)) != NULL;) {
        sp_status status = sp_table_add_column(t, cell, "", SP_COLUMN_NUMBER, err);
        if (status != SP_OK) {
            sp_fail_prefix(err, "%s", path);
            return status;
        }
    }
    *row = sp_alloc((size_t)t->columns, sizeof **row);
    return *row ? SP_OK : sp_fail_memory(err, (size_t)t->columns * sizeof **row);
}

/* row: of so many numbers as there are columns, to work in. */
static sp_status csv_row(const char *path, int64_t line, char *text, double *row, sp_table *t, sp_error *err) {
    int count = 0;
    for (char *cell; (cell = csv_cell(&text)) != NULL; count++) {
        if (count < t->columns && !csv_number(cell, &row[count]))
            return sp_fail(err, SP_EFORMAT, "%s:%lld: %s = \"%.40s\": must be a number or empty", path, (long long)line,
                           t->column[count].name, cell);
    }
    if (count != t->columns)
        return sp_fail(err, SP_EFORMAT, "%s:%lld: %d cells where there are %d columns", path, (long long)line, count,
                       t->columns);
    return sp_table_add_numbers(t, row, err);
}

/* Reads comments after '#', a header, and rows. */
static sp_status csv_lines(const char *path, char *text, sp_table *t, sp_error *err) {
    sp_status status = SP_OK;
    double *row = NULL;
    char *rest = text;
    for (int64_t number = 1; rest && status == SP_OK; number++) {
        char *line = strsep(&rest, "\n");
        line[strcspn(line, "\r")] = '\0';
        if (*line == '#')
            status = sp_table_add_comment(t, err, "%s", line + 1 + (line[1] == ' '));
        else if (*line && t->columns == 0)
            status = csv_header(path, line, &row, t, err);
        else if (*line)
            status = csv_row(path, number, line, row, t, err);
    }
    if (status == SP_OK && t->columns == 0)
        status = sp_fail(err, SP_EFORMAT, "%s: is no table: it has no header", path);
    sp_free(row);
    return status;
}

static sp_status read_csv(const char *path, sp_table *out, sp_error *err) {
    sp_table t = sp_table_none();
    char *text = NULL;
    size_t size = 0;
    sp_status status = sp_file_read_text(path, &text, &size, err);
    if (status != SP_OK)
        return status;
    status = csv_lines(path, text, &t, err);
    sp_free(text);
    if (status == SP_OK)
        *out = t;
    else
        sp_table_free(&t);
    return status;
}

sp_status cli_read_table(const char *path, sp_table *out, sp_error *err) {
    return cli_has_ending(path, ".csv") ? read_csv(path, out, err) : sp_table_read(path, out, err);
}

/* ---- signals ---------------------------------------------------------------------------------------------------- */

sp_status cli_is_packing(const char *path, bool *yes, sp_error *err) {
    struct stat info;
    char head[8192];
    *yes = false;
    if (stat(path, &info) == 0 && !S_ISREG(info.st_mode))
        return SP_OK;
    FILE *file = fopen(path, "rb");
    if (!file)
        return sp_fail(err, SP_EIO, "cannot open %s: %s", path, strerror(errno));
    const size_t size = fread(head, 1, sizeof head - 1, file);
    fclose(file);
    head[size] = '\0';
    *yes = strlen(head) < size || sp_packing_text_looks(head);
    return SP_OK;
}

/* A positive number in the metadata, 0 without one. */
static double positive_number(const sp_table *t, const char *key) {
    double value;
    return sp_table_get_number(t, key, &value) && value > 0.0 ? value : 0.0;
}

int cli_count_signals(const sp_table *t, int first) {
    char name[16];
    int n = 0;
    do {
        n++;
        snprintf(name, sizeof name, "F%d", n);
    } while (first + n <= t->columns && strcmp(t->column[first + n - 1].name, name) == 0 &&
             t->column[first + n - 1].kind != SP_COLUMN_TEXT);
    return n > 1 ? n - 1 : 1;
}

/* A number of the metadata in our unit: in a table in SI its unit stands behind it. */
static double own_number(const sp_table *t, const char *key, const char *unit, const sp_material *m) {
    const char *text = sp_table_get_text(t, key);
    double value;
    const bool si = text && m->young > 0 && sp_quantity_read(text, unit, m, &value, NULL) == SP_OK;
    return si && value > 0.0 ? value : positive_number(t, key);
}

/* The window of the first front, in the unit of the times. A table of ours in SI says of which material. */
static void find_window(const sp_table *table, cli_trace *s) {
    const char *text = sp_table_get_text(table, "material");
    sp_material m = {0};
    char si[SP_UNIT_TEXT] = "";
    double factor = 1.0;
    s->foreign = strcmp(s->t_unit, "d/sqrt(E* / rho)") != 0;
    s->length_unit = s->foreign ? "" : "d";
    if (text && sp_material_read(text, &m, NULL) == SP_OK)
        sp_unit_to_si("d/sqrt(E* / rho)", &m, &factor, si, NULL);
    const bool ours_in_si = si[0] && strcmp(si, s->t_unit) == 0;
    if (ours_in_si)
        s->length_unit = "mm";
    else
        m = (sp_material){0};
    const double height = own_number(table, "height", "d", &m), pressure = own_number(table, "pressure", "E*", &m);
    s->window = height > 0.0 && pressure > 0.0 ? sp_signal_window(height, pressure) : 0.0;
    s->window *= ours_in_si ? factor : 1.0;
}

sp_status cli_trace_of(const sp_table *table, int time, int force, cli_trace *out, sp_error *err) {
    const int64_t n = table->rows;
    double *t = sp_alloc((size_t)n, 2 * sizeof *t);
    if (!t)
        return sp_fail_memory(err, (size_t)n * 2 * sizeof *t);
    for (int64_t k = 0; k < n; k++) {
        t[k] = sp_table_number(table, k, time);
        t[n + k] = sp_table_number(table, k, force);
    }
    const double height = positive_number(table, "height");
    *out = (cli_trace){.n = n, .t = t, .f = t + n, .height = height > 0 ? height : NAN};
    snprintf(out->t_unit, sizeof out->t_unit, "%s", table->column[time].unit);
    snprintf(out->f_unit, sizeof out->f_unit, "%s", table->column[force].unit);
    find_window(table, out);
    return SP_OK;
}

/* The height in "plane:25:normal"; NAN if the place is not a plane. */
static double plane_of(const char *place) {
    char number[100];
    double height = NAN;
    if (strncmp(place, "plane:", 6) != 0)
        return NAN;
    snprintf(number, sizeof number, "%.*s", (int)strspn(place + 6, "0123456789.eE+-"), place + 6);
    sp_word_number(number, &height);
    return height;
}

bool cli_find_detector(const sp_table *t, const char *column, cli_detector *out) {
    const char *text = sp_table_get_text(t, column), *to = text ? strstr(text, " to ") : NULL;
    if (!to)
        return false;
    *out = (cli_detector){.plane = plane_of(to + 4)};
    snprintf(out->word, sizeof out->word, "%.*s", (int)strcspn(to + 4, ","), to + 4);
    const double source = strncmp(text, "from ", 5) == 0 ? plane_of(text + 5) : NAN;
    out->source = isfinite(source) ? source : 0;
    return true;
}

double cli_way(const sp_table *t, const cli_detector *detector, double at) {
    const char *cell = sp_table_get_text(t, "cell");
    const double height = positive_number(t, "height"), way = fabs(at - detector->source);
    return cell && strcmp(cell, "periodic") == 0 && height > way ? fmin(way, height - way) : way;
}
