#ifndef SP_TAPPED_BSR_H
#define SP_TAPPED_BSR_H
/* What the two BSR models share: rows with densities, and the times that no step may cross. */

#include "tapped/column.h"

/* As sp_tapped_row, with the density rho [N] at the particles [g/cm]. */
typedef sp_status (*sp_tapped_bsr_row)(double t, const double *y, const double *v, const double *rho, void *user,
                                       sp_error *err);
typedef struct sp_tapped_sink {
    int64_t n, next; /* times, and the first that is still to come */
    const double *t;
    sp_tapped_bsr_row row;
    void *user;
} sp_tapped_sink;

sp_status sp_tapped_conservative(const sp_tapped_spec *c, sp_tapped_sink *sink, sp_tapped_report *report,
                                 sp_error *err);
sp_status sp_tapped_literal(const sp_tapped_spec *c, sp_tapped_sink *sink, sp_tapped_report *report, sp_error *err);

/* Positions, velocities [N + 1], the floor first, and densities [N] at the start and the end of a step. */
typedef struct sp_tapped_frame {
    double t;
    double *y, *v, *rho;
} sp_tapped_frame;
sp_status sp_tapped_frames_make(const sp_tapped_spec *c, sp_tapped_frame frame[2], sp_error *err);
void sp_tapped_frames_free(sp_tapped_frame frame[2]);
/* Hands over the rows in frame[0].t .. frame[1].t, interpolated between the two; and notes
 * separations and violations at frame[1] in the report. */
sp_status sp_tapped_frames_pass(const sp_tapped_spec *c, sp_tapped_frame frame[2], sp_tapped_sink *sink,
                                sp_tapped_report *report, sp_error *err);

/* Equal particles, which (43)-(48) take for granted, or SP_EINVAL. */
sp_status sp_tapped_check_equal(const sp_tapped_spec *c, sp_error *err);
/* SP_EINVAL for a column.time_step above the stable one. */
sp_status sp_tapped_check_step(const sp_tapped_spec *c, double bound, sp_error *err);

/* The times at which the floor's velocity jumps, in their order: k T and k T + pi/omega. */
typedef struct sp_tapped_clock {
    int32_t tap;
    bool half; /* the half sine of this tap is over */
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
