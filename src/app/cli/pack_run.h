#ifndef SP_CLI_PACK_RUN_H
#define SP_CLI_PACK_RUN_H
/* Runs LAMMPS for pack --engine lammps. */

#include "base/file.h"

#include <sonopack/packing.h>

typedef struct sp_engine_run {
    const char *program; /* NULL: lmp */
    int ranks;           /* more than 1: started by mpirun */
    const char *folder;
    /* Called several times a second with what the log says; returns false to end the run. May be NULL. */
    sp_pack_watch watch;
    void *user;
} sp_engine_run;

/* The absolute paths of LAMMPS and, for several ranks, of mpirun. SP_EIO says which is missing. */
sp_status sp_engine_find(const sp_engine_run *run, char lammps[SP_PATH_MAX], char launcher[SP_PATH_MAX], sp_error *err);
/* Runs LAMMPS on the files of the folder and waits for it; *seconds is the CPU time of all ranks. However this ends, no
 * process is left, and the files are. SP_EFAILED with LAMMPS' own reason, SP_EINTERRUPTED, SP_EIO. */
sp_status sp_engine_execute(const sp_engine_run *run, double *seconds, sp_error *err);

#endif
