/* Rigidity of the packing as it is, from motions that stretch no contact. Random vectors are projected on them; grains
 * that move as one body in eight of these move so in all of them. Random forces of the contacts are projected on those
 * that balance each other; a contact that has a part in these is redundant. */
#include "base/base.h"
#include "base/vector.h"
#include "elastic/rigid.h"
#include "linalg/ldl.h"
#include "network/rows.h"
#include "numeric/random.h"

#include <math.h>
#include <string.h>

/* Eigenvalues of B^T B below SOFT of the largest are those of motions that stretch nothing, those above FIRM are not.
 * Between is neither. Each pass leaves s/(s + lambda) of a motion that stretches something, of s = SOFT: a hundredth
 * or less. */
static const double SOFT = 1e-12, FIRM = 1e-10;
/* Differences of random motions, whose grains move by about 1, that are 0 but for rounding; and forces likewise. */
static const double NOTHING = 2e-6;
enum { LANES = SP_LDL_LANES, PASSES = 8, MOST = 8 };

typedef struct mover {
    sp_rigid *r;
    sp_network net; /* springs of stiffness 1 between grains and walls, which are grains behind the others */
    int32_t *row;   /* [n springs] of each of them its spring in r->net */
    sp_sparse k;
    sp_ldl *factor;
    double top;    /* the size of B^T B */
    double *v, *x; /* [LANES][dofs] random motions; solutions */
    double *force; /* [LANES][springs][MOST] random forces of the rows */
    bool *point;   /* [n] grains whose rotation nothing holds, so that they are points */
    int32_t *up;   /* union-find of grains and walls, then contacts */
} mover;

/* ---- the network of unit springs --------------------------------------------------------------------------------- */

/* Two lever arms together are as long as the contact, or grains that turn as one body would slip. They keep the ratio
 * of the radii, and at walls, which do not turn, the radius: so that a ring of grains that roll on each other, or on a
 * wall, like gears does not slip either. */
static sp_spring unit_spring(const sp_rigid *r, int32_t k) {
    sp_spring s = r->net->springs[k];
    const double shorter = s.j < 0 ? 1 : r->net->length[k] / (s.ri + s.rj);
    s.ri *= shorter;
    s.rj *= shorter;
    s.j = sp_rigid_end(r->net, &s);
    s.kn = 1;
    s.kt = r->bars[k] > 1;
    s.kp = 0;
    return s;
}

static sp_status make_network(mover *m, sp_error *err) {
    const sp_network *net = m->r->net;
    const size_t springs = (size_t)net->n_springs;
    m->net = (sp_network){.dim = net->dim, .dof = net->dof, .n = net->n + SP_RIGID_WALLS};
    m->net.springs = sp_alloc(springs, sizeof *m->net.springs);
    m->row = sp_alloc(springs, sizeof *m->row);
    m->point = sp_alloc((size_t)m->net.n, sizeof *m->point);
    m->up = sp_alloc((size_t)m->net.n + springs, sizeof *m->up);
    if (!m->net.springs || !m->row || !m->point || !m->up)
        return sp_fail_memory(err, springs * (sizeof *m->net.springs + 8));
    for (int32_t i = 0; i < m->net.n; i++)
        m->point[i] = i < net->n;
    for (int32_t k = 0; k < net->n_springs; k++) {
        if (m->r->bars[k] == 0)
            continue;
        m->row[m->net.n_springs] = k;
        const sp_spring s = m->net.springs[m->net.n_springs++] = unit_spring(m->r, k);
        for (int end = 0; end < 2 && s.kt > 0; end++)
            m->point[end ? s.j : s.i] = false;
    }
    m->net.n_bulk = m->net.n_springs;
    for (int32_t i = 0; i < m->net.n + net->n_springs; i++)
        m->up[i] = i;
    return SP_OK;
}

/* Walls do not turn, and those without springs do not move. */
static void hold_walls(const mover *m, sp_sparse *k) {
    const int dof = m->net.dof;
    for (int wall = 0; wall < SP_RIGID_WALLS; wall++)
        for (int a = m->r->used >> wall & 1 ? m->net.dim : 0; a < dof; a++)
            k->x[k->p[(int64_t)(m->r->net->n + wall) * dof + a]] = 1;
}

/* The size of K; of one without springs, 1. */
static double size_of(const sp_sparse *k) {
    double top = 1;
    for (int64_t c = 0; c < k->n; c++)
        top = fmax(top, k->x[k->p[c]]);
    return top;
}

static void draw(mover *m, uint64_t seed) {
    sp_random random = sp_random_make(seed, SP_STREAM_PROBE);
    for (int64_t k = 0; k < LANES * m->k.n; k++)
        m->v[k] = sp_random_normal(&random);
}

/* b -= (K - sigma) x. */
static void subtract(const sp_sparse *k, double sigma, const double *x, double *b) {
    for (int64_t c = 0; c < k->n; c++) {
        b[c] += sigma * x[c] - k->x[k->p[c]] * x[c];
        for (int64_t q = k->p[c] + 1; q < k->p[c + 1]; q++) {
            b[k->i[q]] -= k->x[q] * x[c];
            b[c] -= k->x[q] * x[k->i[q]];
        }
    }
}

/* Factors K - sigma. Its factor is that of K + E - sigma, and for a random b the solution x is mostly in the motions
 * near sigma: b - (K - sigma) x = E x tells the size of E there, where it matters. The bound of E for all motions,
 * sp_ldl_error, would refuse large networks. */
static sp_status factor_at(mover *m, double sigma, sp_error *err) {
    const int64_t n = m->k.n;
    double worst = 0;
    sp_status status = sp_ldl_factor(m->factor, sigma, err);
    if (status != SP_OK)
        return status;
    draw(m, 0);
    sp_ldl_solve(m->factor, m->v, m->x);
    for (int lane = 0; lane < LANES; lane++) {
        subtract(&m->k, sigma, m->x + lane * n, m->v + lane * n);
        worst = fmax(worst, sp_norm(n, m->v + lane * n) / sp_norm(n, m->x + lane * n));
    }
    if (worst <= 0.01 * fabs(sigma))
        return SP_OK;
    return sp_fail(err, SP_EREFUSED, "motions: rounding of %.2g does not tell eigenvalues of %.2g from 0", worst,
                   fabs(sigma));
}

static sp_status factor(mover *m, int64_t *still, sp_error *err) {
    int64_t firm = 0;
    sp_status status = sp_network_assemble(&m->net, &m->k, err);
    if (status != SP_OK)
        return status;
    hold_walls(m, &m->k);
    m->top = size_of(&m->k);
    m->v = sp_alloc_bare(2 * LANES * (size_t)m->k.n, sizeof *m->v);
    if (!m->v)
        return sp_fail_memory(err, 2 * LANES * (size_t)m->k.n * sizeof *m->v);
    m->x = m->v + LANES * m->k.n;
    status = sp_ldl_make(&m->k, NULL, &m->factor, err);
    if (status == SP_OK)
        status = factor_at(m, FIRM * m->top, err);
    if (status == SP_OK) {
        firm = sp_ldl_negative(m->factor);
        status = factor_at(m, SOFT * m->top, err);
    }
    if (status != SP_OK)
        return status;
    *still = sp_ldl_negative(m->factor);
    if (firm != *still)
        return sp_fail(err, SP_EREFUSED,
                       "motions: %lld stretch contacts so little that rounding does not tell them from %lld that "
                       "stretch none",
                       (long long)(firm - *still), (long long)*still);
    return factor_at(m, -SOFT * m->top, err);
}

/* ---- random vectors ---------------------------------------------------------------------------------------------- */

static void project_motions(mover *m) {
    draw(m, 1);
    for (int pass = 0; pass < PASSES; pass++) {
        sp_ldl_solve(m->factor, m->v, m->v);
        for (int64_t k = 0; k < LANES * m->k.n; k++)
            m->v[k] *= SOFT * m->top;
    }
}

/* f = B^T force, or with `back` force -= B f; of one lane. */
static void transform(const mover *m, bool back, double *force, double *f) {
    sp_rows rows;
    if (!back)
        memset(f, 0, (size_t)m->k.n * sizeof *f);
    for (int32_t k = 0; k < m->net.n_springs; k++) {
        const sp_spring *s = &m->net.springs[k];
        sp_network_rows(&m->net, s, &rows);
        for (int q = 0; q < rows.count; q++)
            for (int a = 0; a < rows.width; a++) {
                double *one = &force[(int64_t)k * MOST + q];
                double *two = &f[(int64_t)(a < m->net.dof ? s->i : s->j) * m->net.dof + a % m->net.dof];
                *(back ? one : two) += rows.b[q][a] * (back ? -*two : *one);
            }
    }
}

/* Random normal and tangential forces. */
static void start_forces(mover *m) {
    sp_random random = sp_random_make(2, SP_STREAM_PROBE);
    for (int64_t k = 0; k < (int64_t)LANES * m->net.n_springs; k++) {
        const sp_spring *s = &m->net.springs[k % m->net.n_springs];
        double side[3], *force = m->force + k * MOST;
        force[0] = sp_random_normal(&random);
        for (int a = 0; a < m->net.dim && s->kt > 0; a++)
            side[a] = sp_random_normal(&random);
        if (s->kt > 0 && m->net.dim == 3) { /* rows of the projector across the normal */
            const double off = dot3(side, s->n);
            for (int a = 0; a < 3; a++)
                force[1 + a] = side[a] - off * s->n[a];
        } else if (s->kt > 0)
            force[1] = side[0];
    }
}

static void project_forces(mover *m) {
    const int64_t n = m->k.n, forces = (int64_t)m->net.n_springs * MOST;
    start_forces(m);
    for (int pass = 0; pass < PASSES; pass++) {
        for (int lane = 0; lane < LANES; lane++)
            transform(m, false, m->force + lane * forces, m->v + lane * n);
        sp_ldl_solve(m->factor, m->v, m->v);
        for (int lane = 0; lane < LANES; lane++)
            transform(m, true, m->force + lane * forces, m->v + lane * n);
    }
}

/* ---- clusters ---------------------------------------------------------------------------------------------------- */

/* Whether a difference, as a sum of squares over all vectors, is none. */
static bool none(mover *m, double squares) {
    const double size = sqrt(squares / LANES);
    if (size <= NOTHING)
        m->r->equal = fmax(m->r->equal, size);
    else
        m->r->apart = fmin(m->r->apart, size);
    return size <= NOTHING;
}

static const double *motion(const mover *m, int lane, int32_t i) {
    return m->v + ((int64_t)lane * m->net.n + i) * m->net.dof;
}

/* The spin of a body as a vector; of a wall 0. */
static void spin_of(const mover *m, int lane, int32_t i, double spin[3]) {
    const double *v = motion(m, lane, i) + m->net.dim;
    const bool still = i >= m->r->net->n || m->net.dof == m->net.dim;
    spin[0] = still || m->net.dim == 2 ? 0 : v[0];
    spin[1] = still || m->net.dim == 2 ? 0 : v[1];
    spin[2] = still ? 0 : m->net.dim == 2 ? v[0] : v[2];
}

/* How much the centre of j moves against the body i, with the spin of i; `side` leads from i to j. And how much the
 * spins differ, times the distance. */
static void against(const mover *m, int32_t i, int32_t j, const double side[3], double *place, double *turn) {
    *place = *turn = 0;
    for (int lane = 0; lane < LANES; lane++) {
        double spin[3], other[3], arm[3];
        spin_of(m, lane, i, spin);
        spin_of(m, lane, j, other);
        cross3(spin, side, arm);
        for (int a = 0; a < 3; a++) {
            const double off = a < m->net.dim ? motion(m, lane, j)[a] - motion(m, lane, i)[a] - arm[a] : 0;
            *place += off * off;
            *turn += (other[a] - spin[a]) * (other[a] - spin[a]) * dot3(side, side);
        }
    }
}

static void join(mover *m, int32_t a, int32_t b) { m->up[sp_rigid_root(m->up, a)] = sp_rigid_root(m->up, b); }

/* What a contact moves with: a body that it belongs to; its own node, for two points in the plane, whose line has a
 * spin; or -1. */
static int32_t carrier(mover *m, int32_t k) {
    const sp_spring *s = &m->net.springs[k];
    const double length = m->r->net->length[m->row[k]];
    const double ahead[3] = {length * s->n[0], length * s->n[1], length * s->n[2]};
    const double back[3] = {-ahead[0], -ahead[1], -ahead[2]};
    double place, turn;
    if (m->point[s->i] && m->point[s->j])
        return m->net.dim == 2 ? m->net.n + m->row[k] : -1;
    if (m->point[s->i] || s->j >= m->r->net->n) /* as seen from a wall, which does not turn */
        against(m, s->j, s->i, back, &place, &turn);
    else
        against(m, s->i, s->j, ahead, &place, &turn);
    if (!none(m, place) || (!m->point[s->i] && !m->point[s->j] && !none(m, turn)))
        return -1;
    if (!m->point[s->i] && !m->point[s->j])
        join(m, s->i, s->j);
    return m->point[s->i] ? s->j : s->i;
}

/* The spin of what a contact moves with. */
static void carried_spin(const mover *m, int32_t k, int32_t by, int lane, double spin[3]) {
    const sp_spring *s = &m->net.springs[k];
    const double *i = motion(m, lane, s->i), *j = motion(m, lane, s->j);
    const double length = m->r->net->length[m->row[k]];
    if (by < m->net.n) {
        spin_of(m, lane, by, spin);
        return;
    }
    spin[0] = spin[1] = 0;
    spin[2] = (s->n[0] * (j[1] - i[1]) - s->n[1] * (j[0] - i[0])) / length;
}

/* Contacts of a point that turn about it alike belong together. first, next: lists of the contacts of points. */
static void join_at_points(mover *m, const int32_t *by, const int32_t *first, const int32_t *next) {
    for (int32_t i = 0; i < m->r->net->n; i++)
        for (int32_t a = first[i]; a >= 0; a = next[a])
            for (int32_t b = next[a]; b >= 0; b = next[b]) {
                double squares = 0;
                for (int lane = 0; lane < LANES; lane++) {
                    double one[3], two[3];
                    carried_spin(m, a / 2, by[a / 2], lane, one);
                    carried_spin(m, b / 2, by[b / 2], lane, two);
                    for (int c = 0; c < 3; c++)
                        squares += (one[c] - two[c]) * (one[c] - two[c]);
                }
                if (none(m, squares))
                    join(m, by[a / 2], by[b / 2]);
            }
}

static sp_status find_clusters(mover *m, sp_error *err) {
    const int32_t springs = m->net.n_springs;
    int32_t *by = sp_alloc(3 * (size_t)springs + (size_t)m->net.n, sizeof *by);
    if (!by)
        return sp_fail_memory(err, (3 * (size_t)springs + (size_t)m->net.n) * sizeof *by);
    int32_t *next = by + springs, *first = next + 2 * springs;
    for (int32_t i = 0; i < m->net.n; i++)
        first[i] = -1;
    for (int32_t k = 0; k < springs; k++) {
        by[k] = carrier(m, k);
        for (int end = 0; end < 2 && by[k] >= 0; end++) {
            const int32_t i = end ? m->net.springs[k].j : m->net.springs[k].i;
            if (m->point[i]) {
                next[2 * k + end] = first[i];
                first[i] = 2 * k + end;
            }
        }
    }
    join_at_points(m, by, first, next);
    for (int32_t k = 0; k < springs; k++) { /* what spins moves with none */
        const sp_spring *s = &m->net.springs[k];
        const bool spins = m->net.dof > m->net.dim && (m->point[s->i] || m->point[s->j]);
        if (by[k] >= 0 && !spins)
            m->r->label[m->row[k]] = sp_rigid_root(m->up, by[k]);
    }
    sp_free(by);
    return SP_OK;
}

static void find_redundant(mover *m) {
    const int64_t springs = m->net.n_springs;
    for (int32_t k = 0; k < springs; k++) {
        double squares = 0;
        for (int lane = 0; lane < LANES; lane++) {
            const double *force = m->force + (lane * springs + k) * MOST;
            squares += sp_dot(MOST, force, force);
        }
        m->r->redundant[m->row[k]] = !none(m, squares);
    }
}

/* ---- all ------------------------------------------------------------------------------------------------------- */

/* Motions of all as one body: turns only where neither walls nor periods stand against them. */
static int whole(const sp_rigid *r) {
    const sp_network *net = r->net;
    const bool turns = net->cell != SP_CELL_PERIODIC && net->cell != SP_CELL_PISTON && r->used == 0;
    return net->dim + (!turns ? 0 : net->dim == 3 ? 3 : 1);
}

static sp_status work(mover *m, sp_error *err) {
    int64_t still = 0, moves = (int64_t)m->r->net->n * m->net.dof;
    sp_status status = factor(m, &still, err);
    if (status != SP_OK)
        return status;
    for (int wall = 0; wall < SP_RIGID_WALLS; wall++)
        moves += m->r->used >> wall & 1 ? m->net.dim : 0;
    m->r->held = moves - still;
    m->r->floppy = still - whole(m->r);
    m->force = sp_alloc((size_t)LANES * (size_t)m->net.n_springs * MOST, sizeof *m->force);
    if (!m->force)
        return sp_fail_memory(err, (size_t)LANES * (size_t)m->net.n_springs * MOST * sizeof *m->force);
    project_forces(m);
    find_redundant(m);
    project_motions(m);
    return find_clusters(m, err);
}

sp_status sp_rigid_motions(sp_rigid *r, sp_error *err) {
    mover m = {.r = r};
    r->equal = 0;
    r->apart = INFINITY;
    sp_status status = make_network(&m, err);
    if (status == SP_OK)
        status = work(&m, err);
    sp_ldl_free(m.factor);
    sp_sparse_free(&m.k);
    sp_free(m.net.springs);
    sp_free(m.row);
    sp_free(m.point);
    sp_free(m.up);
    sp_free(m.v);
    sp_free(m.force);
    if (status == SP_OK && !(r->apart > 30 * r->equal))
        status = sp_fail(err, SP_EREFUSED,
                         "motions: differences of %.2g and %.2g are too near each other to tell rigid from soft",
                         r->equal, r->apart);
    return status;
}
