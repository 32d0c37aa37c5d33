/* Rigidity of the packing as it is, from motions that stretch no contact. Random vectors are projected on them; grains
 * that move as one body in eight of these move so in all of them. Random forces of the contacts are projected on those
 * that balance each other; a contact that has a part in these is redundant. */
#include "base/base.h"
#include "base/vector.h"
#include "elastic/mover.h"
#include "network/rows.h"
#include "numeric/random.h"

#include <math.h>
#include <string.h>

/* Eigenvalues of B^T B below SOFT of the largest are those of motions that stretch nothing, those above FIRM are not.
 * Between is neither. Each pass leaves s/(s + lambda) of a motion that stretches something, of s = SOFT: a hundredth
 * or less. */
static const double SOFT = 1e-12, FIRM = 1e-10;
enum { PASSES = 8, MOST = 8 };

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

static void find_redundant(mover *m) {
    const int64_t springs = m->net.n_springs;
    for (int32_t k = 0; k < springs; k++) {
        double squares = 0;
        for (int lane = 0; lane < LANES; lane++) {
            const double *force = m->force + (lane * springs + k) * MOST;
            squares += sp_dot(MOST, force, force);
        }
        m->r->redundant[m->row[k]] = !sp_mover_none(m, squares);
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
    return m->net.dim == 3 && m->net.dof == 3 ? sp_mover_hinges(m, err) : sp_mover_bodies(m, err);
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
