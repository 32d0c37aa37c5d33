#ifndef SP_TAPPED_EVENTS_H
#define SP_TAPPED_EVENTS_H
/* A run of the lattice from tap to tap by events. */

#include "tapped/lattice.h"

typedef struct sp_run {
    sp_lattice l;
    sp_tapped_report *report; /* with one entry a tap, or with a single one that is reused */
    sp_tapped_tap *tap;
    double begin, until; /* start of the tap; end of the present phase, relative to it */
    bool last;
    double interval; /* running mean of the time between events, which limits the step */
    int64_t still;   /* events at the present time */
    int64_t rows, next;
    const double *time;
    sp_tapped_row row;
    void *user;
    double *y, *v;
} sp_run;

/* Free it after a failure, too. */
sp_status sp_run_make(const sp_tapped_spec *c, int tangents, sp_tapped_report *report, sp_run *out, sp_error *err);
void sp_run_free(sp_run *r);
/* Advances the state by one period. */
sp_status sp_run_tap(sp_run *r, int32_t tap, sp_error *err);

#endif
