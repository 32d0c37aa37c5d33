/* Which contacts move as one rigid body: of grains with spins, of walls, and of points in the plane. */
#include "base/base.h"
#include "base/vector.h"
#include "elastic/mover.h"

/* The spin of a body as a vector; of a wall 0. */
static void spin_of(const mover *m, int lane, int32_t i, double spin[3]) {
    const double *v = sp_mover_motion(m, lane, i) + m->net.dim;
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
            const double off =
                a < m->net.dim ? sp_mover_motion(m, lane, j)[a] - sp_mover_motion(m, lane, i)[a] - arm[a] : 0;
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
    if (!sp_mover_none(m, place) || (!m->point[s->i] && !m->point[s->j] && !sp_mover_none(m, turn)))
        return -1;
    if (!m->point[s->i] && !m->point[s->j])
        join(m, s->i, s->j);
    return m->point[s->i] ? s->j : s->i;
}

/* The spin of what a contact moves with. */
static void carried_spin(const mover *m, int32_t k, int32_t by, int lane, double spin[3]) {
    const sp_spring *s = &m->net.springs[k];
    const double *i = sp_mover_motion(m, lane, s->i), *j = sp_mover_motion(m, lane, s->j);
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
                if (sp_mover_none(m, squares))
                    join(m, by[a / 2], by[b / 2]);
            }
}

sp_status sp_mover_bodies(mover *m, sp_error *err) {
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
