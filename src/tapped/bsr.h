#ifndef SP_TAPPED_BSR_H
#define SP_TAPPED_BSR_H
/* Parts common to the two BSR models: rows with densities, and the times that no step may cross. */

#include "tapped/column.h"

/* Row callback as sp_tapped_row, with the densities rho [N] at the particles [g/cm]. */
typedef sp_status (*sp_tapped_bsr_row)(double t, const double *y, const double *v, const double *rho, void *user,
                                       sp_error *err);
typedef struct sp_tapped_sink {
    int64_t n, next; /* number of times; the next one to write */
    const double *t;
    sp_tapped_bsr_row row;
    void *user;
} sp_tapped_sink;

sp_status sp_tapped_conservative(const sp_tapped_spec *c, sp_tapped_sink *sink, sp_tapped_report *report,
                                 sp_error *err);
sp_status sp_tapped_literal(const sp_tapped_spec *c, sp_tapped_sink *sink, sp_tapped_report *report, sp_error *err);

/* State at one end of a step: positions and velocities [N + 1], the floor first, and densities [N]. */
typedef struct sp_tapped_frame {
    double t;
    double *y, *v, *rho;
} sp_tapped_frame;
sp_status sp_tapped_frames_make(const sp_tapped_spec *c, sp_tapped_frame frame[2], sp_error *err);
void sp_tapped_frames_free(sp_tapped_frame frame[2]);
/* Writes the rows between frame[0].t and frame[1].t by interpolation, and records separations and violations at
 * frame[1]. */
sp_status sp_tapped_frames_pass(const sp_tapped_spec *c, sp_tapped_frame frame[2], sp_tapped_sink *sink,
                                sp_tapped_report *report, sp_error *err);

/* Returns SP_EINVAL unless all particles are equal, as (43)-(48) assume. */
sp_status sp_tapped_check_equal(const sp_tapped_spec *c, sp_error *err);
/* Returns SP_EINVAL if column.time_step is above the stability bound. */
sp_status sp_tapped_check_step(const sp_tapped_spec *c, double bound, sp_error *err);

/* Iterates over the times at which the floor's velocity jumps: k T and k T + pi/omega. */
typedef struct sp_tapped_clock {
    int32_t tap;
    bool half; /* whether the half sine of this tap is over */
} sp_tapped_clock;
static inline double sp_tapped_clock_next(const sp_tapped_spec *c, const sp_tapped_clock *k) {
    double end = (k->tap + 1) * c->period;
    return k->half ? end : fmin(end, k->tap * c->period + 0.5 / c->frequency);
}
static inline void sp_tapped_clock_pass(const sp_tapped_spec *c, sp_tapped_clock *k) {
    bool over = sp_tapped_clock_next(c, k) >= (k->tap + 1) * c->period;
    *k = (sp_tapped_clock){.tap = k->tap + over, .half = !over};
}

#endif
