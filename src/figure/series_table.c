/* Reads tables of fronts against distance and cuts them into groups. */
#include "figure/series_table.h"

#include "base/base.h"
#include "figure/unit.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { TABLES_MOST = 32, LABEL_MOST = 24 };
/* `chain front' computes exponents between N and 2 N. */
#define OCTAVE 1.4142135623730951

static const char *const names[Q_BETWEEN] = {
    [Q_DISTANCE] = "distance",    [Q_T10] = "t10",       [Q_T_PEAK] = "t_peak", [Q_T_ZERO] = "t_zero",
    [Q_AMPLITUDE] = "amplitude",  [Q_WIDTH] = "width10", [Q_GAMMA] = "gamma",   [Q_ALPHA] = "alpha",
    [Q_ALPHA_PEAK] = "alpha_peak"};

typedef struct reader {
    const sp_plot_table *from;
    int column[Q_BETWEEN], error[Q_BETWEEN]; /* < 0: not in the table */
    int key[GROUP_KEYS];
    int file; /* the column of `sonopack front' with the files of the rows; < 0: none */
    bool chain;
} reader;

static int number_column(const sp_table *t, const char *name) {
    const int column = sp_table_find_column(t, name);
    return column >= 0 && t->column[column].kind != SP_COLUMN_TEXT ? column : -1;
}

/* No column for the figure: a signal becomes a table of fronts by another command. */
static sp_status fail_column(const sp_table *t, const char *column, sp_error *err) {
    const bool force = sp_table_find_column(t, "F") >= 0 || sp_table_find_column(t, "F1") >= 0;
    if (force && sp_table_find_column(t, "t") >= 0)
        return sp_fail(
            err, SP_EINVAL,
            "is a table of signals, without distances: run `sonopack front' on it first, and draw its table");
    return sp_fail(err, SP_EINVAL,
                   "the table has no column of numbers %s; must be of `sonopack table scaling' or `planes', `chain "
                   "front' or `front'",
                   column);
}

static sp_status find_columns(const sp_plot_table *from, reader *r, sp_error *err) {
    const sp_table *t = from->table;
    *r = (reader){.from = from};
    r->file = sp_table_find_column(t, "file");
    if (r->file >= 0 && t->column[r->file].kind != SP_COLUMN_TEXT)
        r->file = -1;
    r->key[G_PRESSURE] = number_column(t, "p");
    r->key[G_FRICTION] = number_column(t, "friction");
    r->key[G_WIDTH] = -1;
    for (int q = 0; q < Q_BETWEEN; q++) {
        char error[48];
        snprintf(error, sizeof error, "%s_err", names[q]);
        r->column[q] = number_column(t, names[q]);
        r->error[q] = number_column(t, error);
    }
    if (r->column[Q_WIDTH] >= 0)
        r->key[G_WIDTH] = number_column(t, "width"); /* width of the box */
    else
        r->column[Q_WIDTH] = number_column(t, "width"); /* width of the pulse */
    if (r->column[Q_DISTANCE] < 0) {
        r->column[Q_DISTANCE] = number_column(t, "grains");
        r->chain = r->column[Q_DISTANCE] >= 0;
    }
    r->key[G_GRAINS] = r->chain ? -1 : number_column(t, "grains");
    if (r->column[Q_DISTANCE] < 0 || r->column[Q_T10] < 0)
        return fail_column(t, r->column[Q_DISTANCE] < 0 ? "distance or grains" : "t10", err);
    return SP_OK;
}

static double number(const sp_table *t, int64_t row, int column) {
    return column < 0 ? NAN : sp_table_number(t, row, column);
}

static bool same(double a, double b) { return a == b || (isnan(a) && isnan(b)); }

/* The file of a row of `sonopack front', without the ":F2" of one signal of several. Sets whether it had that. */
static size_t file_length(const char *name, bool *several) {
    const char *colon = strrchr(name, ':');
    *several = colon && colon[1] == 'F' && colon[2] && colon[2 + strspn(colon + 2, "0123456789")] == '\0';
    return *several ? (size_t)(colon - name) : strlen(name);
}

static const char *file_of(const reader *r, int64_t row) {
    const sp_table *t = r->from->table;
    const char *name = t->cells[row * t->columns + r->file].text;
    return name ? name : "";
}

/* Signals of one file belong together, and so do files with one signal each, in whatever order. */
static bool of_one_file(const reader *r, int64_t row) {
    bool several, before;
    const char *name = file_of(r, row), *last = file_of(r, row - 1);
    const size_t length = file_length(name, &several);
    return length == file_length(last, &before) && several && before ? strncmp(name, last, length) == 0
                                                                     : !several && !before;
}

/* Rows of one group are consecutive, with increasing distances. */
static bool joined(const reader *r, int64_t row) {
    const sp_table *t = r->from->table;
    bool like = row > 0;
    if (like && r->file >= 0)
        return of_one_file(r, row);
    for (int k = 0; k < G_GRAINS && like; k++)
        like = same(number(t, row, r->key[k]), number(t, row - 1, r->key[k]));
    return like && !(number(t, row, r->column[Q_DISTANCE]) <= number(t, row - 1, r->column[Q_DISTANCE]));
}

static sp_status check_row(const sp_table *t, const reader *r, int64_t row, sp_error *err) {
    for (int q = 0; q < Q_BETWEEN; q++) {
        const double value = number(t, row, r->column[q]), error = number(t, row, r->error[q]);
        const bool positive = q == Q_DISTANCE || q == Q_AMPLITUDE || q == Q_WIDTH;
        if (isinf(value) || (positive && value <= 0))
            return sp_fail(err, SP_EREFUSED, "row %lld, %s = %g: must be %s", (long long)row + 1,
                           t->column[r->column[q]].name, value, positive ? "above 0, or nan" : "finite, or nan");
        if (error < 0 || isinf(error))
            return sp_fail(err, SP_EREFUSED, "row %lld, %s = %g: an error is a number >= 0, or nan", (long long)row + 1,
                           t->column[r->error[q]].name, error);
    }
    return SP_OK;
}

/* The file of a group, without its folder and ending. Several files with one signal each have no name in common. */
static void name_group(const reader *r, int64_t first, front_group *g) {
    bool several;
    const char *name = file_of(r, first);
    const size_t length = file_length(name, &several);
    char raw[128];
    if (!several && g->n > 1) {
        snprintf(g->file, sizeof g->file, "single signals");
        return;
    }
    snprintf(raw, sizeof raw, "%.*s", (int)fmin((double)length, sizeof raw - 1), name);
    char *slash = strrchr(raw, '/'), *base = slash && slash[1] ? slash + 1 : raw, *dot = strrchr(base, '.');
    if (dot && dot > base)
        *dot = '\0';
    sp_figure_text_escape(g->file, sizeof g->file, base, LABEL_MOST);
}

/* Copies the rows of a group into its arrays, [QUANTITIES][2][n]. */
static void fill_group(const reader *r, int64_t first, front_group *g, double *memory) {
    const sp_table *t = r->from->table;
    for (int q = 0; q < QUANTITIES; q++) {
        double *value = memory + 2 * q * g->n, *error = value + g->n;
        g->value[q] = value;
        g->error[q] = error;
        for (int64_t k = 0; k < g->n; k++) {
            value[k] = q < Q_BETWEEN ? number(t, first + k, r->column[q]) : NAN;
            error[k] = q < Q_BETWEEN ? number(t, first + k, r->error[q]) : NAN;
        }
    }
    const double *distance = g->value[Q_DISTANCE];
    double *between = memory + 2 * Q_BETWEEN * g->n;
    for (int64_t k = 0; k < g->n; k++)
        between[k] = r->chain ? OCTAVE * distance[k] : k + 1 < g->n ? sqrt(distance[k] * distance[k + 1]) : NAN;
    for (int q = 0; q < GROUP_KEYS; q++) {
        g->key[q] = number(t, first, r->key[q]);
        for (int64_t k = 1; k < g->n; k++)
            if (!same(number(t, first + k, r->key[q]), g->key[q]))
                g->key[q] = NAN;
    }
    g->chain = r->chain;
    if (r->file >= 0)
        name_group(r, first, g);
}

static sp_status add_table(const reader *r, front_groups *out, double **memory, sp_error *err) {
    const sp_table *t = r->from->table;
    for (int64_t row = 0, end; row < t->rows; row = end) {
        for (end = row; end < t->rows && (end == row || joined(r, end)); end++) {
            sp_status status = check_row(t, r, end, err);
            if (status != SP_OK)
                return status;
        }
        if (out->n == GROUPS_MOST)
            return sp_fail(err, SP_EREFUSED,
                           "more than %d groups of rows of one pressure, width and friction, must be fewer",
                           GROUPS_MOST);
        front_group *g = &out->group[out->n++];
        g->n = end - row;
        fill_group(r, row, g, *memory);
        *memory += 2 * QUANTITIES * g->n;
    }
    return SP_OK;
}

static bool differs(const front_groups *g, int k, group_key key) {
    return isfinite(g->group[k].key[key]) && !same(g->group[k].key[key], g->group[0].key[key]);
}

/* Whether the table of a group has other groups too, so that only its file tells it apart. */
static bool is_split(const front_groups *g, const int *table_of, int k) {
    bool split = false;
    for (int j = 0; j < g->n; j++)
        split = split || (j != k && table_of[j] == table_of[k]);
    return split && g->group[k].file[0];
}

/* Labels each group by what differs: file, pressure, width, friction, number of grains. */
static void label_groups(front_groups *g, const int *table_of, int tables, const sp_plot_table *table) {
    static const char *const words[GROUP_KEYS] = {"|p| = %s%s", "width %s |d|%s", "|\xce\xbc| = %s%s", "|N| = %s%s"};
    char pressure[UNIT_MARKUP + 1] = " ";
    sp_unit_markup(g->pressure_unit, pressure + 1);
    bool differ[GROUP_KEYS] = {false};
    for (int q = 0; q < GROUP_KEYS; q++)
        for (int k = 1; k < g->n; k++)
            differ[q] = differ[q] || differs(g, k, (group_key)q);
    for (int k = 0; k < g->n; k++) {
        front_group *to = &g->group[k];
        const sp_plot_table *of = &table[table_of[k]];
        size_t used = 0;
        if ((tables > 1 || of->named) && of->label)
            sp_figure_text_escape(to->label, 96, of->label, of->named ? 40 : LABEL_MOST);
        if (is_split(g, table_of, k)) {
            used = strlen(to->label);
            snprintf(to->label + used, sizeof to->label - used, "%s%s", used > 0 ? ", " : "", to->file);
        }
        for (int q = 0; q < GROUP_KEYS; q++) {
            char value[40], part[96];
            if (!differ[q] || !isfinite(to->key[q]))
                continue;
            sp_figure_text_number(value, sizeof value, to->key[q], q == G_GRAINS ? 9 : 3);
            snprintf(part, sizeof part, words[q], value, q == G_PRESSURE ? pressure : "");
            used = strlen(to->label);
            snprintf(to->label + used, sizeof to->label - used, "%s%s", used > 0 ? ", " : "", part);
        }
    }
}

/* Distances of a chain count its grains and have no unit. Chains beside packings share no units but that. */
static sp_status find_units(int tables, const sp_plot_table *table, front_groups *out, sp_error *err) {
    const bool width = sp_table_find_column(table[0].table, names[Q_WIDTH]) >= 0; /* `width' is that of the box then */
    int chains = 0;
    for (int j = 0; j < tables; j++)
        chains += sp_table_find_column(table[j].table, "distance") < 0;
    out->chain = chains == tables;
    out->mixed = chains > 0 && chains < tables;
    out->time_unit = out->amplitude_unit = out->width_unit = "";
    sp_status status = sp_unit_common(tables, table, "distance", "", &out->distance_unit, err);
    if (status == SP_OK)
        status = sp_unit_common(tables, table, "p", UNIT_PRESSURE, &out->pressure_unit, err);
    if (out->mixed || status != SP_OK)
        return status;
    status = sp_unit_common(tables, table, "t10", "", &out->time_unit, err);
    if (status == SP_OK)
        status = sp_unit_common(tables, table, "amplitude", "", &out->amplitude_unit, err);
    return status == SP_OK ? sp_unit_common(tables, table, width ? names[Q_WIDTH] : "width", "", &out->width_unit, err)
                           : status;
}

sp_status sp_front_groups_read(int tables, const sp_plot_table *table, front_groups *out, sp_error *err) {
    int64_t rows = 0;
    int table_of[GROUPS_MOST];
    *out = (front_groups){0};
    if (tables < 1 || tables > TABLES_MOST)
        return sp_fail(err, SP_EINVAL, "%d tables: a figure shows 1 to %d", tables, TABLES_MOST);
    for (int j = 0; j < tables; j++)
        rows += table[j].table->rows;
    out->group = sp_alloc(GROUPS_MOST, sizeof *out->group);
    out->memory = sp_alloc((size_t)rows, 2 * QUANTITIES * sizeof *out->memory);
    if (!out->group || !out->memory)
        return sp_fail_memory(err, (size_t)rows * 2 * QUANTITIES * sizeof *out->memory);
    double *memory = out->memory;
    sp_status status = SP_OK;
    for (int j = 0; j < tables && status == SP_OK; j++) {
        reader r;
        const int before = out->n;
        status = find_columns(&table[j], &r, err);
        if (status == SP_OK)
            status = add_table(&r, out, &memory, err);
        for (int k = before; k < out->n; k++)
            table_of[k] = j;
        if (status != SP_OK && tables > 1)
            sp_fail_prefix(err, "table %d", j + 1);
    }
    if (status == SP_OK && out->n == 0)
        status = sp_fail(err, SP_EREFUSED, "nothing to draw: no row");
    if (status == SP_OK)
        status = find_units(tables, table, out, err);
    if (status == SP_OK)
        label_groups(out, table_of, tables, table);
    return status;
}

void sp_front_groups_free(front_groups *g) {
    sp_free(g->group);
    sp_free(g->memory);
    *g = (front_groups){0};
}

int sp_group_ink(const front_groups *g, int k) { return g->n == 1 ? 0 : k % 6 + 1; }

sp_mark sp_group_mark(int k) {
    static const sp_mark marks[] = {SP_MARK_CIRCLE, SP_MARK_SQUARE, SP_MARK_TRIANGLE, SP_MARK_DIAMOND};
    return marks[k % 4];
}

sp_dash sp_group_dash(int k) {
    static const sp_dash dashes[] = {SP_DASH_SOLID, SP_DASH_DASHED, SP_DASH_DOTTED, SP_DASH_DASH_DOT};
    return dashes[k % 4];
}
