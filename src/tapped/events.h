#ifndef SP_TAPPED_EVENTS_H
#define SP_TAPPED_EVENTS_H
/* A run of the lattice from tap to tap by events. */

#include "tapped/lattice.h"

typedef struct sp_event_run {
    sp_lattice l;
    sp_tapped_report *report; /* with one entry for each tap, or own_report with a single one that is reused */
    sp_tapped_report own_report;
    sp_tapped_tap own_tap;
    sp_tapped_tap *tap;
    double begin, until; /* start of the tap; end of the present phase, relative to it */
    bool last;
    double interval;            /* running mean of the time between events, which limits the step */
    int64_t simultaneous;       /* events at the present time */
    const sp_tapped_rows *rows; /* NULL: none */
    int64_t next;               /* row */
    double *y, *v;
} sp_event_run;

/* report: NULL if only the latest tap matters. The run must not be copied or moved. Free it after a failure, too. */
sp_status sp_event_run_make(const sp_tapped_spec *c, int tangents, sp_tapped_report *report, sp_event_run *out,
                            sp_error *err);
void sp_event_run_free(sp_event_run *r);
/* Advances the state by one period. */
sp_status sp_event_run_tap(sp_event_run *r, int32_t tap, sp_error *err);

#endif
