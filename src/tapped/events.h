#ifndef SP_TAPPED_EVENTS_H
#define SP_TAPPED_EVENTS_H
/* A lattice under way: one tap after the other. */

#include "tapped/lattice.h"

typedef struct sp_run {
    sp_lattice l;
    sp_tapped_report *report; /* with as many taps as there are, or with one, that is used again */
    sp_tapped_tap *tap;
    double begin, until; /* start of the tap; end of the present piece, after the start */
    bool last;
    double interval; /* between events, a running mean: steps need not be longer */
    int64_t still;   /* events in this moment */
    int64_t rows, next;
    const double *time;
    sp_tapped_row row;
    void *user;
    double *y, *v;
} sp_run;

/* Free after failure, too. */
sp_status sp_run_make(const sp_tapped_spec *c, int tangents, sp_tapped_report *report, sp_run *out, sp_error *err);
void sp_run_free(sp_run *r);
/* One period from the present state. */
sp_status sp_run_tap(sp_run *r, int32_t tap, sp_error *err);

#endif
