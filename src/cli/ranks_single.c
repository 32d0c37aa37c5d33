/* Runs a study in a single process, for builds without MPI. */
#include "cli/ranks.h"

sp_status cli_ranks_start(cli_ranks *out, sp_error *err) {
    (void)err;
    *out = (cli_ranks){.size = 1};
    return SP_OK;
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
