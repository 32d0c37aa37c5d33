/* The lattice (19) between events: memory, clusters of sticking particles, and the Taylor series of their motion. */
#include "tapped/lattice.h"

#include "base/base.h"

#include <string.h>

/* Gershgorin bound of the matrix with all contacts closed. Clusters are heavier, hence slower. */
static double frequency_bound(const sp_lattice *l) {
    double most = 0;
    for (int32_t i = 0; i < l->n; i++)
        most = fmax(most, (i > 0 ? 2 / l->mass[i - 1] : 0) + (i + 1 < l->n ? 2 : 1) / l->mass[i]);
    return sqrt(l->k * (1 + l->e) * most);
}

sp_status sp_lattice_make(const sp_tapped_spec *c, int tangents, sp_lattice *out, sp_error *err) {
    size_t n = (size_t)c->particles, stride = (n + 16) / 8 * 8, all = (size_t)tangents * n;
    *out = (sp_lattice){.spec = c,
                        .n = c->particles,
                        .k = sp_tapped_stiffness(c),
                        .e = c->e,
                        .g = c->gravity,
                        .a = c->amplitude,
                        .omega = 2 * M_PI * c->frequency,
                        .tap_end = fmin(0.5 / c->frequency, c->period),
                        .period = c->period,
                        .stride = (int32_t)stride,
                        .tangents = tangents};
    sp_lattice *l = out;
    const size_t series = (LATTICE_ORDER + 1) * stride, some = tangents > 0;
    const struct {
        double **array;
        size_t size;
    } part[] = {{&l->c, series},         {&l->t_c, some * series},
                {&l->stiffness, stride}, {&l->inverse_mass, stride},
                {&l->force, stride},     {&l->acceleration, stride},
                {&l->value, stride},     {&l->slope, stride},
                {&l->mass, n},           {&l->distance, n},
                {&l->delta, n},          {&l->w, n},
                {&l->anchor, n},         {&l->slack, n},
                {&l->carried, n},        {&l->t_delta, all},
                {&l->t_w, all},          {&l->before, some * n},
                {&l->after, some * n}};
    size_t size = 0;
    for (size_t k = 0; k < sizeof part / sizeof *part; k++)
        size += part[k].size;
    l->block = sp_alloc(size, sizeof *l->block);
    l->state = sp_alloc(2 * n, sizeof *l->state);
    l->mover = sp_alloc(n + 1, sizeof *l->mover);
    if (!l->block || !l->state || !l->mover)
        return sp_fail_memory(err, size * sizeof *l->block);
    l->released = l->state + n;
    double *next = l->block;
    for (size_t k = 0; k < sizeof part / sizeof *part; next += part[k++].size)
        *part[k].array = next;
    for (int32_t i = 0; i < l->n; i++) {
        l->mass[i] = sp_tapped_mass(c, i + 1);
        l->distance[i] = sp_tapped_distance(c, i);
        l->weight += l->mass[i] * l->g;
    }
    l->fastest = frequency_bound(l);
    return SP_OK;
}

void sp_lattice_free(sp_lattice *l) {
    sp_free(l->block);
    sp_free(l->state);
    sp_free(l->mover);
    *l = (sp_lattice){0};
}

static double stiffness_of(const sp_lattice *l, int32_t i) {
    contact_state s = (contact_state)l->state[i];
    return s == CONTACT_OPEN ? 0 : l->k * (s == CONTACT_APPROACHING ? 1 + l->e : 1 - l->e);
}

void sp_lattice_find_clusters(sp_lattice *l) {
    int32_t j = 0;
    l->closed = 0;
    for (int32_t i = 0; i < l->n; i++)
        if (l->state[i] != CONTACT_STUCK) {
            l->stiffness[j] = stiffness_of(l, i);
            l->closed += l->state[i] != CONTACT_OPEN;
            l->mover[j++] = i;
        }
    l->movers = j;
    l->mover[j] = l->n;
    l->lanes = j < LATTICE_FEW ? LATTICE_FEW : j;
    for (int32_t i = j; i < l->lanes; i++)
        l->stiffness[i] = l->inverse_mass[i] = l->c[i] = l->c[l->stride + i] = 0;
    double carried = 0;
    for (int32_t i = l->n - 1; i >= 0; i--) {
        carried += l->mass[i];
        l->carried[i] = carried;
        if (l->state[i] != CONTACT_STUCK) {
            l->inverse_mass[--j] = 1 / carried;
            carried = 0;
        }
    }
}

double sp_lattice_floor_acceleration(const sp_lattice *l) {
    return l->floor_moves ? -l->a * l->omega * l->omega * sin(l->omega * l->s) : 0;
}

double sp_lattice_floor_jerk(const sp_lattice *l) {
    return l->floor_moves ? -l->a * l->omega * l->omega * l->omega * cos(l->omega * l->s) : 0;
}

/* 1/((p + 1)(p + 2)), tabulated because divisions would dominate the recurrence. */
#define SHARE(p)  1.0 / (((p) + 1) * ((p) + 2))
#define SHARES(p) SHARE(p), SHARE((p) + 1), SHARE((p) + 2), SHARE((p) + 3), SHARE((p) + 4)
static const double shares[LATTICE_ORDER] = {SHARES(0), SHARES(5), SHARES(10), SHARES(15), SHARES(20), SHARES(25)};

/* Taylor series of y0'', up to l->order, plus gravity. */
static void expand_floor(sp_lattice *l) {
    const double acceleration = sp_lattice_floor_acceleration(l), square = -l->omega * l->omega;
    memset(l->floor, 0, sizeof l->floor);
    if (l->floor_moves) {
        l->floor[0] = acceleration;
        l->floor[1] = sp_lattice_floor_jerk(l);
        for (int p = 0; p + 2 <= l->order; p++)
            l->floor[p + 2] = l->floor[p] * square * shares[p];
    }
    l->floor[0] = acceleration + l->g;
}

/* One step of the recurrence: c_(p+2) (p+1) (p+2) = A_below - A_above, the accelerations of the two clusters. For few
 * movers it is called with a constant number of lanes; the unused lanes have zero stiffness. */
static inline void next_power_lanes(const sp_lattice *l, double *c, int p, double floor, int32_t lanes) {
    size_t stride = (size_t)l->stride;
    const double *restrict now = c + (size_t)p * stride, *restrict k = l->stiffness, *restrict im = l->inverse_mass;
    double *restrict next = c + (size_t)(p + 2) * stride, *restrict f = l->force, *restrict a = l->acceleration;
    for (int32_t j = 0; j < lanes; j++)
        f[j] = k[j] * now[j];
    f[lanes] = 0;
    a[0] = floor;
    for (int32_t j = 0; j < lanes; j++)
        a[j + 1] = (f[j] - f[j + 1]) * im[j];
    const double share = shares[p];
    for (int32_t j = 0; j < lanes; j++)
        next[j] = (a[j] - a[j + 1]) * share;
}

static void next_power(const sp_lattice *l, double *c, int p, double floor) {
    if (l->lanes > LATTICE_FEW) {
        next_power_lanes(l, c, p, floor, l->lanes);
        return;
    }
    size_t stride = (size_t)l->stride; /* kept in registers: otherwise memory would be read before it is written */
    const double *now = c + (size_t)p * stride;
    double *next = c + (size_t)(p + 2) * stride, share = shares[p];
    double below = floor, force = l->stiffness[0] * now[0];
    for (int32_t j = 0; j < l->movers; j++) {
        double above = j + 1 < l->movers ? l->stiffness[j + 1] * now[j + 1] : 0;
        double acceleration = (force - above) * l->inverse_mass[j];
        next[j] = (below - acceleration) * share;
        below = acceleration;
        force = above;
    }
}

static void hold_released(const sp_lattice *l, double *c) {
    for (int32_t j = 0; j < l->movers; j++)
        if (l->released[l->mover[j]])
            c[2 * (size_t)l->stride + (size_t)j] = 0;
}

/* Lowest order beyond which the terms of e^x stay below 1e-18; *rest bounds the sum of the omitted terms. */
static int order_for(double x, double *rest) {
    double term = x * x * x / 6;
    int p = 3;
    for (; p + 2 < LATTICE_ORDER && term > 1e-18; p += 2) /* two orders at a time save a division */
        term *= x * x * shares[p];
    *rest = term * x / (p + 1 - fmin(x, p));
    return p;
}

void sp_lattice_expand(sp_lattice *l, double h) {
    double rate = fmax(l->closed > 0 ? l->fastest : 0, l->floor_moves ? l->omega : 0);
    double rest;
    l->order = order_for(rate * h, &rest);
    l->truncation = fmax(l->truncation, rest);
    expand_floor(l);
    for (int32_t j = 0; j < l->movers; j++) {
        l->c[j] = l->delta[l->mover[j]];
        l->c[l->stride + j] = -l->w[l->mover[j]];
    }
    for (int p = 0; p + 2 <= l->order; p++) {
        next_power(l, l->c, p, l->floor[p]);
        if (p == 0)
            hold_released(l, l->c);
    }
}

void sp_lattice_motion(const sp_lattice *l, int32_t mover, double tau, double *overlap, double *opening) {
    double value = 0, slope = 0;
    for (int p = l->order; p >= 0; p--) {
        slope = slope * tau + value;
        value = value * tau + l->c[(size_t)p * (size_t)l->stride + (size_t)mover];
    }
    *overlap = value;
    *opening = -slope;
}

/* Values and slopes of all movers at tau. */
static inline void sum_lanes(sp_lattice *l, const double *c, double tau, int32_t lanes) {
    double *restrict value = l->value, *restrict slope = l->slope;
    size_t stride = (size_t)l->stride;
    for (int32_t j = 0; j < lanes; j++) {
        value[j] = c[(size_t)l->order * stride + (size_t)j];
        slope[j] = 0;
    }
    for (int p = l->order - 1; p >= 0; p--) {
        const double *restrict cp = c + (size_t)p * stride;
        for (int32_t j = 0; j < lanes; j++) {
            slope[j] = slope[j] * tau + value[j];
            value[j] = value[j] * tau + cp[j];
        }
    }
}

static void sum_series(sp_lattice *l, const double *c, double tau) {
    if (l->lanes == LATTICE_FEW)
        sum_lanes(l, c, tau, LATTICE_FEW);
    else
        sum_lanes(l, c, tau, l->lanes);
}

/* Tangents obey the same system without floor and gravity. Those of sticking contacts stay constant. */
static void advance_tangent(sp_lattice *l, double *delta, double *w, double tau) {
    for (int32_t j = 0; j < l->movers; j++) {
        l->t_c[j] = delta[l->mover[j]];
        l->t_c[l->stride + j] = -w[l->mover[j]];
    }
    for (int p = 0; p + 2 <= l->order; p++)
        next_power(l, l->t_c, p, 0);
    sum_series(l, l->t_c, tau);
    for (int32_t j = 0; j < l->movers; j++) {
        delta[l->mover[j]] = l->value[j];
        w[l->mover[j]] = -l->slope[j];
    }
}

void sp_lattice_advance(sp_lattice *l, double tau) {
    if (tau == 0)
        return;
    for (int v = 0; v < l->tangents; v++)
        advance_tangent(l, l->t_delta + (size_t)v * (size_t)l->n, l->t_w + (size_t)v * (size_t)l->n, tau);
    sum_series(l, l->c, tau);
    for (int32_t j = 0; j < l->movers; j++) {
        int32_t i = l->mover[j];
        l->delta[i] = l->value[j];
        l->w[i] = -l->slope[j];
        l->released[i] = 0;
    }
}

void sp_lattice_rates(sp_lattice *l, double *rate) {
    for (int32_t j = 0; j < l->movers; j++)
        l->c[j] = l->delta[l->mover[j]];
    next_power(l, l->c, 0, sp_lattice_floor_acceleration(l) + l->g);
    hold_released(l, l->c);
    memset(rate, 0, (size_t)l->n * sizeof *rate);
    for (int32_t j = 0; j < l->movers; j++)
        rate[l->mover[j]] = -2 * l->c[2 * (size_t)l->stride + (size_t)j];
}
