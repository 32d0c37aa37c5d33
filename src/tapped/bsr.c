/* Runs the BSR model in one of its variants. */
#include "tapped/bsr.h"

sp_status sp_tapped_run_bsr_rows(const sp_tapped_spec *c, const sp_tapped_bsr_rows *rows, sp_tapped_report *report,
                                 sp_error *err) {
    return c->bsr == SP_TAPPED_BSR_CONSERVATIVE ? sp_tapped_conservative(c, rows, report, err)
                                                : sp_tapped_literal(c, rows, report, err);
}

static sp_status without_density(double t, const double *y, const double *v, const double *rho, void *user,
                                 sp_error *err) {
    const sp_tapped_rows *plain = user;
    (void)rho;
    return plain->row(t, y, v, plain->user, err);
}

sp_status sp_tapped_run_bsr(const sp_tapped_spec *c, const sp_tapped_rows *rows, sp_tapped_report *report,
                            sp_error *err) {
    sp_tapped_rows plain = *rows;
    const sp_tapped_bsr_rows with_density = {rows->n, rows->t, without_density, &plain};
    return sp_tapped_run_bsr_rows(c, &with_density, report, err);
}
