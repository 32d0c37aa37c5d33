/* Runs the BSR model in one of its variants. */
#include "tapped/bsr.h"

sp_status sp_tapped_run_bsr_sink(const sp_tapped_spec *c, sp_tapped_sink *sink, sp_tapped_report *report,
                                 sp_error *err) {
    return c->bsr == SP_TAPPED_BSR_CONSERVATIVE ? sp_tapped_conservative(c, sink, report, err)
                                                : sp_tapped_literal(c, sink, report, err);
}

typedef struct plain {
    sp_tapped_row row;
    void *user;
} plain;

static sp_status without_density(double t, const double *y, const double *v, const double *rho, void *user,
                                 sp_error *err) {
    const plain *to = user;
    (void)rho;
    return to->row(t, y, v, to->user, err);
}

sp_status sp_tapped_run_bsr(const sp_tapped_spec *c, int64_t n, const double *t, sp_tapped_row row, void *user,
                            sp_tapped_report *report, sp_error *err) {
    plain to = {.row = row, .user = user};
    sp_tapped_sink sink = {.n = n, .t = t, .row = without_density, .user = &to};
    return sp_tapped_run_bsr_sink(c, &sink, report, err);
}
