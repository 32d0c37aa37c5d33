/* sonopack front: prints arrival, peak and width of the first wave front of packings and of recorded traces. */
#include "base/base.h"
#include "base/file.h"
#include "base/text.h"
#include "cli/files.h"
#include "ensemble/sample.h"
#include "store/packing_text.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- signals ----------------------------------------------------------------------------------------------------- */

/* A positive number in the metadata, 0 without one. */
static double positive_number(const sp_table *t, const char *key) {
    double value;
    return sp_table_get_number(t, key, &value) && value > 0.0 ? value : 0.0;
}

/* Number of columns F1, F2, ... from column `first' on; 1 if that has another name. */
static int count_signals(const sp_table *t, int first) {
    char name[16];
    int n = 0;
    for (; first + n < t->columns && t->column[first + n].kind != SP_COLUMN_TEXT; n++) {
        snprintf(name, sizeof name, "F%d", n + 1);
        if (strcmp(t->column[first + n].name, name) != 0)
            break;
    }
    return n > 0 ? n : 1;
}

/* A number of the metadata in our unit: in a table in SI its unit stands behind it. */
static double own_number(const sp_table *t, const char *key, const char *unit, const sp_material *m) {
    const char *text = sp_table_get_text(t, key);
    double value;
    const bool si = text && m->young > 0 && sp_quantity_read(text, unit, m, &value, NULL) == SP_OK;
    return si && value > 0.0 ? value : positive_number(t, key);
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

/* A number in the unit of a file, which may be that of a laboratory, or a text of a number and its unit. */
typedef struct measure {
    double number;    /* NAN: not given */
    const char *text; /* NULL: a number */
} measure;

typedef struct arguments {
    cli_common common;
    measure window, distance;
    const char *column;
} arguments;

static const char *const time_unit = "d/sqrt(E* / rho)"; /* of packings and their signals */

static bool is_given(const measure *m) { return m->text || !isnan(m->number); }

static sp_status read_measure(const char *option, const char *text, const char *unit, double low, measure *out,
                              sp_error *err) {
    const sp_material any = {1, 0, 1, 1}; /* the unit is checked, the value follows with the file */
    double value;
    if (text[strspn(text, "0123456789+-.eE")] == '\0')
        return cli_number(option, text, low, 1e12, &out->number, err);
    sp_status status = sp_quantity_read(text, unit, &any, &value, err);
    if (status == SP_OK && !(value > 0))
        status = sp_fail(err, SP_EINVAL, "%.40s: must be above 0", text);
    if (status != SP_OK)
        return sp_fail_prefix(err, "%s", option);
    out->text = text;
    return SP_OK;
}

static sp_status set_window(void *user, const char *text, sp_error *err) {
    return read_measure("--window", text, time_unit, 1e-9, &((arguments *)user)->window, err);
}

static sp_status set_distance(void *user, const char *text, sp_error *err) {
    return read_measure("--distance", text, "d", 0, &((arguments *)user)->distance, err);
}

static sp_status in_unit(const arguments *a, const measure *m, const char *unit, double *out, sp_error *err) {
    if (m->text)
        return sp_quantity_read(m->text, unit, cli_material(&a->common), out, err);
    *out = m->number;
    return SP_OK;
}

static const cli_option options[] = {
    {"window", "T", "Search for the front only up to time T", .parse = set_window},
    {"distance", "D", "Distance from source to detector (the height)", .parse = set_distance},
    {"source", "impulse|velocity|displacement", "Kind of source at the bottom wall, for packings (impulse)", CLI_CHOICE,
     .scene = true, .key = "signal.source"},
    {"column", "NAME|N",
     "Column of the trace, by name or by number from 1 (F; else all of F1, F2, ...; else the second column of numbers)",
     CLI_TEXT, CLI_FIELD(column)},
    {0}};

const cli_syntax cmd_front_syntax = {
    .usage = "FILE...",
    .help =
        "Arrival, peak and width of the first wave front. A FILE is a packing, whose signal is computed, or a "
        "trace.\vThe first peak is the first maximum above 0.2 of the largest value that is followed by a fall of at "
        "least 0.01 of that value. t10: first time at which the force reaches a tenth of the peak. t_zero: first zero "
        "crossing after the peak. width: t_zero - t10. A trace is a table of numbers with columns of times and forces. "
        "Its comments `# height = H' and `# pressure = P' set the distance and the time window, from 0 to (8 H + 40) "
        "(P/1e-4)^(-1/6). Without them the whole trace is searched. A table of `sonopack signal' with columns F1, F2, "
        "... gives one row for each; the distance of a plane is its height. A speed needs two distances: (D2 - "
        "D1)/(t10_2 - t10_1). One distance over its time is biased. A unit is shown only if all files have the same "
        "one.",
    .finds_material = true,
    .options = options,
    .file_name = "packing or trace",
    .files_min = 1,
    .files_max = CLI_ANY_NUMBER};

/* One front, and the units of its file. */
typedef struct arrival {
    double distance;
    sp_front front;
    char length[sizeof((sp_column *)0)->unit], time[sizeof((sp_column *)0)->unit], force[sizeof((sp_column *)0)->unit];
} arrival;

/* ---- packings ---------------------------------------------------------------------------------------------------- */

static sp_status packing_front(arguments *a, cli_file *file, arrival *out, sp_error *err) {
    sp_packing p;
    sp_network net;
    sp_status status = cli_read_network(file->path, &file->scene->network, &p, &net, err);
    CLI_THEN(status, cli_take_material(a, &p.material, file->path, err));
    if (status == SP_OK) {
        cli_warn_packing(&a->common, file->path, &p, &net);
        cli_keep_series(&p, file);
        *out = (arrival){.distance = sp_packing_height(&p), .length = "d", .force = "E* d^2"};
        snprintf(out->time, sizeof out->time, "%s", time_unit);
        double window = 0;
        status = cli_need_walls(&p, "a front", err);
        if (status == SP_OK && is_given(&a->window))
            status = in_unit(a, &a->window, time_unit, &window, err);
        CLI_THEN(status, sp_network_front(&net, file->scene->signal.source, window, &out->front, err));
        if (status != SP_OK)
            sp_fail_prefix(err, "%s", file->path);
    }
    sp_network_free(&net);
    sp_packing_free(&p);
    return status;
}

/* ---- traces ------------------------------------------------------------------------------------------------------ */

static int number_column(const sp_table *t, int k) {
    for (int c = 0; c < t->columns; c++)
        if (t->column[c].kind != SP_COLUMN_TEXT && k-- == 0)
            return c;
    return -1;
}

static sp_status find_columns(const arguments *a, const sp_table *t, const char *path, int *time, int *force,
                              sp_error *err) {
    int64_t number;
    *time = sp_table_find_column(t, "t");
    if (*time < 0)
        *time = number_column(t, 0);
    *force = sp_table_find_column(t, a->column ? a->column : "F");
    if (*force < 0 && !a->column)
        *force = number_column(t, number_column(t, 0) == *time ? 1 : 0);
    if (*force < 0 && a->column && cli_integer("--column", a->column, 1, t->columns, &number, NULL) == SP_OK)
        *force = (int)number - 1;
    if (*time < 0 || *force < 0 || t->column[*time].kind == SP_COLUMN_TEXT ||
        t->column[*force].kind == SP_COLUMN_TEXT) {
        if (a->column)
            return sp_fail(err, SP_EFORMAT, "%s: has no column %.60s of numbers beside the times", path, a->column);
        return sp_fail(err, SP_EFORMAT,
                       "%s: must have two columns of numbers, times and forces, separated by tabs or blanks", path);
    }
    return SP_OK;
}

/* How far the detector is from the source, if the table says "F2 = from PLACE to PLACE, ..." of the column; else the
 * packing's height. In a periodic cell by the shorter way. */
static double distance_of(const sp_table *t, const char *column, double height) {
    const char *text = sp_table_get_text(t, column), *to = text ? strstr(text, " to ") : NULL;
    const char *cell = sp_table_get_text(t, "cell");
    if (!to)
        return height;
    if (strstr(text, "grain:"))
        return NAN;
    const double plane = plane_of(to + 4), source = strncmp(text, "from ", 5) == 0 ? plane_of(text + 5) : NAN;
    const double whole = positive_number(t, "height"),
                 way = fabs((isfinite(plane) ? plane : height) - (isfinite(source) ? source : 0));
    return cell && strcmp(cell, "periodic") == 0 && whole > way ? fmin(way, whole - way) : way;
}

/* The error of a signal by its table: "F2 = ..., error E" of the column, or else "error = E"; 0 if it says nothing. */
static double error_of(const sp_table *t, const char *column) {
    const char *text = sp_table_get_text(t, column), *at = text ? strstr(text, ", error ") : NULL;
    double error = 0;
    if (at)
        return fabs(strtod(at + strlen(", error "), NULL));
    return sp_table_get_number(t, "error", &error) ? fabs(error) : 0;
}

/* t10 is where the force passes a tenth of the peak. An error of that size could put it anywhere. */
static sp_status check_error(const arguments *a, const char *path, double error, const sp_front *f, sp_error *err) {
    const double most = 0.1, much = 0.01;
    if (error >= most * f->amplitude)
        return sp_fail(
            err, SP_EREFUSED,
            "%s: error = %.3g of F, at a peak of %.3g: must be below a tenth of the peak, where t10 is (a sum "
            "over few modes is no signal: see `sonopack help signal')",
            path, error, f->amplitude);
    if (error >= much * f->amplitude)
        cli_note(&a->common, "%s: warning: error = %.3g of F is %.2g of the peak: t10 and width are uncertain", path,
                 error, error / f->amplitude);
    return SP_OK;
}

/* The units of a trace, and the window in which its first front is sought; 0: everywhere. A table of ours in SI says of
 * which material. */
static double find_units(const sp_table *t, int time, int force, arrival *out) {
    const char *text = sp_table_get_text(t, "material");
    sp_material m = {0};
    char si[SP_UNIT_TEXT] = "";
    double factor = 1.0;
    snprintf(out->time, sizeof out->time, "%s", t->column[time].unit);
    snprintf(out->force, sizeof out->force, "%s", t->column[force].unit);
    if (text && sp_material_read(text, &m, NULL) == SP_OK)
        sp_unit_to_si(time_unit, &m, &factor, si, NULL);
    const bool ours_in_si = si[0] && strcmp(si, out->time) == 0;
    if (!ours_in_si)
        m = (sp_material){0};
    snprintf(out->length, sizeof out->length, "%s", ours_in_si ? "mm" : strcmp(out->time, time_unit) == 0 ? "d" : "");
    const double height = own_number(t, "height", "d", &m), pressure = own_number(t, "pressure", "E*", &m);
    const double window = height > 0.0 && pressure > 0.0 ? sp_signal_window(height, pressure) : 0.0;
    return window * (ours_in_si ? factor : 1.0);
}

static sp_status trace_front(const arguments *a, const char *path, const sp_table *table, int time, int force,
                             arrival *out, sp_error *err) {
    const int64_t n = table->rows;
    const double height = positive_number(table, "height");
    const char *name = table->column[force].name;
    sp_front_options rule = sp_front_options_default();
    sp_status status = SP_OK;
    double *t = sp_alloc((size_t)n, 2 * sizeof *t);
    if (!t)
        return sp_fail_memory(err, (size_t)n * 2 * sizeof *t);
    for (int64_t k = 0; k < n; k++) {
        t[k] = sp_table_number(table, k, time);
        t[n + k] = sp_table_number(table, k, force);
    }
    *out = (arrival){.distance = distance_of(table, name, height > 0 ? height : NAN)};
    rule.window = find_units(table, time, force, out);
    if (is_given(&a->window))
        status = in_unit(a, &a->window, out->time, &rule.window, err);
    CLI_THEN(status, sp_front_find(n, t, t + n, &rule, &out->front, err));
    if (status != SP_OK)
        sp_fail_prefix(err, "%s", path);
    CLI_THEN(status, check_error(a, path, error_of(table, name), &out->front, err));
    sp_free(t);
    return status;
}

/* ---- the table --------------------------------------------------------------------------------------------------- */

static sp_status add_columns(void *user, cli_writer *w) {
    (void)user;
    cli_columns(w, SP_COLUMN_TEXT, "file", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "distance", "", "t10", "", "t_peak", "", "t_zero", "", "amplitude", "", "width",
                "", NULL);
    return w->status;
}

/* Merges the units of the last row into the columns. A column keeps a unit that all of its rows have. */
static void merge_units(sp_table *t, const arrival *m) {
    const char *const unit[] = {"", m->length, m->time, m->time, m->time, m->force, m->time};
    for (int c = 1; c < (int)(sizeof unit / sizeof *unit); c++) {
        char *common = t->column[c].unit;
        if (t->rows == 1)
            snprintf(common, sizeof t->column[c].unit, "%s", unit[c]);
        else if (strcmp(common, unit[c]) != 0)
            common[0] = '\0';
    }
}

/* Notes options that do not apply to this kind of file, and a trace in which noise may hide the arrival. */
static void add_notes(const arguments *a, const char *path, bool packing, const sp_front *f) {
    if (packing && a->column)
        cli_note(&a->common, "%s: is a packing: --column is not used", path);
    if (!packing && cli_given(&cmd_front_syntax, &a->common, "source"))
        cli_note(&a->common, "%s: is a trace: --source is not used", path);
    if (!packing && a->common.sets > 0)
        cli_note(&a->common, "%s: is a trace: --set is not used", path);
    if (f->crossings > 1)
        cli_note(
            &a->common,
            "%s: F crosses a tenth of the peak %lld times before the peak, because of noise or a precursor; t10 is "
            "the first crossing: filter the trace",
            path, (long long)f->crossings);
}

static void to_si(const sp_material *m, double *value, char unit[SP_UNIT_TEXT]) {
    double factor;
    char si[SP_UNIT_TEXT];
    if (sp_unit_is_ours(unit) && sp_unit_to_si(unit, m, &factor, si, NULL) == SP_OK) {
        *value *= factor;
        snprintf(unit, SP_UNIT_TEXT, "%s", si);
    }
}

/* Each file by itself: some may be in SI already, and a column has one unit. */
static void arrival_to_si(const sp_material *m, arrival *one) {
    double *const time[] = {&one->front.t10, &one->front.t_peak, &one->front.t_zero, &one->front.width};
    for (size_t k = 0; k < sizeof time / sizeof *time; k++) {
        char unit[SP_UNIT_TEXT];
        snprintf(unit, sizeof unit, "%s", one->time);
        to_si(m, time[k], unit);
        if (k + 1 == sizeof time / sizeof *time)
            snprintf(one->time, sizeof one->time, "%s", unit);
    }
    to_si(m, &one->front.amplitude, one->force);
    to_si(m, &one->distance, one->length);
}

static sp_status add_front(const arguments *a, const char *name, bool packing, arrival *m, cli_writer *w) {
    sp_status status = SP_OK;
    if (a->distance.text && !m->length[0])
        snprintf(m->length, sizeof m->length, "mm");
    if (is_given(&a->distance))
        status = in_unit(a, &a->distance, m->length, &m->distance, w->err);
    if (status != SP_OK)
        return sp_fail_prefix(w->err, "%s", name);
    if (a->common.units == CLI_UNITS_SI && cli_material(&a->common))
        arrival_to_si(cli_material(&a->common), m);
    const sp_front *f = &m->front;
    const char *before = w->table->rows > 0 ? w->table->column[2].unit : "";
    if (*before && m->time[0] && strcmp(before, m->time) != 0)
        return sp_fail(w->err, SP_EINVAL,
                       "%s: its times are in %s, those of the files before it in %s; must be the same", name, m->time,
                       before);
    add_notes(a, name, packing, f);
    status = cli_row(w, name, m->distance, f->t10, f->t_peak, f->t_zero, f->amplitude, f->width);
    if (status == SP_OK)
        merge_units(w->table, m);
    return status;
}

/* Adds a row for each signal of a table. A signal without a front is reported, and the next one follows. */
static sp_status add_signals(const arguments *a, cli_file *file, const sp_table *read, cli_writer *w) {
    int time = 0, force = 0;
    sp_status status = find_columns(a, read, file->path, &time, &force, w->err);
    const int signals = status == SP_OK && !a->column ? count_signals(read, force) : 1;
    const size_t size = strlen(file->path) + 16;
    char *name = sp_alloc(size, 1);
    if (status == SP_OK && !name)
        status = sp_fail_memory(w->err, size);
    for (int k = 0; k < signals && status == SP_OK; k++) {
        arrival m;
        sp_error reason = {0};
        snprintf(name, size, signals > 1 ? "%s:F%d" : "%s", file->path, k + 1);
        if (trace_front(a, name, read, time, force + k, &m, &reason) == SP_OK) {
            status = add_front(a, name, false, &m, w);
        } else {
            cli_fail(&reason);
            file->failed = true;
        }
    }
    sp_free(name);
    return status;
}

static sp_status add_file(void *user, cli_file *file, cli_writer *w) {
    arguments *a = user;
    sp_table read = sp_table_none();
    arrival m;
    bool packing = false;
    sp_status status = sp_packing_file_looks(file->path, &packing, w->err);
    if (status == SP_OK && packing) {
        status = packing_front(a, file, &m, w->err);
        return status == SP_OK ? add_front(a, file->path, true, &m, w) : status;
    }
    CLI_THEN(status, sp_table_read(file->path, &read, w->err));
    CLI_THEN(status, cli_take_table_material(a, &read, file->path, w->err));
    CLI_THEN(status, add_signals(a, file, &read, w));
    sp_table_free(&read);
    return status;
}

int cmd_front(int argc, char **argv) {
    static const cli_files command = {.groups = "network signal", .begin = add_columns, .add = add_file};
    arguments a = {.window = {.number = NAN}, .distance = {.number = NAN}};
    cli_parse(&cmd_front_syntax, argc, argv, &a);
    return cli_run_files(&command, &a);
}
