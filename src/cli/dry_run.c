/* Prints what a command would make: --dry-run. */
#include "base/base.h"
#include "base/file.h"
#include "cli/files.h"

#include <math.h>
#include <sonopack/study/forecast.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const double program = 15e6; /* bytes of a command that does next to nothing */

sp_status cli_plan_begin(const cli_common *common, unsigned kernels, cli_plan *plan, sp_error *err) {
    static const char *const names[SP_KERNELS] = {"step", "product", "dense", "sparse"};
    *plan = (cli_plan){.common = common, .table = sp_table_none()};
    plan->w = (cli_writer){.table = &plan->table, .err = err};
    plan->w.status = sp_machine_measure(kernels, &plan->machine, err);
    cli_comment(&plan->w, "dry run: nothing was made");
    cli_comment(&plan->w, "threads = %d", common->threads);
    for (int k = 0; k < SP_KERNELS; k++)
        if (kernels >> k & 1)
            cli_comment(&plan->w, "machine_%s = %.2f", names[k], plan->machine.slower[k]);
    cli_comment(&plan->w, "machine: time of a kernel on this machine, now, over that on the machine of the laws");
    cli_comment(&plan->w, "accuracy = 2 (factor of cpu_s and wall_s in nine cases of ten; wall_s on free cores)");
    cli_columns(&plan->w, SP_COLUMN_TEXT, "what", "", NULL);
    cli_columns(&plan->w, SP_COLUMN_INTEGER, "count", "", NULL);
    cli_columns(&plan->w, SP_COLUMN_NUMBER, "cpu_s", "s", "wall_s", "s", "memory_MB", "MB", "disk_MB", "MB", NULL);
    return plan->w.status;
}

/* Three digits: more would claim what is not known. */
static double rounded(double value) {
    char text[32];
    snprintf(text, sizeof text, "%.3g", value);
    return strtod(text, NULL);
}

static void add_row(cli_plan *plan, const char *what, int64_t count, sp_cost cost, double bytes) {
    CLI_THEN(plan->w.status,
             sp_table_add_row(&plan->table, plan->w.err, what, count, rounded(cost.cpu), rounded(cost.wall),
                              rounded(1e-6 * (program + cost.memory)), rounded(1e-6 * bytes)));
}

void cli_plan_add(cli_plan *plan, const char *what, int64_t count, sp_cost cost, double bytes) {
    plan->total = sp_cost_add(plan->total, cost);
    plan->bytes += bytes;
    add_row(plan, what, count, cost, bytes);
}

void cli_plan_note(cli_plan *plan, const char *what, int64_t count) {
    const sp_cost none = {.memory = -program};
    add_row(plan, what, count, none, 0);
}

sp_status cli_plan_end(cli_plan *plan) {
    plan->total.wall = fmax(plan->total.wall, plan->longest);
    add_row(plan, "total", 1, plan->total, plan->bytes);
    if (program + plan->total.memory > 0.5 * sp_memory_limit()) /* what is expected is within a factor of 2 */
        cli_comment(&plan->w, "warning: there are %.3g MB of memory, which may be too little",
                    1e-6 * sp_memory_limit());
    CLI_THEN(plan->w.status, cli_write_table_to(plan->common, NULL, &plan->table, plan->w.err));
    return plan->w.status;
}

void cli_plan_free(cli_plan *plan) { sp_table_free(&plan->table); }

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

/* Samples are made side by side, each by one thread. */
static void add_samples(cli_plan *plan, const sp_forecast *f, int jobs) {
    const int64_t missing = f->samples - f->stored - f->failed;
    const double side_by_side = fmax(1, fmin(jobs, (double)missing));
    cli_plan_note(plan, "samples", f->samples);
    cli_plan_note(plan, "samples in the store", f->stored);
    if (f->failed > 0)
        cli_plan_note(plan, "samples recorded as failed", f->failed);
    for (int k = 0; k < SP_FORECAST_PARTS; k++) {
        const sp_forecast_part *part = &f->part[k];
        if (!part->what || part->count == 0)
            continue;
        const sp_cost cost = {part->cost.cpu, part->cost.wall / side_by_side, part->cost.memory * side_by_side};
        cli_plan_add(plan, part->what, part->count, cost, part->bytes);
    }
    if (missing > 0)
        plan->longest = fmax(plan->longest, f->longest);
    if (f->looked > 0 && f->looked < f->samples)
        cli_comment(&plan->w, "samples looked for = %lld; the others are taken to be like them", (long long)f->looked);
}

sp_status cli_plan_study(cli_plan *plan, const sp_scene *study, const sp_study_options *opt, const char *store,
                         sp_error *err) {
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
        add_samples(plan, &f, opt->jobs);
    return status == SP_OK ? plan->w.status : status;
}
