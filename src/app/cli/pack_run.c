/* Runs LAMMPS, and says why it failed. */
#include "cli/pack_run.h"
#include "base/base.h"
#include "cli/child.h"
#include "foreign/engine.h"

#include <stdio.h>
#include <string.h>

enum { TESTED = 20210929 }; /* the release that the input script was written for */

static const char needed[] = "pair_style granular of LAMMPS of 29 Sep 2021 or later, with its package GRANULAR";

/* Whether LAMMPS does not know what the script asks of it. */
static bool is_lacking(const sp_engine_log *log) {
    static const char *const signs[] = {"granular", "Unknown", "Unrecognized", "Illegal", "Invalid"};
    const int date = sp_engine_date(log->version);
    for (size_t k = 0; k < sizeof signs / sizeof *signs; k++)
        if (strstr(log->fault, signs[k]))
            return true;
    return date > 0 && date < TESTED;
}

static sp_status fail(const char *program, const char *folder, const sp_child_end *end, sp_error *err) {
    sp_engine_log log;
    char how[100];
    sp_engine_read_log(folder, &log);
    if (end->signal)
        snprintf(how, sizeof how, "was killed by signal %d (%s)", end->signal, strsignal(end->signal));
    else
        snprintf(how, sizeof how, "ended with status %d", end->status);
    sp_fail(err, SP_EFAILED, "%s %s after %lld steps: %s%s", program, how, (long long)(log.steps < 0 ? 0 : log.steps),
            log.fault[0] ? log.fault : "it gives no reason, see ",
            log.fault[0] ? "" : sp_engine_names[SP_ENGINE_WORDS]);
    if (!is_lacking(&log))
        return SP_EFAILED;
    sp_error reason = *err;
    return sp_fail(err, SP_EFAILED, "%s; this is LAMMPS %s, and what is needed is %s", reason.text,
                   log.version[0] ? log.version : "of an unknown version", needed);
}

static bool look(void *user) {
    const sp_engine_run *run = user;
    sp_engine_log log;
    if (!run->watch)
        return true;
    sp_engine_read_log(run->folder, &log);
    const sp_pack_progress progress = {
        .phase = "LAMMPS", .steps = log.steps < 0 ? 0 : log.steps, .height = log.height, .residual = log.acceleration};
    return run->watch(&progress, run->user);
}

/* Removes what an earlier run has left, which could be taken for the result of this one. */
static sp_status forget(const char *folder, sp_error *err) {
    char path[SP_PATH_MAX];
    sp_status status = SP_OK;
    for (int k = SP_ENGINE_WORDS; k < SP_ENGINE_FILES && status == SP_OK; k++) {
        status = sp_engine_path(folder, (sp_engine_file)k, path, err);
        if (status == SP_OK)
            remove(path);
    }
    return status;
}

sp_status sp_engine_find(const sp_engine_run *run, char lammps[SP_PATH_MAX], char launcher[SP_PATH_MAX],
                         sp_error *err) {
    if (sp_child_find(run->program ? run->program : "lmp", lammps, err) != SP_OK)
        return sp_fail_prefix(err, "LAMMPS (Debian: apt install lammps; another program: --lammps PATH)");
    if (run->ranks > 1 && sp_child_find("mpirun", launcher, err) != SP_OK)
        return sp_fail_prefix(err, "--ranks %d", run->ranks);
    return SP_OK;
}

sp_status sp_engine_execute(const sp_engine_run *run, double *seconds, sp_error *err) {
    char lammps[SP_PATH_MAX], launcher[SP_PATH_MAX], ranks[16];
    sp_child_end end;
    sp_status status = sp_engine_find(run, lammps, launcher, err);
    if (status != SP_OK)
        return status;
    snprintf(ranks, sizeof ranks, "%d", run->ranks);
    const char *const words[] = {launcher,
                                 "-n",
                                 ranks,
                                 lammps,
                                 "-nocite",
                                 "-in",
                                 sp_engine_names[SP_ENGINE_INPUT],
                                 "-log",
                                 sp_engine_names[SP_ENGINE_LOG],
                                 NULL};
    sp_engine_run watched = *run;
    status = forget(run->folder, err);
    if (status == SP_OK)
        status = sp_child_run(run->ranks > 1 ? words : words + 3, run->folder, sp_engine_names[SP_ENGINE_WORDS], look,
                              &watched, &end, err);
    if (status != SP_OK)
        return status;
    *seconds = end.seconds;
    if (end.stopped)
        return sp_fail(err, SP_EINTERRUPTED, "stopped while LAMMPS was running");
    return end.status == 0 ? SP_OK : fail(lammps, run->folder, &end, err);
}
