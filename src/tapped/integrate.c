/* Integrates a model with explicit steps from tap to tap, and writes rows, energies and separations. */
#include "tapped/integrate.h"

#include "base/base.h"

#include <float.h>

typedef struct integration {
    const sp_tapped_spec *c;
    const sp_tapped_stepper *m;
    const sp_tapped_rows *rows;
    sp_tapped_report *report;
    double *state, *next, *extra; /* [size] */
    double *y, *v;                /* [N + 1] */
    int64_t row;                  /* next row to write */
    int64_t steps;                /* taken in this tap */
    double start, separation;     /* start of the tap; current smallest separation */
    double checkpoint;            /* time in the tap at the last check of the progress */
} integration;

static sp_status write_row(integration *w, const double *state, sp_error *err) {
    double t = w->rows->t[w->row++];
    w->m->positions(w->m->model, state, w->y, w->v);
    w->y[0] = sp_tapped_floor(w->c, t);
    w->v[0] = sp_tapped_floor_velocity(w->c, t);
    return w->rows->row(t, w->y, w->v, NULL, w->rows->user, err);
}

/* Writes the rows from s on and before s + h. A time that lies below the end of a phase only by rounding belongs to the
 * next phase. */
static sp_status write_rows_before(integration *w, double s, double h, sp_error *err) {
    sp_status status = SP_OK;
    while (status == SP_OK && w->row < w->rows->n) {
        double at = w->rows->t[w->row] * (1 + 2 * DBL_EPSILON) - w->start;
        if (!(at < s + h))
            break;
        if (at > s)
            w->m->step(w->m->model, s, at - s, w->state, w->extra);
        status = write_row(w, at > s ? w->extra : w->state, err);
    }
    return status;
}

/* Records the smallest separation of the state at s. If it has become negative, the time of the violation is
 * interpolated linearly over the last step. */
static sp_status track_separation(integration *w, sp_tapped_tap *tap, double s, double h, sp_error *err) {
    w->m->positions(w->m->model, w->state, w->y, w->v);
    w->y[0] = sp_tapped_phase_floor(w->m->phase, s);
    double smallest = INFINITY;
    int32_t contact = 0;
    for (int32_t i = 0; i < w->c->particles; i++) {
        double apart = w->y[i + 1] - w->y[i];
        if (!(apart >= smallest)) {
            smallest = apart;
            contact = i;
        }
    }
    if (!isfinite(smallest))
        return sp_fail(err, SP_EFAILED, "column: positions are no longer finite at t = %.9g s, contact %d",
                       w->start + s, contact);
    if (smallest < tap->separation) {
        tap->separation = smallest;
        tap->at = w->start + s;
        tap->contact = contact;
    }
    if (smallest < 0 && !(w->report->violated >= 0)) {
        double back = w->separation > 0 ? h * smallest / (smallest - w->separation) : 0;
        w->report->violated_at = w->start + s - back;
        w->report->violated = contact;
    }
    w->separation = smallest;
    return SP_OK;
}

static sp_status fail_too_many(const integration *w, double s, double h, sp_error *err) {
    return sp_fail(
        err, w->m->adapt ? SP_EFAILED : SP_EINVAL,
        "column: steps of %.3g s at t = %.6g s, hence more than %d in the tap; the cause is %s: change it, or use "
        "column.method = \"event\"",
        h, w->start + s, SP_TAPPED_MOST_STEPS, w->m->cause);
}

/* Whether the tap needs too many steps. With fixed steps the number is known at once. Adaptive steps give up at the
 * limit, or when the last hundredth of it has advanced so little that ten times the limit would be needed. */
static bool is_hopeless(integration *w, double s, double parts) {
    const int64_t most = SP_TAPPED_MOST_STEPS, interval = most / 100;
    if (!w->m->adapt)
        return !(parts <= (double)most);
    if (w->steps > most)
        return true;
    if (w->steps % interval != 0)
        return false;
    bool slow = (w->c->period - s) * (double)interval > 10 * (double)most * (s - w->checkpoint);
    w->checkpoint = s;
    return slow;
}

/* Integrates over one phase of the floor's motion, from s to end. */
static sp_status integrate_phase(integration *w, sp_tapped_tap *tap, double s, double end, sp_error *err) {
    const sp_tapped_stepper *m = w->m;
    sp_status status = track_separation(w, tap, s, 0, err);
    while (status == SP_OK && s < end) {
        double most = m->max_step(m->model, s, w->state);
        double left = end - s, parts = ceil(left / most * (1 - 1e-9)), h = left / fmax(1, parts);
        status = sp_tapped_check_steps(w->c, ++w->steps, 0, w->start + s, err);
        if (status != SP_OK)
            return status;
        if (is_hopeless(w, s, parts) || !(s + h > s))
            return fail_too_many(w, s, h, err);
        double error = m->step(m->model, s, h, w->state, w->next);
        if (m->adapt)
            m->adapt(m->model, h, error);
        if (!(error <= 1))
            continue;
        status = write_rows_before(w, s, h, err);
        double *previous = w->state;
        w->state = w->next;
        w->next = previous;
        s = parts > 1 ? s + h : end;
        w->report->time_step = fmin(w->report->time_step, h);
        if (status == SP_OK)
            status = track_separation(w, tap, s, h, err);
    }
    return status;
}

static sp_status integrate_tap(integration *w, sp_tapped_tap *tap, double *energy, sp_error *err) {
    const sp_tapped_spec *c = w->c;
    double omega = 2 * M_PI * c->frequency, top = fmin(0.5 / c->frequency, c->period);
    double *work = &w->state[w->m->size - 2];
    work[0] = work[1] = 0;
    w->steps = 0;
    w->separation = w->checkpoint = 0;
    *w->m->phase = (sp_tapped_phase){.amplitude = c->amplitude, .omega = omega};
    sp_status status = c->amplitude > 0 ? integrate_phase(w, tap, 0, top, err) : SP_OK;
    *w->m->phase = (sp_tapped_phase){0};
    if (status == SP_OK)
        status = integrate_phase(w, tap, c->amplitude > 0 ? top : 0, c->period, err);
    if (status != SP_OK)
        return status;
    work = &w->state[w->m->size - 2];
    tap->work = work[0];
    tap->dissipated = work[1];
    tap->energy = w->m->energy(w->m->model, 0, w->state);
    double scale = fmax(fmax(fabs(tap->work), tap->dissipated), 1e-3 * fabs(*energy));
    tap->residual = (tap->energy - *energy - tap->work + tap->dissipated) / scale;
    *energy = tap->energy;
    w->report->steps += w->steps;
    return SP_OK;
}

sp_status sp_tapped_integrate(const sp_tapped_spec *c, const sp_tapped_stepper *m, const double *state,
                              const sp_tapped_rows *rows, sp_tapped_report *report, sp_error *err) {
    const size_t size = (size_t)m->size, particles = (size_t)c->particles + 1;
    double *memory = sp_alloc(3 * size + 2 * particles, sizeof *memory);
    if (!memory)
        return sp_fail_memory(err, (3 * size + 2 * particles) * sizeof *memory);
    integration w = {.c = c, .m = m, .rows = rows, .report = report};
    w.state = memory;
    w.next = w.state + size;
    w.extra = w.next + size;
    w.y = w.extra + size;
    w.v = w.y + particles;
    for (size_t i = 0; i < size; i++)
        w.state[i] = state[i];
    *m->phase = (sp_tapped_phase){0};
    report->time_step = INFINITY;
    double energy = report->initial_energy = m->energy(m->model, 0, w.state);
    sp_status status = SP_OK;
    for (int32_t k = 0; k < c->taps && status == SP_OK; k++) {
        w.start = k * c->period;
        status = integrate_tap(&w, &report->tap[k], &energy, err);
    }
    while (status == SP_OK && w.row < rows->n)
        status = write_row(&w, w.state, err);
    sp_free(memory);
    return status;
}
