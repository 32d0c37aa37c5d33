/* Moduli by imposed strain. The displacement is the affine field plus what the grains add to it, u, at equilibrium:
 * K u = -B^T k d, with d the affine field's own relative displacements at the contacts. A wall's contact points follow
 * the affine field too, so that stress and strain are conjugate and C is symmetric. Extension and tension count
 * positive here, shrinking and compression in Eq. (7): the moduli are the same. */
#include "base/base.h"
#include "elastic/stiffness.h"
#include "linalg/cholesky.h"
#include "network/rows.h"

#include <float.h>
#include <math.h>
#include <sonopack/elastic.h>

/* Affine displacement of one end of a spring against the other. */
static void affine(const sp_network *net, int strain, const sp_spring *s, double length, double out[3]) {
    const int up = net->dim - 1;
    out[0] = out[1] = out[2] = 0;
    if (strain == STRAIN_11)
        out[0] = length * s->n[0];
    else if (strain == STRAIN_22)
        out[up] = length * s->n[up];
    else
        out[0] = length * s->n[up];
}

static double row_gap(const sp_rows *rows, int q, const double affine_gap[3]) {
    return rows->gap[q][0] * affine_gap[0] + rows->gap[q][1] * affine_gap[1] + rows->gap[q][2] * affine_gap[2];
}

/* Where the entries of a row belong. */
static int64_t place(const sp_network *net, const sp_spring *s, int entry) {
    return (int64_t)(entry < net->dof ? s->i : s->j) * net->dof + entry % net->dof;
}

/* f = -B^T k d; returns |k d|, the scale of its terms. */
static double load(const sp_network *net, int strain, double *f) {
    double squares = 0;
    for (int64_t k = 0; k < sp_network_dofs(net); k++)
        f[k] = 0;
    for (int32_t k = 0; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        double gap[3];
        sp_rows rows;
        sp_network_rows(net, s, &rows);
        affine(net, strain, s, net->length[k], gap);
        for (int q = 0; q < rows.count; q++) {
            const double force = rows.k[q] * row_gap(&rows, q, gap);
            squares += force * force;
            for (int a = 0; a < rows.width; a++)
                f[place(net, s, a)] -= force * rows.b[q][a];
        }
    }
    return sqrt(squares);
}

/* Stresses sum F d/V over all springs for the solution u of one strain, and the force on the top wall. */
static void stresses(const sp_network *net, int strain, const double *u, sp_stiffness *out) {
    const double area = net->dim == 2 ? net->box[0] : 1, volume = area * net->box[net->dim - 1];
    double sum[STRAINS] = {0}, wall = 0;
    for (int32_t k = 0; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        double gap[STRAINS][3];
        sp_rows rows;
        sp_network_rows(net, s, &rows);
        for (int b = 0; b < STRAINS; b++)
            affine(net, b, s, net->length[k], gap[b]);
        for (int q = 0; q < rows.count; q++) {
            double stretch = row_gap(&rows, q, gap[strain]);
            for (int a = 0; a < rows.width; a++)
                stretch += rows.b[q][a] * u[place(net, s, a)];
            for (int b = 0; b < STRAINS; b++)
                sum[b] += rows.k[q] * stretch * row_gap(&rows, q, gap[b]);
            if (s->j == SP_TOP)
                wall += rows.k[q] * stretch * rows.gap[q][net->dim - 1];
        }
    }
    for (int b = 0; b < STRAINS; b++)
        out->c[b][strain] = sum[b] / volume;
    out->wall[strain] = wall / area;
}

/* The sums of absolute values that stand behind a residual and a stress, against which they are rounded. size[i]: of
 * the terms of (K u - f)_i; sum[a]: of the terms of the stress sum k d_a (d + B u). */
static void rounding_sizes(const sp_network *net, int strain, const double *u, double *size, double sum[STRAINS]) {
    sum[0] = sum[1] = sum[2] = 0;
    for (int64_t k = 0; k < sp_network_dofs(net); k++)
        size[k] = 0;
    for (int32_t k = 0; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        double gap[STRAINS][3], along[STRAINS];
        sp_rows rows;
        sp_network_rows(net, s, &rows);
        for (int b = 0; b < STRAINS; b++)
            affine(net, b, s, net->length[k], gap[b]);
        for (int q = 0; q < rows.count; q++) {
            for (int b = 0; b < STRAINS; b++)
                along[b] = fabs(rows.gap[q][0] * gap[b][0]) + fabs(rows.gap[q][1] * gap[b][1]) +
                           fabs(rows.gap[q][2] * gap[b][2]);
            double stretch = along[strain];
            for (int a = 0; a < rows.width; a++)
                stretch += fabs(rows.b[q][a] * u[place(net, s, a)]);
            for (int a = 0; a < rows.width; a++)
                size[place(net, s, a)] += fabs(rows.k[q] * rows.b[q][a]) * stretch;
            for (int b = 0; b < STRAINS; b++)
                sum[b] += fabs(rows.k[q]) * stretch * along[b];
        }
    }
}

/* What the walls hold: count of springs and their tangential stiffness. */
typedef struct hold {
    int32_t springs;
    double tangential;
} hold;

static hold wall_hold(const sp_network *net, int32_t wall) {
    hold h = {0, 0};
    for (int32_t k = net->n_bulk; k < net->n_springs; k++)
        if (net->springs[k].j == wall) {
            h.springs++;
            h.tangential += net->springs[k].kt;
        }
    return h;
}

/* Degrees of freedom that no strain can move are held, which changes no force: rotations without any tangential
 * spring, and, between walls that do not grip, the sideways position of the whole, at its first grain. */
static void hold_free(const sp_network *net, bool slips, sp_sparse *k) {
    double largest = 0;
    for (int64_t c = 0; c < k->n; c++)
        largest = fmax(largest, k->x[k->p[c]]);
    for (int64_t c = 0; c < k->n; c++)
        if (c % net->dof >= net->dim && k->x[k->p[c]] == 0)
            k->x[k->p[c]] = largest;
    if (slips)
        k->x[k->p[0]] += largest;
}

/* Floppy parts (a cluster that hangs on too few contacts, say) make K singular. Yet K u = f can always be solved, as f
 * is made of spring forces and does no work on a motion that stretches no spring, and the stress is that of any of the
 * solutions. So the diagonal is raised by this fraction, and the refinement below takes the change out again. */
static const double RAISE = 1e-9;

static void raise_diagonal(sp_sparse *k) {
    double largest = 0;
    for (int64_t c = 0; c < k->n; c++)
        largest = fmax(largest, k->x[k->p[c]]);
    for (int64_t c = 0; c < k->n; c++)
        k->x[k->p[c]] += RAISE * (k->x[k->p[c]] > 0 ? k->x[k->p[c]] : largest);
}

/* Whether springs lead from wall to wall: else there is nothing that could carry a stress. Grains reached from the
 * bottom are marked until no more are found; a sweep in either direction follows long paths at once. */
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
    return top ? SP_OK : sp_fail(err, SP_EREFUSED, "the network is in parts: no springs lead from wall to wall");
}

static double length(int64_t n, const double *x) {
    double sum = 0;
    for (int64_t k = 0; k < n; k++)
        sum += x[k] * x[k];
    return sqrt(sum);
}

/* work: f, u and two of scratch, [4][dofs] (and the solutions of all strains). u = K^-1 f with refinement until the
 * residual |K u - f|, which goes into *residual, stays the same: one step for a factor of K itself, a few for one with
 * a raised diagonal. */
static sp_status solve(const sp_network *net, sp_cholesky *factor, double *work, double *residual, sp_error *err) {
    enum { PASSES_MAX = 60 };
    const int64_t n = sp_network_dofs(net);
    double *f = work, *u = work + n, *rest = work + 2 * n, *more = work + 3 * n, before;
    for (int64_t k = 0; k < n; k++) {
        u[k] = 0;
        rest[k] = f[k];
    }
    *residual = length(n, rest);
    int pass = 0;
    do {
        before = *residual;
        sp_status status = sp_cholesky_solve(factor, 1, rest, more, err);
        if (status != SP_OK)
            return status;
        for (int64_t k = 0; k < n; k++)
            u[k] += more[k];
        sp_network_apply(net, u, more);
        for (int64_t k = 0; k < n; k++)
            rest[k] = f[k] - more[k];
        *residual = length(n, rest);
    } while (++pass < 2 || (*residual < 0.5 * before && pass < PASSES_MAX));
    return SP_OK;
}

static sp_status check_network(const sp_network *net, sp_error *err) {
    if (net->dim == 3)
        return sp_fail(err, SP_EREFUSED, "moduli of a 3D packing: global strain is for 1D and 2D packings");
    if (wall_hold(net, SP_BOTTOM).springs == 0 || wall_hold(net, SP_TOP).springs == 0)
        return sp_fail(err, SP_EREFUSED, "moduli need carrying contacts at both walls, there are %d and %d",
                       wall_hold(net, SP_BOTTOM).springs, wall_hold(net, SP_TOP).springs);
    return check_connected(net, err);
}

/* A stress computed from u_b is off by u_a . (K u_b - f_b) over the volume, u_a being the exact solution of the strain
 * that belongs to it, and by rounding. solutions: of all strains, [STRAINS][n]; work: [4][n]. Twice the first part
 * makes up for the second order. */
static void put_errors(const sp_network *net, int strain, const double *solutions, double *work, sp_stiffness *out) {
    const int64_t n = sp_network_dofs(net);
    double *f = work, *ku = work + n, *size = work + 2 * n, sum[STRAINS];
    const double *u = solutions + strain * n, area = net->dim == 2 ? net->box[0] : 1;
    const double noise = DBL_EPSILON * (16 + sqrt((double)net->n_springs)), volume = area * net->box[net->dim - 1];
    rounding_sizes(net, strain, u, size, sum);
    load(net, strain, f);
    sp_network_apply(net, u, ku);
    for (int a = 0; a < STRAINS; a++) {
        double off = 0;
        for (int64_t k = 0; k < n; k++)
            off += fabs(solutions[a * n + k]) * (fabs(f[k] - ku[k]) + noise * size[k]);
        out->error[a][strain] = (2 * off + noise * sum[a]) / volume;
    }
}

static bool wanted(const sp_network *net, int strain, bool grips) {
    return net->dim == 1 ? strain == STRAIN_22 : strain != STRAIN_SHEAR || grips;
}

static sp_status strain_all(const sp_network *net, sp_cholesky *factor, bool grips, double *work, sp_stiffness *out,
                            sp_error *err) {
    const int64_t n = sp_network_dofs(net);
    double *f = work, *u = work + n, *solutions = work + 4 * n;
    sp_status status = SP_OK;
    for (int a = 0; a < STRAINS; a++) {
        if (!wanted(net, a, grips))
            continue;
        double residual = 0, norm = 0;
        const double scale = load(net, a, f);
        status = solve(net, factor, work, &residual, err);
        if (status != SP_OK)
            return status;
        for (int64_t k = 0; k < n; k++)
            norm += f[k] * f[k];
        /* in a lattice f is rounding alone */
        out->residual = fmax(out->residual, residual / fmax(sqrt(norm), 1e-6 * scale));
        stresses(net, a, u, out);
        for (int64_t k = 0; k < n; k++)
            solutions[a * n + k] = u[k];
    }
    for (int a = 0; a < STRAINS; a++)
        if (wanted(net, a, grips))
            put_errors(net, a, solutions, work, out);
    for (int a = 0; a < STRAINS; a++)
        for (int b = 0; b < STRAINS; b++)
            if (!wanted(net, a, grips) || !wanted(net, b, grips))
                out->c[a][b] = NAN;
    for (int b = 0; b < STRAINS; b++)
        if (!wanted(net, b, grips))
            out->wall[b] = NAN;
    return SP_OK;
}

sp_status sp_stiffness_make(const sp_network *net, sp_stiffness *out, sp_error *err) {
    sp_stiffness c = {0};
    sp_sparse k = {0};
    sp_cholesky *factor = NULL;
    double *work = NULL;
    sp_status status = check_network(net, err);
    if (status != SP_OK)
        return status;
    const double bottom = wall_hold(net, SP_BOTTOM).tangential, top = wall_hold(net, SP_TOP).tangential;
    const bool slips = net->dim > 1 && bottom == 0 && top == 0, grips = bottom > 0 && top > 0;
    status = sp_network_assemble(net, &k, err);
    if (status != SP_OK)
        return status;
    hold_free(net, slips, &k);
    work = sp_alloc((4 + STRAINS) * (size_t)k.n, sizeof *work);
    status =
        work ? sp_cholesky_make(&k, &factor, err) : sp_fail_memory(err, (4 + STRAINS) * (size_t)k.n * sizeof *work);
    if (status == SP_EREFUSED) {
        raise_diagonal(&k);
        status = sp_cholesky_make(&k, &factor, err);
    }
    if (status == SP_OK)
        status = strain_all(net, factor, grips, work, &c, err);
    if (status == SP_OK && !(c.residual < 1e-8))
        status = sp_fail(err, SP_EREFUSED, "moduli: residual %.3g of the solves, must be below 1e-8", c.residual);
    sp_cholesky_free(factor);
    sp_free(work);
    sp_sparse_free(&k);
    if (status == SP_OK)
        *out = c;
    return status;
}

/* A modulus below zero is one of a mechanism, zero but for rounding: what is unstable has no Cholesky factor. */
static double speed(double modulus, double density) {
    return density > 0 ? sqrt((modulus < 0 ? 0 : modulus) / density) : NAN;
}

sp_status sp_moduli_make(const sp_network *net, double phi3s, sp_moduli *out, sp_error *err) {
    sp_stiffness s;
    sp_status status = sp_stiffness_make(net, &s, err);
    if (status != SP_OK)
        return status;
    *out = (sp_moduli){
        .c11 = s.c[STRAIN_11][STRAIN_11],
        .c12 = s.c[STRAIN_11][STRAIN_22],
        .c22 = s.c[STRAIN_22][STRAIN_22],
        .c33 = s.c[STRAIN_SHEAR][STRAIN_SHEAR],
        .c_l = speed(s.c[STRAIN_22][STRAIN_22], phi3s),
        .c_t = speed(s.c[STRAIN_SHEAR][STRAIN_SHEAR], phi3s),
        .residual = s.residual,
        .error11 = s.error[STRAIN_11][STRAIN_11],
        .error12 = s.error[STRAIN_11][STRAIN_22],
        .error22 = s.error[STRAIN_22][STRAIN_22],
        .error33 = s.error[STRAIN_SHEAR][STRAIN_SHEAR],
    };
    return SP_OK;
}
