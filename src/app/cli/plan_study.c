/* Plans studies: --dry-run of study. */
#include "cli/plan_study.h"

#include "base/file.h"

#include <math.h>
#include <sonopack/study/forecast.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static bool is_folder(const char *path) {
    struct stat info;
    return stat(path, &info) == 0 && S_ISDIR(info.st_mode);
}

/* Whether the store has the file of a sample, whose results may be incomplete. */
static bool has_file(void *user, const char *name) {
    char path[SP_PATH_MAX];
    const int length = snprintf(path, sizeof path, "%s/%s.h5", (const char *)user, name);
    return length < SP_PATH_MAX && access(path, R_OK) == 0;
}

static void note(cli_plan *plan, const char *prefix, const char *what, int64_t count) {
    char text[120];
    snprintf(text, sizeof text, "%s%s", prefix, what);
    cli_plan_note(plan, text, count);
}

/* Samples are made side by side, each by one thread. */
static void add_rows(cli_plan *plan, const char *prefix, const sp_forecast *f, int jobs) {
    const int64_t missing = f->samples - f->stored - f->failed;
    const double side_by_side = fmax(1, fmin(jobs, (double)missing));
    note(plan, prefix, "samples", f->samples);
    note(plan, prefix, "samples in the store", f->stored);
    if (f->failed > 0)
        note(plan, prefix, "samples recorded as failed", f->failed);
    for (int k = 0; k < SP_FORECAST_PARTS; k++) {
        const sp_forecast_part *part = &f->part[k];
        char what[120];
        if (!part->what || part->count == 0)
            continue;
        snprintf(what, sizeof what, "%s%s", prefix, part->what);
        const sp_cost cost = {part->cost.cpu, part->cost.wall / side_by_side, part->cost.memory * side_by_side};
        cli_plan_add(plan, what, part->count, cost, part->bytes);
    }
    if (missing > 0)
        plan->longest = fmax(plan->longest, f->longest);
    if (f->looked > 0 && f->looked < f->samples)
        cli_comment(&plan->w, "%ssamples looked for = %lld; the others are taken to be like them", prefix,
                    (long long)f->looked);
}

sp_status cli_plan_study(cli_plan *plan, const char *prefix, const sp_scene *study, const sp_study_options *opt,
                         const char *store, sp_error *err) {
    sp_store *open = NULL;
    sp_study_sink sink;
    sp_forecast f;
    sp_status status = is_folder(store) ? sp_store_open(store, false, &open, err) : SP_OK;
    if (status != SP_OK)
        return status;
    if (open)
        sink = sp_store_sink(open);
    status = sp_study_expect(study, opt, open ? &sink : NULL, has_file, (char *)store, &plan->machine, &f, err);
    if (open)
        sp_store_close(open);
    if (status == SP_OK)
        add_rows(plan, prefix, &f, opt->jobs);
    return status == SP_OK ? plan->w.status : status;
}
