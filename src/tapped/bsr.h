#ifndef SP_TAPPED_BSR_H
#define SP_TAPPED_BSR_H
/* Parts common to the two BSR models: rows with densities, and the time loop. */

#include "tapped/column.h"

/* Row callback as sp_tapped_row, with the densities rho [N] at the particles [g/cm]. */
typedef sp_status (*sp_tapped_bsr_row)(double t, const double *y, const double *v, const double *rho, void *user,
                                       sp_error *err);
typedef struct sp_tapped_bsr_rows {
    int64_t n;
    const double *t;
    sp_tapped_bsr_row row;
    void *user;
} sp_tapped_bsr_rows;

typedef sp_status sp_tapped_bsr_solver(const sp_tapped_spec *c, const sp_tapped_bsr_rows *rows,
                                       sp_tapped_report *report, sp_error *err);
/* The two schemes, and the one that c->bsr asks for. */
sp_tapped_bsr_solver sp_tapped_conservative, sp_tapped_literal, sp_tapped_run_bsr_rows;

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
                                  const sp_tapped_bsr_rows *rows, sp_tapped_report *report, sp_error *err);

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
