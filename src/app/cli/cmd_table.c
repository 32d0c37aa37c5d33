/* sonopack table: prints a table of the samples in a store. */
#include "base/base.h"
#include "cli/tables.h"

#include <string.h>

typedef struct arguments {
    cli_common common;
    const char *store;
    cli_filter filter;
    double level;
    int64_t bins;
    double omega_max;
} arguments;

static sp_status check(void *user, sp_error *err) {
    const arguments *a = user;
    if (!a->store)
        return sp_fail(err, SP_EINVAL, "no store: must be --store DIR");
    if (a->common.sets > 0 && a->common.files == 0)
        return sp_fail(err, SP_EINVAL, "--set: needs the SCENE that made the store");
    return SP_OK;
}

static const cli_option options[] = {
    {"store", "DIR", "Folder of the samples", CLI_TEXT, .field = offsetof(arguments, store)},
    {"width", "W", "Only samples in boxes of this width [d]", CLI_NUMBER, .field = offsetof(arguments, filter.width),
     .key = "packing.width"},
    {"grains", "N", "Only samples of N grains", CLI_INTEGER, .field = offsetof(arguments, filter.grains),
     .key = "packing.grains"},
    {"pressure", "P", "Only samples at this pressure [E*]", CLI_NUMBER, .field = offsetof(arguments, filter.pressure),
     .key = "packing.pressure"},
    {"friction", "MU", "Only samples with this friction coefficient", CLI_NUMBER,
     .field = offsetof(arguments, filter.friction), .key = "packing.friction"},
    {"interval", "LEVEL", "Confidence level of the intervals, 0.5 to 0.999 (0.95)", CLI_NUMBER,
     .field = offsetof(arguments, level), .low = SP_LEVEL_LEAST, .high = SP_LEVEL_MOST},
    {"bins", "N", "spectrum: number of bins of equal width (20 to 100, depending on the number of modes)", CLI_INTEGER,
     .field = offsetof(arguments, bins), .low = 1, .high = CLI_BINS_MAX, .kinds = "spectrum"},
    {"omega-max", "OMEGA", "spectrum: last frequency (the largest of all samples, rounded up).", CLI_NUMBER,
     .field = offsetof(arguments, omega_max), .low = 1e-12, .high = 1e9, .kinds = "spectrum"},
    {0}};

const cli_syntax cmd_table_syntax = {
    .usage = "NAME --store DIR [SCENE]",
    .help =
        "Prints a table of the samples in a store.\v"
        "ctof: speed of the first front, one row per pressure.\n"
        "scaling: fronts against distance, with speeds and exponents, one row per height, pressure, friction and "
        "width.\n"
        "planes: the same inside packings, one row per plane (and per number of grains).\n"
        "statics, moduli, probes: one row per pressure and size with means X, their standard deviation over the "
        "samples X_sd, the standard error X_err, and the confidence interval X_low to X_high; left_out counts the "
        "samples that should have them and do not.\n"
        "ensemble: one row per sample, with all its results.\n"
        "spectrum: density of states, in modes per grain (without rattlers) and unit of omega, one row per bin, with "
        "standard errors, confidence intervals and the integral from 0; for samples of one pressure and size, made "
        "with spectrum in study.want.\n"
        "signal: mean of the stored signals, rms deviation from it, its standard error and confidence interval, one "
        "row per time; for samples of one pressure and size whose signals have the same times, made with signal in "
        "study.want, and signal.until.\n"
        "\n"
        "With a SCENE (and --set) only the samples of that scene are used; at least one must be in the store, and "
        "signal and spectrum have one table for each value of a swept key. A store may hold several ensembles: "
        "samples that differ in more than pressure and size are not averaged. --width, --grains, --pressure and "
        "--friction select among them.",
    .finds_material = true,
    .options = options,
    .kinds = cli_table_names,
    .kind_name = "table",
    .file_name = "scene",
    .files_max = 1,
    .check = check};

/* The material of the samples, which must be one: different studies may have shared the store. */
static sp_status find_material(arguments *a, sp_store *store, sp_error *err) {
    int64_t n = 0, bad = 0;
    sp_sample *sample = NULL;
    sp_status status = sp_store_samples(store, &n, &sample, &bad, err);
    for (int64_t k = 0; k < n && status == SP_OK; k++) {
        sp_packing p = sp_packing_none();
        if (!sample[k].failed)
            status = sp_store_read(store, sample[k].name, &p, NULL, NULL, err);
        if (status == SP_OK && !sample[k].failed)
            status = cli_take_material(a, &p.material, k == 0 ? "a sample of the store" : "another sample", err);
        sp_packing_free(&p);
    }
    sp_free(sample);
    return status;
}

/* That of --material, of the scene, or of the samples: these are read only if it is needed. */
static sp_status take_material(arguments *a, const sp_scene *scene, sp_store *store, sp_error *err) {
    if (a->common.material.young > 0 || scene->material.young > 0)
        return cli_take_material(a, &scene->material, "the scene", err);
    const bool needed = a->common.units == CLI_UNITS_SI || a->common.quantities > 0;
    return needed ? find_material(a, store, err) : SP_OK;
}

static sp_status work(arguments *a, sp_scene *scene, sp_store **store, sp_error *err) {
    const char *path = a->common.files > 0 ? a->common.file[0] : NULL;
    sp_status status = SP_OK;
    if (path)
        status = cli_read_scene(&a->common, path, scene, err);
    CLI_THEN(status, sp_scene_check_sweeps(scene, err));
    cli_tables tables = {.common = &a->common,
                         .scene = path ? scene : NULL,
                         .needs_samples = true,
                         .count = 1,
                         .name = {cli_table_names[a->common.kind]},
                         .filter = a->filter,
                         .level = a->level,
                         .bins = {(int32_t)a->bins, a->omega_max}};
    CLI_THEN(status, cli_tables_may_write(&tables, err));
    CLI_THEN(status, sp_store_open(a->store, false, store, err));
    CLI_THEN(status, take_material(a, scene, *store, err));
    tables.filter = a->filter;
    return status == SP_OK ? cli_tables_write(&tables, *store, err) : status;
}

int cmd_table(int argc, char **argv) {
    arguments a = {.filter = cli_filter_none(), .level = sp_table_options_default().level};
    cli_parse(&cmd_table_syntax, argc, argv, &a);
    sp_error err = {0};
    sp_scene scene = sp_scene_default();
    sp_store *store = NULL;
    sp_status status = work(&a, &scene, &store, &err);
    if (store)
        sp_store_close(store);
    sp_scene_free(&scene);
    return status == SP_OK ? CLI_OK : cli_fail(&err);
}
