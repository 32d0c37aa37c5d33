/* Figure of bifurcations and Lyapunov exponents of the tapped column against a parameter. */
#include "figure/tapped_table.h"

#include "base/base.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { MARKED_MOST = 60 };

static sp_status check_parameter(const tapped_table *s, double *to, double *low, double *high, sp_error *err) {
    for (int64_t k = 0; k < s->table->rows; k++) {
        to[k] = sp_table_number(s->table, k, s->abscissa);
        if (!isfinite(to[k]))
            return sp_fail(err, SP_EREFUSED, "row %lld, parameter = %g: must be finite", (long long)k + 1, to[k]);
        *low = fmin(*low, to[k]);
        *high = fmax(*high, to[k]);
    }
    return SP_OK;
}

/* Draws marks without a line: the exponent jumps between windows of cycles, and a line would show values that it never
 * takes. */
static sp_curve exponents(const tapped_table *s, const double *x, double *memory) {
    const int64_t n = s->table->rows;
    const int error = sp_tapped_table_column(s, "error");
    const double *y = sp_tapped_table_values(s, sp_tapped_table_column(s, "lambda"), memory);
    sp_curve curve = {.n = n, .x = x, .y = y, .ink = 1, .dash = SP_DASH_NONE, .width = 0.8};
    curve.mark = n <= MARKED_MOST ? SP_MARK_CIRCLE : SP_MARK_DOT;
    if (error >= 0 && n <= MARKED_MOST) {
        double *e = memory + n;
        sp_tapped_table_values(s, error, e);
        for (int64_t k = 0; k < n; k++)
            e[k] = isfinite(e[k]) ? fabs(e[k]) : 0;
        curve.error = e;
    }
    return curve;
}

typedef struct diagram {
    const tapped_table *bifurcation, *lyapunov;
    int column;
    double low, high; /* of the parameter */
    sp_curve dots, exponents;
    char x[TAPPED_LABEL], y[2][TAPPED_LABEL], note[2 * TAPPED_LABEL];
} diagram;

/* Refuses two tables with different parameters. */
static sp_status check_common(const diagram *d, sp_error *err) {
    const char *one = d->bifurcation ? sp_table_get_text(d->bifurcation->table, "parameter") : NULL;
    const char *two = d->lyapunov ? sp_table_get_text(d->lyapunov->table, "parameter") : NULL;
    if (one && two && strcmp(one, two) != 0)
        return sp_fail(err, SP_EINVAL, "a bifurcation over the %.40s, but exponents over the %.40s: must be the same",
                       one, two);
    return SP_OK;
}

static sp_status read(diagram *d, double *memory, sp_error *err) {
    sp_status status = check_common(d, err);
    d->low = INFINITY;
    d->high = -INFINITY;
    if (d->bifurcation && status == SP_OK) {
        const int64_t n = d->bifurcation->table->rows;
        status = check_parameter(d->bifurcation, memory, &d->low, &d->high, err);
        d->dots = (sp_curve){.n = n, .x = memory, .ink = 1, .dash = SP_DASH_NONE, .mark = SP_MARK_DOT};
        d->dots.y = sp_tapped_table_values(d->bifurcation, d->column, memory + n);
        memory += 2 * n;
    }
    if (d->lyapunov && status == SP_OK) {
        status = check_parameter(d->lyapunov, memory, &d->low, &d->high, err);
        d->exponents = exponents(d->lyapunov, memory, memory + d->lyapunov->table->rows);
    }
    if (status == SP_OK && d->bifurcation && !sp_tapped_any_finite(d->dots.n, d->dots.y))
        status = sp_fail(err, SP_EREFUSED, "nothing to draw: no position is finite");
    if (status == SP_OK && d->lyapunov && !sp_tapped_any_finite(d->exponents.n, d->exponents.y))
        status = sp_fail(err, SP_EREFUSED, "nothing to draw: no Lyapunov exponent is finite");
    if (status == SP_OK && !(d->low < d->high))
        status = sp_fail(err, SP_EREFUSED, "nothing to draw: only one value of the parameter, %g; must be two or more",
                         d->low);
    return status;
}

/* Writes the warnings of the tables into the note; equal ones only once. */
static void write_note(diagram *d) {
    char one[TAPPED_LABEL] = "", two[TAPPED_LABEL] = "";
    if (d->bifurcation)
        sp_tapped_violation_note(d->bifurcation, one);
    if (d->lyapunov)
        sp_tapped_violation_note(d->lyapunov, two);
    if (!d->bifurcation || !d->lyapunov || strcmp(one, two) == 0)
        snprintf(d->note, sizeof d->note, "%s", *one ? one : two);
    else
        snprintf(d->note, sizeof d->note, "%s%s%s%s%s", *one ? "(a): " : "", one, *one && *two ? "\n(b): " : "",
                 *one || !*two ? "" : "(b): ", two);
}

static sp_status draw(diagram *d, const char *path, sp_error *err) {
    const tapped_table *one = d->bifurcation ? d->bifurcation : d->lyapunov;
    const double margin = 0.015 * (d->high - d->low);
    const sp_axis x = {.label = sp_tapped_parameter_label(one, d->x), .low = d->low - margin, .high = d->high + margin};
    sp_panel panel[2] = {{0}, {0}};
    int panels = 0;
    if (d->bifurcation) {
        char name[64];
        snprintf(name, sizeof name, "|y|_{%d} after a tap", d->column - d->bifurcation->first + 1);
        panel[panels] = (sp_panel){.tag = d->lyapunov ? "(a)" : NULL, .x = x, .curves = 1, .curve = &d->dots};
        panel[panels++].y.label = sp_tapped_axis_label(d->bifurcation, name, d->column, d->y[0]);
    }
    if (d->lyapunov) {
        panel[panels] = (sp_panel){.tag = d->bifurcation ? "(b)" : NULL, .x = x, .curves = 1, .curve = &d->exponents};
        panel[panels].zero_line = true;
        panel[panels++].y.label =
            sp_tapped_axis_label(d->lyapunov, "|\xce\xbb|", sp_tapped_table_column(d->lyapunov, "lambda"), d->y[1]);
    }
    write_note(d);
    const tapped_sheet sheet = {.title = d->bifurcation ? "Bifurcations of a tapped column" : "Lyapunov exponents",
                                .panels = panels,
                                .panel = panel,
                                .aspect = panels == 2 ? 0.66 : 0.75,
                                .note = d->note};
    return sp_tapped_draw_sheet(&sheet, path, err);
}

sp_status sp_tapped_draw_diagram(const tapped_table *bifurcation, int column, const tapped_table *lyapunov,
                                 const char *path, sp_error *err) {
    diagram d = {.bifurcation = bifurcation, .column = column, .lyapunov = lyapunov};
    const size_t count =
        2 * (size_t)(bifurcation ? bifurcation->table->rows : 0) + 3 * (size_t)(lyapunov ? lyapunov->table->rows : 0);
    double *memory = sp_alloc(count, sizeof *memory);
    sp_status status = memory ? read(&d, memory, err) : sp_fail_memory(err, count * sizeof *memory);
    if (status == SP_OK)
        status = draw(&d, path, err);
    sp_free(memory);
    return status;
}
