#include "cli/tables.h"

#include "base/base.h"
#include "cli/table_signal.h"
#include "numeric/interval.h"
#include "store/file.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- cases ------------------------------------------------------------------------------------------------------ */

const char *const cli_table_names[CLI_TABLES] = {"ctof",   "scaling",  "planes",   "statics", "moduli",
                                                 "probes", "spectrum", "ensemble", "signal"};

/* Keys that a table has rows for. Seeds are what tables average over. */
static bool has_rows(const char *table, const sp_sweep *sweep) {
    if (strcmp(sweep->key, "packing.seed") == 0)
        return true;
    if (strcmp(table, "signal") == 0 || strcmp(table, "spectrum") == 0)
        return false;
    static const char *const keys[] = {"packing.pressure", "packing.grains", "packing.height", "packing.width",
                                       "packing.friction"};
    static const char *const means[] = {"ctof", "statics", "moduli", "probes", "ensemble"};
    size_t count = 5;
    for (size_t k = 0; k < sizeof means / sizeof *means; k++)
        if (strcmp(table, means[k]) == 0)
            count = 3;
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

/* The scene with the other sweeps at their values of case c; the sweeps that are left stay the scene's own. */
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
        status = sp_scene_take(&one, sweep, (int)(c % sweep->count), err);
        c /= sweep->count;
    }
    *out = one;
    return status;
}

/* The values of case c as comments. */
static sp_status add_case(sp_table *t, const char *table, const sp_scene *scene, int64_t c, sp_error *err) {
    char value[200];
    sp_status status = SP_OK;
    for (int s = 0; s < scene->sweeps && status == SP_OK; s++) {
        const sp_sweep *sweep = &scene->sweep[s];
        if (has_rows(table, sweep))
            continue;
        status = sp_table_add_comment(t, err, "%s = %s", sweep->key,
                                      sp_sweep_text(sweep, (int)(c % sweep->count), value, sizeof value));
        c /= sweep->count;
    }
    return status;
}

/* ---- files ------------------------------------------------------------------------------------------------------ */

/* Where table k of case c goes: the file of -o itself for the first of all. */
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
        return sp_fail(err, SP_EINVAL, "-o: a name of %d bytes: must be below %d", length, SP_PATH_MAX);
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
            if (status == SP_OK)
                status = cli_may_write_table(&common, err);
        }
    return status;
}

static sp_status write_table(const cli_tables *tables, int k, int64_t c, sp_table *t, sp_error *err) {
    cli_common common = *tables->common;
    char path[SP_PATH_MAX];
    if (!common.output) {
        if (k > 0 || c > 0)
            putchar('\n');
        return cli_write_table(&common, t, err);
    }
    sp_status status = path_of(tables, k, c, path, err);
    common.output = path;
    if (status == SP_OK)
        status = cli_write_table(&common, t, err);
    if (status == SP_OK && (k > 0 || c > 0))
        cli_note(&common, "table %s: %s", tables->name[k], path);
    return status;
}

/* ---- samples ---------------------------------------------------------------------------------------------------- */

/* The samples that a table is made of. */
typedef struct choice {
    int64_t n, missing; /* missing: samples of the scene that the store does not have */
    sp_sample *sample;
} choice;

static int by_name(const void *a, const void *b) { return strcmp(((const sp_sample *)a)->name, b); }

static int by_names(const void *a, const void *b) { return by_name(a, ((const sp_sample *)b)->name); }

static int find_name(const void *name, const void *sample) { return -by_name(sample, name); }

/* Those of `all' (sorted by name) that a scene makes. One without a part that the scene wants counts as failed. */
static sp_status choose(const sp_scene *scene, int64_t n, const sp_sample *all, choice *out, sp_error *err) {
    int64_t count = sp_study_count(scene);
    choice c = {.sample = sp_alloc((size_t)(count < n ? count : n), sizeof *c.sample)};
    if (!c.sample)
        return sp_fail_memory(err, (size_t)n * sizeof *c.sample);
    sp_status status = SP_OK;
    for (int64_t k = 0; k < count && status == SP_OK; k++) {
        sp_scene one;
        char name[SP_NAME_MAX];
        status = sp_study_scene(scene, k, &one, err);
        if (status != SP_OK)
            break;
        sp_sample_name(&one, name);
        if (name[0] == '\0')
            status = sp_fail_memory(err, 4096);
        const sp_sample *found = bsearch(name, all, (size_t)n, sizeof *all, find_name);
        if (!found || c.n == n) {
            c.missing++;
            continue;
        }
        sp_sample *s = &c.sample[c.n++];
        *s = *found;
        const unsigned parts = sp_sample_parts(&one, s);
        if (!s->failed && sp_want_parts(scene->want) & ~parts) {
            s->failed = true;
            if (!(s->lacks && s->reason[0]))
                snprintf(s->reason, sizeof s->reason, "it lacks a part that is wanted: not made yet");
        }
        if (one.planes > 0) /* those of another scene are not asked for */
            s->have &= parts | ~(unsigned)SP_WANT_PLANES;
        if (scene->want & SP_WANT_SIGNAL)
            s->have &= parts | ~(unsigned)SP_WANT_SIGNAL;
    }
    if (status == SP_OK)
        *out = c;
    else
        sp_free(c.sample);
    return status;
}

/* ---- the filter ------------------------------------------------------------------------------------------------- */

cli_bins cli_bins_default(void) { return (cli_bins){.bins = 100}; }

cli_filter cli_filter_none(void) { return (cli_filter){.width = NAN, .pressure = NAN, .friction = NAN}; }

/* Numbers are given with a few digits: 1e-6 of the value is rounding. */
static bool is_near(double asked, double value) { return isnan(asked) || fabs(asked - value) <= 1e-6 * fabs(asked); }

static bool passes(const cli_filter *f, const sp_sample *s) {
    return is_near(f->width, s->width) && is_near(f->pressure, s->pressure) && is_near(f->friction, s->friction) &&
           (f->grains == 0 || f->grains == s->grains);
}

static bool is_filter(const cli_filter *f) {
    return f->grains != 0 || !isnan(f->width) || !isnan(f->pressure) || !isnan(f->friction);
}

/* Moves the samples that pass to the front; the others do not count. */
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

/* ---- writing ---------------------------------------------------------------------------------------------------- */

/* SP_EREFUSED if the store has no sample, or none of the scene. */
static sp_status check_samples(const sp_scene *scene, int64_t n, const sp_sample *all, sp_error *err) {
    if (n == 0)
        return sp_fail(err, SP_EREFUSED, "no table: there is no sample in the store");
    if (!scene)
        return SP_OK;
    choice chosen = {0};
    sp_status status = choose(scene, n, all, &chosen, err);
    if (status == SP_OK && chosen.n == 0)
        status = sp_fail(err, SP_EREFUSED,
                         "no table: none of the %lld samples of the scene is among the %lld in the store: must be the "
                         "scene (and --set) that made them, see `sonopack table ensemble'",
                         (long long)chosen.missing, (long long)n);
    sp_free(chosen.sample);
    return status;
}

/* Samples of the scene that the filter leaves out are not missing. */
static sp_status add_missing(const cli_tables *tables, int64_t missing, sp_table *t, sp_error *err) {
    if (missing == 0 || is_filter(&tables->filter))
        return SP_OK;
    return sp_table_add_comment(t, err, "missing = %lld samples of the scene that are not in the store yet",
                                (long long)missing);
}

void cli_parse_interval(double *level, const char *arg, struct argp_state *state) {
    sp_error err = {0};
    if (cli_number("--interval", arg, SP_LEVEL_LEAST, SP_LEVEL_MOST, level, &err) != SP_OK)
        argp_error(state, "%s", err.text);
}

/* All samples of the store that pass the filter, sorted by name. */
typedef struct stored {
    sp_store *store;
    int64_t n;
    sp_sample *sample;
} stored;

static sp_status make_table(const cli_tables *tables, const char *name, const stored *all, const choice *of,
                            sp_table *out, sp_error *err) {
    const sp_table_options options = {.level = tables->level};
    if (strcmp(name, "signal") == 0)
        return cli_table_signal(all->store, of->n, of->sample, &options, out, err);
    if (strcmp(name, "spectrum") == 0)
        return cli_table_spectrum(all->store, of->n, of->sample, &options, &tables->bins, out, err);
    return sp_study_table(name, of->n, of->sample, &options, out, err);
}

/* *written: how many of table k there are so far. */
static sp_status write_case(const cli_tables *tables, int k, int64_t c, const stored *all, int64_t *written,
                            sp_error *err) {
    const char *name = tables->name[k];
    sp_scene one = {0};
    choice chosen = {0};
    sp_status status = SP_OK;
    if (tables->scene) {
        status = case_scene(name, tables->scene, c, &one, err);
        if (status == SP_OK)
            status = choose(&one, all->n, all->sample, &chosen, err);
    } else {
        chosen = (choice){.n = all->n, .sample = all->sample};
    }
    sp_table t = sp_table_none();
    if (status == SP_OK && chosen.n == 0 && tables->scene && is_filter(&tables->filter))
        goto out; /* another case is what it chooses */
    if (status == SP_OK)
        status = make_table(tables, name, all, &chosen, &t, err);
    if (status == SP_OK && tables->scene)
        status = add_case(&t, name, tables->scene, c, err);
    if (status == SP_OK)
        status = add_missing(tables, chosen.missing, &t, err);
    if (status == SP_OK)
        status = write_table(tables, k, (*written)++, &t, err);
out:
    sp_table_free(&t);
    if (tables->scene)
        sp_free(chosen.sample);
    return status;
}

/* Case by case, all tables of a case together. */
static sp_status write_all(const cli_tables *tables, const stored *all, sp_error *err) {
    int64_t most = 1, written[CLI_TABLES] = {0};
    for (int k = 0; k < tables->count; k++) {
        const int64_t cases = cases_of(tables->name[k], tables->scene);
        most = cases > most ? cases : most;
    }
    sp_status status = SP_OK;
    for (int64_t c = 0; c < most; c++)
        for (int k = 0; k < tables->count && status == SP_OK; k++)
            if (c < cases_of(tables->name[k], tables->scene))
                status = write_case(tables, k, c, all, &written[k], err);
    return status;
}

sp_status cli_tables_write(const cli_tables *tables, sp_store *store, sp_error *err) {
    sp_sample *all = NULL;
    int64_t n = 0, bad = 0;
    sp_error reason = {0};
    sp_status status = sp_store_samples(store, &n, &all, &bad, &reason);
    if (status != SP_OK) {
        *err = reason;
        return status;
    }
    if (n == 0 && !tables->needs_samples)
        cli_note(tables->common, "there is no sample in the store");
    if (bad > 0)
        cli_note(tables->common, "%lld files of the store are left out: %s", (long long)bad, reason.text);
    const int64_t found = n;
    n = filter(&tables->filter, n, all);
    if (found > 0 && n == 0)
        status = sp_fail(err, SP_EREFUSED,
                         "no table: none of the %lld samples in the store has the width, grains, pressure and friction "
                         "asked for: see `sonopack table ensemble'",
                         (long long)found);
    if (n > 0)
        qsort(all, (size_t)n, sizeof *all, by_names);
    if (status == SP_OK && tables->needs_samples)
        status = check_samples(tables->scene, n, all, err);
    if (status == SP_OK)
        status = write_all(tables, &(stored){store, n, all}, err);
    sp_free(all);
    return status;
}
