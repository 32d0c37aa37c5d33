#ifndef SP_CLI_RANKS_H
#define SP_CLI_RANKS_H
/* The processes that compute one study together: the ranks of an MPI job (ranks_mpi.c, -DSONOPACK_MPI=ON), or only this
 * process (ranks_single.c). Rank 0 distributes the samples, shows the progress of all ranks, and alone prints. */

#include "cli/cli.h"

typedef struct cli_ranks {
    int rank, size;
    bool mpi;                    /* this build has it */
    int64_t (*take)(void *user); /* for sp_study_options: the next sample; NULL: a single process */
} cli_ranks;

/* Joins the other ranks, if a launcher has started this process. Call it once, before the command line is read: however
 * the process ends from here on, all ranks end together. */
sp_status cli_ranks_start(cli_ranks *out, sp_error *err);
/* SP_EINVAL if a launcher has started several processes that are no MPI job, and --shard does not divide the work: each
 * of them would print all tables. */
sp_status cli_ranks_check(const cli_ranks *group, int shards, sp_error *err);
/* Sets what this rank computes, as text. Rank 0 gives samples only to ranks with the same text. Call before the run. */
void cli_ranks_begin(const char *what);
/* Call from the watch of the run: reports this rank's progress and whether it stops. On rank 0 *progress becomes that
 * of all ranks. Returns false if some rank has stopped or failed. */
bool cli_ranks_share(sp_study_progress *progress, bool stopped);
/* Call after the run, or after a failure before it. Rank 0 waits for the others, and calls the watch meanwhile;
 * *progress, this rank's, becomes that of all. Returns SP_OK only if all ranks succeeded; on other ranks, `status`. */
sp_status cli_ranks_join(sp_status status, sp_study_watch watch, void *user, sp_study_progress *progress,
                         sp_error *err);
/* Waits until rank 0 calls this as well. Returns the exit status of rank 0. */
int cli_ranks_end(int exit_status);

/* What the environment says of the launcher: mpirun, srun, ... */
typedef struct cli_launch {
    bool mpi;      /* MPI can be started */
    int processes; /* number of processes; 0: unknown, or no launcher */
    const char *variable;
} cli_launch;
cli_launch cli_launch_of_environment(void);

#endif
