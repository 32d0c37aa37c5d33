/* Chooses the figure of the tapped column that suits the given tables. */
#include "figure/canvas.h"
#include "figure/tapped_table.h"

#include "base/base.h"

#include <stdio.h>
#include <string.h>

enum { TABLES_MOST = 6 };

static bool suits_surface(const tapped_table *s) {
    return s->output == TAPPED_TRAJECTORY || s->output == TAPPED_DENSITY;
}

static bool all_suit_surface(int tables, const tapped_table *s) {
    bool all = true;
    for (int k = 0; k < tables; k++)
        all = all && suits_surface(&s[k]);
    return all;
}

/* Sorts a bifurcation and a Lyapunov table, given in any order; false if there are others. */
static bool sort_diagram(int tables, const tapped_table *s, const tapped_table *of[2]) {
    of[0] = of[1] = NULL;
    for (int k = 0; k < tables; k++) {
        if (s[k].output != TAPPED_BIFURCATION && s[k].output != TAPPED_LYAPUNOV)
            return false;
        const int which = s[k].output == TAPPED_LYAPUNOV;
        if (of[which])
            return false;
        of[which] = &s[k];
    }
    return true;
}

static sp_status draw_diagram(const tapped_table *const of[2], const char *wanted, const char *path, sp_error *err) {
    int column = -1;
    if (of[0]) {
        column = sp_tapped_table_column(of[0], wanted ? wanted : "y1");
        if (column < of[0]->first || column >= of[0]->first + of[0]->particles)
            return sp_fail(err, SP_EINVAL, "the table has no column %.40s of positions, must be y1 to y%d", wanted,
                           of[0]->particles);
    }
    return sp_tapped_draw_diagram(of[0], column, of[1], path, err);
}

static bool share_a_figure(const tapped_table *a, const tapped_table *b) {
    return (suits_surface(a) && suits_surface(b)) ||
           (a->output == TAPPED_BIFURCATION && b->output == TAPPED_LYAPUNOV) ||
           (a->output == TAPPED_LYAPUNOV && b->output == TAPPED_BIFURCATION);
}

/* Reports the first two tables that cannot share a figure. */
static sp_status fail_together(int tables, const tapped_table *s, sp_error *err) {
    int one = 0, two = 1;
    while (one + 2 < tables && share_a_figure(&s[one], &s[two])) {
        two = two + 1 < tables ? two + 1 : ++one + 1;
    }
    return sp_fail(err, SP_EINVAL,
                   "table %d is %s and table %d %s: they make no figure together; must be trajectories, densities, or "
                   "a bifurcation and a Lyapunov table",
                   one + 1, sp_tapped_table_kind(s[one].output), two + 1, sp_tapped_table_kind(s[two].output));
}

static sp_status draw_one(const tapped_table *s, const char *path, sp_error *err) {
    switch (s->output) {
    case TAPPED_STROBE: return sp_tapped_draw_strobe(s, path, err);
    case TAPPED_COMPARE: return sp_tapped_draw_compare(s, path, err);
    case TAPPED_DENSITY: return sp_tapped_draw_density(s, path, err);
    case TAPPED_ENERGY: return sp_tapped_draw_energy(s, path, err);
    case TAPPED_TRAJECTORY:
    case TAPPED_LYAPUNOV:
    case TAPPED_BIFURCATION: break;
    }
    return sp_tapped_draw_trajectory(s, path, err);
}

static sp_status draw(int tables, const tapped_table *s, const sp_plot_column_options *o, const char *path,
                      sp_error *err) {
    const tapped_table *of[2];
    const bool diagram = sort_diagram(tables, s, of), surface = tables > 1 || o->surface;
    if (o->column && !(diagram && of[0]))
        return sp_fail(err, SP_EINVAL, "column %.40s: only a bifurcation has a choice of column", o->column);
    if (o->surface && !all_suit_surface(tables, s))
        return sp_fail(err, SP_EINVAL, "a surface is drawn of trajectories (t y0 y1 ...) or densities only");
    if (diagram)
        return draw_diagram(of, o->column, path, err);
    if (surface && all_suit_surface(tables, s))
        return sp_tapped_draw_surfaces(tables, s, path, err);
    if (tables > 1)
        return fail_together(tables, s, err);
    return draw_one(s, path, err);
}

sp_status sp_plot_column(int tables, const sp_plot_table *table, const sp_plot_column_options *options,
                         const char *path, sp_error *err) {
    static const sp_plot_column_options none = {0};
    tapped_table s[TABLES_MOST];
    sp_status status = sp_canvas_check(path, err);
    if (status == SP_OK && (tables < 1 || tables > TABLES_MOST))
        status = sp_fail(err, SP_EINVAL, "%d tables: a figure shows 1 to %d", tables, TABLES_MOST);
    for (int k = 0; k < tables && status == SP_OK; k++) {
        status = sp_tapped_table_read(&table[k], &s[k], err);
        if (status != SP_OK && tables > 1)
            sp_fail_prefix(err, "table %d", k + 1);
    }
    return status == SP_OK ? draw(tables, s, options ? options : &none, path, err) : status;
}
