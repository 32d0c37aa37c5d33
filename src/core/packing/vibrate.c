/* Nonlinear motion of a packing about its rest state. */
#include "packing/vibrate.h"

#include "base/base.h"
#include "base/vector.h"
#include "packing/contact.h"
#include "packing/geometry.h"

#include <math.h>
#include <string.h>

/* Width of watched gaps, in units of the smallest radius. */
#define REACH 0.4

void sp_vibration_free(vibration *m) {
    sp_free(m->touch);
    sp_free(m->u);
    *m = (vibration){0};
}

/* ---- what touches -------------------------------------------------------------------------------------------- */

typedef struct survey {
    const sp_packing *p;
    vibration *m;
    size_t capacity; /* of m->touch */
    bool narrow;     /* the sweep may visit a pair twice: it reaches half around a periodic cell */
} survey;

/* Fills in everything that follows from i, j and the overlap. */
static void complete(const survey *s, touching *t) {
    const sp_packing *p = s->p;
    const double ri = p->r[t->i], mi = s->m->mass[2 * (int64_t)t->i];
    const bool wall = t->j < 0;
    t->arm_i = ri;
    t->arm_j = wall ? 0 : p->r[t->j];
    t->e = contact_stiffness_in(p, t->i, t->j);
    t->m_eff = wall ? mi : mi / (mi + s->m->mass[2 * (int64_t)t->j]) * s->m->mass[2 * (int64_t)t->j];
    t->length = ri + t->arm_j - t->overlap;
    t->fn0 = t->overlap > 0 ? contact_force(t->e, t->overlap) : 0;
}

static sp_status add(survey *s, touching t, sp_error *err) {
    vibration *m = s->m;
    const size_t need = (size_t)m->count + 1;
    touching *touch = need <= INT32_MAX ? sp_grow(m->touch, need, &s->capacity, sizeof *touch) : NULL;
    if (!touch)
        return sp_fail_memory(err, need * sizeof *touch);
    m->touch = touch;
    complete(s, &t);
    m->touch[m->count++] = t;
    return SP_OK;
}

static sp_status add_contacts(survey *s, sp_error *err) {
    sp_status status = SP_OK;
    for (int32_t c = 0; c < s->p->n_contacts && status == SP_OK; c++) {
        const sp_contact *from = &s->p->contacts[c];
        touching t = {.i = from->i, .j = from->j, .overlap = from->overlap};
        for (int a = 0; a < 3; a++) {
            t.n0[a] = from->n[a];
            t.ft0[a] = s->m->turns && from->overlap > 0 ? from->ft[a] : 0;
        }
        status = add(s, t, err);
    }
    return status;
}

static bool is_watched(const survey *s, int32_t i, int32_t j) {
    for (int32_t k = s->p->n_contacts; s->narrow && k < s->m->count; k++)
        if (s->m->touch[k].i == i && s->m->touch[k].j == j)
            return true;
    return false;
}

static bool is_narrow(const sp_packing *p, double reach) {
    double largest = 0;
    for (int32_t i = 0; i < p->n; i++)
        largest = fmax(largest, p->r[i]);
    return p->cell == SP_CELL_PERIODIC && sp_packing_height(p) <= 4 * largest + 2 * reach;
}

/* Adds a pair, or a grain and a wall, that is no contact but closer than the watched gap. */
static sp_status add_gap(int32_t i, int32_t j, void *user, sp_error *err) {
    survey *s = user;
    const sp_packing *p = s->p;
    touching t = {.i = i, .j = j};
    double r = 1;
    if (j < 0) {
        t.overlap = p->r[i] - sp_packing_wall_distance(p, i, j);
        t.n0[sp_packing_wall_axis(p, j)] = sp_packing_wall_side(j);
    } else {
        sp_packing_separation(p, i, j, t.n0);
        r = length3(t.n0);
        t.overlap = p->r[i] + p->r[j] - r;
    }
    if (!(t.overlap > -s->m->reach && r > 0) || sp_packing_has_contact(p, i, j) || is_watched(s, i, j))
        return SP_OK;
    t.overlap = fmin(t.overlap, 0); /* an unlisted pair is open at rest */
    for (int a = 0; a < 3 && j >= 0; a++)
        t.n0[a] /= r;
    return add(s, t, err);
}

sp_status sp_vibration_make(const sp_packing *p, double damping, vibration *out, sp_error *err) {
    return sp_vibration_make_wide(p, damping, REACH, out, err);
}

sp_status sp_vibration_make_wide(const sp_packing *p, double damping, double radii, vibration *out, sp_error *err) {
    vibration m = {.dim = p->dim, .n = p->n, .damping = damping, .reach = INFINITY};
    survey s = {.p = p, .m = &m};
    const size_t n = (size_t)p->n;
    sp_status status = sp_packing_need_law(p, "motion at a finite amplitude", err);
    if (status != SP_OK)
        return status;
    m.turns = p->dim > 1 && p->friction > 0;
    m.friction = m.turns ? p->friction : 0;
    m.eta = m.turns ? contact_eta(p->poisson) : 0;
    m.u = sp_alloc(26 * n, sizeof *m.u); /* and the arrays behind it */
    if (!m.u)
        return sp_fail_memory(err, 26 * n * sizeof *m.u);
    m.v = m.u + 6 * n;
    m.a = m.v + 6 * n;
    m.now = m.a + 6 * n;
    m.mass = m.now + 6 * n;
    for (size_t i = 0; i < n; i++) {
        m.mass[2 * i] = grain_mass(p->r[i]);
        m.mass[2 * i + 1] = 0.4 * m.mass[2 * i] * p->r[i] * p->r[i];
        m.reach = fmin(m.reach, radii * p->r[i]);
    }
    s.narrow = is_narrow(p, m.reach);
    status = add_contacts(&s, err);
    if (status == SP_OK)
        status = sp_packing_sweep(p, m.reach, add_gap, &s, err);
    if (status == SP_OK) {
        sp_vibration_rest(&m);
        *out = m;
    } else {
        sp_vibration_free(&m);
    }
    return status;
}

void sp_vibration_rest(vibration *m) {
    const size_t bytes = 6 * (size_t)m->n * sizeof *m->u;
    memset(m->u, 0, bytes);
    memset(m->v, 0, bytes);
    memset(m->a, 0, bytes);
    if (m->work)
        memset(m->work, 0, (size_t)m->count * sizeof *m->work);
    for (int32_t k = 0; k < m->count; k++) {
        touching *t = &m->touch[k];
        memcpy(t->n, t->n0, sizeof t->n);
        memset(t->ft, 0, sizeof t->ft);
        memset(t->force, 0, sizeof t->force);
        t->fn = 0;
        t->held = 1;
        t->kn = t->overlap > 0 ? contact_normal_stiffness(t->e, t->overlap) : 0;
    }
}

/* ---- forces -------------------------------------------------------------------------------------------------- */

/* For u or v: the translation of j minus that of i, and the rotations of i and j times their radii, added. */
static void relative(const touching *t, const double *of, double d[3], double turn[3]) {
    const double *x = of + 6 * (int64_t)t->i, *y = t->j >= 0 ? of + 6 * (int64_t)t->j : NULL;
    for (int a = 0; a < 3; a++) {
        d[a] = (y ? y[a] : 0) - x[a];
        turn[a] = t->arm_i * x[3 + a] + (y ? t->arm_j * y[3 + a] : 0);
    }
}

/* Updates normal, overlap and normal force for the current u. False for an open contact. */
static bool place(const vibration *m, touching *t, double change[3]) {
    double d[3], turn[3], n[3], stretch = 0, r = 0, overlap;
    relative(t, m->u, d, turn);
    for (int a = 0; a < 3; a++)
        d[a] += t->shift[a];
    if (t->j < 0 || m->straight) { /* planes and straight springs have a fixed normal */
        stretch = dot3(t->n0, d);
        memcpy(n, t->n0, sizeof n);
    } else {
        const double along = dot3(t->n0, d), square = dot3(d, d);
        r = sqrt(t->length * t->length + 2 * t->length * along + square);
        stretch = (2 * t->length * along + square) / (r + t->length);
        for (int a = 0; a < 3; a++)
            n[a] = t->n0[a] + (d[a] - t->n0[a] * stretch) / r;
    }
    for (int a = 0; a < 3; a++) {
        change[a] = n[a] - t->n[a];
        t->n[a] = n[a];
    }
    overlap = t->overlap - stretch;
    if (!(overlap > 0)) {
        t->kn = 0;
        t->fn = -t->fn0;
        return false;
    }
    /* f(overlap) - f(rest), without a difference of large numbers */
    const double rest = fmax(0, t->overlap), delta = t->overlap > 0 ? -stretch : overlap;
    t->fn = 4.0 / 3.0 * t->e * delta * (overlap * overlap + overlap * rest + rest * rest) /
            (overlap * sqrt(overlap) + rest * sqrt(rest));
    t->kn = contact_normal_stiffness(t->e, overlap);
    return true;
}

/* Work over a step in which the tangential force was `before` and would have become `whole` without sliding; s is the
 * tangential displacement. The mean of the forces at both ends is of second order in the step. */
static void keep_work(const touching *t, spring_work *w, const double before[3], const double whole[3],
                      const double s[3], double kt) {
    for (int a = 0; a < 3; a++) {
        const double force = 0.5 * (before[a] + t->held * whole[a]);
        const double slide = kt > 0 ? (1 - t->held) * whole[a] / kt : 0;
        w->whole += force * s[a];
        w->slid += force * slide;
        w->carried += t->ft0[a] * (s[a] - slide);
    }
}

/* Tangential spring over a step: turns with the contact, stretches by the slip `moved` (relative displacement and
 * rotation), and slides at Coulomb's limit. */
static void drag(vibration *m, touching *t, double kn_old, const double change[3], const double moved[3],
                 const double turn[3], double twist) {
    double n[3], arm[3], whole[3], side[3], off = 0, size = 0;
    for (int a = 0; a < 3; a++) {
        n[a] = t->n[a] - 0.5 * change[a];
        whole[a] = t->ft0[a] + t->ft[a];
    }
    const double kt = 0.5 * m->eta * (kn_old + t->kn), along = dot3(moved, n), tilt = dot3(whole, change);
    cross3(turn, n, arm);
    cross3(n, whole, side);
    for (int a = 0; a < 3; a++)
        t->ft[a] += -tilt * n[a] + 0.5 * twist * side[a] + kt * (moved[a] - along * n[a] - arm[a]);
    for (int a = 0; a < 3; a++) /* (ft0 + ft) . n, and ft0 . n0 = 0 */
        off += t->ft0[a] * (t->n[a] - t->n0[a]) + t->ft[a] * t->n[a];
    for (int a = 0; a < 3; a++) {
        t->ft[a] -= off * t->n[a];
        size += (t->ft0[a] + t->ft[a]) * (t->ft0[a] + t->ft[a]);
    }
    size = sqrt(size);
    const double limit = m->friction * (t->fn0 + t->fn);
    t->held = size > limit ? limit / size : 1;
    if (m->work) {
        double s[3], free[3];
        for (int a = 0; a < 3; a++) {
            s[a] = moved[a] - along * n[a] - arm[a];
            free[a] = t->ft0[a] + t->ft[a];
        }
        keep_work(t, &m->work[t - m->touch], whole, free, s, kt);
    }
    if (size > limit)
        for (int a = 0; a < 3; a++)
            t->ft[a] = t->ft[a] * (limit / size) + t->ft0[a] * (limit / size - 1);
}

/* Updates all contacts for the current u. Tangential springs follow h times `path`, the velocity during the step. For
 * an initial displacement h = 1, `path` is u itself, and `shifted` = 1 adds the shifts. */
static void follow(vibration *m, const double *path, double h, double shifted) {
    for (int32_t k = 0; k < m->count; k++) {
        touching *t = &m->touch[k];
        double change[3], moved[3], turn[3];
        const double kn_old = t->kn;
        if (!place(m, t, change)) {
            for (int a = 0; a < 3; a++)
                t->ft[a] = -t->ft0[a];
            continue;
        }
        if (!m->turns)
            continue;
        relative(t, path, moved, turn);
        double twist = path[6 * (int64_t)t->i + 3] * t->n[0] + path[6 * (int64_t)t->i + 4] * t->n[1] +
                       path[6 * (int64_t)t->i + 5] * t->n[2];
        if (t->j >= 0)
            twist += path[6 * (int64_t)t->j + 3] * t->n[0] + path[6 * (int64_t)t->j + 4] * t->n[1] +
                     path[6 * (int64_t)t->j + 5] * t->n[2];
        for (int a = 0; a < 3; a++) {
            moved[a] = h * moved[a] + shifted * t->shift[a];
            turn[a] *= h;
        }
        drag(m, t, kn_old, change, moved, turn, m->straight ? 0 : h * twist);
    }
}

/* Coefficient of the normal dashpot of a closed contact. */
static double dashpot(const vibration *m, const touching *t) {
    if (m->damping_kind == SP_DAMPING_ZETA)
        return 2 * m->damping * sqrt(t->m_eff * t->kn);
    return m->damping_kind == SP_DAMPING_MASS ? m->damping * t->m_eff : m->damping;
}

/* Change of the force on i, including dashpots. The total normal force is never attractive; the viscous tangential
 * force has no limit. `side` is the change of the total tangential force. */
static void press(const vibration *m, touching *t, double side[3]) {
    double normal = t->fn, v[3], turn[3], arm[3];
    memcpy(side, t->ft, sizeof t->ft);
    if (m->damping > 0 && t->kn > 0) {
        const double c = dashpot(m, t), ct = c * (m->damping_kind == SP_DAMPING_ZETA ? sqrt(m->eta) : m->damping_ratio);
        const bool sides = m->turns || (m->damping_kind != SP_DAMPING_ZETA && m->dim > 1);
        relative(t, m->now, v, turn);
        const double along = dot3(v, t->n);
        cross3(turn, t->n, arm);
        normal = fmax(-t->fn0, t->fn - c * along);
        for (int a = 0; a < 3 && sides; a++)
            side[a] += ct * (v[a] - along * t->n[a] - arm[a]);
    }
    for (int a = 0; a < 3; a++)
        t->force[a] = side[a] - normal * t->n[a] - t->fn0 * (t->n[a] - t->n0[a]);
}

static void accelerate(vibration *m) {
    memset(m->a, 0, 6 * (size_t)m->n * sizeof *m->a);
    for (int32_t k = 0; k < m->count; k++) {
        touching *t = &m->touch[k];
        double side[3], lean[3], one[3], two[3];
        if (t->kn == 0 && t->fn0 == 0) {
            memset(t->force, 0, sizeof t->force);
            continue;
        }
        press(m, t, side);
        for (int a = 0; a < 3; a++)
            lean[a] = t->n[a] - t->n0[a];
        cross3(t->n, side, one); /* n x (ft0 + side) - n0 x ft0 */
        cross3(lean, t->ft0, two);
        double *i = m->a + 6 * (int64_t)t->i, *j = t->j >= 0 ? m->a + 6 * (int64_t)t->j : NULL;
        for (int a = 0; a < 3; a++) {
            i[a] += t->force[a];
            i[3 + a] += t->arm_i * (one[a] + two[a]);
            if (j) {
                j[a] -= t->force[a];
                j[3 + a] += t->arm_j * (one[a] + two[a]);
            }
        }
    }
    for (int64_t i = 0; i < m->n; i++)
        for (int a = 0; a < 3; a++) {
            m->a[6 * i + a] /= m->mass[2 * i];
            m->a[6 * i + 3 + a] = m->turns ? m->a[6 * i + 3 + a] / m->mass[2 * i + 1] : 0;
        }
}

void sp_vibration_begin(vibration *m) {
    follow(m, m->u, 1, 1);
    memcpy(m->now, m->v, 6 * (size_t)m->n * sizeof *m->v);
    accelerate(m);
}

void sp_vibration_step(vibration *m, double h) {
    const int64_t n = 6 * (int64_t)m->n;
    for (int64_t k = 0; k < n; k++) {
        m->v[k] += 0.5 * h * m->a[k];
        m->u[k] += h * m->v[k];
        m->now[k] = m->v[k] + 0.5 * h * m->a[k]; /* velocity at the dashpots, of second order */
    }
    follow(m, m->v, h, 0);
    accelerate(m);
    for (int64_t k = 0; k < n; k++)
        m->v[k] += 0.5 * h * m->a[k];
}

bool sp_vibration_sane(const vibration *m) {
    double worst = 0;
    for (int64_t i = 0; i < m->n; i++) {
        const double square = dot3(m->u + 6 * i, m->u + 6 * i);
        if (!isfinite(square))
            return false;
        worst = fmax(worst, square);
    }
    return 4 * worst <= m->reach * m->reach;
}
