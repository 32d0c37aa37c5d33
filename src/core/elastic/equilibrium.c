/* Solves for the static equilibrium of a network between fixed walls. */
#include "elastic/equilibrium.h"

#include "base/base.h"
#include "network/spins.h"

#include <math.h>
#include <string.h>

sp_equilibrium sp_equilibrium_none(void) { return (sp_equilibrium){0}; }

void sp_equilibrium_free(sp_equilibrium *e) {
    sp_cholesky_free(e->factor);
    sp_lu_free(e->lu);
    sp_free(e->factored);
    sp_free(e->diagonal);
    sp_sparse_free(&e->k);
    sp_free(e->free_dofs);
    sp_free(e->work);
    *e = sp_equilibrium_none();
}

/* A wall's springs: their number and their total tangential stiffness. */
typedef struct wall_support {
    int32_t springs;
    double tangential;
} wall_support;

static wall_support support_of(const sp_network *net, int32_t wall) {
    wall_support h = {0, 0};
    for (int32_t k = net->n_bulk; k < net->n_springs; k++)
        if (net->springs[k].j == wall) {
            h.springs++;
            h.tangential += net->springs[k].kt;
        }
    return h;
}

/* Refuses a network in which no chain of springs connects the walls: it carries no stress. Marks grains reached from
 * the bottom until there are no more. Sweeps run in both directions, so that long chains take few sweeps. */
static sp_status check_connected(const sp_network *net, sp_error *err) {
    uint8_t *reached = sp_alloc((size_t)net->n, 1);
    bool more = true, top = false;
    if (!reached)
        return sp_fail_memory(err, (size_t)net->n);
    while (more && !top) {
        more = false;
        for (int32_t pass = 0; pass < 2 * net->n_springs; pass++) {
            const sp_spring *s = &net->springs[pass < net->n_springs ? pass : 2 * net->n_springs - 1 - pass];
            if (s->kn == 0)
                continue;
            if (s->j == SP_TOP) {
                top = top || reached[s->i];
            } else if (s->j == SP_BOTTOM) {
                more = more || !reached[s->i];
                reached[s->i] = 1;
            } else if (reached[s->i] != reached[s->j]) {
                reached[s->i] = reached[s->j] = 1;
                more = true;
            }
        }
    }
    sp_free(reached);
    return top ? SP_OK : sp_fail(err, SP_EREFUSED, "no chain of springs leads from wall to wall");
}

static sp_status check_network(const sp_network *net, sp_error *err) {
    const int32_t bottom = support_of(net, SP_BOTTOM).springs, top = support_of(net, SP_TOP).springs;
    if (bottom == 0 || top == 0)
        return sp_fail(err, SP_EREFUSED, "moduli need carrying contacts at both walls, there are %d and %d", bottom,
                       top);
    return check_connected(net, err);
}

/* The degree of freedom of column c of K. */
static int64_t dof_of(const sp_equilibrium *e, int64_t c) { return e->free_dofs ? e->free_dofs[c] : c; }

static double largest_diagonal(const sp_equilibrium *e) {
    double largest = 0;
    for (int64_t c = 0; c < e->k.n; c++)
        largest = fmax(largest, e->k.x[e->diagonal[c]]);
    return largest;
}

/* Fixes degrees of freedom that no strain can move, which changes no force: rotations without any tangential spring,
 * and, between walls without friction, the sideways position of the network, at its first grain. */
static void fix_free_motions(const sp_equilibrium *e) {
    const sp_network *net = e->net;
    const double largest = largest_diagonal(e);
    for (int64_t c = 0; c < e->k.n; c++) {
        const int64_t d = dof_of(e, c);
        if (d % net->dof >= net->dim && e->k.x[e->diagonal[c]] == 0)
            e->k.x[e->diagonal[c]] = largest;
    }
    for (int a = 0; a < net->dim - 1 && e->slips && !e->free_dofs; a++)
        e->k.x[e->diagonal[a]] += largest;
}

/* Floppy parts, such as a cluster with too few contacts, make K singular. K u = f still has a solution if f consists of
 * spring forces, since these do no work on a motion that stretches no spring; the stress is the same for all
 * solutions. So this fraction is added to the diagonal, and iterative refinement removes its effect. */
static const double SHIFT_SMALLEST = 1e-9;

static void shift_diagonal(const sp_equilibrium *e) {
    const double largest = largest_diagonal(e);
    for (int64_t c = 0; c < e->k.n; c++) {
        double *x = &e->k.x[e->diagonal[c]];
        if (e->shift_kind == SHIFT_DIAGONAL)
            *x += e->shift * (*x > 0 ? *x : largest);
        else if (e->shift_kind == SHIFT_MASS)
            *x += e->shift * e->net->mass[dof_of(e, c)];
    }
}

static sp_status factorize_symmetric(sp_equilibrium *e, sp_error *err) {
    sp_status status = SP_OK;
    if (!e->factor)
        status = sp_cholesky_analyze(&e->k, &e->factor, err);
    return status == SP_OK ? sp_cholesky_factorize(e->factor, &e->k, err) : status;
}

static sp_status factorize_whole(sp_equilibrium *e, sp_error *err) {
    const size_t entries = (size_t)e->k.p[e->k.n];
    sp_status status = SP_OK;
    if (!e->lu) {
        e->factored = sp_alloc(entries, sizeof *e->factored);
        status = e->factored ? sp_lu_make(e->k.n, e->k.p, e->k.i, false, &e->lu, err)
                             : sp_fail_memory(err, entries * sizeof *e->factored);
    }
    if (status != SP_OK)
        return status;
    memcpy(e->factored, e->k.x, entries * sizeof *e->factored);
    return sp_lu_factor(e->lu, e->factored, err);
}

/* Factors K with fixed motions and shift, then restores K's diagonal. */
static sp_status factorize(sp_equilibrium *e, sp_error *err) {
    double *before = e->work;
    for (int64_t c = 0; c < e->k.n; c++)
        before[c] = e->k.x[e->diagonal[c]];
    fix_free_motions(e);
    shift_diagonal(e);
    sp_status status = e->net->carried ? factorize_whole(e, err) : factorize_symmetric(e, err);
    for (int64_t c = 0; c < e->k.n; c++)
        e->k.x[e->diagonal[c]] = before[c];
    return status;
}

sp_status sp_equilibrium_apply(const sp_equilibrium *e, const double *b, double *x, sp_error *err) {
    return e->lu ? sp_lu_solve(e->lu, e->factored, e->transposed, b, x, err)
                 : sp_cholesky_solve(e->factor, 1, b, x, err);
}

/* Whether there are spheres with at most two contacts. One with two spins about the line through them; one with a
 * single contact has more free rotations. */
static sp_status has_spins(const sp_network *net, bool *out, sp_error *err) {
    sp_spin *spin;
    *out = false;
    sp_status status = sp_spins_make(net, &spin, err);
    for (int32_t i = 0; i < net->n && status == SP_OK && spin; i++)
        *out = *out || spin[i].springs < 3;
    sp_free(spin);
    return status;
}

/* Factors K itself if it is regular, else with a shift. */
static sp_status factorize_or_shift(sp_equilibrium *e, sp_error *err) {
    bool spins;
    sp_status status = has_spins(e->net, &spins, err);
    if (status == SP_OK && !spins)
        status = factorize(e, err);
    if ((status == SP_OK && spins) || status == SP_EREFUSED) {
        e->shift_kind = SHIFT_DIAGONAL;
        e->shift = e->net->carried ? SHIFT_NONSYMMETRIC : SHIFT_SMALLEST;
        status = factorize(e, err);
        if (status == SP_EREFUSED && e->net->prestress)
            sp_fail_prefix(err, "the network is unstable under its prestress");
    }
    return status;
}

/* An LU factor does not reveal instability. The eigenvalues of A are within `skew` of those of its symmetric part. If
 * that has none below -skew, the network is not obviously unstable. */
static sp_status check_stable(const sp_network *net, sp_error *err) {
    sp_sparse k = {0};
    sp_cholesky *factor = NULL;
    sp_status status = sp_network_assemble(net, &k, err);
    for (int64_t c = 0; c < k.n && status == SP_OK; c++)
        k.x[k.p[c]] += sp_network_skew(net) * net->mass[c];
    if (status == SP_OK)
        status = sp_cholesky_make(&k, &factor, err);
    if (status == SP_EREFUSED)
        sp_fail_prefix(err, "the network is unstable under its prestress");
    sp_cholesky_free(factor);
    sp_sparse_free(&k);
    return status;
}

static sp_status allocate(sp_equilibrium *e, sp_error *err) {
    const size_t size = 2 * (size_t)sp_network_dofs(e->net) + 2 * (size_t)e->count;
    e->work = sp_alloc(size, sizeof *e->work);
    e->diagonal = sp_alloc((size_t)e->count, sizeof *e->diagonal);
    if (!e->work || !e->diagonal)
        return sp_fail_memory(err, size * sizeof *e->work);
    for (int64_t c = 0; c < e->k.n; c++)
        for (int64_t q = e->k.p[c]; q < e->k.p[c + 1]; q++)
            if (e->k.i[q] == c)
                e->diagonal[c] = q;
    return SP_OK;
}

sp_status sp_equilibrium_make(const sp_network *net, sp_equilibrium *out, sp_error *err) {
    sp_equilibrium e = {.net = net, .count = sp_network_dofs(net)};
    sp_status status = check_network(net, err);
    if (status != SP_OK)
        return status;
    const double bottom = support_of(net, SP_BOTTOM).tangential, top = support_of(net, SP_TOP).tangential;
    e.slips = net->dim > 1 && bottom == 0 && top == 0;
    e.grips = bottom > 0 && top > 0;
    if (net->carried)
        status = check_stable(net, err);
    if (status == SP_OK)
        status = net->carried ? sp_network_assemble_whole(net, &e.k, err) : sp_network_assemble(net, &e.k, err);
    if (status == SP_OK)
        status = allocate(&e, err);
    if (status == SP_OK)
        status = factorize_or_shift(&e, err);
    if (status == SP_OK)
        *out = e;
    else
        sp_equilibrium_free(&e);
    return status;
}

sp_status sp_equilibrium_shift(sp_equilibrium *e, equilibrium_shift kind, double fraction, sp_error *err) {
    double fastest = 0;
    for (int64_t c = 0; c < e->k.n; c++)
        fastest = fmax(fastest, e->k.x[e->diagonal[c]] / e->net->mass[dof_of(e, c)]);
    e->shift_kind = kind;
    e->shift = fmax(fraction, SHIFT_SMALLEST) * (kind == SHIFT_MASS ? fastest : 1);
    return factorize(e, err);
}

/* Extracts the rows and columns of K that are not fixed. */
static sp_status extract_free(const sp_sparse *k, const uint8_t *fixed, sp_equilibrium *e, sp_error *err) {
    const size_t n = (size_t)k->n, entries = (size_t)k->p[k->n];
    int64_t *to = sp_alloc(n, sizeof *to), at = 0;
    e->free_dofs = sp_alloc(n, sizeof *e->free_dofs);
    e->k.p = sp_alloc(n + 1, sizeof *e->k.p);
    e->k.i = sp_alloc(entries, sizeof *e->k.i);
    e->k.x = sp_alloc(entries, sizeof *e->k.x);
    if (!to || !e->free_dofs || !e->k.p || !e->k.i || !e->k.x) {
        sp_free(to);
        return sp_fail_memory(err, 24 * n + 16 * entries);
    }
    for (int64_t c = 0; c < k->n; c++)
        if (!fixed[c]) {
            to[c] = e->count;
            e->free_dofs[e->count++] = c;
        }
    for (int64_t c = 0; c < e->count; c++) {
        const int64_t column = e->free_dofs[c];
        for (int64_t q = k->p[column]; q < k->p[column + 1]; q++)
            if (!fixed[k->i[q]]) {
                e->k.i[at] = to[k->i[q]];
                e->k.x[at++] = k->x[q];
            }
        e->k.p[c + 1] = at;
    }
    e->k.n = e->count;
    sp_free(to);
    return SP_OK;
}

sp_status sp_equilibrium_restrict(const sp_equilibrium *whole, const uint8_t *fixed, sp_equilibrium *out,
                                  sp_error *err) {
    sp_equilibrium e = {.net = whole->net, .slips = whole->slips, .grips = whole->grips};
    sp_status status = extract_free(&whole->k, fixed, &e, err);
    if (status == SP_OK)
        status = allocate(&e, err);
    if (status == SP_OK && e.count > 0)
        status = factorize_or_shift(&e, err);
    if (status == SP_OK)
        *out = e;
    else
        sp_equilibrium_free(&e);
    return status;
}

double sp_equilibrium_residual(sp_equilibrium *e, const double *f, const double *u, double *rest) {
    const int64_t n = sp_network_dofs(e->net);
    double *ku = e->work, sum = 0;
    if (e->transposed)
        sp_network_apply_transposed(e->net, u, ku);
    else
        sp_network_apply(e->net, u, ku);
    if (e->free_dofs)
        memset(rest, 0, (size_t)n * sizeof *rest);
    for (int64_t c = 0; c < e->count; c++) {
        const int64_t d = dof_of(e, c);
        rest[d] = f[d] - ku[d];
        sum += rest[d] * rest[d];
    }
    return sqrt(sum);
}

sp_status sp_equilibrium_solve(sp_equilibrium *e, const double *f, double *u, double *residual, sp_error *err) {
    enum { PASSES_MAX = 60 };
    const int64_t n = sp_network_dofs(e->net);
    double *rest = e->work + n, *right = e->work + 2 * n, *more = right + e->count, before;
    int pass = 0;
    *residual = sp_equilibrium_residual(e, f, u, rest);
    if (e->count == 0)
        return SP_OK;
    do {
        before = *residual;
        for (int64_t c = 0; c < e->count; c++)
            right[c] = rest[dof_of(e, c)];
        sp_status status = sp_equilibrium_apply(e, right, more, err);
        if (status != SP_OK)
            return status;
        for (int64_t c = 0; c < e->count; c++)
            u[dof_of(e, c)] += more[c];
        *residual = sp_equilibrium_residual(e, f, u, rest);
    } while (++pass < 2 || (*residual < 0.5 * before && pass < PASSES_MAX));
    return SP_OK;
}
