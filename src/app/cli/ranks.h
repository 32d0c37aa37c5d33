#ifndef SP_CLI_RANKS_H
#define SP_CLI_RANKS_H
/* The processes that make one study together: the ranks of an MPI job (ranks_mpi.c, -DSONOPACK_MPI=ON), or this process
 * alone (ranks_single.c). Rank 0 hands out the numbers of the samples, shows the progress of all, and is the only one
 * that prints. */

#include "cli/cli.h"

typedef struct cli_ranks {
    int rank, size;
    int64_t (*take)(void *user); /* for sp_study_options; NULL: this process counts for itself */
} cli_ranks;

/* Where a launcher has started this process, meets the others. Call once, before the command line is read: whatever way
 * the process ends from here on, all ranks end together. */
sp_status cli_ranks_start(cli_ranks *out, sp_error *err);
/* SP_EINVAL where a launcher has started several processes that do not know each other, and that were not told to share
 * the work by --shard either: they would share the samples by their store, but each would print all tables. */
sp_status cli_ranks_check(const cli_ranks *group, int shards, sp_error *err);
/* What is to be made, in words: numbers are handed out only to ranks that say the same as rank 0. Call before the run.
 */
void cli_ranks_begin(const char *what);
/* Call from the watch of the run: tells this rank's numbers and whether it is to stop. On rank 0 *progress is then that
 * of all ranks. False: some rank has stopped, or failed. */
bool cli_ranks_share(sp_study_progress *progress, bool stopped);
/* After the run, or what failed before it. Rank 0 waits for the others, calling the watch; *progress, this rank's, is
 * then that of all, and the status is SP_OK only where each rank's is. On other ranks: the status that is given. */
sp_status cli_ranks_join(sp_status status, sp_study_watch watch, void *user, sp_study_progress *progress,
                         sp_error *err);
/* Waits until rank 0 is here as well. The exit status of all ranks is rank 0's. */
int cli_ranks_end(int exit_status);

/* What the environment says of the launcher: mpirun, srun, ... */
typedef struct cli_launch {
    bool mpi;      /* MPI can start from it */
    int processes; /* that it has started; 0: not known, or no launcher */
    const char *variable;
} cli_launch;
cli_launch cli_launch_look(void);

#endif
