/* The stroboscopic map of the lattice, from the start of a tap to the start of the next, and its derivative. */
#include "base/base.h"
#include "tapped/events.h"

sp_status sp_tapped_state_make(const sp_tapped_spec *c, sp_tapped_state *out, sp_error *err) {
    sp_lattice l;
    sp_status status = sp_tapped_check(c, err);
    if (status != SP_OK)
        return status;
    status = sp_lattice_make(c, 0, &l, err);
    sp_tapped_state s = {sp_alloc((size_t)c->particles, sizeof(double)),
                         sp_alloc((size_t)c->particles, sizeof(double))};
    if (status == SP_OK && (!s.overlap || !s.opening))
        status = sp_fail_memory(err, 2 * sizeof(double) * (size_t)c->particles);
    if (status == SP_OK) {
        sp_lattice_start(&l);
        sp_lattice_get(&l, s.overlap, s.opening);
        *out = s;
    } else
        sp_tapped_state_free(&s);
    sp_lattice_free(&l);
    return status;
}

void sp_tapped_state_free(sp_tapped_state *s) {
    sp_free(s->overlap);
    sp_free(s->opening);
    *s = (sp_tapped_state){0};
}

void sp_tapped_positions(const sp_tapped_spec *c, const sp_tapped_state *s, double *y, double *v) {
    double height = 0, velocity = 0;
    for (int32_t i = 0; i < c->particles; i++) {
        height += sp_tapped_distance(c, i) - s->overlap[i];
        velocity += s->opening[i];
        y[i] = height;
        v[i] = velocity;
    }
}

static void start_tangents(sp_lattice *l) {
    size_t n = (size_t)l->n;
    for (size_t v = 0; v < (size_t)l->tangents; v++) {
        if (v < n)
            l->t_delta[v * n + v] = 1;
        else if (l->state[v - n] !=
                 CONTACT_STUCK) /* a perturbation of the velocity at a sticking contact vanishes at once */
            l->t_w[v * n + v - n] = 1;
    }
}

static void copy_tangents(const sp_lattice *l, double *derivative) {
    size_t n = (size_t)l->n;
    for (size_t row = 0; row < n; row++)
        for (size_t v = 0; v < 2 * n; v++) {
            derivative[row * 2 * n + v] = l->t_delta[v * n + row];
            derivative[(row + n) * 2 * n + v] = l->t_w[v * n + row];
        }
}

sp_status sp_tapped_map(const sp_tapped_spec *c, sp_tapped_state *s, int32_t periods, double *derivative,
                        sp_error *err) {
    sp_event_run r = {0};
    sp_status status = sp_tapped_check(c, err);
    if (status != SP_OK)
        return status;
    status = sp_event_run_make(c, derivative ? 2 * c->particles : 0, NULL, &r, err);
    if (status == SP_OK) {
        sp_lattice_set(&r.l, s->overlap, s->opening);
        if (derivative)
            start_tangents(&r.l);
    }
    for (int32_t k = 0; status == SP_OK && k < periods; k++)
        status = sp_event_run_tap(&r, k, err);
    if (status == SP_OK) {
        sp_lattice_get(&r.l, s->overlap, s->opening);
        if (derivative)
            copy_tangents(&r.l, derivative);
    }
    sp_event_run_free(&r);
    return status;
}
