/* sonopack coda: finds the grain whose contacts have changed, from the change of signals. */
#include "base/base.h"
#include "cli/coda.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static sp_status add_source(void *user, const char *word, sp_error *err) {
    return cli_places_add(&((coda_arguments *)user)->sources, "--from", word, err);
}

static sp_status add_detector(void *user, const char *word, sp_error *err) {
    return cli_places_add(&((coda_arguments *)user)->detectors, "--detector", word, err);
}

static sp_status set_window(void *user, const char *text, sp_error *err) {
    coda_arguments *a = user;
    char first[64] = "";
    const char *colon = strchr(text, ':');
    const size_t length = colon ? (size_t)(colon - text) : 0;
    if (length == 0 || length >= sizeof first)
        return sp_fail(err, SP_EINVAL, "--window %.60s: must be two times, T1:T2", text);
    memcpy(first, text, length);
    sp_status status = cli_number("--window", first, 0, 1e9, &a->low, err);
    if (status == SP_OK)
        status = cli_number("--window", colon + 1, 1e-9, 1e9, &a->high, err);
    if (status == SP_OK && !(a->low < a->high))
        status = sp_fail(err, SP_EINVAL, "--window %.60s: must be two times T1:T2 with T1 below T2", text);
    return status;
}

static const cli_option options[] = {
    {.help = "Measured signals:"},
    {"before", "TABLE", "Signals before the change: columns t and F, or F1, F2, ...", CLI_TEXT,
     .field = offsetof(coda_arguments, before)},
    {"after", "TABLE", "Signals after the change, at the same times", CLI_TEXT,
     .field = offsetof(coda_arguments, after)},
    {.help = "Computed signals:"},
    {"change", "EPS", "Relative change of the stiffness of all contacts of a grain (0.01)", CLI_NUMBER,
     .field = offsetof(coda_arguments, change), .low = -0.99, .high = 10},
    {"grain", "I", "The grain that changes", CLI_INTEGER, .field = offsetof(coda_arguments, grain), .high = INT32_MAX},
    {"trials", "N", "Change N grains drawn at random, one after another, and tell how far away they are found",
     CLI_INTEGER, .field = offsetof(coda_arguments, trials), .low = 1, .high = 1000000},
    {"seed", "S", "Seed of the noise and of the trials (1)", CLI_INTEGER, .field = offsetof(coda_arguments, seed),
     .high = 1e15},
    {"points", "N", "Number of equally spaced times in the window (400)", CLI_INTEGER,
     .field = offsetof(coda_arguments, points), .low = 10, .high = 1000000},
    {.help = "Comparison:"},
    {"window", "T1:T2", "Times that are compared [d/sqrt(E* / rho)] (W/2:2 W with W = (8 H + 40) (p/1e-4)^(-1/6))",
     .parse = set_window},
    {"noise", "SD",
     "Noise of both signals, relative to the root mean square of the signal in the window (0; of measured signals what "
     "the best fit leaves)",
     CLI_NUMBER, .field = offsetof(coda_arguments, noise), .high = 1e6},
    {"from", "PLACE", "Source, as in signal (bottom); repeatable", .parse = add_source},
    {"detector", "PLACE", "Detector, as in signal (top); repeatable", .parse = add_detector},
    {"component", "normal|shear", "Component at every PLACE without one (normal)", CLI_CHOICE,
     .field = offsetof(coda_arguments, component), .words = cli_component_names},
    {"source", "impulse|velocity|displacement", "Kind of source (impulse)", CLI_CHOICE,
     .field = offsetof(coda_arguments, source), .words = cli_source_names},
    {"rows", "N", "Print the N most probable grains (20)", CLI_INTEGER, .field = offsetof(coda_arguments, rows),
     .low = 1, .high = INT32_MAX},
    {0}};

static const cli_syntax syntax;

static sp_status check(void *user, sp_error *err) {
    const coda_arguments *a = user;
    const bool measured = a->before || a->after;
    if (measured && !(a->before && a->after))
        return sp_fail(err, SP_EINVAL, "--before and --after: must be given both");
    if (measured + (a->grain >= 0) + (a->trials > 0) != 1)
        return sp_fail(err, SP_EINVAL, "one of --grain I, --trials N, and --before with --after must be given");
    sp_status status = cli_need(&syntax, &a->common, "rows", a->trials == 0, "--grain, or --before and --after", err);
    static const char *const computed[] = {"change", "points", "seed"};
    for (size_t k = 0; k < sizeof computed / sizeof *computed && status == SP_OK; k++)
        status = cli_need(&syntax, &a->common, computed[k], !measured, "--grain or --trials", err);
    return status;
}

static const cli_syntax syntax = {
    .usage = "FILE",
    .help =
        "Coda-wave interferometry: finds the grain whose contacts have changed from the change of the signals, most of "
        "all of their late part, which has passed every place many times.\v"
        "The kernel of a grain is the derivative of the signal by the logarithm of the stiffness of all its contacts. "
        "Each grain alone, with the change that fits best, is compared with the change of the signals. misfit: part of "
        "the squared change that it leaves unexplained. probability: of being the place, if noise is white and each "
        "grain is equally likely beforehand. change: of the stiffness, relative to it. change_err: its standard error, "
        "from the noise and from what the kernel leaves out, which knows changes to first order. The packing must be "
        "that of the measurement, and tables of measured "
        "signals have one column for each pair of a source and a detector, detectors running fastest.\n"
        "\n"
        "stretch: relative change of speed that stretches the first signal to that after the change, by least "
        "squares.\n"
        "\n"
        "With --grain a change is computed and sought, with noise of the given level in both signals. With --trials "
        "there is a row for each of several grains: where it was found, at which distance d, with which probability; "
        "rank: how many grains are as probable as the right one or more. The comments found and distance are the "
        "fraction that was found exactly and the mean distance.",
    .finds_material = true,
    .options = options,
    .file_name = "packing",
    .files_min = 1,
    .files_max = 1,
    .springs = true,
    .check = check};

static sp_status begin(void *user, sp_table *t, sp_error *err) {
    const coda_arguments *a = user;
    cli_writer w = {.table = t, .err = err};
    if (a->trials > 0) {
        cli_columns(&w, SP_CELL_INTEGER, "grain", "", "found", "", "rank", "", NULL);
        cli_columns(&w, SP_CELL_NUMBER, "distance", "d", "probability", "", "change", "", "change_err", "", "misfit",
                    "", NULL);
        return w.status;
    }
    cli_columns(&w, SP_CELL_INTEGER, "grain", "", NULL);
    cli_columns(&w, SP_CELL_NUMBER, "x", "d", "y", "d", "z", "d", "probability", "", "change", "", "change_err", "",
                "misfit", "", NULL);
    return w.status;
}

int cmd_coda(int argc, char **argv) {
    static const cli_files command = {
        .groups = "network", .contents = CLI_NETWORK, .stop = true, .begin = begin, .add = coda_rows};
    coda_arguments a = {.change = 0.01,
                        .grain = -1,
                        .seed = 1,
                        .points = 400,
                        .rows = 20,
                        .low = NAN,
                        .high = NAN,
                        .sources = {.sources = true}};
    cli_parse(&syntax, argc, argv, &a);
    return cli_run_files(&command, &a);
}
