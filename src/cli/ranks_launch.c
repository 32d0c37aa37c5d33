/* Finds out from the environment which launcher has started this process, and whether it may work. */
#include "base/base.h"
#include "cli/ranks.h"

#include <stdlib.h>

static int number_of(const char *variable) {
    const char *text = getenv(variable);
    int64_t number;
    return text && cli_integer(variable, text, 1, INT32_MAX, &number, NULL) == SP_OK ? (int)number : 0;
}

cli_launch cli_launch_of_environment(void) {
    /* mpirun of OpenMPI; of MPICH and Intel, and srun --mpi=pmi2; of MVAPICH; srun, last because the others know more
     */
    static const char *const sizes[] = {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "MV2_COMM_WORLD_SIZE",
                                        "SLURM_STEP_NUM_TASKS"};
    static const char *const marks[] = {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMI_RANK", "MV2_COMM_WORLD_SIZE",
                                        "PMIX_RANK"};
    cli_launch launch = {.variable = ""};
    for (size_t k = 0; k < sizeof marks / sizeof *marks; k++)
        launch.mpi = launch.mpi || getenv(marks[k]);
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes && launch.processes == 0; k++) {
        launch.processes = number_of(sizes[k]);
        launch.variable = sizes[k];
    }
    return launch;
}

sp_status cli_ranks_check(const cli_ranks *group, int shards, sp_error *err) {
    const cli_launch launch = cli_launch_of_environment();
    if (launch.processes <= 1 || group->size > 1 || shards > 1)
        return SP_OK;
    return sp_fail(err, SP_EINVAL,
                   "%d processes were started (%s), but %s, so that each would print all tables: %s, or give each its "
                   "--shard I/%d",
                   launch.processes, launch.variable, group->mpi ? "not as one MPI job" : "this build has no MPI",
                   group->mpi ? "start them with mpirun or srun --mpi=pmix" : "build with -DSONOPACK_MPI=ON",
                   launch.processes);
}
