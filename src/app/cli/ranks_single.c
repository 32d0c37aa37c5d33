/* Runs a study in a single process, for builds without MPI. */
#include "cli/ranks.h"

#include "base/base.h"

sp_status cli_ranks_start(cli_ranks *out, sp_error *err) {
    (void)err;
    *out = (cli_ranks){.rank = 0, .size = 1};
    return SP_OK;
}

sp_status cli_ranks_check(const cli_ranks *group, int shards, sp_error *err) {
    const cli_launch launch = cli_launch_of_environment();
    if (launch.processes <= group->size || shards > 1)
        return SP_OK;
    return sp_fail(err, SP_EINVAL,
                   "%d processes were started (%s), but this build has no MPI, so that each would print all tables: "
                   "build with -DSONOPACK_MPI=ON, or give each process its --shard I/%d",
                   launch.processes, launch.variable, launch.processes);
}

void cli_ranks_begin(const char *what) { (void)what; }

bool cli_ranks_share(sp_study_progress *progress, bool stopped) {
    (void)progress;
    return !stopped;
}

sp_status cli_ranks_join(sp_status status, sp_study_watch watch, void *user, sp_study_progress *progress,
                         sp_error *err) {
    (void)watch, (void)user, (void)progress, (void)err;
    return status;
}

int cli_ranks_end(int exit_status) { return exit_status; }
