/* Solves for the static equilibrium of a network between fixed walls, or in a periodic cell. */
#include "base/base.h"
#include "base/vector.h"
#include "elastic/equilibrium.h"
#include "elastic/strain.h"
#include "linalg/krylov.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static void apply_stiffness(const sp_equilibrium *e, const double *u, double *out) {
    if (e->transposed)
        sp_network_apply_transposed(e->net, u, out);
    else
        sp_network_apply(e->net, u, out);
}

double sp_equilibrium_residual(sp_equilibrium *e, const double *f, const double *u, double *rest) {
    const int64_t n = sp_network_dofs(e->net);
    double *ku = e->work, sum = 0;
    apply_stiffness(e, u, ku);
    if (e->free_dofs)
        memset(rest, 0, (size_t)n * sizeof *rest);
    for (int64_t c = 0; c < e->count; c++) {
        const int64_t d = sp_equilibrium_dof(e, c);
        rest[d] = f[d] - ku[d];
        sum += rest[d] * rest[d];
    }
    return sqrt(sum);
}

void sp_equilibrium_add_spins(const sp_equilibrium *e, double factor, const double *in, double *out) {
    for (int32_t s = 0; s < e->spins; s++) {
        const equilibrium_spin *spin = &e->spin[s];
        const double force = factor * sp_dot(spin->width, spin->push, in + spin->column);
        for (int a = 0; a < spin->width; a++)
            out[spin->column + a] += force * spin->push[a];
    }
}

/* K over the free degrees of freedom, with the springs that hold spins. */
static void apply_free(void *with, const double *in, double *out) {
    sp_equilibrium *e = with;
    const int64_t n = sp_network_dofs(e->net);
    double *u = e->work, *ku = u + n;
    if (!e->free_dofs) {
        apply_stiffness(e, in, out);
    } else {
        memset(u, 0, (size_t)n * sizeof *u);
        for (int64_t c = 0; c < e->count; c++)
            u[e->free_dofs[c]] = in[c];
        apply_stiffness(e, u, ku);
        for (int64_t c = 0; c < e->count; c++)
            out[c] = ku[e->free_dofs[c]];
    }
    sp_equilibrium_add_spins(e, 1, in, out);
}

static void precondition(void *with, const double *in, double *out) { sp_equilibrium_apply(with, in, out); }

/* The residual over the free degrees of freedom, with the springs that hold spins, and its norm. work: [count]. */
static double residual_of(sp_equilibrium *e, const double *f, const double *u, double *work, double *out) {
    double *rest = e->work + sp_network_dofs(e->net);
    sp_equilibrium_residual(e, f, u, rest);
    for (int64_t c = 0; c < e->count; c++) {
        work[c] = u[sp_equilibrium_dof(e, c)];
        out[c] = rest[sp_equilibrium_dof(e, c)];
    }
    sp_equilibrium_add_spins(e, -1, work, out);
    return sp_norm(e->count, out);
}

double sp_equilibrium_spin_work(const sp_equilibrium *e, const double *rest, double least, const double *u) {
    double sum = 0;
    for (int32_t s = 0; s < e->spins; s++) {
        const equilibrium_spin *spin = &e->spin[s];
        const int64_t d = sp_equilibrium_dof(e, spin->column);
        sum += fabs(sp_dot(spin->width, spin->motion, rest + d)) * fmax(least, sp_norm(spin->width, u + d));
    }
    return sum;
}

const double *sp_equilibrium_spin_rest(sp_equilibrium *e, const double *f, const double *w) {
    double *rest = e->work + sp_network_dofs(e->net);
    if (e->spins == 0)
        return NULL;
    e->transposed = true;
    sp_equilibrium_residual(e, f, w, rest);
    e->transposed = false;
    return rest;
}

/* Size of the rounding errors in f - K u. */
static double rounding_of(sp_equilibrium *e, double scale, const double *u) {
    double *size = e->work, sum = 0;
    sp_strain_rounding(e->net, -1, u, size, NULL);
    for (int64_t c = 0; c < e->count; c++)
        sum += size[sp_equilibrium_dof(e, c)] * size[sp_equilibrium_dof(e, c)];
    return DBL_EPSILON * (sqrt(sum) + scale);
}

static void add(const sp_equilibrium *e, double factor, const double *more, double *u) {
    for (int64_t c = 0; c < e->count; c++)
        u[sp_equilibrium_dof(e, c)] += factor * more[c];
}

/* K itself was factored: iterative refinement, at least two steps. */
static void refine(sp_equilibrium *e, const double *f, double *u) {
    enum { PASSES_MAX = 60 };
    double *right = e->work + 2 * sp_network_dofs(e->net), *more = right + e->count;
    double now = residual_of(e, f, u, more, right), before;
    int pass = 0;
    do {
        before = now;
        sp_equilibrium_apply(e, right, more);
        add(e, 1, more, u);
        now = residual_of(e, f, u, more, right);
    } while (++pass < 2 || (now < 0.5 * before && pass < PASSES_MAX));
}

/* Motions with less stiffness than this fraction of the diagonal are not resisted. In rounding errors they have 1e-16.
 */
static const double NOTHING = 1e-14;

/* What was added to the diagonal of column c. */
static double shift_of(const sp_equilibrium *e, int64_t c) {
    return e->shift * (e->shift_kind == SHIFT_MASS ? e->net->mass[sp_equilibrium_dof(e, c)] : e->k.x[e->k.p[c]]);
}

/* load = S F^-1 load, where S is the shift and F = K + S: keeps what acts on floppy motions, and little else. motion =
 * F^-1 load, [count]. */
static void keep_floppy(const sp_equilibrium *e, double *load, double *motion) {
    sp_equilibrium_apply(e, load, motion);
    for (int64_t c = 0; c < e->count; c++)
        load[c] = shift_of(e, c) * motion[c];
}

/* Whether K does not resist the motion. image: [count] scratch. */
static bool is_floppy(sp_equilibrium *e, const double *motion, double *image) {
    double threshold = 0;
    apply_free(e, motion, image);
    for (int64_t c = 0; c < e->count; c++)
        threshold += NOTHING * e->k.x[e->k.p[c]] * motion[c] * motion[c];
    return fabs(sp_dot(e->count, motion, image)) <= threshold;
}

/* Removes from a load what acts on motions that K does not resist, if this is so much that it would hide the rest.
 * Returns the norm of what remains, which was `norm`. load, motion: [count] scratch. */
static double drop_floppy(sp_equilibrium *e, double *right, double norm, double *load, double *motion) {
    enum { PASSES = 3 };
    memcpy(load, right, (size_t)e->count * sizeof *load);
    keep_floppy(e, load, motion);
    if (sp_dot(e->count, load, motion) < 1e-3 * sp_dot(e->count, right, motion))
        return norm;
    for (int pass = 1; pass < PASSES; pass++)
        keep_floppy(e, load, motion);
    if (!is_floppy(e, motion, motion + e->count))
        return norm;
    for (int64_t c = 0; c < e->count; c++)
        right[c] -= load[c];
    return sp_norm(e->count, right);
}

/* more = K^-1 right, nearly: up to a residual `goal`. */
static sp_status correct(sp_equilibrium *e, double goal, const double *right, double *more, double *zero,
                         sp_error *err) {
    enum { STEPS_MAX = 60 };
    const krylov_problem p = {e->count, apply_free, precondition, e, goal, STEPS_MAX};
    double left;
    if (e->net->carried)
        return sp_gmres(&p, right, more, &left, err);
    for (int64_t c = 0; c < e->count; c++)
        zero[c] = NOTHING * e->k.x[e->k.p[c]];
    return sp_cg(&p, zero, right, more, err);
}

/* A neighbour of K was factored. Rounding errors act on floppy motions, too, which would move far if only rounding
 * errors resisted them. So what acts on such motions is removed; a load without prestress does not. */
static sp_status iterate(sp_equilibrium *e, const double *f, double scale, double *u, sp_error *err) {
    enum { PASSES_MAX = 8, ENOUGH = 16 }; /* sp_strain_noise allows for as many */
    double *right = e->work + 2 * sp_network_dofs(e->net), *more = right + e->count, *spare = more + e->count;
    double before = HUGE_VAL;
    for (int pass = 0; pass < PASSES_MAX; pass++) {
        double now = residual_of(e, f, u, spare, right);
        const double floor = rounding_of(e, scale, u);
        const bool drop = !e->net->carried && (pass > 0 || e->net->prestress || e->shift_kind == SHIFT_MASS);
        if (now > ENOUGH * floor && drop)
            now = drop_floppy(e, right, now, spare, spare + e->count);
        if (pass > 0 && !(now <= before)) /* rounding errors only */
            add(e, -1, more, u);
        if (!(now > ENOUGH * floor) || now > 0.5 * before)
            break;
        before = now;
        const sp_status status = correct(e, fmax(1e-14 * now, floor), right, more, spare, err);
        if (status != SP_OK)
            return status;
        add(e, 1, more, u);
    }
    return SP_OK;
}

/* Forces on spins that are held are forces that do not balance at rest. They count as a residual, but less. */
static const double SPINNING = 1e-3;

/* *residual: without the forces on spins that are held. */
static sp_status solve(sp_equilibrium *e, const double *f, double scale, double *u, double *residual, sp_error *err) {
    double *right = e->work + 2 * sp_network_dofs(e->net);
    sp_status status = SP_OK;
    if (e->count > 0 && (e->shift_kind || e->net->carried))
        status = iterate(e, f, scale, u, err);
    else if (e->count > 0)
        refine(e, f, u);
    *residual = residual_of(e, f, u, right + e->count, right);
    return status;
}

sp_status sp_equilibrium_solve(sp_equilibrium *e, const double *f, double scale, double *u, double *residual,
                               sp_error *err) {
    sp_status status = solve(e, f, scale, u, residual, err);
    const double whole = sp_equilibrium_residual(e, f, u, e->work + sp_network_dofs(e->net));
    *residual = fmax(*residual, SPINNING * whole);
    return status;
}

sp_status sp_equilibrium_weights(sp_equilibrium *e, const double *f, double scale, double *w, sp_error *err) {
    const int64_t n = sp_network_dofs(e->net);
    const double load = fmax(sp_norm(n, f), 1e-6 * scale);
    double residual = 0;
    memset(w, 0, (size_t)n * sizeof *w);
    e->transposed = true;
    sp_status status = solve(e, f, scale, w, &residual, err);
    if (status == SP_OK && residual > 1e-8 * load)
        status = sp_equilibrium_refuse(e, "weights of the errors", load, f, w, err);
    e->transposed = false;
    return status;
}

/* ---- refusals --------------------------------------------------------------------------------------------------- */

/* The grain with the largest part of rest, whose part is then set to 0; *square: that part's square. */
static int32_t take_largest(const sp_network *net, double *rest, double *square) {
    int32_t worst = 0;
    *square = 0;
    for (int32_t i = 0; i < net->n; i++) {
        const double *own = rest + (int64_t)i * net->dof, part = sp_dot(net->dof, own, own);
        if (part > *square) {
            *square = part;
            worst = i;
        }
    }
    memset(rest + (int64_t)worst * net->dof, 0, (size_t)net->dof * sizeof *rest);
    return net->grain[worst];
}

sp_status sp_equilibrium_refuse(sp_equilibrium *e, const char *what, double load, const double *f, const double *u,
                                sp_error *err) {
    enum { NAMED_MAX = 6 };
    char list[NAMED_MAX * 16] = "";
    size_t used = 0;
    double *rest = e->work + sp_network_dofs(e->net), square;
    const double norm = sp_equilibrium_residual(e, f, u, rest);
    double left = norm * norm;
    for (int k = 0; k < NAMED_MAX && left > 0.1 * norm * norm; k++) {
        const int32_t grain = take_largest(e->net, rest, &square);
        used += (size_t)snprintf(list + used, sizeof list - used, "%s%d", k > 0 ? ", " : "", grain);
        left -= square;
    }
    return sp_fail(err, SP_EREFUSED,
                   "%s: residual %.3g of the load, must be below 1e-8: the load does work on a motion that nothing "
                   "resists, of grains %s%s",
                   what, norm / load, list, left > 0.1 * norm * norm ? " and others" : "");
}
