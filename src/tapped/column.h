#ifndef SP_TAPPED_COLUMN_H
#define SP_TAPPED_COLUMN_H
/* Declarations shared by the models of the tapped column. */

#include <math.h>
#include <sonopack/tapped/tapped.h>

/* The rows that the caller of a run asks for: n ascending times t. rho [N]: densities at the particles [g/cm], of BSR;
 * NULL of the other models. */
typedef struct sp_tapped_rows {
    int64_t n;
    const double *t;
    sp_status (*row)(double t, const double *y, const double *v, const double *rho, void *user, sp_error *err);
    void *user;
} sp_tapped_rows;

/* The solver of one model. The caller has checked that the times lie within the taps, and has made the report. */
typedef sp_status sp_tapped_solver(const sp_tapped_spec *c, const sp_tapped_rows *rows, sp_tapped_report *report,
                                   sp_error *err);
sp_tapped_solver sp_tapped_run_events, sp_tapped_run_ode, sp_tapped_run_longwave, sp_tapped_run_bsr;
/* Models (35) and (37): returns SP_EREFUSED; the message gives the growth rate of the worst wave. */
sp_tapped_solver sp_tapped_refuse_printed;

/* Called once a step, at time t. Returns SP_EINTERRUPTED if the user has stopped the run, and SP_EFAILED after more
 * than `most` steps (0: no limit). */
sp_status sp_tapped_check_steps(const sp_tapped_spec *c, int64_t steps, int64_t most, double t, sp_error *err);
/* Limit on the steps of one tap, for the continua, the smooth lattice and RK4. */
enum { SP_TAPPED_MOST_STEPS = 10000000 };

/* Distance of the two centres when contact i (0 .. N - 1) just touches; contact i lies below particle i + 1. */
static inline double sp_tapped_distance(const sp_tapped_spec *c, int32_t contact) {
    return sp_tapped_radius(c, contact + 1) + (contact > 0 ? sp_tapped_radius(c, contact) : 0);
}

/* Bifurcation and Lyapunov diagrams. The caller has checked that c asks for the lattice by events. */
sp_status sp_tapped_diagram(const sp_tapped_spec *c, int threads, sp_tapped_watcher watcher, sp_table *out,
                            sp_error *err);

#endif
