/* Checks the files of a store and prints a table of them. */

#include "base/base.h"
#include "cli/tables.h"
#include "ensemble/sample.h"

#include <math.h>
#include <stdio.h>

typedef struct verification {
    const cli_common *common;
    sp_table table;
    int64_t samples, failed, bad; /* files: good samples, good records of failures, others */
    int64_t expected;             /* samples of the scene; 0: no scene */
    int64_t present, last;        /* how many of them have a file; the number of the last one */
    double begun;
    sp_status status; /* of the table */
    sp_error error;
} verification;

static bool found(const sp_store_finding *f, void *user) {
    verification *v = user;
    char text[120];
    const double seconds = sp_clock_wall() - v->begun, fraction = (double)f->done / (double)f->names;
    const bool sound = f->verdict == SP_SOUND;
    v->present += f->done != v->last;
    v->last = f->done;
    v->samples += sound && !f->record;
    v->failed += sound && f->record;
    v->bad += !sound;
    if (!sound) {
        sp_error fault = {0};
        cli_progress_end();
        sp_fail(&fault, SP_EFAILED, "%s: %s%s", f->file, f->reason,
                f->aside                   ? "; renamed to .bad"
                : f->verdict == SP_DAMAGED ? "; it could not be renamed"
                                           : "");
        cli_fail(&fault);
    }
    char reason[SP_ERROR_TEXT + 16];
    snprintf(reason, sizeof reason, "%s%s", sound && f->record ? "failed: " : "", *f->reason ? f->reason : "-");
    v->status =
        sp_table_add_row(&v->table, &v->error, f->file, sound ? "yes" : "no", reason, *f->field ? f->field : "-");
    snprintf(text, sizeof text, "%lld/%lld samples checked", (long long)f->done, (long long)f->names);
    cli_progress(v->common, text, fraction, seconds * (1 / fraction - 1));
    return v->status == SP_OK && !cli_stopped();
}

static sp_status scene_names(const sp_scene *scene, sp_store_check *check, char (**out)[SP_NAME_MAX], sp_error *err) {
    const int64_t count = sp_study_count(scene);
    if (count < 1)
        return sp_fail(err, SP_EINVAL, "study.sweep: no values, or more than 2^63 samples");
    char(*name)[SP_NAME_MAX] = sp_alloc((size_t)count, sizeof *name);
    if (!name)
        return sp_fail_memory(err, (size_t)count * sizeof *name);
    *out = name;
    for (int64_t k = 0; k < count; k++) {
        sp_scene one;
        sp_status status = sp_study_sample(scene, k, &one, name[k], err);
        if (status != SP_OK)
            return status;
    }
    check->names = count;
    check->name = (const char(*)[SP_NAME_MAX])name;
    return SP_OK;
}

static sp_status verify(verification *v, sp_store *store, const sp_scene *scene, double tolerance, int jobs,
                        sp_error *err) {
    sp_store_check check = {.names = -1, .tolerance = tolerance, .jobs = jobs, .found = found, .user = v};
    char(*name)[SP_NAME_MAX] = NULL;
    cli_writer w = {.table = &v->table, .err = err};
    cli_columns(&w, SP_COLUMN_TEXT, "file", "", "ok", "", "reason", "", "field", "", NULL);
    sp_status status = w.status;
    if (status == SP_OK && scene)
        status = scene_names(scene, &check, &name, err);
    if (status == SP_OK && scene)
        v->expected = check.names;
    CLI_THEN(status, sp_store_verify(store, &check, err));
    if (v->status != SP_OK) {
        status = v->status;
        *err = v->error;
    }
    sp_free(name);
    return status;
}

sp_status cli_verify(const cli_common *common, const char *dir, const sp_scene *scene, double tolerance, int jobs,
                     bool *good, sp_error *err) {
    verification v = {.common = common, .table = sp_table_none(), .begun = sp_clock_wall()};
    sp_store *store = NULL;
    sp_status status = cli_may_write_table(common, err);
    CLI_THEN(status, sp_store_open(dir, false, &store, err));
    if (status == SP_OK) {
        cli_catch_signals(common);
        status = verify(&v, store, scene, tolerance, jobs, err);
        cli_progress_end();
    }
    CLI_THEN(status, cli_write_table(common, &v.table, err));
    if (status == SP_OK)
        cli_note(common, "%lld samples are sound, %lld are recorded as failed, %lld files are not ok",
                 (long long)v.samples, (long long)v.failed, (long long)v.bad);
    if (status == SP_OK && v.expected > v.present)
        cli_note(common, "%lld of the %lld samples of the scene are not in the store",
                 (long long)(v.expected - v.present), (long long)v.expected);
    *good = v.bad == 0;
    if (store)
        sp_store_close(store);
    sp_table_free(&v.table);
    return status;
}
