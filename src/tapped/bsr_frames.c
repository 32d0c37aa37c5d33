/* Time loop of the two BSR models: steps between the jumps of the floor, rows by interpolation, and the report. */
#include "base/base.h"
#include "tapped/bsr.h"

sp_status sp_tapped_check_equal(const sp_tapped_spec *c, sp_error *err) {
    for (int32_t i = 2; i <= c->particles; i++) {
        if (sp_tapped_mass(c, i) != sp_tapped_mass(c, 1))
            return sp_fail_key(err, SP_EINVAL, "column.mass",
                               ": particle %d has %.17g g, the first %.17g g; BSR, (43)-(48), requires equal masses", i,
                               sp_tapped_mass(c, i), sp_tapped_mass(c, 1));
        if (sp_tapped_radius(c, i) != sp_tapped_radius(c, 1))
            return sp_fail_key(err, SP_EINVAL, "column.radius",
                               ": particle %d has %.17g cm, the first %.17g cm; BSR, (43)-(48), requires equal radii",
                               i, sp_tapped_radius(c, i), sp_tapped_radius(c, 1));
    }
    return SP_OK;
}

sp_status sp_tapped_check_time_step(const sp_tapped_spec *c, double bound, sp_error *err) {
    char step[SP_NUMBER_TEXT], most[SP_NUMBER_TEXT];
    if (c->time_step > bound)
        return sp_fail_key(err, SP_EINVAL, "column.time_step",
                           " = %s s: must not be above %s s, where the BSR scheme becomes unstable (0 "
                           "chooses the steps)",
                           sp_number_text(c->time_step, step), sp_number_text(bound, most));
    return SP_OK;
}

/* Start, end and interpolated state of a step, and the caller's rows. */
typedef struct loop {
    const sp_tapped_spec *c;
    sp_tapped_frame from, to, mixed;
    const sp_tapped_rows *rows;
    int64_t next; /* row */
    sp_tapped_report *report;
} loop;

/* The times at which the floor's velocity jumps: k T and k T + pi/omega. */
typedef struct jumps {
    int32_t tap;
    bool half; /* whether the half sine of this tap is over */
} jumps;

static double next_jump(const sp_tapped_spec *c, const jumps *k) {
    double end = (k->tap + 1) * c->period;
    return k->half ? end : fmin(end, k->tap * c->period + 0.5 / c->frequency);
}

static void pass_jump(const sp_tapped_spec *c, jumps *k) {
    bool over = next_jump(c, k) >= (k->tap + 1) * c->period;
    *k = (jumps){.tap = k->tap + over, .half = !over};
}

static void note_separations(const sp_tapped_spec *c, const sp_tapped_frame *now, sp_tapped_report *report) {
    int32_t tap = (int32_t)fmin(now->t / c->period, sp_tapped_taps(c) - 1);
    sp_tapped_tap *at = &report->tap[tap];
    for (int32_t i = 0; i < c->particles; i++) {
        double separation = now->y[i + 1] - now->y[i];
        if (separation < at->separation) {
            at->separation = separation;
            at->at = now->t;
            at->contact = i;
        }
        if (separation < 0 && report->violated < 0) {
            report->violated_at = now->t;
            report->violated = i;
        }
    }
}

/* Interpolates positions by Hermite cubics, which are exact in free fall, and the other quantities linearly. */
static sp_status write_row(loop *w, double t, sp_error *err) {
    const sp_tapped_frame *a = &w->from, *b = &w->to;
    const double span = b->t - a->t, x = span > 0 ? fmin(1, fmax(0, (t - a->t) / span)) : 1;
    const double rest = 1 - x;
    double *y = w->mixed.y, *v = w->mixed.v, *rho = w->mixed.rho;
    y[0] = sp_tapped_floor(w->c, t);
    v[0] = sp_tapped_floor_velocity(w->c, t);
    for (int32_t i = 1; i <= w->c->particles; i++) {
        y[i] = rest * rest * ((1 + 2 * x) * a->y[i] + x * span * a->v[i]) +
               x * x * ((1 + 2 * rest) * b->y[i] - rest * span * b->v[i]);
        v[i] = rest * a->v[i] + x * b->v[i];
        rho[i - 1] = rest * a->rho[i - 1] + x * b->rho[i - 1];
    }
    return w->rows->row(t, y, v, rho, w->rows->user, err);
}

/* Records the end of a step, and writes the rows within it. */
static sp_status finish_step(loop *w, sp_error *err) {
    const sp_tapped_spec *c = w->c;
    const sp_tapped_rows *rows = w->rows;
    const int64_t most = (int64_t)SP_TAPPED_MOST_STEPS * sp_tapped_taps(c);
    sp_status status = sp_tapped_check_steps(c, w->report->steps, most, w->to.t, err);
    if (status != SP_OK)
        return status;
    w->to.y[0] = sp_tapped_floor(c, w->to.t);
    note_separations(c, &w->to, w->report);
    bool last = w->to.t >= sp_tapped_taps(c) * c->period; /* includes times that exceed the end by rounding */
    while (status == SP_OK && w->next < rows->n && (rows->t[w->next] <= w->to.t || last))
        status = write_row(w, rows->t[w->next++], err);
    return status;
}

static sp_status run_taps(loop *w, const sp_tapped_bsr_scheme *scheme, sp_error *err) {
    const double end = sp_tapped_taps(w->c) * w->c->period;
    jumps jump = {0};
    scheme->start(scheme->model, &w->to);
    w->from.t = w->to.t;
    sp_status status = finish_step(w, err);
    while (status == SP_OK && w->to.t < end) {
        sp_tapped_frame old = w->from;
        w->from = w->to;
        w->to = old;
        status = scheme->step(scheme->model, next_jump(w->c, &jump), &w->from, &w->to, err);
        if (status != SP_OK)
            break;
        if (w->to.t >= next_jump(w->c, &jump))
            pass_jump(w->c, &jump);
        w->report->steps++;
        status = finish_step(w, err);
    }
    return status;
}

sp_status sp_tapped_bsr_integrate(const sp_tapped_spec *c, const sp_tapped_bsr_scheme *scheme,
                                  const sp_tapped_rows *rows, sp_tapped_report *report, sp_error *err) {
    const size_t n = (size_t)c->particles + 1;
    double *all = sp_alloc(9 * n, sizeof *all);
    if (!all)
        return sp_fail_memory(err, 9 * n * sizeof *all);
    loop w = {.c = c, .rows = rows, .report = report};
    sp_tapped_frame *frames[] = {&w.from, &w.to, &w.mixed};
    for (size_t k = 0; k < 3; k++)
        *frames[k] = (sp_tapped_frame){.y = all + 3 * k * n, .v = all + (3 * k + 1) * n, .rho = all + (3 * k + 2) * n};
    report->time_step = c->time_step;
    sp_status status = run_taps(&w, scheme, err);
    sp_free(all);
    return status;
}

sp_status sp_tapped_bsr_limit_step(double t, double until, double *dt, double *end, sp_error *err) {
    *end = t + *dt;
    if (*end >= until) {
        *dt = until - t;
        *end = until;
    } else if (!(*end > t))
        return sp_fail(err, SP_EFAILED, "BSR, t = %.17g s: the velocities are too large for any time step", t);
    return SP_OK;
}

sp_status sp_tapped_bsr_check_finite(double sum, double t, sp_error *err) {
    return isfinite(sum) ? SP_OK : sp_fail(err, SP_EFAILED, "BSR, t = %.17g s: the solution is no longer finite", t);
}
