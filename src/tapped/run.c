/* Runs a column with the model that its specification names, and returns the report. */
#include "base/base.h"
#include "tapped/column.h"

static sp_tapped_solver *solver_of(const sp_tapped_spec *c) {
    switch (c->model) {
    case SP_TAPPED_LATTICE:
        return c->method == SP_TAPPED_EVENT    ? sp_tapped_run_events
               : c->method == SP_TAPPED_SMOOTH ? sp_tapped_run_smooth
                                               : sp_tapped_run_rk4;
    case SP_TAPPED_LONGWAVE: return sp_tapped_run_longwave;
    case SP_TAPPED_BSR:
        return c->bsr == SP_TAPPED_BSR_CONSERVATIVE ? sp_tapped_run_conservative : sp_tapped_run_literal;
    case SP_TAPPED_EQ35:
    case SP_TAPPED_EQ37: break;
    }
    return sp_tapped_refuse_printed;
}

sp_status sp_tapped_go_on(const sp_tapped_spec *c, int64_t steps, int64_t most, double t, sp_error *err) {
    enum { SELDOM = 256 };
    if (steps % SELDOM != 0)
        return SP_OK;
    if (c->stopped && c->stopped(c->user))
        return sp_fail(err, SP_EINTERRUPTED, "stopped at t = %.6g s: nothing is written", t);
    if (most > 0 && steps > most)
        return sp_fail(err, SP_EFAILED,
                       "t = %.6g s: more than %lld steps per tap; change column.time_step, column.stiffness or "
                       "column.amplitude to allow longer steps",
                       t, (long long)(most / sp_tapped_taps(c)));
    return SP_OK;
}

static sp_status make_report(const sp_tapped_spec *c, sp_tapped_report *r, sp_error *err) {
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

sp_status sp_tapped_check_times(const sp_tapped_spec *c, int64_t n, const double *t, sp_error *err) {
    double last = sp_tapped_taps(c) * c->period, end = last * (1 + 1e-12);
    for (int64_t i = 0; i < n; i++)
        if (!(t[i] >= (i > 0 ? t[i - 1] : 0) && t[i] <= end))
            return sp_fail(err, SP_EINVAL, "time %lld, %.17g s: must be ascending, from 0 to %.17g s", (long long)i + 1,
                           t[i], last);
    return SP_OK;
}

sp_status sp_tapped_run(const sp_tapped_spec *spec, int64_t n, const double *t, sp_tapped_row row, void *user,
                        sp_tapped_report *report, sp_error *err) {
    sp_tapped_report made = {0};
    sp_tapped_spec own = *spec, *c = &own;
    own.taps = sp_tapped_taps(spec);
    sp_status status = sp_tapped_check(c, err);
    if (status == SP_OK)
        status = sp_tapped_check_times(c, n, t, err);
    if (status == SP_OK)
        status = make_report(c, &made, err);
    if (status == SP_OK)
        status = solver_of(c)(c, n, t, row, user, &made, err);
    if (status == SP_OK && report)
        *report = made;
    else
        sp_tapped_report_free(&made);
    return status;
}
