/* Decides which contacts stick. At w = 0, Filippov's solution asks for forces F_i within K delta_i (1 -+ e) such that
 * dw_i/dt is zero inside this band, positive at its lower end and negative at its upper end. Plot F against the mass x
 * carried: its slope is the acceleration of the particles plus g. The solution is therefore the taut string through a
 * tube, which touches the lower edge where it bends one way and the upper edge where it bends the other way. One pass
 * finds it for any N, without iteration. */
#include "tapped/lattice.h"

#include <math.h>
#include <string.h>

/* ---- the taut string -------------------------------------------------------------------------------------------- */

static void fill(const taut_ends *from, int32_t begin, int32_t end, double slope, const double *x, double *f) {
    for (int32_t k = begin; k < end; k++)
        f[k] = from->f0 + slope * (x[k] - from->x0);
}

void sp_taut_string(int32_t n, const double *x, const double *lo, const double *hi, const taut_ends *ends, double *f,
                    double *bend) {
    taut_ends knot = *ends; /* the string is final up to here */
    int32_t done = 0, turning = -1;
    double last = 0; /* slope of the last straight piece */
    for (int32_t k = 0; k < n; k++)
        bend[k] = 0;
    for (;;) {
        double most = INFINITY, least = -INFINITY, slope;
        int32_t at_most = -1, at_least = -1, k = done;
        bool over = false, under = false; /* the tube rises, or falls, more steeply than the string can follow */
        for (; k <= n; k++) {
            bool end = k == n, past = end && ends->free;
            double width = (end ? ends->x_end : x[k]) - knot.x0;
            double upper = past ? ends->slope_end : ((end ? ends->f_end : hi[k]) - knot.f0) / width;
            double lower = past ? ends->slope_end : ((end ? ends->f_end : lo[k]) - knot.f0) / width;
            over = lower > most;
            under = upper < least;
            if (over || under)
                break;
            if (upper <= most)
                most = upper, at_most = k;
            if (lower >= least)
                least = lower, at_least = k;
        }
        int32_t next = over ? at_most : under ? at_least : n;
        slope = under ? least : most;
        if (turning >= 0)
            bend[turning] = last - slope;
        fill(&knot, done, next, slope, x, f);
        if (next == n)
            return;
        f[next] = over ? hi[next] : lo[next];
        knot.x0 = x[next], knot.f0 = f[next];
        turning = next, last = slope, done = next + 1;
    }
}

/* ---- contacts --------------------------------------------------------------------------------------------------- */

/* A connected run of contacts low .. high with w = 0 and delta > 0; node k of the string is contact high - k. Rounding
 * must not decide: where a force lies on the edge of its band and the string does not bend, the rate of the force
 * decides. */
typedef struct run {
    sp_lattice *l;
    int32_t low, high, n;
    double *x, *lo, *hi, *f, *bend;
    double edge;     /* forces that differ by less count as equal */
    double straight; /* slopes that differ by less count as equal */
} run;

static bool rests(const sp_lattice *l, int32_t i) { return i >= 0 && i < l->n && l->w[i] == 0 && l->delta[i] > 0; }

/* Force of a moving contact (quantity: its overlap), or the rate of this force (quantity: the rate of the overlap). */
static double force_of(const sp_lattice *l, int32_t i, double quantity) {
    if (i >= l->n || l->state[i] == CONTACT_OPEN)
        return 0;
    return l->k * (l->state[i] == CONTACT_APPROACHING ? 1 + l->e : 1 - l->e) * quantity;
}

static run find_run(sp_lattice *l, int32_t at) {
    int32_t low = at, high = at;
    while (rests(l, low - 1))
        low--;
    while (rests(l, high + 1))
        high++;
    size_t stride = (size_t)l->stride;
    double *scratch = l->c + 3 * stride; /* free for use: the series are recomputed afterwards */
    run r = {.l = l, .low = low, .high = high, .n = high - low + 1};
    r.x = scratch;
    r.lo = scratch + stride;
    r.hi = scratch + 2 * stride;
    r.f = scratch + 3 * stride;
    r.bend = scratch + 4 * stride;
    double x = 0, lightest = low > 0 ? l->mass[low - 1] : INFINITY, most = l->weight;
    most = fmax(most, fabs(force_of(l, high + 1, high + 1 < l->n ? l->delta[high + 1] : 0)));
    if (low > 0)
        most = fmax(most, fabs(force_of(l, low - 1, l->delta[low - 1])));
    for (int32_t k = 0; k < r.n; k++) {
        int32_t i = high - k;
        x += l->mass[i];
        lightest = fmin(lightest, l->mass[i]);
        r.x[k] = x;
        r.lo[k] = l->k * (1 - l->e) * l->delta[i];
        r.hi[k] = l->k * (1 + l->e) * l->delta[i];
    }
    r.edge = 3e-13 * most;
    r.straight = 3e-12 * most / lightest;
    return r;
}

static taut_ends ends_of(const run *r, bool rates) {
    const sp_lattice *l = r->l;
    int32_t above = r->high + 1, below = r->low - 1;
    taut_ends e = {0, 0, r->low == 0, 0, 0, 0};
    if (above < l->n)
        e.f0 = force_of(l, above, rates ? -l->w[above] : l->delta[above]);
    if (e.free)
        e.slope_end = rates ? sp_lattice_floor_jerk(l) : sp_lattice_floor_acceleration(l) + l->g;
    else {
        e.x_end = r->x[r->n - 1] + l->mass[below];
        e.f_end = force_of(l, below, rates ? -l->w[below] : l->delta[below]);
    }
    return e;
}

static void set_state(sp_lattice *l, int32_t i, contact_state state, bool released, double slack) {
    l->state[i] = (unsigned char)state;
    l->released[i] = released;
    l->anchor[i] = l->delta[i];
    l->slack[i] = slack;
}

/* Decides by forces. Returns whether some contacts remain undecided: at the edge of their band with a straight string.
 */
static bool decide_by_forces(run *r) {
    taut_ends ends = ends_of(r, false);
    bool doubtful = false;
    sp_taut_string(r->n, r->x, r->lo, r->hi, &ends, r->f, r->bend);
    for (int32_t k = 0; k < r->n; k++) {
        int32_t i = r->high - k;
        bool bent = fabs(r->bend[k]) > r->straight;
        double slack = r->l->state[i] == CONTACT_STUCK ? fmax(r->l->slack[i], 0.1 * r->edge) : 0.1 * r->edge;
        set_state(r->l, i,
                  !bent            ? CONTACT_STUCK
                  : r->bend[k] < 0 ? CONTACT_APPROACHING
                                   : CONTACT_SEPARATING,
                  false, slack);
        bool at_high = r->f[k] >= r->hi[k] - r->edge, at_low = r->f[k] <= r->lo[k] + r->edge;
        doubtful = doubtful || (!bent && (at_high || at_low));
        r->lo[k] = bent || at_low ? 0 : -INFINITY; /* bounds of the rates */
        r->hi[k] = bent || at_high ? 0 : INFINITY;
        if (!bent && at_low && at_high) /* the band is as narrow as rounding: the contact sticks */
            r->lo[k] = -INFINITY, r->hi[k] = INFINITY;
    }
    return doubtful;
}

/* Decides by the rates of the forces where dw/dt = 0 leaves the direction open; then d2w/dt2 gives it. */
static void decide_by_rates(run *r) {
    sp_lattice *l = r->l;
    taut_ends ends = ends_of(r, true);
    sp_taut_string(r->n, r->x, r->lo, r->hi, &ends, r->f, r->bend);
    for (int32_t k = 0; k < r->n; k++) {
        int32_t i = r->high - k;
        if (l->state[i] == CONTACT_STUCK && fabs(r->bend[k]) > 1e-3 * r->straight * l->fastest)
            set_state(l, i, r->bend[k] < 0 ? CONTACT_APPROACHING : CONTACT_SEPARATING, true, 0);
    }
}

void sp_lattice_stick(sp_lattice *l, int32_t at, int32_t cause) {
    double slack = cause >= 0 ? l->slack[cause] : 0;
    run r = find_run(l, at);
    if (decide_by_forces(&r))
        decide_by_rates(&r);
    /* the force left its band by less than rounding: allow it to go a little further */
    if (cause >= 0 && l->state[cause] == CONTACT_STUCK)
        l->slack[cause] = 2 * slack;
}

/* ---- states of contacts ----------------------------------------------------------------------------------------- */

/* Finds the states of all contacts from their overlaps and opening velocities. */
static void classify(sp_lattice *l) {
    for (int32_t i = 0; i < l->n; i++) {
        bool closed = l->delta[i] > 0 || (l->delta[i] == 0 && l->w[i] < 0);
        l->state[i] = (unsigned char)(!closed                    ? CONTACT_OPEN
                                      : l->e == 0 || l->w[i] > 0 ? CONTACT_SEPARATING
                                                                 : CONTACT_APPROACHING);
        l->anchor[i] = l->delta[i];
        l->slack[i] = 0;
        l->released[i] = 0;
    }
    if (l->e > 0)
        for (int32_t i = 0; i < l->n; i++)
            if (l->w[i] == 0 && l->delta[i] > 0) {
                sp_lattice_stick(l, i, -1);
                while (i + 1 < l->n && l->w[i + 1] == 0 && l->delta[i + 1] > 0)
                    i++;
            }
    sp_lattice_find_clusters(l);
}

void sp_lattice_start(sp_lattice *l) {
    double above =
        0; /* summed from the top: differences from below would give each contact a rounding error of its own */
    for (int32_t i = l->n - 1; i >= 0; i--) {
        above += l->mass[i];
        l->delta[i] = l->spec->drop < 0 ? above * l->g / l->k : i == 0 ? -l->spec->drop : 0;
        l->w[i] = 0;
    }
    l->s = 0;
    l->floor_moves = false;
    classify(l);
}

void sp_lattice_set(sp_lattice *l, const double *overlap, const double *opening) {
    memcpy(l->delta, overlap, (size_t)l->n * sizeof *overlap);
    memcpy(l->w, opening, (size_t)l->n * sizeof *opening);
    classify(l);
}

void sp_lattice_get(const sp_lattice *l, double *overlap, double *opening) {
    memcpy(overlap, l->delta, (size_t)l->n * sizeof *overlap);
    memcpy(opening, l->w, (size_t)l->n * sizeof *opening);
}
