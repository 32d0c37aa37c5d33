/* Integrates the lattice exactly from event to event: one tap, its energies, and its rows. */
#include "tapped/events.h"

#include "base/base.h"

enum { CROWD = 1 /* above this number of movers, steps end before the next event to need fewer powers */ };
enum { SIMULTANEOUS_MAX = 400 }; /* limit on simultaneous events, for each of 1 + N; more are an error */

static const double longest = 1; /* product of the step and the frequency bound */

/* ---- energies and separations ----------------------------------------------------------------------------------- */

static double energy_of(const sp_lattice *l) {
    double sum = 0, velocity = l->floor_moves ? l->a * l->omega * cos(l->omega * l->s) : 0;
    double height = l->floor_moves ? l->a * sin(l->omega * l->s) : 0;
    for (int32_t i = 0; i < l->n; i++) {
        velocity += l->w[i];
        height += l->distance[i] - l->delta[i];
        sum += l->mass[i] * (0.5 * velocity * velocity + l->g * height);
        if (l->delta[i] > 0)
            sum += 0.5 * l->k * l->delta[i] * l->delta[i];
    }
    return sum;
}

/* Adds the dissipation of a closed contact since its anchor. It has moved in one direction since then. */
static void add_dissipation(sp_lattice *l, int32_t i) {
    if (l->state[i] == CONTACT_APPROACHING || l->state[i] == CONTACT_SEPARATING) {
        double now = l->delta[i], then = l->anchor[i];
        l->dissipated += 0.5 * l->e * l->k * fabs((now - then) * (now + then));
    }
    l->anchor[i] = l->delta[i];
}

static void note_separation(sp_event_run *r, int32_t i, double delta, double s) {
    double separation = r->l.distance[i] - delta;
    if (separation < r->tap->separation) {
        r->tap->separation = separation;
        r->tap->at = r->begin + s;
        r->tap->contact = i;
    }
}

static void note_all_separations(sp_event_run *r) {
    for (int32_t i = 0; i < r->l.n; i++)
        note_separation(r, i, r->l.delta[i], r->l.s);
}

static void note_violation(sp_event_run *r, int32_t j, double tau) {
    sp_lattice *l = &r->l;
    double f[LATTICE_ORDER + 1];
    for (int p = 0; p <= l->order; p++)
        f[p] = l->c[(size_t)p * (size_t)l->stride + (size_t)j];
    f[0] -= l->distance[l->mover[j]];
    double at = r->begin + l->s + fmin(tau, sp_first_root(f, l->order, tau));
    if (r->report->violated < 0 || at < r->report->violated_at) {
        r->report->violated = l->mover[j];
        r->report->violated_at = at;
    }
}

/* Elastic contacts have no event at their turning point: finds the deepest_overlap overlap within the step. */
static double deepest_overlap(sp_event_run *r, int32_t j, double tau) {
    sp_lattice *l = &r->l;
    double f[LATTICE_ORDER + 1], overlap, opening;
    for (int p = 1; p <= l->order; p++)
        f[p - 1] = -p * l->c[(size_t)p * (size_t)l->stride + (size_t)j];
    double at = fmin(tau, sp_first_root(f, l->order - 1, tau));
    sp_lattice_motion(l, j, at, &overlap, &opening);
    note_separation(r, l->mover[j], overlap, l->s + at);
    return overlap;
}

/* To be called after sp_lattice_advance, while the series and l->s are still those of the start of the step. */
static void check_order(sp_event_run *r, double tau) {
    sp_lattice *l = &r->l;
    bool kept = r->report->violated < 0;
    for (int32_t j = 0; j < l->movers; j++) {
        int32_t i = l->mover[j];
        bool turned = l->e == 0 && l->c[l->stride + j] > 0 && l->w[i] > 0;
        double most = turned ? deepest_overlap(r, j, tau) : l->delta[i];
        if (kept && most >= l->distance[i] && l->c[j] < l->distance[i])
            note_violation(r, j, tau);
    }
}

/* Integral of F_0 dy_0 over tau, from the product of the two series. */
static void add_work(sp_event_run *r, double tau) {
    sp_lattice *l = &r->l;
    if (l->movers > 0 && l->mover[0] == 0 && l->stiffness[0] == 0)
        return; /* no particle is on the floor */
    double velocity[LATTICE_ORDER + 2] = {l->a * l->omega * cos(l->omega * l->s)}, sum = 0, power = tau;
    for (int p = 0; p <= l->order; p++)
        velocity[p + 1] = (l->floor[p] - (p == 0 ? l->g : 0)) / (p + 1);
    double force[LATTICE_ORDER + 1], carried = l->movers == 0 || l->mover[0] > 0 ? l->carried[0] : 0;
    for (int p = 0; p <= l->order; p++)
        force[p] = (l->movers > 0 ? l->stiffness[0] * l->c[(size_t)p * (size_t)l->stride] : 0) + carried * l->floor[p];
    for (int p = 0; p <= l->order; p++, power *= tau) {
        double product = 0;
        for (int q = 0; q <= p; q++)
            product += force[q] * velocity[p - q];
        sum += product * power / (p + 1);
    }
    r->tap->work += sum;
}

/* ---- rows ------------------------------------------------------------------------------------------------------- */

static sp_status write_row(sp_event_run *r, double t, sp_error *err) {
    const sp_lattice *l = &r->l;
    double tau = fmax(0, t - r->begin - l->s), s = l->s + tau;
    int32_t j = 0;
    r->y[0] = l->floor_moves ? l->a * sin(l->omega * s) : 0;
    r->v[0] = l->floor_moves ? l->a * l->omega * cos(l->omega * s) : 0;
    for (int32_t i = 0; i < l->n; i++) {
        double overlap = l->delta[i], opening = 0;
        if (j < l->movers && l->mover[j] == i)
            sp_lattice_motion(l, j++, tau, &overlap, &opening);
        r->y[i + 1] = r->y[i] + (l->distance[i] - overlap);
        r->v[i + 1] = r->v[i] + opening;
    }
    return r->rows->row(t, r->y, r->v, NULL, r->rows->user, err);
}

/* Writes the rows of the step up to tau. Rows at the end of the tap belong to the next tap, unless this is the last. */
static sp_status write_rows(sp_event_run *r, double tau, sp_error *err) {
    sp_status status = SP_OK;
    for (; status == SP_OK && r->rows && r->next < r->rows->n; r->next++) {
        double t = r->rows->t[r->next];
        bool ends = r->l.s + tau >= r->l.period;
        if (ends ? !(r->last || t < r->begin + r->l.period) : t - r->begin > r->l.s + tau)
            break;
        status = write_row(r, t, err);
    }
    return status;
}

/* ---- steps ------------------------------------------------------------------------------------------------------ */

/* Updates the tangents at an event (saltation). An event at a fixed time leaves them unchanged. If the event's time
 * depends on the state, w changes by the jump of dw/dt times the shift of that time. */
static void apply_saltation(sp_lattice *l, int32_t at) {
    sp_lattice_rates(l, l->after);
    for (int v = 0; v < l->tangents; v++) {
        double *w = l->t_w + (size_t)v * (size_t)l->n, rate = l->before[at];
        double shift = rate != 0 ? -w[at] / rate : 0;
        for (int32_t i = 0; i < l->n; i++)
            w[i] = l->state[i] == CONTACT_STUCK ? 0 : w[i] + (l->before[i] - l->after[i]) * shift;
    }
}

static void handle_turn(sp_event_run *r, int32_t i) {
    sp_lattice *l = &r->l;
    if (l->tangents > 0)
        sp_lattice_rates(l, l->before);
    add_dissipation(l, i);
    note_separation(r, i, l->delta[i], l->s);
    l->w[i] = 0;
    if (l->delta[i] > 0)
        sp_lattice_stick(l, i, -1);
    else
        l->state[i] = CONTACT_OPEN;
    sp_lattice_find_clusters(l);
    if (l->tangents > 0)
        apply_saltation(l, i);
}

static void handle_event(sp_event_run *r, lattice_event event) {
    sp_lattice *l = &r->l;
    int32_t i = event.contact;
    switch (event.kind) {
    case EVENT_NONE: return;
    case EVENT_TURN: handle_turn(r, i); return;
    case EVENT_CLOSE:
        l->delta[i] = l->anchor[i] = 0;
        l->state[i] = l->e > 0 ? CONTACT_APPROACHING : CONTACT_SEPARATING;
        break;
    case EVENT_OPEN:
        l->delta[i] = 0;
        add_dissipation(l, i);
        l->state[i] = CONTACT_OPEN;
        break;
    case EVENT_SLIP: sp_lattice_stick(l, i, i); break;
    }
    sp_lattice_find_clusters(l);
}

static sp_status fail_stalled(const sp_event_run *r, lattice_event event, sp_error *err) {
    return sp_fail(err, SP_EFAILED,
                   "t = %.17g s, contact %d: events follow each other without end in one moment; e = %.17g may be too "
                   "near to 0 or 1, or masses too unlike, for double precision",
                   r->begin + r->l.s, event.contact, r->l.e);
}

/* Takes a step of at most `left`. */
static sp_status step(sp_event_run *r, double left, sp_error *err) {
    sp_lattice *l = &r->l;
    double rate = fmax(l->closed > 0 ? l->fastest : 0, l->floor_moves ? l->omega : 0);
    double h = rate * left > longest ? longest / rate : left;
    if (l->movers > CROWD && h > 3 * r->interval)
        h = 3 * r->interval;
    sp_lattice_expand(l, h);
    lattice_event event = sp_lattice_next_event(l, h);
    bool ends = event.kind == EVENT_NONE && h == left;
    sp_status status = sp_tapped_check_steps(l->spec, ++r->report->steps, 0, r->begin + l->s, err);
    if (status == SP_OK)
        status = write_rows(r, event.tau, err);
    if (status != SP_OK)
        return status;
    if (l->floor_moves)
        add_work(r, event.tau);
    sp_lattice_advance(l, event.tau);
    check_order(r, event.tau);
    l->s = ends ? r->until : l->s + event.tau;
    r->interval = event.kind == EVENT_NONE ? 2 * r->interval
                  : isinf(r->interval)     ? event.tau
                                           : 0.75 * r->interval + 0.25 * event.tau;
    r->interval = fmax(r->interval, 1e-3 * longest / l->fastest);
    if (event.kind == EVENT_NONE)
        return SP_OK;
    r->report->events++;
    r->simultaneous = event.tau > 1e-15 * l->s ? 0 : r->simultaneous + 1;
    if (r->simultaneous > SIMULTANEOUS_MAX * (1 + (int64_t)l->n))
        return fail_stalled(r, event, err);
    handle_event(r, event);
    return SP_OK;
}

static sp_status advance_to(sp_event_run *r, double until, sp_error *err) {
    sp_lattice *l = &r->l;
    sp_status status = SP_OK;
    r->until = until;
    while (status == SP_OK && l->s < until) {
        if (l->movers == 0 && !l->floor_moves) {
            r->tap->rest = isnan(r->tap->rest) ? l->s : r->tap->rest;
            status = write_rows(r, until - l->s, err);
            l->s = until;
        } else
            status = step(r, until - l->s, err);
    }
    return status;
}

/* Applies a jump of the floor's velocity, upwards positive. */
static void apply_jump(sp_event_run *r, double jump) {
    sp_lattice *l = &r->l;
    add_dissipation(l, 0);
    note_separation(r, 0, l->delta[0], l->s);
    l->w[0] -= jump;
    l->slack[0] = 0;
    l->released[0] = 0;
    bool closed = l->delta[0] > 0 || (l->delta[0] == 0 && l->w[0] < 0);
    if (!closed)
        l->state[0] = CONTACT_OPEN;
    else if (l->e == 0 || l->w[0] > 0)
        l->state[0] = CONTACT_SEPARATING;
    else if (l->w[0] < 0)
        l->state[0] = CONTACT_APPROACHING;
    int32_t first = l->w[0] == 0 && l->delta[0] > 0 ? 0 : 1;
    if (l->e > 0 && first < l->n && l->w[first] == 0 && l->delta[first] > 0)
        sp_lattice_stick(l, first, -1);
    sp_lattice_find_clusters(l);
}

sp_status sp_event_run_tap(sp_event_run *r, int32_t tap, sp_error *err) {
    sp_lattice *l = &r->l;
    double energy = energy_of(l), dissipated = l->dissipated;
    sp_status status = sp_tapped_check_steps(l->spec, 0, 0, tap * l->period, err);
    if (status != SP_OK)
        return status;
    r->tap = &r->report->tap[r->report->taps > tap ? tap : 0];
    *r->tap = (sp_tapped_tap){.rest = NAN, .separation = INFINITY, .at = NAN};
    r->begin = tap * l->period;
    l->s = 0;
    note_all_separations(r);
    if (l->a > 0) {
        l->floor_moves = true;
        apply_jump(r, l->a * l->omega);
        status = advance_to(r, l->tap_end, err);
        if (status != SP_OK)
            return status;
        l->floor_moves = false;
        apply_jump(r, l->a * l->omega);
    }
    status = advance_to(r, l->period, err);
    if (status != SP_OK)
        return status;
    for (int32_t i = 0; i < l->n; i++)
        add_dissipation(l, i);
    note_all_separations(r);
    r->tap->dissipated = l->dissipated - dissipated;
    r->tap->energy = energy_of(l);
    double scale = fmax(fabs(r->tap->work), r->tap->dissipated);
    scale = fmax(scale, 1e-3 * fmax(fabs(energy), fabs(r->tap->energy)));
    r->tap->residual = scale > 0 ? (r->tap->energy - energy - r->tap->work + r->tap->dissipated) / scale : 0;
    return SP_OK;
}

sp_status sp_event_run_make(const sp_tapped_spec *c, int tangents, sp_tapped_report *report, sp_event_run *out,
                            sp_error *err) {
    *out = (sp_event_run){.report = report, .interval = INFINITY};
    out->own_report = (sp_tapped_report){.taps = 1, .tap = &out->own_tap, .violated_at = NAN, .violated = -1};
    if (!report)
        out->report = &out->own_report;
    sp_status status = sp_lattice_make(c, tangents, &out->l, err);
    if (status != SP_OK)
        return status;
    out->y = sp_alloc((size_t)c->particles + 1, sizeof(double));
    out->v = sp_alloc((size_t)c->particles + 1, sizeof(double));
    return out->y && out->v ? SP_OK : sp_fail_memory(err, 2 * sizeof(double) * (size_t)c->particles);
}

void sp_event_run_free(sp_event_run *r) {
    sp_lattice_free(&r->l);
    sp_free(r->y);
    sp_free(r->v);
}

sp_status sp_tapped_run_events(const sp_tapped_spec *c, const sp_tapped_rows *rows, sp_tapped_report *report,
                               sp_error *err) {
    sp_event_run r;
    sp_status status = sp_event_run_make(c, 0, report, &r, err);
    if (status == SP_OK) {
        r.rows = rows;
        sp_lattice_start(&r.l);
        report->initial_energy = energy_of(&r.l);
    }
    for (int32_t k = 0; status == SP_OK && k < c->taps; k++) {
        r.last = k + 1 == c->taps;
        status = sp_event_run_tap(&r, k, err);
    }
    report->error = r.l.truncation;
    sp_event_run_free(&r);
    return status;
}
