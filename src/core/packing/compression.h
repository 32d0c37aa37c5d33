#ifndef SP_COMPRESSION_H
#define SP_COMPRESSION_H
/* One compression, from its start (start.c) to the packing: the protocol (piston.c), what presses (drive.c), its state
 * as bytes (state.c) and its end (freeze.c). */
#include "packing/dynamics.h"

/* Forces every so many steps: inspected; sides' rates chosen; at rest for so long: done. Every so many: the lists are
 * made anew, at the cost of some ten steps, and the state may be saved. In so many the residual of grains that come to
 * rest at all has halved. */
enum { CHECK_STEPS = 40, SIDE_STEPS = 10, REST_STEPS = 200, STATE_STEPS = 4000, STALL_STEPS = 20000 };

typedef enum run_phase { PHASE_FLIGHT = 0, PHASE_COMPACTION, PHASE_EQUILIBRATION } run_phase;

/* All that changes from step to step, here and in dynamics, is part of the state: state.c. */
typedef struct piston_run {
    const sp_pack_spec *whole; /* the spec of the making */
    sp_pack_spec now;          /* the same with pressure and tolerance of the stage under way */
    const sp_pack_spec *spec;  /* &now */
    dynamics d;
    double r_min;
    int32_t *id; /* [n] the grain's number in the packing */
    double start_height, start_side[2];
    double side_end[2]; /* periods to be reached before the pressure alone decides; 0: none */
    int32_t sides_free; /* isotropic: the grains have been calm under the piston, the sides move */
    double ramp_time;   /* in which the pressure changes by a factor e, from stage to stage */
    double past;        /* last step */
    int64_t steps, max_steps;
    int32_t stage;   /* of history_count + 1 */
    int rest_checks; /* checks in a row that found equilibrium */
    run_phase phase;
    double residual, wall_imbalance, side_imbalance;
    double full_drag, ease, stall_residual; /* equilibration: the drag, its last share, the residual at stall_step */
    int64_t stall_step;
    double first_acceleration, first_residual; /* of the phase under way; 0: not yet known */
    double fraction;                           /* of the work, as told last */
    bool resumed;                              /* the state of the step under way need not be saved */
    const sp_pack_hooks *hooks;
} piston_run;

/* The grains where they start, or where hooks->state has them. *run has spec and hooks; sp_compression_free frees it in
 * every case. */
sp_status sp_compression_start(piston_run *run, sp_error *err);
void sp_compression_free(piston_run *run);
/* A making's first time step, unless the packing says more. */
double sp_compression_first_step(const piston_run *run);
/* Room for the grains of `spec` at x with radii r, given in the packing's numbers, and the order in memory. */
sp_status sp_compression_place(piston_run *run, const sp_pack_spec *spec, const double *r, const double *x,
                               double height, sp_error *err);

/* Pressure of a stage. */
double sp_compression_stage_pressure(const sp_pack_spec *spec, int32_t stage);
/* Sets `now` for run->stage. */
void sp_compression_set_stage(piston_run *run);
/* Called before each step of length dt: the pressure on its way to the stage's, and the motion of the sides. */
void sp_compression_drive(piston_run *run, double dt);
/* The pressure is the stage's, and the sides have come where they start from. */
bool sp_compression_pressed(const piston_run *run);
/* And the sides press with nearly the same. */
bool sp_compression_driven(const piston_run *run);

sp_status sp_state_save(piston_run *run, sp_error *err);
/* Fills *run, which has spec and hooks and nothing else, from hooks->state. */
sp_status sp_state_load(piston_run *run, sp_error *err);

/* The packing out of the final state. */
sp_status sp_compression_freeze(const piston_run *run, sp_packing *out, sp_error *err);

#endif
