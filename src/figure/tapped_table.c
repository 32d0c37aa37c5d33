/* Recognises tables of `sonopack column` and reads their columns, for figures. */
#include "figure/tapped_table.h"

#include "base/base.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const char what[] = "must be a table of `sonopack column'";

int sp_tapped_table_column(const tapped_table *s, const char *name) {
    const int column = sp_table_find_column(s->table, name);
    return column >= 0 && s->table->column[column].kind != SP_COLUMN_TEXT ? column : -1;
}

/* Finds the first of the consecutive columns name1, name2, ..., and their number. */
static int find_run(const tapped_table *s, const char *name, int *count) {
    char wanted[24];
    snprintf(wanted, sizeof wanted, "%s1", name);
    const int first = sp_tapped_table_column(s, wanted);
    for (*count = 0; first >= 0 && first + *count < s->table->columns; ++*count) {
        snprintf(wanted, sizeof wanted, "%s%d", name, *count + 1);
        if (sp_tapped_table_column(s, wanted) != first + *count)
            break;
    }
    return first;
}

/* Recognises the output by columns that no other output has. That y1 exists is checked afterwards. */
static bool find_output(tapped_table *s) {
    static const struct {
        tapped_output output;
        const char *abscissa, *sign;
    } signs[] = {{TAPPED_LYAPUNOV, "parameter", "lambda"},
                 {TAPPED_BIFURCATION, "parameter", "tap"},
                 {TAPPED_ENERGY, "tap", "work"},
                 {TAPPED_STROBE, "tap", "density"},
                 {TAPPED_COMPARE, "t", "mean_longwave"},
                 {TAPPED_COMPARE, "t", "mean_bsr"},
                 {TAPPED_DENSITY, "t", "rho1"},
                 {TAPPED_TRAJECTORY, "t", "y0"},
                 {TAPPED_TRAJECTORY, "t", "y1"}};
    for (size_t k = 0; k < sizeof signs / sizeof *signs; k++)
        if (sp_tapped_table_column(s, signs[k].abscissa) >= 0 && sp_tapped_table_column(s, signs[k].sign) >= 0) {
            s->output = signs[k].output;
            s->abscissa = sp_tapped_table_column(s, signs[k].abscissa);
            return true;
        }
    return false;
}

static sp_status check(const tapped_table *s, int densities, sp_error *err) {
    const tapped_output o = s->output;
    if (s->particles == 0 && (o == TAPPED_TRAJECTORY || o == TAPPED_STROBE || o == TAPPED_BIFURCATION))
        return sp_fail(err, SP_EINVAL, "the table has no column y1 of numbers; %s", what);
    if (o == TAPPED_DENSITY && densities != s->particles)
        return sp_fail(err, SP_EINVAL, "%d columns y1, y2, ... and %d columns rho1, rho2, ...: must be equal numbers",
                       s->particles, densities);
    if (o == TAPPED_ENERGY && sp_tapped_table_column(s, "dissipated") < 0)
        return sp_fail(err, SP_EINVAL, "the table has no column dissipated of numbers; %s", what);
    if (s->table->rows == 0)
        return sp_fail(err, SP_EREFUSED, "nothing to draw: no row");
    return SP_OK;
}

sp_status sp_tapped_table_read(const sp_plot_table *from, tapped_table *out, sp_error *err) {
    int densities = 0;
    tapped_table s = {.table = from->table, .label = from->label, .named = from->named};
    for (int c = 0; c < from->table->columns; c++)
        if (from->table->column[c].kind == SP_COLUMN_TEXT)
            return sp_fail(err, SP_EINVAL, "column %s holds text: must be numbers", from->table->column[c].name);
    if (!find_output(&s))
        return sp_fail(err, SP_EINVAL,
                       "the table is not one of `sonopack column', with columns t y0 y1 ..., tap t y1 ... density, "
                       "parameter lambda, parameter tap y1 ..., t mean_longwave ..., t y1 ... rho1 ..., or tap work "
                       "dissipated ...");
    s.first = find_run(&s, "y", &s.particles);
    s.floor = sp_tapped_table_column(&s, "y0");
    s.density = find_run(&s, "rho", &densities);
    sp_status status = check(&s, densities, err);
    if (status == SP_OK)
        *out = s;
    return status;
}

const double *sp_tapped_table_values(const tapped_table *s, int column, double *to) {
    for (int64_t k = 0; k < s->table->rows; k++) {
        const double value = sp_table_number(s->table, k, column);
        to[k] = isfinite(value) ? value : NAN;
    }
    return to;
}

bool sp_tapped_any_finite(int64_t n, const double *y) {
    for (int64_t k = 0; k < n; k++)
        if (isfinite(y[k]))
            return true;
    return false;
}

sp_status sp_tapped_table_abscissa(const tapped_table *s, double *to, sp_error *err) {
    const char *name = s->table->column[s->abscissa].name;
    if (s->table->rows < 2)
        return sp_fail(err, SP_EREFUSED, "nothing to draw: one row, must be two or more");
    for (int64_t k = 0; k < s->table->rows; k++) {
        to[k] = sp_table_number(s->table, k, s->abscissa);
        if (!isfinite(to[k]))
            return sp_fail(err, SP_EREFUSED, "row %lld, %s = %g: must be finite", (long long)k + 1, name, to[k]);
        if (k > 0 && !(to[k] > to[k - 1]))
            return sp_fail(err, SP_EREFUSED, "row %lld, %s = %g after %g: must rise", (long long)k + 1, name, to[k],
                           to[k - 1]);
    }
    return SP_OK;
}

double sp_tapped_table_setting(const tapped_table *s, const char *key) {
    double value;
    return sp_table_get_number(s->table, key, &value) && value > 0 && isfinite(value) ? value : NAN;
}

const char *sp_tapped_axis_label(const tapped_table *s, const char *name, int column, char out[TAPPED_LABEL]) {
    const char *unit = column >= 0 ? s->table->column[column].unit : "";
    char markup[120];
    sp_figure_text_escape(markup, sizeof markup, unit, 24);
    snprintf(out, TAPPED_LABEL, "%.70s%s%s%s", name, *unit ? "  [" : "", markup, *unit ? "]" : "");
    return out;
}

const char *sp_tapped_table_kind(tapped_output output) {
    static const char *const names[] = {[TAPPED_TRAJECTORY] = "a trajectory",   [TAPPED_STROBE] = "a strobe table",
                                        [TAPPED_LYAPUNOV] = "a Lyapunov table", [TAPPED_BIFURCATION] = "a bifurcation",
                                        [TAPPED_COMPARE] = "a comparison",      [TAPPED_DENSITY] = "a density table",
                                        [TAPPED_ENERGY] = "an energy table"};
    return names[output];
}

const char *sp_tapped_violation_note(const tapped_table *s, char out[TAPPED_LABEL]) {
    int count = 0, points = 0;
    out[0] = '\0';
    for (int k = 0; k < s->table->comments; k++)
        if (sscanf(s->table->comment[k], " warning: ordering (1) violated at %9d of %9d points", &count, &points) == 2)
            snprintf(out, TAPPED_LABEL, "order (1) violated at %d of %d points", count, points);
    return out;
}

const char *sp_tapped_parameter_label(const tapped_table *s, char out[TAPPED_LABEL]) {
    static const char *const known[][2] = {
        {"amplitude", "|a|"}, {"period", "|T|"}, {"frequency", "|f|"}, {"restitution", "|e|"}, {"e", "|e|"}};
    const char *text = sp_table_get_text(s->table, "parameter");
    char name[100];
    sp_figure_text_escape(name, sizeof name, text ? text : "parameter", 30);
    for (size_t k = 0; text && k < sizeof known / sizeof *known; k++)
        if (strcmp(text, known[k][0]) == 0)
            snprintf(name, sizeof name, "%s", known[k][1]);
    return sp_tapped_axis_label(s, name, s->abscissa, out);
}

sp_status sp_tapped_draw_with_memory(tapped_draw *draw, size_t count, const tapped_table *s, const char *path,
                                     sp_error *err) {
    double *memory = sp_alloc(count, sizeof *memory);
    const sp_status status = memory ? draw(s, memory, path, err) : sp_fail_memory(err, count * sizeof *memory);
    sp_free(memory);
    return status;
}
