/* Rows and reports of the two BSR models. */
#include "tapped/bsr.h"
#include "base/base.h"

sp_status sp_tapped_check_equal(const sp_tapped_spec *c, sp_error *err) {
    for (int32_t i = 2; i <= c->particles; i++) {
        if (sp_tapped_mass(c, i) != sp_tapped_mass(c, 1))
            return sp_fail(
                err, SP_EINVAL,
                "column.mass: particle %d has %.17g g, the first %.17g g; BSR, (43)-(48), requires equal masses", i,
                sp_tapped_mass(c, i), sp_tapped_mass(c, 1));
        if (sp_tapped_radius(c, i) != sp_tapped_radius(c, 1))
            return sp_fail(
                err, SP_EINVAL,
                "column.radius: particle %d has %.17g cm, the first %.17g cm; BSR, (43)-(48), requires equal "
                "radii",
                i, sp_tapped_radius(c, i), sp_tapped_radius(c, 1));
    }
    return SP_OK;
}

sp_status sp_tapped_check_step(const sp_tapped_spec *c, double bound, sp_error *err) {
    char step[SP_NUMBER_TEXT], most[SP_NUMBER_TEXT];
    if (c->time_step > bound)
        return sp_fail(err, SP_EINVAL,
                       "column.time_step = %s s: must not be above %s s, where the BSR scheme becomes unstable (0 "
                       "chooses the steps)",
                       sp_number_text(c->time_step, step), sp_number_text(bound, most));
    return SP_OK;
}

sp_status sp_tapped_frames_make(const sp_tapped_spec *c, sp_tapped_frame frame[2], sp_error *err) {
    size_t n = (size_t)c->particles + 1;
    for (int k = 0; k < 2; k++) {
        double *all = sp_alloc(3 * n, sizeof *all);
        if (!all) {
            sp_tapped_frames_free(frame);
            return sp_fail_memory(err, 3 * n * sizeof *all);
        }
        frame[k] = (sp_tapped_frame){.y = all, .v = all + n, .rho = all + 2 * n};
    }
    return SP_OK;
}

void sp_tapped_frames_free(sp_tapped_frame frame[2]) {
    for (int k = 0; k < 2; k++) {
        sp_free(frame[k].y);
        frame[k] = (sp_tapped_frame){.t = 0};
    }
}

static void note(const sp_tapped_spec *c, const sp_tapped_frame *now, sp_tapped_report *report) {
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
static sp_status between(const sp_tapped_spec *c, const sp_tapped_frame frame[2], double t, sp_tapped_frame *mixed,
                         const sp_tapped_sink *sink, sp_error *err) {
    const double span = frame[1].t - frame[0].t, x = span > 0 ? fmin(1, fmax(0, (t - frame[0].t) / span)) : 1;
    const double rest = 1 - x;
    mixed->y[0] = sp_tapped_floor(c, t);
    mixed->v[0] = sp_tapped_floor_velocity(c, t);
    for (int32_t i = 0; i < c->particles; i++) {
        const double from = frame[0].y[i + 1], to = frame[1].y[i + 1], v = frame[0].v[i + 1], w = frame[1].v[i + 1];
        mixed->y[i + 1] =
            rest * rest * ((1 + 2 * x) * from + x * span * v) + x * x * ((1 + 2 * rest) * to - rest * span * w);
        mixed->v[i + 1] = rest * v + x * w;
        mixed->rho[i] = rest * frame[0].rho[i] + x * frame[1].rho[i];
    }
    return sink->row(t, mixed->y, mixed->v, mixed->rho, sink->user, err);
}

sp_status sp_tapped_frames_pass(const sp_tapped_spec *c, sp_tapped_frame frame[2], sp_tapped_sink *sink,
                                sp_tapped_report *report, sp_error *err) {
    const int64_t most = (int64_t)SP_TAPPED_MOST_STEPS * sp_tapped_taps(c);
    sp_status status = sp_tapped_go_on(c, report->steps, most, frame[1].t, err);
    if (status != SP_OK)
        return status;
    frame[1].y[0] = sp_tapped_floor(c, frame[1].t);
    note(c, &frame[1], report);
    bool last = frame[1].t >=
                sp_tapped_taps(c) * c->period; /* in the last frame, includes times that exceed the end by rounding */
    if (sink->next >= sink->n || !(sink->t[sink->next] <= frame[1].t || last))
        return status;
    sp_tapped_frame mixed[2] = {{.t = 0}, {.t = 0}};
    status = sp_tapped_frames_make(c, mixed, err);
    while (status == SP_OK && sink->next < sink->n && (sink->t[sink->next] <= frame[1].t || last)) {
        status = between(c, frame, sink->t[sink->next], mixed, sink, err);
        sink->next++;
    }
    sp_tapped_frames_free(mixed);
    return status;
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

sp_status sp_tapped_run_conservative(const sp_tapped_spec *c, int64_t n, const double *t, sp_tapped_row row, void *user,
                                     sp_tapped_report *report, sp_error *err) {
    plain to = {.row = row, .user = user};
    sp_tapped_sink sink = {.n = n, .t = t, .row = without_density, .user = &to};
    return sp_tapped_conservative(c, &sink, report, err);
}

sp_status sp_tapped_run_literal(const sp_tapped_spec *c, int64_t n, const double *t, sp_tapped_row row, void *user,
                                sp_tapped_report *report, sp_error *err) {
    plain to = {.row = row, .user = user};
    sp_tapped_sink sink = {.n = n, .t = t, .row = without_density, .user = &to};
    return sp_tapped_literal(c, &sink, report, err);
}
