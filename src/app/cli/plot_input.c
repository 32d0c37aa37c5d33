/* Reads tables and signals for figures. */
#include "cli/plot_input.h"

#include "base/base.h"
#include "base/file.h"
#include "base/text.h"
#include "cli/output.h"
#include "cli/plot_units.h"
#include "cli/trace.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

sp_status plot_read_table(const char *path, sp_table *out, sp_error *err) {
    sp_table t = sp_table_none();
    sp_status status = cli_read_table(path, &t, err);
    if (status == SP_OK)
        status = plot_units_convert(&t, err);
    if (status == SP_OK)
        *out = t;
    else
        sp_table_free(&t);
    return status;
}

/* ---- signals ---------------------------------------------------------------------------------------------------- */

/* Where figures are in SI, turns the signal of a packing into SI too. */
static void to_si(plot_signal *s) {
    const sp_material *m = plot_units_material();
    double time, force, length;
    char unit[SP_UNIT_TEXT];
    if (!m || sp_unit_to_si("d/sqrt(E* / rho)", m, &time, s->t_unit, NULL) != SP_OK ||
        sp_unit_to_si("E* d^2", m, &force, s->f_unit, NULL) != SP_OK ||
        sp_unit_to_si("d", m, &length, unit, NULL) != SP_OK)
        return;
    for (int64_t k = 0; k < s->n; k++) {
        s->t[k] *= time;
        s->f[k] *= force;
    }
    s->window *= time;
    s->distance *= length;
    s->length_unit = "mm";
    s->foreign = true;
}

static sp_status packing_signal(const char *path, const sp_scene *scene, plot_signal *out, sp_error *err) {
    sp_packing p = sp_packing_none();
    sp_network net = sp_network_none();
    sp_signal signal = sp_signal_none();
    sp_signal_options options = scene->signal;
    sp_status status = sp_packing_read(path, &p, err);
    if (status != SP_OK)
        return status;
    const double window = sp_signal_window(sp_packing_height(&p), p.pressure);
    if (!(options.until > 0.0))
        options.until = window;
    status = sp_network_make(&p, &scene->network, &net, err);
    if (status == SP_OK)
        status = sp_signal_make(&net, &options, &signal, err);
    double *t = status == SP_OK ? sp_alloc((size_t)signal.n, 2 * sizeof *t) : NULL;
    if (t) {
        memcpy(t, signal.t, (size_t)signal.n * sizeof *t);
        memcpy(t + signal.n, signal.f, (size_t)signal.n * sizeof *t);
        *out = (plot_signal){.n = signal.n, .t = t, .f = t + signal.n, .window = window};
        out->distance = sp_packing_height(&p);
        snprintf(out->t_unit, sizeof out->t_unit, "d/sqrt(E* / rho)");
        snprintf(out->f_unit, sizeof out->f_unit, "E* d^2");
        out->length_unit = "d";
        to_si(out);
    } else if (status == SP_OK) {
        status = sp_fail_memory(err, (size_t)signal.n * 2 * sizeof *t);
    } else {
        sp_fail_prefix(err, "%s", path);
    }
    sp_signal_free(&signal);
    sp_network_free(&net);
    sp_packing_free(&p);
    return status;
}

/* A positive number in the metadata, 0 without one. */
static double positive_number(const sp_table *t, const char *key) {
    double value;
    return sp_table_get_number(t, key, &value) && value > 0.0 ? value : 0.0;
}

/* Finds the columns t and F or F1, or the first two columns of numbers. A table with a column omega is no signal. */
static sp_status find_columns(const char *path, const sp_table *t, int column[2], sp_error *err) {
    column[0] = sp_table_find_column(t, "t");
    column[1] = sp_table_find_column(t, "F");
    if (column[1] < 0)
        column[1] = sp_table_find_column(t, "F1");
    if (column[0] < 0 && column[1] < 0 && sp_table_find_column(t, "omega") < 0) {
        int found = 0;
        for (int c = 0; c < t->columns && found < 2; c++)
            if (t->column[c].kind != SP_COLUMN_TEXT)
                column[found++] = c;
    }
    for (int k = 0; k < 2; k++)
        if (column[k] < 0 || t->column[column[k]].kind == SP_COLUMN_TEXT)
            return sp_fail(err, SP_EFORMAT,
                           "%s: a signal needs columns of numbers t and F, or t, F1, F2, ...: times and forces", path);
    return SP_OK;
}

static sp_status column_signal(const sp_table *table, int time, int force, plot_signal *out, sp_error *err) {
    cli_trace s;
    const sp_status status = cli_trace_of(table, time, force, &s, err);
    if (status != SP_OK)
        return status;
    *out = (plot_signal){.n = s.n, .t = s.t, .f = s.f, .window = s.window, .foreign = s.foreign, .height = s.height};
    out->distance = NAN;
    out->length_unit = s.length_unit;
    memcpy(out->t_unit, s.t_unit, sizeof out->t_unit);
    memcpy(out->f_unit, s.f_unit, sizeof out->f_unit);
    return SP_OK;
}

/* Names a plane by its height, which is z in three dimensions. */
static void name_plane(const sp_table *table, double plane, bool shear, plot_signal *out) {
    double dimension = 2;
    sp_table_get_number(table, "dimension", &dimension);
    const char axis = dimension == 3 ? 'z' : 'y';
    const char *unit = strcmp(out->length_unit, "d") == 0 ? "|d|" : out->length_unit;
    snprintf(out->name, sizeof out->name, "%c = %.4g%s", axis, plane, shear ? " shear" : "");
    snprintf(out->place, sizeof out->place, "|%c| = %.4g%s%s%s", axis, plane, *unit ? " " : "", unit,
             shear ? ", shear" : "");
}

/* Names one signal of several by its detector: "y = 25", "top", "part:0:3"; without metadata "F2". */
static void name_signal(const sp_table *table, int k, bool several, plot_signal *out) {
    char key[16];
    cli_detector to;
    const double height = positive_number(table, "height");
    snprintf(key, sizeof key, "F%d", k + 1);
    if (several)
        snprintf(out->name, sizeof out->name, "%s", key);
    if (!cli_find_detector(table, key, &to)) {
        out->distance = height > 0 && !several ? height : NAN;
        return;
    }
    const int length = (int)strlen(to.word),
              normal = length > 7 && strcmp(to.word + length - 7, ":normal") == 0 ? 7 : 0;
    const bool shear = length > 6 && strcmp(to.word + length - 6, ":shear") == 0;
    if (isfinite(to.plane)) {
        out->distance = cli_way(table, &to, to.plane);
        if (several)
            name_plane(table, to.plane, shear, out);
        return;
    }
    if (several && length > normal)
        snprintf(out->name, sizeof out->name, "%.*s", length - normal < 40 ? length - normal : 40, to.word);
    if (strncmp(to.word, "top", 3) == 0 && height > 0)
        out->distance = cli_way(table, &to, height);
}

static sp_status begin_signals(int n, plot_signals *out, sp_error *err) {
    *out = (plot_signals){.n = n, .signal = sp_alloc((size_t)n, sizeof *out->signal)};
    return out->signal ? SP_OK : sp_fail_memory(err, (size_t)n * sizeof *out->signal);
}

static sp_status table_signals(const char *path, plot_signals *out, sp_error *err) {
    sp_table table = sp_table_none();
    int column[2];
    sp_status status = plot_read_table(path, &table, err);
    if (status != SP_OK)
        return status;
    status = find_columns(path, &table, column, err);
    if (status == SP_OK)
        status = begin_signals(cli_count_signals(&table, column[1]), out, err);
    for (int k = 0; status == SP_OK && k < out->n; k++) {
        status = column_signal(&table, column[0], column[1] + k, &out->signal[k], err);
        if (status == SP_OK)
            name_signal(&table, k, out->n > 1, &out->signal[k]);
    }
    sp_table_free(&table);
    return status;
}

void plot_signals_free(plot_signals *s) {
    for (int k = 0; s->signal && k < s->n; k++)
        sp_free(s->signal[k].t);
    sp_free(s->signal);
    *s = (plot_signals){0};
}

sp_status plot_read_signals(const char *path, const sp_scene *scene, plot_signals *out, sp_error *err) {
    bool packing;
    plot_signals read = {0};
    sp_status status = cli_is_packing(path, &packing, err);
    if (status == SP_OK && packing)
        status = begin_signals(1, &read, err);
    if (status == SP_OK)
        status = packing ? packing_signal(path, scene, read.signal, err) : table_signals(path, &read, err);
    if (status == SP_OK)
        *out = read;
    else
        plot_signals_free(&read);
    return status;
}
