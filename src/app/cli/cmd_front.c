/* sonopack front: arrival, peak and width of the first wave front, of packings and of traces. */
#include "base/base.h"
#include "cli/cli.h"
#include "cli/plot_input.h"
#include "ensemble/sample.h"
#include "store/packing_text.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

typedef struct arguments {
    cli_common common;
    double window, distance; /* NAN: not given */
    const char *column;
    bool source_given;
    sp_source source;
    int files;
    char **file;
} arguments;

enum { KEY_WINDOW = 0x1000, KEY_DISTANCE, KEY_SOURCE, KEY_COLUMN };

static const struct argp_option options[] = {
    {"window", KEY_WINDOW, "T", 0, "Look for the front up to this time only", 0},
    {"distance", KEY_DISTANCE, "D", 0, "Distance from source to detector, instead of the height", 0},
    {"source", KEY_SOURCE, "impulse|velocity|displacement", 0, "What the bottom wall does (packings)", 0},
    {"column", KEY_COLUMN, "NAME|N", 0,
     "Column of the trace, by name or number from 1 (F; all of F1, F2, ...; or the second of numbers)", 0},
    {0}};
static const struct argp_child children[] = {{&cli_common_argp, 0, "Common options:", 90}, {0}};

static void parse_source(arguments *a, const char *word, struct argp_state *state) {
    static const char *const words[] = {
        [SP_SOURCE_IMPULSE] = "impulse", [SP_SOURCE_VELOCITY] = "velocity", [SP_SOURCE_DISPLACEMENT] = "displacement"};
    for (unsigned k = 0; k < sizeof words / sizeof *words; k++) {
        if (strcmp(word, words[k]) == 0) {
            a->source = (sp_source)k;
            a->source_given = true;
            return;
        }
    }
    argp_error(state, "--source %.60s: must be impulse, velocity or displacement", word);
}

static error_t parse(int key, char *arg, struct argp_state *state) {
    arguments *a = state->input;
    sp_error err;
    switch (key) {
    case ARGP_KEY_INIT: state->child_inputs[0] = &a->common; return 0;
    case KEY_WINDOW:
        if (cli_number("--window", arg, 1e-9, 1e12, &a->window, &err) != SP_OK)
            argp_error(state, "%s", err.text);
        return 0;
    case KEY_DISTANCE:
        if (cli_number("--distance", arg, 0, 1e12, &a->distance, &err) != SP_OK)
            argp_error(state, "%s", err.text);
        return 0;
    case KEY_SOURCE: parse_source(a, arg, state); return 0;
    case KEY_COLUMN: a->column = arg; return 0;
    case ARGP_KEY_ARGS:
        a->file = state->argv + state->next;
        a->files = state->argc - state->next;
        return 0;
    case ARGP_KEY_NO_ARGS: argp_error(state, "no file: must be one packing or trace, or more"); return 0;
    default: return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp argp = {
    options,
    parse,
    "FILE...",
    "Arrival, peak and width of the first wave front of packings (their signal is computed) and of traces.\v"
    "First peak: the first maximum above 0.2 of the largest value, and followed by a fall of 0.01 of it. t10: first "
    "time at a tenth of its height; t_zero: first zero crossing after it; width: t_zero - t10. A trace is a table of "
    "numbers, times and forces; its comments `# height = H' and `# pressure = P' give distance and window, [0, 8 H + "
    "40] times (P/1e-4)^(-1/6). Without them the whole trace is used, and its first maximum above 0.2 of the largest "
    "value of all. A table of `sonopack signal' with F1, F2, ... gives a row a signal, planes with their distance from "
    "the bottom. Two distances make a speed, (D2 - D1)/(t10_2 - t10_1); one distance over one time does not. Units are "
    "those of the files, as far as all agree.",
    children,
    NULL,
    NULL};

/* What is found in one file, and its units. */
typedef struct measured {
    double distance;
    sp_front front;
    char length[sizeof((sp_column *)0)->unit], time[sizeof((sp_column *)0)->unit], force[sizeof((sp_column *)0)->unit];
} measured;

static const char *const time_unit = "d/sqrt(E* / rho)"; /* of packings and their signals */

/* ---- packings --------------------------------------------------------------------------------------------------- */

/* Whether a file is a packing rather than a table: binary, or text with a packing's header. What cannot be looked into
 * without using it up (a pipe) is taken for a table. */
static sp_status is_packing(const char *path, bool *yes, sp_error *err) {
    struct stat info;
    if (stat(path, &info) != 0)
        return sp_fail(err, SP_EIO, "cannot read %s: %s", path, strerror(errno));
    *yes = false;
    if (!S_ISREG(info.st_mode))
        return SP_OK;
    FILE *file = fopen(path, "rb");
    if (!file)
        return sp_fail(err, SP_EIO, "cannot read %s: %s", path, strerror(errno));
    char head[8192];
    const size_t size = fread(head, 1, sizeof head - 1, file);
    fclose(file);
    head[size] = '\0';
    *yes = strlen(head) < size || strncmp(head, "# packing", 9) == 0 || sp_packing_text_looks(head);
    return SP_OK;
}

static sp_status packing_front(const arguments *a, const sp_scene *scene, const char *path, measured *out,
                               sp_error *err) {
    sp_packing p = sp_packing_none();
    sp_network net = sp_network_none();
    sp_status status = sp_packing_read(path, &p, err);
    if (status != SP_OK)
        return status;
    status = sp_network_make(&p, &scene->network, &net, err);
    if (status == SP_OK) {
        *out = (measured){.distance = sp_packing_height(&p), .length = "d", .force = "E* d^2"};
        snprintf(out->time, sizeof out->time, "%s", time_unit);
        status = sp_network_front(&net, a->source_given ? a->source : scene->signal.source,
                                  isnan(a->window) ? 0 : a->window, &out->front, err);
    }
    if (status != SP_OK)
        sp_fail_prefix(err, "%s", path);
    sp_network_free(&net);
    sp_packing_free(&p);
    return status;
}

/* ---- traces ----------------------------------------------------------------------------------------------------- */

static double positive_number(const sp_table *t, const char *key) {
    double value;
    return sp_table_get_number(t, key, &value) && value > 0 ? value : NAN;
}

/* The k-th column of numbers, from 0; -1 if there are not so many. */
static int number_column(const sp_table *t, int k) {
    for (int c = 0; c < t->columns; c++)
        if (t->column[c].kind != SP_CELL_TEXT && k-- == 0)
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
    if (*time < 0 || *force < 0 || t->column[*time].kind == SP_CELL_TEXT || t->column[*force].kind == SP_CELL_TEXT) {
        if (a->column)
            return sp_fail(err, SP_EFORMAT, "%s: no column %.60s of numbers beside the times", path, a->column);
        return sp_fail(err, SP_EFORMAT,
                       "%s: two columns of numbers are needed, times and forces, parted by tabs or blanks", path);
    }
    return SP_OK;
}

/* From source to detector by the comment of a signal's column, "F2 = from PLACE to PLACE, ..."; the height where it
 * says nothing else. */
static double distance_of(const sp_table *t, const char *column, double height) {
    plot_detector detector;
    if (!plot_find_detector(t, column, &detector))
        return height;
    if (strstr(sp_table_get_text(t, column), "grain:"))
        return NAN;
    return isfinite(detector.plane) ? detector.plane : height;
}

static sp_status trace_front(const arguments *a, const char *path, const sp_table *t, int time, int force,
                             measured *out, sp_error *err) {
    const size_t n = (size_t)t->rows;
    double *memory = sp_alloc(n, 2 * sizeof *memory);
    if (!memory)
        return sp_fail_memory(err, n * 2 * sizeof *memory);
    for (size_t k = 0; k < n; k++) {
        memory[k] = sp_table_number(t, (int64_t)k, time);
        memory[n + k] = sp_table_number(t, (int64_t)k, force);
    }
    const double height = positive_number(t, "height"), pressure = positive_number(t, "pressure");
    sp_front_options rule = sp_front_options_default();
    if (!isnan(a->window))
        rule.window = a->window;
    else if (!isnan(height) && !isnan(pressure))
        rule.window = sp_signal_window(height, pressure);
    *out = (measured){.distance = distance_of(t, t->column[force].name, height)};
    snprintf(out->time, sizeof out->time, "%s", t->column[time].unit);
    snprintf(out->force, sizeof out->force, "%s", t->column[force].unit);
    if (strcmp(out->time, time_unit) == 0)
        snprintf(out->length, sizeof out->length, "d");
    const sp_status status = sp_front_find(t->rows, memory, memory + n, &rule, &out->front, err);
    if (status != SP_OK)
        sp_fail_prefix(err, "%s", path);
    sp_free(memory);
    return status;
}

/* ---- the table -------------------------------------------------------------------------------------------------- */

static sp_status add_columns(sp_table *t, sp_error *err) {
    static const char *const names[] = {"distance", "t10", "t_peak", "t_zero", "amplitude", "width"};
    sp_status status = sp_table_add_column(t, "file", "", SP_CELL_TEXT, err);
    for (size_t k = 0; k < sizeof names / sizeof *names && status == SP_OK; k++)
        status = sp_table_add_column(t, names[k], "", SP_CELL_NUMBER, err);
    return status;
}

/* The units of a row, which is the table's last: a column keeps those that all of its rows have. */
static void merge_units(sp_table *t, const measured *m) {
    const char *const unit[] = {"", m->length, m->time, m->time, m->time, m->force, m->time};
    for (int c = 1; c < t->columns; c++) {
        char *common = t->column[c].unit;
        if (t->rows == 1)
            snprintf(common, sizeof t->column[c].unit, "%s", unit[c]);
        else if (strcmp(common, unit[c]) != 0)
            common[0] = '\0';
    }
}

/* Options that say nothing about this kind of file, and a first crossing that may be noise. */
static void add_notes(const arguments *a, const char *path, bool packing, const sp_front *f) {
    if (packing && a->column)
        cli_note(&a->common, "%s: is a packing: --column is not used", path);
    if (!packing && a->source_given)
        cli_note(&a->common, "%s: is a trace: --source is not used", path);
    if (!packing && a->common.sets > 0)
        cli_note(&a->common, "%s: is a trace: --set is not used", path);
    if (f->crossings > 1)
        cli_note(&a->common,
                 "%s: F crosses a tenth of the peak %lld times before it: noise or a precursor; t10 is the first, "
                 "filter the trace",
                 path, (long long)f->crossings);
}

/* One row. */
static sp_status add_front(const arguments *a, const char *name, bool packing, measured *m, sp_table *t,
                           sp_error *err) {
    if (!isnan(a->distance))
        m->distance = a->distance;
    const sp_front *f = &m->front;
    add_notes(a, name, packing, f);
    const sp_status status =
        sp_table_add_row(t, err, name, m->distance, f->t10, f->t_peak, f->t_zero, f->amplitude, f->width);
    if (status == SP_OK)
        merge_units(t, m);
    return status;
}

/* A row a signal of the table; those without a front are told on stderr and set *failed. */
static sp_status add_trace(const arguments *a, const char *path, sp_table *t, bool *failed, sp_error *err) {
    sp_table read = sp_table_none();
    measured m;
    int time = 0, force = 0;
    sp_error fault = {0};
    sp_status status = sp_table_read(path, &read, &fault);
    if (status == SP_OK)
        status = find_columns(a, &read, path, &time, &force, &fault);
    const bool readable = status == SP_OK;
    const int signals = readable && !a->column ? plot_count_signals(&read, force) : 1;
    char *name = sp_alloc(strlen(path) + 16, 1);
    if (!readable)
        cli_fail(&fault);
    *failed = *failed || !readable;
    status = name ? SP_OK : sp_fail_memory(err, strlen(path) + 16);
    for (int k = 0; k < signals && readable && status == SP_OK; k++) {
        if (signals > 1)
            snprintf(name, strlen(path) + 16, "%s:F%d", path, k + 1);
        else
            snprintf(name, strlen(path) + 16, "%s", path);
        if (trace_front(a, name, &read, time, force + k, &m, &fault) == SP_OK) {
            status = add_front(a, name, false, &m, t, err);
        } else {
            cli_fail(&fault);
            *failed = true;
        }
    }
    sp_free(name);
    sp_table_free(&read);
    return status;
}

static sp_status add_file(const arguments *a, const sp_scene *scene, const char *path, sp_table *t, bool *failed,
                          sp_error *err) {
    measured m;
    sp_error fault = {0};
    bool packing = false;
    sp_status status = is_packing(path, &packing, &fault);
    if (status == SP_OK && !packing)
        return add_trace(a, path, t, failed, err);
    if (status == SP_OK)
        status = packing_front(a, scene, path, &m, &fault);
    if (status == SP_OK)
        return add_front(a, path, true, &m, t, err);
    cli_fail(&fault);
    *failed = true;
    return SP_OK;
}

static sp_status work(const arguments *a, bool *failed, sp_error *err) {
    sp_scene scene = sp_scene_default();
    sp_table t = sp_table_none();
    sp_status status = cli_may_write_table(&a->common, err);
    if (status == SP_OK)
        status = cli_scene_of_sets(&a->common, "network signal", &scene, err);
    if (status == SP_OK)
        status = add_columns(&t, err);
    for (int k = 0; k < a->files && status == SP_OK; k++)
        status = add_file(a, &scene, a->file[k], &t, failed, err);
    if (status == SP_OK && t.rows > 0)
        status = cli_write_table(&a->common, &t, err);
    sp_table_free(&t);
    sp_scene_free(&scene);
    return status;
}

int cmd_front(int argc, char **argv) {
    arguments a = {.window = NAN, .distance = NAN};
    argp_parse(&argp, argc, argv, 0, NULL, &a);
    sp_error err = {0};
    bool failed = false;
    if (work(&a, &failed, &err) != SP_OK)
        return cli_fail(&err);
    return failed ? CLI_FAILED : CLI_OK;
}
