/* Finds the time of the next event: the first zero of the Taylor polynomials, with certainty. */
#include "tapped/lattice.h"

#include <float.h>
#include <stddef.h>

typedef struct jet {
    double value, slope, noise;
} jet;

static jet evaluate(const double *f, int n, double tau) {
    jet j = {f[n], 0, fabs(f[n])};
    for (int k = n - 1; k >= 0; k--) {
        j.slope = j.slope * tau + j.value;
        j.value = j.value * tau + f[k];
        j.noise = j.noise * tau + fabs(f[k]);
    }
    j.noise *= 4 * DBL_EPSILON;
    return j;
}

/* Upper bound of f'' in [0, end]. */
static double curvature(const double *f, int n, double end) {
    double bound = 0;
    for (int k = n; k > 2; k--)
        bound = bound * end + (f[k] > 0 ? (double)(k * (k - 1)) * f[k] : 0);
    return n >= 2 ? bound * end + 2 * f[2] : 0;
}

/* With the largest curvature ahead, the parabola through the value and slope of f lies above f. Up to the zero of the
 * parabola f has no zero. Steps to these zeros converge from one side, like Newton's method. */
double sp_first_root(const double *f, int n, double h) {
    while (n >= 0 && f[0] == 0) /* f/tau has the same sign as f */
        f++, n--;
    if (n < 0)
        return INFINITY;
    if (f[0] > 0)
        return 0;
    jet j = {f[0], n > 0 ? f[1] : 0, 4 * DBL_EPSILON * -f[0]};
    double tau = 0, end = 0.5 * h, curvature_bound = curvature(f, n, end);
    while (j.value < -j.noise) {
        double square = j.slope * j.slope - 2 * curvature_bound * j.value, step = INFINITY;
        if (square >= 0 && j.slope >= 0)
            step = -2 * j.value / (j.slope + sqrt(square));
        else if (square >= 0 && curvature_bound > 0)
            step = (sqrt(square) - j.slope) / curvature_bound;
        double next = tau + step;
        if (next > end && end >= h)
            return INFINITY;
        if (next > end) { /* no zero up to there */
            next = end;
            end = h;
            curvature_bound = curvature(f, n, end);
        } else if (next == tau)
            break;
        tau = next;
        j = evaluate(f, n, tau);
    }
    return tau;
}

typedef struct search {
    sp_lattice *l;
    lattice_event best;
    double reach_floor; /* bound of the change of y0'' within h */
} search;

static void keep_earlier(search *s, event_kind kind, int32_t contact, const double *f, int n) {
    double tau = sp_first_root(f, n, s->best.tau);
    if (tau < s->best.tau || (tau == s->best.tau && s->best.kind == EVENT_NONE))
        s->best = (lattice_event){kind, contact, tau};
}

static void overlap_series(const sp_lattice *l, int32_t j, double sign, double *f) {
    for (int p = 0; p <= l->order; p++)
        f[p] = sign * l->c[(size_t)p * (size_t)l->stride + (size_t)j];
}

static void opening_series(const sp_lattice *l, int32_t j, double sign, double *f) {
    for (int p = 1; p <= l->order; p++)
        f[p - 1] = -sign * p * l->c[(size_t)p * (size_t)l->stride + (size_t)j];
}

/* Bounds of the changes of the overlaps (value) and of the opening velocities (slope) within h. */
static inline void reach_lanes(sp_lattice *l, double h, int32_t lanes) {
    double *restrict value = l->value, *restrict slope = l->slope;
    for (int32_t j = 0; j < lanes; j++)
        value[j] = slope[j] = 0;
    for (int p = l->order; p >= 1; p--) {
        const double *restrict c = l->c + (size_t)p * (size_t)l->stride;
        const double times = p > 1 ? p : 0;
        for (int32_t j = 0; j < lanes; j++) {
            double size = fabs(c[j]);
            slope[j] = slope[j] * h + times * size;
            value[j] = (value[j] + size) * h;
        }
    }
}

static void find_reach(sp_lattice *l, double h) {
    if (l->lanes == LATTICE_FEW)
        reach_lanes(l, h, LATTICE_FEW);
    else
        reach_lanes(l, h, l->lanes);
}

static void search_mover(search *s, int32_t j) {
    sp_lattice *l = s->l;
    double f[LATTICE_ORDER + 1], overlap = l->c[j], opening = -l->c[(size_t)l->stride + (size_t)j];
    int32_t i = l->mover[j];
    contact_state state = (contact_state)l->state[i];
    if (state == CONTACT_OPEN && overlap + l->value[j] >= 0) {
        overlap_series(l, j, 1, f);
        keep_earlier(s, EVENT_CLOSE, i, f, l->order);
    }
    if (state == CONTACT_SEPARATING && overlap - l->value[j] <= 0) {
        overlap_series(l, j, -1, f);
        keep_earlier(s, EVENT_OPEN, i, f, l->order);
    }
    if (l->e == 0 || state == CONTACT_OPEN)
        return;
    double sign = state == CONTACT_APPROACHING ? 1 : -1;
    if (sign * opening + l->slope[j] >= 0) {
        opening_series(l, j, sign, f);
        keep_earlier(s, EVENT_TURN, i, f, l->order - 1);
    }
}

static const double zero[1] = {0};

/* The force on sticking contact i interpolates between the forces at the two ends of its cluster, in proportion to the
 * mass that it carries. For the cluster on the floor it follows from that mass and the floor's acceleration. */
static void search_stuck(search *s, int32_t j, int32_t i) {
    sp_lattice *l = s->l;
    int32_t top = j + 1;
    size_t stride = (size_t)l->stride;
    const double *c_top = top < l->movers ? l->c + top : zero; /* nothing rests on the uppermost cluster */
    size_t stride_top = top < l->movers ? stride : 0;
    double above = top < l->movers ? l->stiffness[top] : 0, below = j >= 0 ? l->stiffness[j] : 0;
    double carried = l->carried[i], share = j >= 0 ? carried * l->inverse_mass[j] : 0;
    double at_top = above * c_top[0], at_bottom = j >= 0 ? below * l->c[j] : at_top + carried * l->floor[0];
    double force = j >= 0 ? at_top + share * (at_bottom - at_top) : at_bottom;
    double reach_top = top < l->movers ? above * l->value[top] : 0;
    double reach =
        j >= 0 ? reach_top + share * (below * l->value[j] - reach_top) : reach_top + carried * s->reach_floor;
    double low = l->k * (1 - l->e) * l->delta[i] - l->slack[i], high = l->k * (1 + l->e) * l->delta[i] + l->slack[i];
    if (force - reach > low && force + reach < high)
        return;
    double f[LATTICE_ORDER + 1], g[LATTICE_ORDER + 1];
    for (int p = 0; p <= l->order; p++) {
        double upper = above * c_top[(size_t)p * stride_top];
        f[p] = j >= 0 ? upper + share * (below * l->c[(size_t)p * stride + (size_t)j] - upper)
                      : upper + carried * l->floor[p];
        g[p] = -f[p];
    }
    f[0] -= high;
    g[0] += low;
    if (force + reach >= high)
        keep_earlier(s, EVENT_SLIP, i, f, l->order);
    if (force - reach <= low)
        keep_earlier(s, EVENT_SLIP, i, g, l->order);
}

lattice_event sp_lattice_next_event(sp_lattice *l, double h) {
    search s = {l, {EVENT_NONE, -1, h}, 0};
    double power = h;
    for (int p = 1; l->floor_moves && p <= l->order; p++, power *= h)
        s.reach_floor += fabs(l->floor[p]) * power;
    find_reach(l, h);
    for (int32_t j = 0; j < l->movers; j++)
        search_mover(&s, j);
    for (int32_t j = -1; j < l->movers; j++)
        for (int32_t i = (j < 0 ? 0 : l->mover[j] + 1); i < l->mover[j + 1]; i++)
            search_stuck(&s, j, i);
    return s.best;
}
