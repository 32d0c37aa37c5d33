#ifndef SP_COLUMN_COLUMN_H
#define SP_COLUMN_COLUMN_H
/* What the models of the column share. */

#include <math.h>
#include <sonopack/column.h>

static const double sp_column_pi = 3.14159265358979323846;

/* One model: as sp_column_run. report is never NULL, its taps are there, zeroed but for rest and at (NAN) and
 * separation (INFINITY); t is ascending, within the taps. */
typedef sp_status sp_column_solver(const sp_column_spec *c, int64_t n, const double *t, sp_column_row row, void *user,
                                   sp_column_report *report, sp_error *err);
sp_column_solver sp_column_run_events, sp_column_run_smooth, sp_column_run_rk4, sp_column_run_longwave,
    sp_column_run_conservative, sp_column_run_literal;
/* (35) and (37): SP_EREFUSED, with the symbol in the text. */
sp_column_solver sp_column_refuse_printed;

/* Whether a run may go on after so many steps: SP_EINTERRUPTED if it is stopped, SP_EFAILED above `most` (0: any). */
sp_status sp_column_go_on(const sp_column_spec *c, int64_t steps, int64_t most, double t, sp_error *err);
/* Most steps of one tap of continua, smooth lattice and RK4: what needs more is refused. */
enum { SP_COLUMN_MOST_STEPS = 10000000 };

/* SP_EINVAL unless times are ascending and within the taps. */
sp_status sp_column_check_times(const sp_column_spec *c, int64_t n, const double *t, sp_error *err);

/* Contact i (0 .. N - 1) has particle i + 1 above it. */
static inline double sp_column_distance(const sp_column_spec *c, int32_t contact) {
    return sp_column_radius(c, contact + 1) + (contact > 0 ? sp_column_radius(c, contact) : 0);
}

/* Diagrams of the lattice by events, which the caller has made sure of: Lyapunov exponents and bifurcations. */
sp_status sp_column_diagram(const sp_column_spec *c, int threads, sp_column_watcher watcher, sp_table *out,
                            sp_error *err);

#endif
