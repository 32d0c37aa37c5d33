#ifndef SP_TAPPED_BSR_H
#define SP_TAPPED_BSR_H
/* Parts common to the two BSR models: the time loop. */

#include "tapped/column.h"

/* The two schemes. */
sp_tapped_solver sp_tapped_conservative, sp_tapped_literal;

/* State at one end of a step: positions and velocities [N + 1], the floor first, and densities [N]. */
typedef struct sp_tapped_frame {
    double t;
    double *y, *v, *rho;
} sp_tapped_frame;

typedef struct sp_tapped_bsr_scheme {
    void *model;
    /* Writes the initial state, except that of the floor. */
    void (*start)(void *model, sp_tapped_frame *at);
    /* Takes one step, at most to `until`, and writes the new state. */
    sp_status (*step)(void *model, double until, const sp_tapped_frame *from, sp_tapped_frame *to, sp_error *err);
} sp_tapped_bsr_scheme;
/* Integrates over all taps. Steps end at the jumps of the floor's velocity. Rows are interpolated; separations and
 * violations go into the report. */
sp_status sp_tapped_bsr_integrate(const sp_tapped_spec *c, const sp_tapped_bsr_scheme *scheme,
                                  const sp_tapped_rows *rows, sp_tapped_report *report, sp_error *err);

/* Shortens a step dt from t so that its end, *end, does not exceed `until`. Returns SP_EFAILED if dt is lost in the
 * rounding of t. */
sp_status sp_tapped_bsr_limit_step(double t, double until, double *dt, double *end, sp_error *err);
/* Returns SP_EFAILED if the sum of the solution's values at t is not finite. */
sp_status sp_tapped_bsr_check_finite(double sum, double t, sp_error *err);
/* Returns SP_EINVAL unless all particles are equal, as (43)-(48) assume. */
sp_status sp_tapped_check_equal(const sp_tapped_spec *c, sp_error *err);
/* Returns SP_EINVAL if column.time_step is above the stability bound. */
sp_status sp_tapped_check_time_step(const sp_tapped_spec *c, double bound, sp_error *err);

#endif
