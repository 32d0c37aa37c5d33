#ifndef SP_TAPPED_COLUMN_H
#define SP_TAPPED_COLUMN_H
/* What the models of the column share. */

#include <math.h>
#include <sonopack/tapped/tapped.h>

static const double sp_tapped_pi = 3.14159265358979323846;

/* One model: as sp_tapped_run. report is never NULL, its taps are there, zeroed but for rest and at (NAN) and
 * separation (INFINITY); t is ascending, within the taps. */
typedef sp_status sp_tapped_solver(const sp_tapped_spec *c, int64_t n, const double *t, sp_tapped_row row, void *user,
                                   sp_tapped_report *report, sp_error *err);
sp_tapped_solver sp_tapped_run_events, sp_tapped_run_smooth, sp_tapped_run_rk4, sp_tapped_run_longwave,
    sp_tapped_run_conservative, sp_tapped_run_literal;
/* (35) and (37): SP_EREFUSED, with the symbol in the text. */
sp_tapped_solver sp_tapped_refuse_printed;

/* Whether a run may go on after so many steps: SP_EINTERRUPTED if it is stopped, SP_EFAILED above `most` (0: any). */
sp_status sp_tapped_go_on(const sp_tapped_spec *c, int64_t steps, int64_t most, double t, sp_error *err);
/* Most steps of one tap of continua, smooth lattice and RK4: what needs more is refused. */
enum { SP_TAPPED_MOST_STEPS = 10000000 };

/* SP_EINVAL unless times are ascending and within the taps. */
sp_status sp_tapped_check_times(const sp_tapped_spec *c, int64_t n, const double *t, sp_error *err);

/* Contact i (0 .. N - 1) has particle i + 1 above it. */
static inline double sp_tapped_distance(const sp_tapped_spec *c, int32_t contact) {
    return sp_tapped_radius(c, contact + 1) + (contact > 0 ? sp_tapped_radius(c, contact) : 0);
}

/* Diagrams of the lattice by events, which the caller has made sure of: Lyapunov exponents and bifurcations. */
sp_status sp_tapped_diagram(const sp_tapped_spec *c, int threads, sp_tapped_watcher watcher, sp_table *out,
                            sp_error *err);

#endif
