/* sonopack table: prints tables of the samples in a store, as study does at its end. */
#include "base/base.h"
#include "base/file.h"
#include "cli/tables.h"
#include "ensemble/sample.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- cases ------------------------------------------------------------------------------------------------------- */

const char *const cli_table_names[CLI_TABLES + 1] = {"ctof",   "scaling",  "planes",   "statics", "moduli",
                                                     "probes", "spectrum", "ensemble", "signal",  NULL};

/* Whether the table has a row for each value of the sweep. It averages over seeds. */
static bool has_rows(const char *table, const sp_sweep *sweep) {
    if (strcmp(sweep->key, "packing.seed") == 0)
        return true;
    if (strcmp(table, "signal") == 0 || strcmp(table, "spectrum") == 0)
        return false;
    static const char *const keys[] = {"packing.pressure", "packing.fraction", "packing.stages",  "packing.grains",
                                       "packing.height",   "packing.width",    "packing.friction"};
    static const char *const means[] = {"ctof", "statics", "moduli", "probes", "ensemble"};
    size_t count = 7;
    for (size_t k = 0; k < sizeof means / sizeof *means; k++)
        if (strcmp(table, means[k]) == 0)
            count = 5;
    for (size_t k = 0; k < count; k++)
        if (strcmp(sweep->key, keys[k]) == 0)
            return true;
    return false;
}

static int64_t cases_of(const char *table, const sp_scene *scene) {
    int64_t cases = 1;
    for (int s = 0; scene && s < scene->sweeps; s++)
        cases *= has_rows(table, &scene->sweep[s]) ? 1 : scene->sweep[s].count;
    return cases;
}

/* Sets the sweeps without rows to their values of case c. The other sweeps remain. */
static sp_status case_scene(const char *table, const sp_scene *scene, int64_t c, sp_scene *out, sp_error *err) {
    sp_scene one = *scene;
    sp_status status = SP_OK;
    one.sweeps = 0;
    for (int s = 0; s < scene->sweeps && status == SP_OK; s++) {
        const sp_sweep *sweep = &scene->sweep[s];
        if (has_rows(table, sweep)) {
            one.sweep[one.sweeps++] = *sweep;
            continue;
        }
        status = sp_scene_set_swept(&one, sweep, (int)(c % sweep->count), err);
        c /= sweep->count;
    }
    *out = one;
    return status;
}

/* The value of sweep s in case c, or NULL if the table has rows for it. Divides *c for the next sweep. */
static const char *case_value(const char *table, const sp_scene *scene, int s, int64_t *c, char *buf, size_t size) {
    const sp_sweep *sweep = &scene->sweep[s];
    if (has_rows(table, sweep))
        return NULL;
    const int k = (int)(*c % sweep->count);
    *c /= sweep->count;
    return sp_sweep_text(sweep, k, buf, size);
}

static sp_status add_case(sp_table *t, const char *table, const sp_scene *scene, int64_t c, sp_error *err) {
    char buf[200];
    sp_status status = SP_OK;
    for (int s = 0; s < scene->sweeps && status == SP_OK; s++) {
        const char *value = case_value(table, scene, s, &c, buf, sizeof buf);
        if (value)
            status = sp_table_add_comment(t, err, "%s = %s", scene->sweep[s].key, value);
    }
    return status;
}

/* The values of case c as text, ", packing.friction = 0.1"; "" if there is only one case. */
static void case_text(const char *table, const sp_scene *scene, int64_t c, char *text, size_t size) {
    char buf[200];
    size_t used = 0;
    *text = '\0';
    for (int s = 0; scene && s < scene->sweeps && used < size; s++) {
        const char *value = case_value(table, scene, s, &c, buf, sizeof buf);
        if (value)
            used += (size_t)snprintf(text + used, size - used, ", %s = %s", scene->sweep[s].key, value);
    }
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

/* The file of table k of case c. The very first table goes to the file of -o itself. */
static sp_status path_of(const cli_tables *tables, int k, int64_t c, char path[SP_PATH_MAX], sp_error *err) {
    const char *output = tables->common->output, *slash = strrchr(output, '/');
    const char *name = slash ? slash + 1 : output, *dot = strrchr(name, '.');
    const int stem = (int)(dot && dot > name ? dot - output : (ptrdiff_t)strlen(output));
    char number[32] = "";
    if (c > 0)
        snprintf(number, sizeof number, "-%lld", (long long)c + 1);
    int length;
    if (k == 0 && c == 0)
        length = snprintf(path, SP_PATH_MAX, "%s", output);
    else
        length = snprintf(path, SP_PATH_MAX, "%.*s-%s%s%s", stem, output, tables->name[k], number, output + stem);
    if (length >= SP_PATH_MAX)
        return sp_fail(err, SP_EINVAL, "-o: the file name has %d bytes, must have fewer than %d", length, SP_PATH_MAX);
    return SP_OK;
}

sp_status cli_tables_may_write(const cli_tables *tables, sp_error *err) {
    cli_common common = *tables->common;
    if (!common.output)
        return cli_may_write_table(&common, err);
    sp_status status = SP_OK;
    for (int k = 0; k < tables->count; k++)
        for (int64_t c = 0; c < cases_of(tables->name[k], tables->scene) && status == SP_OK; c++) {
            char path[SP_PATH_MAX];
            common.output = path;
            status = path_of(tables, k, c, path, err);
            CLI_THEN(status, cli_may_write_table(&common, err));
        }
    return status;
}

/* Writes table k. c counts the cases that have been written, `of` is the text of this one. */
static sp_status write_table(const cli_tables *tables, int k, int64_t c, const char *of, sp_table *t, sp_error *err) {
    char path[SP_PATH_MAX];
    if (!tables->common->output) {
        if (k > 0 || c > 0)
            putchar('\n');
        return cli_write_table(tables->common, t, err);
    }
    sp_status status = path_of(tables, k, c, path, err);
    CLI_THEN(status, cli_write_table_to(tables->common, path, t, err));
    if (status == SP_OK && (tables->count > 1 || *of))
        cli_note(tables->common, "table %s%s: %s", tables->name[k], of, path);
    return status;
}

/* ---- samples ----------------------------------------------------------------------------------------------------- */

/* The samples of a table. */
typedef struct choice {
    int64_t n, missing; /* missing: samples of the scene that are not in the store */
    sp_sample *sample;
} choice;

static int by_name(const void *a, const void *b) { return strcmp(((const sp_sample *)a)->name, b); }

static int by_names(const void *a, const void *b) { return by_name(a, ((const sp_sample *)b)->name); }

static int find_name(const void *name, const void *sample) { return -by_name(sample, name); }

/* Marks which results the scene asks for and the sample lacks, and hides those of another scene. */
static void compare_parts(const sp_scene *scene, sp_sample *s) {
    const unsigned parts = sp_sample_parts(scene, s), missing = sp_want_parts(scene->want) & ~parts;
    if (!s->failed && missing) {
        if (!(s->lacks & missing) || !s->reason[0])
            snprintf(s->reason, sizeof s->reason, "it lacks a part that is wanted: not made yet");
        s->lacks = missing;
    }
    if (scene->planes > 0)
        s->have &= parts | ~(unsigned)SP_WANT_PLANES;
    if (scene->want & SP_WANT_SIGNAL)
        s->have &= parts | ~(unsigned)SP_WANT_SIGNAL;
}

/* Copies the samples that the scene makes from `all', which is sorted by name. */
static sp_status choose(const sp_scene *scene, const choice *all, choice *out, sp_error *err) {
    const int64_t count = sp_study_count(scene);
    choice c = {.sample = sp_alloc((size_t)(count < all->n ? count : all->n), sizeof *c.sample)};
    bool *taken = sp_alloc((size_t)all->n, sizeof *taken); /* two heights may make one number of grains */
    sp_status status = c.sample && taken ? SP_OK : sp_fail_memory(err, (size_t)all->n * sizeof *c.sample);
    for (int64_t k = 0; k < count && status == SP_OK; k++) {
        sp_scene one;
        char name[SP_NAME_MAX];
        status = sp_study_sample(scene, k, &one, name, err);
        if (status != SP_OK)
            break;
        const sp_sample *found = bsearch(name, all->sample, (size_t)all->n, sizeof *found, find_name);
        c.missing += !found;
        if (!found || taken[found - all->sample])
            continue;
        taken[found - all->sample] = true;
        c.sample[c.n] = *found;
        compare_parts(&one, &c.sample[c.n++]);
    }
    sp_free(taken);
    if (status == SP_OK)
        *out = c;
    else
        sp_free(c.sample);
    return status;
}

/* ---- the filter -------------------------------------------------------------------------------------------------- */

cli_filter cli_filter_none(void) { return (cli_filter){.width = NAN, .pressure = NAN, .friction = NAN}; }

/* The precision allows for numbers that are given with a few digits. */
static bool is_near(double asked, double value) { return isnan(asked) || fabs(asked - value) <= 1e-3 * fabs(asked); }

static bool passes(const cli_filter *f, const sp_sample *s) {
    return is_near(f->width, s->width) && is_near(f->pressure, s->pressure) && is_near(f->friction, s->friction) &&
           (f->grains == 0 || f->grains == s->grains);
}

static bool is_filter(const cli_filter *f) {
    return f->grains != 0 || !isnan(f->width) || !isnan(f->pressure) || !isnan(f->friction);
}

/* Moves the samples that pass to the front, and returns their number. */
static int64_t filter(const cli_filter *f, int64_t n, sp_sample *all) {
    int64_t kept = 0;
    for (int64_t k = 0; k < n; k++) {
        if (!passes(f, &all[k]))
            continue;
        if (kept < k)
            all[kept] = all[k];
        kept++;
    }
    return kept;
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

/* With a filter, samples that it leaves out would be counted as well. */
static sp_status add_missing(const cli_tables *tables, int64_t missing, sp_table *t, sp_error *err) {
    if (missing == 0 || is_filter(&tables->filter))
        return SP_OK;
    return sp_table_add_comment(t, err, "missing = %lld samples of the scene that are not in the store yet",
                                (long long)missing);
}

/* The samples of all tables, sorted by name. */
typedef struct stored {
    sp_store *store;
    choice of;
    int64_t cases; /* of the table with the most cases */
} stored;

static sp_status make_table(const cli_tables *tables, const char *name, const stored *all, const choice *of,
                            sp_table *out, sp_error *err) {
    const sp_table_options options = {.level = tables->level};
    const cli_averaged averaged = {
        strcmp(name, "spectrum") == 0, all->store, of->n, of->sample, tables->level, tables->bins};
    if (averaged.spectrum || strcmp(name, "signal") == 0)
        return cli_table_averaged(&averaged, out, err);
    return sp_study_table(name, of->n, of->sample, &options, out, err);
}

/* *written: how many cases of table k have been written. */
static sp_status write_case(const cli_tables *tables, int k, int64_t c, const stored *all, int64_t *written,
                            sp_error *err) {
    const char *name = tables->name[k];
    char of[400];
    sp_scene one = {0};
    choice chosen = {0};
    sp_status status = SP_OK;
    const bool copied = tables->scene && all->cases > 1;
    if (copied) {
        status = case_scene(name, tables->scene, c, &one, err);
        CLI_THEN(status, choose(&one, &all->of, &chosen, err));
    } else {
        chosen = all->of;
    }
    sp_table t = sp_table_none();
    if (status == SP_OK && chosen.n == 0 && tables->scene && is_filter(&tables->filter))
        goto out; /* the filter selects another case */
    CLI_THEN(status, make_table(tables, name, all, &chosen, &t, err));
    if (status == SP_OK && tables->scene)
        status = add_case(&t, name, tables->scene, c, err);
    CLI_THEN(status, add_missing(tables, chosen.missing, &t, err));
    case_text(name, tables->scene, c, of, sizeof of);
    CLI_THEN(status, write_table(tables, k, (*written)++, of, &t, err));
out:
    sp_table_free(&t);
    if (copied)
        sp_free(chosen.sample);
    return status;
}

static int64_t most_cases(const cli_tables *tables) {
    int64_t most = 1;
    for (int k = 0; k < tables->count; k++) {
        const int64_t cases = cases_of(tables->name[k], tables->scene);
        most = cases > most ? cases : most;
    }
    return most;
}

/* All tables of the first case come first, then those of the second, ... */
static sp_status write_all(const cli_tables *tables, const stored *all, sp_error *err) {
    int64_t written[CLI_TABLES] = {0};
    sp_status status = SP_OK;
    for (int64_t c = 0; c < all->cases; c++)
        for (int k = 0; k < tables->count && status == SP_OK; k++)
            if (c < cases_of(tables->name[k], tables->scene))
                status = write_case(tables, k, c, all, &written[k], err);
    return status;
}

/* Keeps the samples that pass the filter and belong to the scene. SP_EREFUSED if none is left and the table needs one.
 */
static sp_status select_samples(const cli_tables *tables, choice *of, sp_error *err) {
    const int64_t stored_ones = of->n;
    of->n = filter(&tables->filter, of->n, of->sample);
    const int64_t found = of->n;
    if (stored_ones > 0 && found == 0)
        return sp_fail(err, SP_EREFUSED,
                       "no table: none of the %lld samples in the store has this width, number of grains, pressure and "
                       "friction: see `sonopack table ensemble'",
                       (long long)stored_ones);
    if (found == 0 && tables->needs_samples)
        return sp_fail(err, SP_EREFUSED, "no table: the store has no samples");
    if (found > 0)
        qsort(of->sample, (size_t)found, sizeof *of->sample, by_names);
    choice chosen = *of;
    sp_status status = tables->scene ? choose(tables->scene, of, &chosen, err) : SP_OK;
    if (status == SP_OK && chosen.sample != of->sample) {
        sp_free(of->sample);
        *of = chosen;
        qsort(of->sample, (size_t)of->n, sizeof *of->sample, by_names);
    }
    if (status == SP_OK && of->n == 0 && tables->needs_samples)
        status =
            sp_fail(err, SP_EREFUSED,
                    "no table: none of the %lld samples of the scene is among the %lld in the store: use the scene "
                    "(and --set) that made them, see `sonopack table ensemble'",
                    (long long)of->missing, (long long)found);
    return status;
}

sp_status cli_tables_write(const cli_tables *tables, sp_store *store, sp_error *err) {
    stored all = {.store = store, .cases = most_cases(tables)};
    int64_t bad = 0;
    sp_error reason = {0};
    sp_status status = sp_store_samples(store, &all.of.n, &all.of.sample, &bad, &reason);
    if (status != SP_OK) {
        *err = reason;
        return status;
    }
    if (all.of.n == 0 && !tables->needs_samples)
        cli_note(tables->common, "the store has no samples");
    if (bad > 0)
        cli_note(tables->common, "%lld files of the store are not used: %s", (long long)bad, reason.text);
    status = select_samples(tables, &all.of, err);
    CLI_THEN(status, write_all(tables, &all, err));
    sp_free(all.of.sample);
    return status;
}

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
    {"store", "DIR", "Folder of the samples", CLI_TEXT, CLI_FIELD(store)},
    {"width", "W", "Only samples in boxes of this width [d]", CLI_NUMBER, CLI_FIELD(filter.width),
     .key = "packing.width"},
    {"grains", "N", "Only samples of N grains", CLI_INTEGER, CLI_FIELD(filter.grains), .key = "packing.grains"},
    {"pressure", "P", "Only samples at this pressure [E*]", CLI_NUMBER, CLI_FIELD(filter.pressure),
     .key = "packing.pressure"},
    {"friction", "MU", "Only samples with this friction coefficient", CLI_NUMBER, CLI_FIELD(filter.friction),
     .key = "packing.friction"},
    {"interval", "LEVEL", "Confidence level of the intervals, 0.5 to 0.999 (0.95)", CLI_NUMBER, CLI_FIELD(level),
     .low = SP_LEVEL_LEAST, .high = SP_LEVEL_MOST},
    {"bins", "N", "spectrum: number of bins of equal width (20 to 100, depending on the number of modes)", CLI_INTEGER,
     CLI_FIELD(bins), .low = 1, .high = CLI_BINS_MAX, .kinds = "spectrum"},
    {"omega-max", "OMEGA", "spectrum: last frequency (the largest of all samples, rounded up).", CLI_NUMBER,
     CLI_FIELD(omega_max), .low = 1e-12, .high = 1e9, .kinds = "spectrum"},
    {0}};

const cli_syntax cmd_table_syntax = {
    .usage = "NAME --store DIR [SCENE]",
    .help =
        "Prints a table of the samples in a store.\vctof: speed of the first front, one row per pressure.\n"
        "scaling: fronts against distance, with speeds and exponents, one row per height, pressure, friction and "
        "width.\n"
        "planes: the same inside packings, one row per plane (and per number of grains).\n"
        "statics, moduli, probes: one row per pressure and size with means X, their standard deviation over the "
        "samples X_sd, the standard error X_err, and the confidence interval X_low to X_high; left_out counts the "
        "samples that should have them and do not.\n"
        "With packing.fraction, or with stages of a history or path of strain, rows are also by fraction, stage and "
        "strain, and p is a mean with the error p_err.\n"
        "ensemble: one row per sample, with all its results.\n"
        "spectrum: density of states, in modes per grain (without rattlers) and unit of omega, one row per bin, with "
        "standard errors, confidence intervals and the integral from 0; for samples of one pressure and size, made "
        "with spectrum in study.want.\n"
        "signal: mean of the stored signals, rms deviation from it, its standard error and confidence interval, one "
        "row per time; for samples of one pressure and size whose signals have the same times, made with signal in "
        "study.want, and signal.until.\n"
        "\n"
        "With a SCENE (and --set) only the samples of that scene are used; at least one must be in the store, and "
        "signal and spectrum have one table for each value of a swept key. A store may hold several ensembles: samples "
        "that differ in more than pressure and size are not averaged. --width, --grains, --pressure and --friction "
        "select among them.",
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
