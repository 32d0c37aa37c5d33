/* Draws what becomes of fronts and bursts as they grow loud. */
#include "figure/canvas.h"
#include "figure/columns.h"
#include "figure/markup.h"
#include "figure/unit.h"

#include "base/base.h"

#include <math.h>
#include <sonopack/figure/figure.h>
#include <sonopack/figure/plot.h>
#include <stdio.h>
#include <string.h>

enum { GROUPS_MOST = 18, KEYS = 4, LABEL = 160, VALUES = 6 };
static const char *const key_names[KEYS] = {"dimension", "friction", "p", "amplitude"};
static const char *const key_symbols[KEYS] = {"dimensions", "|\xce\xbc|", "|p|", "|A|"};

/* The columns of a kind of table, and which keys divide its rows into groups. Fronts have numbers of contacts, which
 * are drawn over that of all; bursts have heights. */
typedef struct layout {
    const char *column[VALUES]; /* x, y, its error, then of fronts slid, opened and carrying */
    int values, keys;
} layout;
static const layout fronts = {
    {"amplitude", "speed_ratio", "speed_ratio_err", "slid", "opened", "carrying"}, VALUES, KEYS - 1};
static const layout bursts = {{"y", "ratio", "ratio_err"}, 3, KEYS};

/* Successive rows of one table with the same keys. */
typedef struct group {
    int64_t n;
    double key[KEYS]; /* NAN: the table has none */
    double *value[VALUES];
    char label[LABEL];
} group;

typedef struct groups {
    const layout *layout;
    int n;
    group group[GROUPS_MOST];
    double *memory;
    bool open; /* the last group may grow */
} groups;

/* ---- reading ---------------------------------------------------------------------------------------------------- */

static bool has(const sp_table *t, const layout *l) {
    for (int q = 0; q < l->values; q++) {
        const int at = sp_table_find_column(t, l->column[q]);
        if (at < 0 || t->column[at].kind == SP_COLUMN_TEXT)
            return false;
    }
    return true;
}

static double key_of(const sp_table *t, int64_t row, int key) {
    const int at = sp_table_find_column(t, key_names[key]);
    return at < 0 ? NAN : sp_table_number(t, row, at);
}

static bool same(double a, double b) { return a == b || (isnan(a) && isnan(b)); }

/* Whether a row goes on with a group; the x of a group ascend, so that files with the same keys make several. */
static bool belongs(const groups *g, const group *last, const sp_table *t, int64_t row, double x) {
    for (int k = 0; k < g->layout->keys; k++)
        if (!same(last->key[k], key_of(t, row, k)))
            return false;
    return last->n == 0 || x > last->value[0][last->n - 1];
}

static sp_status add_row(groups *g, const sp_table *t, int64_t row, double **memory, sp_error *err) {
    const double x = sp_table_number(t, row, sp_table_find_column(t, g->layout->column[0]));
    group *to = g->n > 0 ? &g->group[g->n - 1] : NULL;
    if (!g->open || !belongs(g, to, t, row, x)) {
        if (g->n == GROUPS_MOST)
            return sp_fail(err, SP_EREFUSED, "more than %d curves: draw fewer rows, or means (--mean)", GROUPS_MOST);
        to = &g->group[g->n++];
        g->open = true;
        for (int k = 0; k < KEYS; k++)
            to->key[k] = k < g->layout->keys ? key_of(t, row, k) : NAN;
        for (int q = 0; q < g->layout->values; q++) {
            to->value[q] = *memory;
            *memory += t->rows;
        }
    }
    for (int q = 0; q < g->layout->values; q++) {
        const double value = sp_table_number(t, row, sp_table_find_column(t, g->layout->column[q]));
        to->value[q][to->n] = isfinite(value) ? value : NAN;
    }
    for (int q = 3; q < 5 && g->layout->values > 5; q++) /* shares of contacts */
        to->value[q][to->n] /= sp_table_number(t, row, sp_table_find_column(t, g->layout->column[5]));
    to->n++;
    return SP_OK;
}

/* Names what differs between the groups, or the files. */
static void name_groups(groups *g, const sp_plot_table *first, bool own, const char *unit) {
    for (int j = 0; j < g->n; j++) {
        group *a = &g->group[j];
        size_t used = 0; /* four short numbers: the label holds them */
        *a->label = '\0';
        for (int k = 0; k < KEYS && !own; k++) {
            char number[48];
            bool differs = false;
            for (int i = 0; i < g->n; i++)
                differs = differs || !same(g->group[i].key[k], a->key[k]);
            if (!differs || isnan(a->key[k]))
                continue;
            sp_figure_text_number(number, sizeof number, a->key[k], 3);
            used += (size_t)snprintf(a->label + used, LABEL - used, "%s%s = %s%s%s", used ? ", " : "", key_symbols[k],
                                     number, k == 2 && *unit ? " " : "", k == 2 ? unit : "");
        }
        if (own && g->n == 1)
            sp_figure_text_escape(a->label, LABEL, first->label, 40);
    }
}

static sp_status read_groups(int tables, const sp_plot_table *table, groups *g, sp_error *err) {
    size_t rows = 0, most = 0;
    g->layout = has(table[0].table, &fronts) ? &fronts : &bursts;
    for (int j = 0; j < tables; j++) {
        if (!has(table[j].table, g->layout))
            return sp_fail(err, SP_EINVAL,
                           "table %d: must be of `sonopack amplitude', with fronts (amplitude, speed_ratio) or with "
                           "bursts at planes (y, ratio), all of one kind",
                           j + 1);
        rows += (size_t)table[j].table->rows;
        most = (size_t)table[j].table->rows > most ? (size_t)table[j].table->rows : most;
    }
    if (rows == 0)
        return sp_fail(err, SP_EREFUSED, "nothing to draw: the table has no row");
    g->memory = sp_alloc(GROUPS_MOST * VALUES * most, sizeof *g->memory);
    if (!g->memory)
        return sp_fail_memory(err, GROUPS_MOST * VALUES * most * sizeof *g->memory);
    double *memory = g->memory;
    sp_status status = SP_OK;
    for (int j = 0; j < tables && status == SP_OK; j++) {
        g->open = false;
        for (int64_t row = 0; row < table[j].table->rows && status == SP_OK; row++)
            status = add_row(g, table[j].table, row, &memory, err);
    }
    const char *unit;
    char pressure[UNIT_MARKUP];
    if (status == SP_OK)
        status = sp_unit_common(tables, table, "p", UNIT_PRESSURE, &unit, err);
    if (status != SP_OK)
        return status;
    sp_unit_markup(unit, pressure);
    name_groups(g, table, tables == 1 && table[0].named, pressure);
    return SP_OK;
}

/* ---- drawing ---------------------------------------------------------------------------------------------------- */

/* The place of a group's key among the different values of this key. */
static int rank_of(const groups *g, int j, int key) {
    int rank = 0;
    for (int i = 0; i < g->n; i++) {
        bool first = true;
        for (int k = 0; k < i; k++)
            first = first && !same(g->group[k].key[key], g->group[i].key[key]);
        if (same(g->group[i].key[key], g->group[j].key[key]))
            return rank;
        rank += first;
    }
    return rank;
}

/* Pressures (of bursts amplitudes) have colours, frictions marks, so that curves of both can be told apart. */
static void dress(const groups *g, int j, sp_curve *c) {
    static const sp_mark marks[] = {SP_MARK_CIRCLE, SP_MARK_SQUARE, SP_MARK_TRIANGLE, SP_MARK_DIAMOND};
    const int mark = rank_of(g, j, 1);
    c->ink = rank_of(g, j, g->layout == &fronts ? 2 : KEYS - 1) % 6 + 1;
    c->mark = marks[mark % 4];
    c->open = mark % 2 == 1;
}

static sp_curve curve_of(const groups *g, int j, int q) {
    const group *a = &g->group[j];
    sp_curve c = {.n = a->n, .x = a->value[0], .y = a->value[q], .error = q == 1 ? a->value[2] : NULL};
    dress(g, j, &c);
    return c;
}

static bool slides(const group *a) {
    for (int64_t k = 0; k < a->n; k++)
        if (a->value[3][k] > 0)
            return true;
    return false;
}

/* Shares of contacts that opened, and dashed of those that slid: without friction none does. Returns the curves. */
static int share_curves(const groups *g, sp_curve *share) {
    int n = g->n, first = g->n;
    for (int j = 0; j < g->n; j++) {
        share[j] = curve_of(g, j, 4);
        share[j].label = j == 0 ? "opened" : NULL;
        if (!slides(&g->group[j]))
            continue;
        share[n] = curve_of(g, j, 3);
        share[n].dash = SP_DASH_DASHED;
        share[n].mark = SP_MARK_NONE;
        share[n].label = n == first ? "slid" : NULL;
        n++;
    }
    return n;
}

static sp_status draw_fronts(const groups *g, const char *path, sp_error *err) {
    sp_curve speed[GROUPS_MOST], share[2 * GROUPS_MOST];
    const sp_axis x = {.label = "amplitude |A|", .log = true};
    const int shares = share_curves(g, share);
    for (int j = 0; j < g->n; j++) {
        speed[j] = curve_of(g, j, 1);
        speed[j].label = *g->group[j].label ? g->group[j].label : NULL;
    }
    const sp_panel panel[2] = {
        {.tag = "(a)", .x = x, .y = {.label = "speed over its linear limit"}, .curves = g->n, .curve = speed},
        {.tag = "(b)", .x = x, .y = {.label = "share of the contacts"}, .curves = shares, .curve = share}};
    const sp_sheet sheet = {.title = "Loud pulses", .rows = 2, .columns = 1, .panel = panel, .aspect = 0.68};
    return sp_plot_sheet(&sheet, path, err);
}

static sp_status draw_bursts(int tables, const sp_plot_table *table, const groups *g, const char *path, sp_error *err) {
    char label[UNIT_MARKUP + 40];
    sp_curve ratio[GROUPS_MOST];
    const char *unit;
    const sp_status status = sp_unit_common(tables, table, "y", UNIT_LENGTH, &unit, err);
    if (status != SP_OK)
        return status;
    sp_unit_label("height |y|", unit, label, sizeof label);
    for (int j = 0; j < g->n; j++) {
        ratio[j] = curve_of(g, j, 1);
        ratio[j].label = *g->group[j].label ? g->group[j].label : NULL;
    }
    const sp_panel panel = {
        .x = {.label = label}, .y = {.label = "|F|_{2}/|F|_{1}^{2}"}, .curves = g->n, .curve = ratio};
    const sp_sheet sheet = {.title = "Loud bursts", .rows = 1, .columns = 1, .panel = &panel};
    return sp_plot_sheet(&sheet, path, err);
}

sp_status sp_plot_amplitude(int tables, const sp_plot_table *table, const char *path, sp_error *err) {
    groups g = {0};
    sp_status status = sp_canvas_check(path, err);
    if (status == SP_OK && tables < 1)
        status = sp_fail(err, SP_EINVAL, "no table to draw");
    if (status == SP_OK)
        status = read_groups(tables, table, &g, err);
    if (status == SP_OK)
        status = g.layout == &fronts ? draw_fronts(&g, path, err) : draw_bursts(tables, table, &g, path, err);
    sp_free(g.memory);
    return status;
}
