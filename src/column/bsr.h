#ifndef SP_COLUMN_BSR_H
#define SP_COLUMN_BSR_H
/* What the two BSR models share: rows with densities, and the times that no step may cross. */

#include "column/column.h"

/* As sp_column_row, with the density rho [N] at the particles [g/cm]. */
typedef sp_status (*sp_column_bsr_row)(double t, const double *y, const double *v, const double *rho, void *user,
                                       sp_error *err);
typedef struct sp_column_sink {
    int64_t n, next; /* times, and the first that is still to come */
    const double *t;
    sp_column_bsr_row row;
    void *user;
} sp_column_sink;

sp_status sp_column_conservative(const sp_column_spec *c, sp_column_sink *sink, sp_column_report *report,
                                 sp_error *err);
sp_status sp_column_literal(const sp_column_spec *c, sp_column_sink *sink, sp_column_report *report, sp_error *err);

/* Positions, velocities [N + 1], the floor first, and densities [N] at the start and the end of a step. */
typedef struct sp_column_frame {
    double t;
    double *y, *v, *rho;
} sp_column_frame;
sp_status sp_column_frames_make(const sp_column_spec *c, sp_column_frame frame[2], sp_error *err);
void sp_column_frames_free(sp_column_frame frame[2]);
/* Hands over the rows in frame[0].t .. frame[1].t, interpolated between the two; and notes
 * separations and violations at frame[1] in the report. */
sp_status sp_column_frames_pass(const sp_column_spec *c, sp_column_frame frame[2], sp_column_sink *sink,
                                sp_column_report *report, sp_error *err);

/* Equal particles, which (43)-(48) take for granted, or SP_EINVAL. */
sp_status sp_column_check_equal(const sp_column_spec *c, sp_error *err);
/* SP_EINVAL for a column.time_step above the stable one. */
sp_status sp_column_check_step(const sp_column_spec *c, double bound, sp_error *err);

/* The times at which the floor's velocity jumps, in their order: k T and k T + pi/omega. */
typedef struct sp_column_clock {
    int32_t tap;
    bool half; /* the half sine of this tap is over */
} sp_column_clock;
static inline double sp_column_clock_next(const sp_column_spec *c, const sp_column_clock *k) {
    double end = (k->tap + 1) * c->period;
    return k->half ? end : fmin(end, k->tap * c->period + 0.5 / c->frequency);
}
static inline void sp_column_clock_pass(const sp_column_spec *c, sp_column_clock *k) {
    bool over = sp_column_clock_next(c, k) >= (k->tap + 1) * c->period;
    *k = (sp_column_clock){.tap = k->tap + over, .half = !over};
}

#endif
