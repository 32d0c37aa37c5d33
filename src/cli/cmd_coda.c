/* sonopack coda: finds the grain whose contacts have changed, from the change of signals. */
#include "base/base.h"
#include "cli/excitation.h"
#include "cli/files.h"
#include "numeric/random.h"
#include "packing/geometry.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct arguments {
    cli_common common;
    const char *before, *after; /* tables of measured signals; NULL: computed ones */
    double change, noise, window[2];
    int64_t grain, trials, seed, points, rows;
    cli_places sources, detectors;
    int component, source;
} arguments;

static const cli_option options[] = {
    {.help = "Measured signals:"},
    {"before", "TABLE", "Signals before the change: columns t and F, or F1, F2, ...", CLI_TEXT, CLI_FIELD(before)},
    {"after", "TABLE", "Signals after the change, at the same times", CLI_TEXT, CLI_FIELD(after)},
    {.help = "Computed signals:"},
    {"change", "EPS", "Relative change of the stiffness of all contacts of a grain (0.01)", CLI_NUMBER,
     CLI_FIELD(change), .low = -0.99, .high = 10},
    {"grain", "I", "The grain that changes", CLI_INTEGER, CLI_FIELD(grain), .high = INT32_MAX},
    {"trials", "N", "Change N grains drawn at random, one after another, and tell how far away they are found",
     CLI_INTEGER, CLI_FIELD(trials), .low = 1, .high = 1000000},
    {"seed", "S", "Seed of the noise and of the trials (1)", CLI_INTEGER, CLI_FIELD(seed), .high = 1e15},
    {"points", "N", "Number of equally spaced times in the window (400)", CLI_INTEGER, CLI_FIELD(points), .low = 10,
     .high = 1000000},
    {.help = "Comparison:"},
    {"window", "T1:T2", "Times that are compared [d/sqrt(E* / rho)] (W/2:2 W with W = (8 H + 40) (p/1e-4)^(-1/6))",
     CLI_PAIR, CLI_FIELD(window), .high = 1e9},
    {"noise", "SD",
     "Noise of both signals, relative to the root mean square of the signal in the window (0; of measured signals what "
     "the best fit leaves)",
     CLI_NUMBER, CLI_FIELD(noise), .high = 1e6},
    {"from", "PLACE", "Source, as in signal (bottom); repeatable", .parse = cli_places_add, CLI_FIELD(sources)},
    {"detector", "PLACE", "Detector, as in signal (top); repeatable", .parse = cli_places_add, CLI_FIELD(detectors)},
    {"component", "normal|shear", "Component at every PLACE without one (normal)", CLI_CHOICE, CLI_FIELD(component),
     .words = cli_component_names},
    {"source", "impulse|velocity|displacement", "Kind of source (impulse)", CLI_CHOICE, CLI_FIELD(source),
     .words = cli_source_names},
    {"rows", "N", "Print the N most probable grains (20)", CLI_INTEGER, CLI_FIELD(rows), .low = 1, .high = INT32_MAX},
    {0}};

static sp_status check(void *user, sp_error *err) {
    const arguments *a = user;
    const bool measured = a->before || a->after;
    if (measured && !(a->before && a->after))
        return sp_fail(err, SP_EINVAL, "--before and --after: must be given both");
    if (measured + (a->grain >= 0) + (a->trials > 0) != 1)
        return sp_fail(err, SP_EINVAL, "one of --grain I, --trials N, and --before with --after must be given");
    sp_status status =
        cli_need(&cmd_coda_syntax, &a->common, "rows", a->trials == 0, "--grain, or --before and --after", err);
    static const char *const computed[] = {"change", "points", "seed"};
    for (size_t k = 0; k < sizeof computed / sizeof *computed && status == SP_OK; k++)
        status = cli_need(&cmd_coda_syntax, &a->common, computed[k], !measured, "--grain or --trials", err);
    return status;
}

const cli_syntax cmd_coda_syntax = {
    .usage = "FILE",
    .help =
        "Coda-wave interferometry: finds the grain whose contacts have changed from the change of the signals, most of "
        "all of their late part, which has passed every place many times.\vThe kernel of a grain is the derivative of "
        "the signal by the logarithm of the stiffness of all its contacts. Each grain alone, with the change that fits "
        "best, is compared with the change of the signals. misfit: part of the squared change that it leaves "
        "unexplained. probability: of being the place, if noise is white and each grain is equally likely beforehand. "
        "change: of the stiffness, relative to it. change_err: its standard error, from the noise and from what the "
        "kernel leaves out, which knows changes to first order. The packing must be that of the measurement, and "
        "tables of measured signals have one column for each pair of a source and a detector, detectors running "
        "fastest.\n"
        "\n"
        "fits = no: the best grain explains less than 3/4 of the squared change beyond the noise that --noise tells. "
        "Then something else has changed (one contact, masses, several grains, or one by much), and probabilities mean "
        "nothing. stretch: relative change of speed that stretches the first signal to that after the change, by least "
        "squares.\n"
        "\n"
        "With --grain a change is computed and sought, with noise of the given level in both signals. With --trials "
        "there is a row for each of several grains: where it was found, at which distance d, with which probability; "
        "rank: how many grains are as probable as the right one or more. The comments found and distance are the "
        "fraction that was found exactly and the mean distance.",
    CLI_ONE_PACKING,
    .options = options,
    .springs = true,
    .check = check};

/* Signals on the times of the window. */
typedef struct signals {
    int32_t times, pairs;
    double *t;               /* [times], one block with the others */
    double *before, *change; /* [pairs][times] */
    double *base;            /* [pairs][times] computed signals without the change */
    double noise;            /* standard deviation of each value of the change; 0: unknown */
} signals;

static sp_status alloc_signals(signals *s, sp_error *err) {
    const size_t values = (size_t)s->pairs * (size_t)s->times, all = (size_t)s->times + 3 * values;
    s->t = sp_alloc(all, sizeof *s->t);
    s->before = s->t ? s->t + s->times : NULL;
    s->change = s->t ? s->before + values : NULL;
    s->base = s->t ? s->change + values : NULL;
    return s->t ? SP_OK : sp_fail_memory(err, all * sizeof *s->t);
}

/* ---- measured signals -------------------------------------------------------------------------------------------- */

static sp_status find_columns(const sp_table *t, const char *path, int32_t pairs, int *time, int *force,
                              sp_error *err) {
    char next[16];
    *time = sp_table_find_column(t, "t");
    *force = sp_table_find_column(t, pairs > 1 ? "F1" : "F");
    if (*force < 0)
        *force = sp_table_find_column(t, "F1");
    if (*time < 0 || *force < 0 || *force + pairs > t->columns)
        return sp_fail(err, SP_EFORMAT,
                       "%s: must have the columns t and %s, one for each pair of a source and a detector", path,
                       pairs > 1 ? "F1, F2, ..." : "F");
    snprintf(next, sizeof next, "F%d", pairs + 1);
    if (sp_table_find_column(t, next) >= 0)
        return sp_fail(err, SP_EFORMAT,
                       "%s: has a column %s, but sources and detectors are only %d pair%s: --from and --detector must "
                       "name them all",
                       path, next, pairs, pairs > 1 ? "s" : "");
    return SP_OK;
}

/* The values of the rows from `first` on: before the change, or the change. */
static void copy_columns(const sp_table *t, int64_t first, int time, int force, signals *s, bool after) {
    for (int32_t l = 0; l < s->times; l++) {
        s->t[l] = sp_table_number(t, first + l, time);
        for (int32_t k = 0; k < s->pairs; k++) {
            const size_t at = (size_t)k * (size_t)s->times + (size_t)l;
            const double f = sp_table_number(t, first + l, force + k);
            (after ? s->change : s->before)[at] = after ? f - s->before[at] : f;
        }
    }
}

static sp_status same_times(const sp_table *a, const sp_table *b, int time_a, int time_b, const char *path,
                            sp_error *err) {
    for (int64_t row = 0; row < a->rows && a->rows == b->rows; row++) {
        const double x = sp_table_number(a, row, time_a), y = sp_table_number(b, row, time_b);
        if (!(fabs(x - y) <= 1e-9 * fabs(x)))
            return sp_fail(err, SP_EINVAL, "%s: row %lld is at t = %g, must be at %g as before the change", path,
                           (long long)row + 1, y, x);
    }
    return a->rows == b->rows ? SP_OK
                              : sp_fail(err, SP_EINVAL, "%s: has %lld rows, must have %lld as before the change", path,
                                        (long long)b->rows, (long long)a->rows);
}

static sp_status take_window(const arguments *a, const sp_table *before, const sp_table *after, const int column[4],
                             signals *s, sp_error *err) {
    int64_t first = 0;
    while (first < before->rows && !(sp_table_number(before, first, column[0]) >= a->window[0]))
        first++;
    for (s->times = 0; first + s->times < before->rows; s->times++)
        if (!(sp_table_number(before, first + s->times, column[0]) <= a->window[1]))
            break;
    if (s->times < 10)
        return sp_fail(err, SP_EINVAL, "%s: has %d rows in the window %g:%g, must have at least 10", a->before,
                       s->times, a->window[0], a->window[1]);
    const sp_status status = alloc_signals(s, err);
    if (status != SP_OK)
        return status;
    copy_columns(before, first, column[0], column[1], s, false);
    copy_columns(after, first, column[2], column[3], s, true);
    return SP_OK;
}

static sp_status read_signals(const arguments *a, signals *s, sp_error *err) {
    sp_table before = sp_table_none(), after = sp_table_none();
    int column[4] = {0}; /* time and first signal of both */
    sp_status status = sp_table_read(a->before, &before, err);
    CLI_THEN(status, sp_table_read(a->after, &after, err));
    CLI_THEN(status, find_columns(&before, a->before, s->pairs, &column[0], &column[1], err));
    CLI_THEN(status, find_columns(&after, a->after, s->pairs, &column[2], &column[3], err));
    CLI_THEN(status, same_times(&before, &after, column[0], column[2], a->after, err));
    CLI_THEN(status, take_window(a, &before, &after, column, s, err));
    sp_table_free(&after);
    sp_table_free(&before);
    return status;
}

/* ---- computed signals -------------------------------------------------------------------------------------------- */

static double root_mean_square(const signals *s) {
    const int64_t values = (int64_t)s->pairs * s->times;
    double sum = 0;
    for (int64_t k = 0; k < values; k++)
        sum += s->before[k] * s->before[k];
    return sqrt(sum / (double)values);
}

/* change = after - before, with independent noise in both: sqrt(2) times that of one. */
static sp_status change_grain(const arguments *a, const sp_network *net, const sp_coda_options *o, int32_t grain,
                              sp_random *random, signals *s, sp_error *err) {
    sp_status status = sp_coda_signal(net, o, grain, a->change, s->change, err);
    for (int64_t k = 0; k < (int64_t)s->pairs * s->times && status == SP_OK; k++)
        s->change[k] += s->noise * sp_random_normal(random) - s->before[k];
    return status;
}

/* ---- the tables -------------------------------------------------------------------------------------------------- */

static double distance(const sp_packing *p, int32_t i, int32_t j) {
    double d[3];
    for (int a = 0; a < 3; a++)
        d[a] = p->x[3 * (size_t)j + (size_t)a] - p->x[3 * (size_t)i + (size_t)a];
    sp_packing_nearest(p, d);
    return sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
}

static sp_status add_candidates(const arguments *a, const cli_file *file, const sp_coda *c, const sp_coda_options *o,
                                signals *s, sp_coda_candidate *found, cli_writer *w) {
    sp_status status = SP_OK;
    for (int32_t k = 0; k < c->n && k < a->rows && status == SP_OK; k++) {
        const double *x = file->packing.x + 3 * (size_t)found[k].grain;
        status = sp_coda_first_order(&file->network, o, c, s->base, &found[k], w->err);
        CLI_THEN(status, cli_row(w, (int64_t)found[k].grain, x[0], x[1], x[2], found[k].probability, found[k].change,
                                 found[k].error, found[k].misfit));
    }
    return status;
}

static int64_t rank_of(const sp_coda *c, const sp_coda_candidate *found, int32_t grain) {
    int32_t k = 0;
    while (k < c->n && found[k].grain != grain)
        k++;
    return k + 1;
}

/* Sums over trials. */
typedef struct tally {
    double n, distance, square, hits;
} tally;

static sp_status add_trial(const sp_packing *p, const sp_coda *c, const sp_coda_candidate *found, int32_t grain,
                           tally *sum, cli_writer *w) {
    const double away = distance(p, grain, found[0].grain);
    sum->n++;
    sum->distance += away;
    sum->square += away * away;
    sum->hits += found[0].grain == grain;
    return cli_row(w, (int64_t)grain, (int64_t)found[0].grain, rank_of(c, found, grain), away, found[0].probability,
                   found[0].change, found[0].error, found[0].misfit);
}

static void add_tally(const arguments *a, const tally *s, cli_writer *w) {
    const double mean = s->distance / s->n, part = s->hits / s->n;
    const double likely = (s->hits + 1) / (s->n + 2); /* with none or all found, the error is not 0 */
    cli_value(w, "change", a->change);
    cli_value(w, "distance", mean);
    cli_value(w, "distance_err", sqrt(fmax(s->square / s->n - mean * mean, 0) / fmax(s->n - 1, 1)));
    cli_value(w, "found", part);
    cli_value(w, "found_err", sqrt(likely * (1 - likely) / s->n));
}

static sp_status search_trials(const arguments *a, const cli_file *file, const sp_coda *c, const sp_coda_options *o,
                               signals *s, sp_coda_candidate *found, cli_writer *w) {
    sp_random random = sp_random_make((uint64_t)a->seed, SP_STREAM_TRIALS);
    tally sum = {0};
    sp_status status = SP_OK;
    for (int64_t k = 0; k < a->trials && status == SP_OK; k++) {
        const int32_t grain = c->grain[sp_random_below(&random, (uint64_t)c->n)];
        status = change_grain(a, &file->network, o, grain, &random, s, w->err);
        CLI_THEN(status, sp_coda_locate(c, s->change, s->noise, found, w->err));
        CLI_THEN(status, sp_coda_first_order(&file->network, o, c, s->base, &found[0], w->err));
        CLI_THEN(status, add_trial(&file->packing, c, found, grain, &sum, w));
    }
    if (status == SP_OK)
        add_tally(a, &sum, w);
    return status == SP_OK ? w->status : status;
}

/* Whether the best grain explains at least three quarters of what is not noise in the squared change of the signals. */
static bool fits(const signals *s, const sp_coda_candidate *best) {
    const int64_t values = (int64_t)s->pairs * s->times;
    double square = 0;
    for (int64_t k = 0; k < values; k++)
        square += s->change[k] * s->change[k];
    return (1 - best->misfit) * square >= 0.75 * (square - s->noise * s->noise * (double)values);
}

static sp_status search_one(const arguments *a, const cli_file *file, const sp_coda *c, const sp_coda_options *o,
                            signals *s, sp_coda_candidate *found, cli_writer *w) {
    sp_random random = sp_random_make((uint64_t)a->seed, SP_STREAM_TRIALS);
    double stretch, error;
    sp_status status = SP_OK;
    if (a->grain >= 0)
        status = change_grain(a, &file->network, o, (int32_t)a->grain, &random, s, w->err);
    CLI_THEN(status, sp_coda_locate(c, s->change, s->noise, found, w->err));
    if (status != SP_OK)
        return status;
    sp_coda_stretch(s->times, s->t, s->before, s->change, &stretch, &error);
    cli_value(w, "stretch", stretch); /* of the first signal */
    cli_value(w, "stretch_err", error);
    cli_comment(w, "fits = %s", fits(s, &found[0]) ? "yes" : "no");
    if (a->grain >= 0) {
        cli_value(w, "change", a->change);
        cli_comment(w, "grain = %lld", (long long)a->grain);
        cli_value(w, "distance", distance(&file->packing, (int32_t)a->grain, found[0].grain));
    }
    return w->status == SP_OK ? add_candidates(a, file, c, o, s, found, w) : w->status;
}

/* ---- all of it --------------------------------------------------------------------------------------------------- */

static sp_status prepare(arguments *a, const cli_file *file, signals *s, sp_coda_options *o, sp_error *err) {
    const double usual = sp_signal_window(sp_packing_height(&file->packing), file->packing.pressure);
    sp_status status;
    cli_places_set_component(&a->sources, a->component == 1);
    cli_places_set_component(&a->detectors, a->component == 1);
    if (isnan(a->window[0])) {
        a->window[0] = 0.5 * usual;
        a->window[1] = 2 * usual;
    }
    s->pairs = a->sources.n * a->detectors.n;
    s->times = (int32_t)a->points;
    *o = (sp_coda_options){.source = (sp_source)a->source,
                           .sources = a->sources.n,
                           .detectors = a->detectors.n,
                           .from = a->sources.at,
                           .to = a->detectors.at,
                           .threads = a->common.threads};
    status = a->before ? read_signals(a, s, err) : alloc_signals(s, err);
    o->times = s->times;
    o->t = s->t;
    if (status != SP_OK || a->before)
        return status;
    for (int32_t l = 0; l < s->times; l++)
        s->t[l] = a->window[0] + (a->window[1] - a->window[0]) * l / (s->times - 1);
    return sp_coda_signal(&file->network, o, -1, 0, s->before, err);
}

static void describe(const arguments *a, const cli_file *file, const sp_coda *c, cli_writer *w) {
    cli_comment(w, "file = %s", file->path);
    cli_value(w, "window_low", a->window[0]);
    cli_value(w, "window_high", a->window[1]);
    cli_comment(w, "pairs = %d", c->pairs);
    cli_comment(w, "times = %d", c->times);
    if (a->noise > 0)
        cli_value(w, "noise", a->noise);
}

static sp_status add_rows(void *user, cli_file *file, cli_writer *w) {
    arguments *a = user;
    signals s = {0};
    sp_coda c = sp_coda_none();
    sp_coda_options o;
    sp_coda_candidate *found = NULL;
    sp_status status = prepare(a, file, &s, &o, w->err);
    CLI_THEN(status, sp_coda_make(&file->network, &o, &c, w->err));
    if (status == SP_OK) {
        found = sp_alloc((size_t)c.n, sizeof *found);
        s.noise = sqrt(2) * a->noise * root_mean_square(&s);
        status = sp_coda_signal(&file->network, &o, -1, 0, s.base, w->err);
        describe(a, file, &c, w);
        CLI_THEN(status, found ? w->status : sp_fail_memory(w->err, (size_t)c.n * sizeof *found));
    }
    CLI_THEN(status, (a->trials > 0 ? search_trials : search_one)(a, file, &c, &o, &s, found, w));
    sp_free(found);
    sp_coda_free(&c);
    sp_free(s.t);
    return status;
}

static sp_status begin(void *user, cli_writer *w) {
    const arguments *a = user;
    if (a->trials > 0) {
        cli_columns(w, SP_COLUMN_INTEGER, "grain", "", "found", "", "rank", "", NULL);
        cli_columns(w, SP_COLUMN_NUMBER, "distance", "d", "probability", "", "change", "", "change_err", "", "misfit",
                    "", NULL);
        return w->status;
    }
    cli_columns(w, SP_COLUMN_INTEGER, "grain", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "x", "d", "y", "d", "z", "d", "probability", "", "change", "", "change_err", "",
                "misfit", "", NULL);
    return w->status;
}

int cmd_coda(int argc, char **argv) {
    static const cli_files command = {CLI_OF_NETWORK, .stop = true, .begin = begin, .add = add_rows};
    arguments a = {.change = 0.01,
                   .grain = -1,
                   .seed = 1,
                   .points = 400,
                   .rows = 20,
                   .window = {NAN, NAN},
                   .sources = {.sources = true}};
    cli_parse(&cmd_coda_syntax, argc, argv, &a);
    return cli_run_files(&command, &a);
}
