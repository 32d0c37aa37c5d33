#ifndef SP_COMPRESSION_H
#define SP_COMPRESSION_H
/* State and functions of one compression run: start (start.c), protocol and resulting packing (piston.c), loading
 * (drive.c), saved state (state.c). */
#include "packing/dynamics.h"

#include <math.h>

/* Intervals in steps. CHECK: the forces are inspected. LATERAL: the lateral strain rates are updated. REST: equilibrium
 * must last this long. STATE: the neighbour lists are rebuilt, at the cost of about ten steps, and the state may be
 * saved. STALL: the residual of a packing that will come to rest halves at least once in this interval; LONG_STALL: the
 * same in the long steps of dashpots that lag. */
enum {
    CHECK_STEPS = 40,
    LATERAL_STEPS = 10,
    REST_STEPS = 200,
    STATE_STEPS = 4000,
    STALL_STEPS = 20000,
    LONG_STALL_STEPS = 6000
};

typedef enum compression_phase { PHASE_FLIGHT = 0, PHASE_COMPACTION, PHASE_EQUILIBRATION } compression_phase;

/* State of a run. Everything here and in dynamics that changes from step to step is saved by state.c. */
typedef struct compression {
    const sp_pack_spec *whole; /* the spec of the run, with the final pressure */
    sp_pack_spec now;          /* the same with the pressure and tolerance of the current stage */
    const sp_pack_spec *spec;  /* &now */
    dynamics d;
    double r_min;
    int32_t *id; /* [n] index of each grain in the packing */
    double start_height, start_period[2];
    double period_end[2];   /* periods to reach before the pressure alone controls them; 0: none */
    bool squeezed;          /* affine protocol: the gas is compressed by a homogeneous strain, not by the piston */
    int32_t lateral_free;   /* isotropic: the grains have settled under the piston, and the periods may change */
    double flow, flow_rate; /* without a piston: shear strain of the cell so far, and its present rate */
    double ramp_time;       /* time in which the pressure changes by a factor e between stages */
    double past;            /* length of the last step */
    int64_t steps, max_steps;
    int32_t stage;         /* current stage, 0 .. sp_pack_stages - 1 */
    double strained, goal; /* where the cell is on the path of strain, in multiples of packing.path.strain; and at the
                              end of the stage */
    int rest_checks;       /* consecutive checks that found equilibrium */
    compression_phase phase;
    double residual, wall_imbalance, lateral_imbalance;
    /* during equilibration: full drag, its current reduction, and the residual at stall_step */
    double full_drag, ease, stall_residual;
    int64_t stall_step;
    double first_acceleration, first_residual; /* of the current phase; 0: not known yet */
    double fraction;                           /* of the work, as last reported */
    bool resumed;                              /* just resumed: do not save the same state again */
    const sp_pack_hooks *hooks;
} compression;

/* Starts a run at its initial state or at hooks->state. *run has `whole` and `hooks`. Call sp_compression_free even if
 * this fails. */
sp_status sp_compression_start(compression *run, sp_error *err);
void sp_compression_free(compression *run);

/* Sets the pressure and tolerance of stage run->stage. */
void sp_compression_set_stage(compression *run);
/* Starts the homogeneous compression of the affine protocol, or continues it in a run that was saved meanwhile. */
void sp_compression_squeeze(compression *run);
/* Called before each step of length dt: ends the homogeneous compression at the pressure, moves the pressure towards
 * that of the stage, and sets the lateral strain rates. */
void sp_compression_drive(compression *run, double dt);
/* Whether the pressure is that of the stage, and the periods have reached their required start. */
bool sp_compression_pressed(const compression *run);
/* The same, and the lateral pressure is close to the pressure as well. */
bool sp_compression_driven(const compression *run);

/* Stiffness of a packing against the strain of one edge. Measured: 0.2 .. 0.35 p^(1/3), largest for frictionless
 * grains. */
static inline double compression_stiffness(double pressure, double exponent) {
    return 0.3 * (exponent == 1.5 ? cbrt(pressure) : pow(pressure, 1 - 1 / exponent));
}

sp_status sp_state_save(compression *run, sp_error *err);
/* Restores *run from hooks->state. *run has `whole` and `hooks` only. SP_EFORMAT, SP_ENOMEM. */
sp_status sp_state_load(compression *run, sp_error *err);

/* ---- cells without a piston: the cell shrinks around the gas at a small inertial number, and then follows the
 * difference between the stress in the grains and its target. ---- */

/* Whether the strain is that of the stage. */
bool sp_squeeze_strained(const compression *run);
/* Largest difference between the stress and its target: of the mean normal stress, or of all components that are free.
 */
double sp_squeeze_imbalance(const compression *run);
/* Mean normal stress. */
double sp_squeeze_pressure(const compression *run);
/* Whether the grains carry half of the pressure. */
bool sp_squeeze_carried(const compression *run);
/* SP_EFAILED if the cell flows under its stress without end. */
sp_status sp_squeeze_check(const compression *run, sp_error *err);
/* Fraction of the way from the gas to a packing, by the volume. */
double sp_squeeze_progress(const compression *run);

#endif
