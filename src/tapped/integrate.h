#ifndef SP_TAPPED_INTEGRATE_H
#define SP_TAPPED_INTEGRATE_H
/* Time integration for every model with explicit steps. A step never crosses a jump of the floor's velocity. Rows are
 * computed by an extra step from the last state, so that the times asked for do not change the trajectory. Energies and
 * smallest separations go into the report. */

#include "tapped/column.h"

/* Motion of the floor at s seconds after the start of the tap. At the end of a phase it gives the left-hand limits,
 * which (2) and (3) leave open. */
typedef struct sp_tapped_phase {
    double amplitude, omega; /* both 0 while the floor rests */
} sp_tapped_phase;

static inline double sp_tapped_phase_floor(const sp_tapped_phase *p, double s) {
    return p->amplitude * sin(p->omega * s);
}
static inline double sp_tapped_phase_velocity(const sp_tapped_phase *p, double s) {
    return p->amplitude * p->omega * cos(p->omega * s);
}

/* What a model provides. Its state has `size` numbers; the last two are the work of the floor and the dissipated
 * energy. */
typedef struct sp_tapped_stepper {
    void *model;
    int64_t size;
    sp_tapped_phase *phase; /* owned by the model, set by sp_tapped_integrate */
    /* Longest step allowed from this state. */
    double (*max_step)(void *model, double s, const double *state);
    /* One step of length h from s. Returns the error over the tolerance; a step with an error above 1 is repeated.
     * Schemes with fixed steps return 0. */
    double (*step)(void *model, double s, double h, const double *from, double *to);
    /* Adapts the step length to the error of a step of length h; NULL for fixed steps. */
    void (*adapt)(void *model, double h, double error);
    /* Writes y_1 .. y_N to y[1 .. N] and v_1 .. v_N to v[1 .. N]. */
    void (*positions)(void *model, const double *state, double *y, double *v);
    double (*energy)(void *model, double floor, const double *state);
    const char *cause; /* the scene key that makes the steps short, for a message */
} sp_tapped_stepper;

/* Runs all taps from `state`, which is left unchanged. */
sp_status sp_tapped_integrate(const sp_tapped_spec *c, const sp_tapped_stepper *m, const double *state,
                              const sp_tapped_rows *rows, sp_tapped_report *report, sp_error *err);

#endif
