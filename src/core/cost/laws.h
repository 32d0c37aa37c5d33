#ifndef SP_LAWS_H
#define SP_LAWS_H
/* The fitted laws of laws.inc. */

#include <sonopack/cost.h>

typedef enum sp_work {
    SP_WORK_STEP_DISKS = 0,
    SP_WORK_STEP_SPHERES,
    SP_WORK_STEP_SMOOTH_SPHERES,
    SP_WORK_STEP_PLAIN,
    SP_WORK_VIBRATION,
    SP_WORK_FABER,
    SP_WORK_DENSITY,
    SP_WORK_TRANSMISSION,
    SP_WORK_DISPERSION,
    SP_WORK_FREQUENCIES,
    SP_WORK_VECTORS,
    SP_WORK_SOLVES_DISKS,
    SP_WORK_SOLVES_SPHERES,
    SP_WORK_FACTORS_SPHERES,
    SP_WORK_PIECES_DISKS,
    SP_WORK_PIECES_SPHERES,
    SP_WORK_MODULI,
    SP_WORK_MODULI_SPHERES,
    SP_WORK_HARMONIC,
    SP_WORK_HARMONIC_SPHERES,
    SP_WORK_CONTINUUM,
    SP_WORK_NETWORK,
    SP_WORK_STATICS,
    SP_WORK_SAMPLE
} sp_work;

/* Seconds of CPU time of a work of size n, k times. */
double sp_law_seconds(sp_work work, double n, double k, const sp_machine *machine);

#endif
