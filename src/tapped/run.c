/* Runs a column with the model that its specification names, and returns the report. */
#include "base/base.h"
#include "tapped/column.h"

static sp_tapped_solver *solver_of(const sp_tapped_spec *c) {
    switch (c->model) {
    case SP_TAPPED_LATTICE: return c->method == SP_TAPPED_EVENT ? sp_tapped_run_events : sp_tapped_run_ode;
    case SP_TAPPED_LONGWAVE: return sp_tapped_run_longwave;
    case SP_TAPPED_BSR: return sp_tapped_run_bsr;
    case SP_TAPPED_EQ35:
    case SP_TAPPED_EQ37: break;
    }
    return sp_tapped_refuse_printed;
}

sp_status sp_tapped_report_make(const sp_tapped_spec *c, sp_tapped_report *r, sp_error *err) {
    *r = (sp_tapped_report){.violated_at = NAN, .violated = -1};
    r->tap = sp_alloc((size_t)c->taps, sizeof *r->tap);
    if (!r->tap)
        return sp_fail_memory(err, (size_t)c->taps * sizeof *r->tap);
    r->taps = c->taps;
    for (int32_t k = 0; k < c->taps; k++)
        r->tap[k] = (sp_tapped_tap){.rest = NAN, .separation = INFINITY, .at = NAN};
    return SP_OK;
}

void sp_tapped_report_free(sp_tapped_report *r) {
    sp_free(r->tap);
    *r = (sp_tapped_report){.violated_at = NAN, .violated = -1};
}

sp_status sp_tapped_run(const sp_tapped_spec *spec, int64_t n, const double *t, sp_tapped_row row, void *user,
                        sp_tapped_report *report, sp_error *err) {
    const sp_tapped_rows rows = {n, t, row, user};
    sp_tapped_report made = {0};
    sp_tapped_spec own = *spec, *c = &own;
    own.taps = sp_tapped_taps(spec);
    sp_status status = sp_tapped_check(c, err);
    if (status == SP_OK)
        status = sp_tapped_check_times(c, n, t, err);
    if (status == SP_OK)
        status = sp_tapped_report_make(c, &made, err);
    if (status == SP_OK)
        status = solver_of(c)(c, &rows, &made, err);
    if (status == SP_OK && report)
        *report = made;
    else
        sp_tapped_report_free(&made);
    return status;
}
