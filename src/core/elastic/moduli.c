/* Moduli by imposed strain. The displacement is the affine field plus u, which the grains add at equilibrium: K u =
 * -B^T k d with the affine relative displacements d at the contacts. The contact points of a wall follow the affine
 * field too, so that stress and strain are conjugate and C is symmetric if K is. Extension and tension are positive
 * here, compression in Eq. (7); the moduli are the same. */
#include "elastic/moduli.h"

#include "base/base.h"
#include "base/vector.h"
#include "elastic/strain.h"
#include "network/network_cell.h"

#include <math.h>
#include <string.h>

/* Mean of the normal stresses at rest that turn with the contacts, for prestress: from the forces of the springs in a
 * periodic cell, where there is nothing else. */
static double pressure_at_rest(const sp_network *net, double volume) {
    double sum = 0;
    if (!net->prestress)
        return 0;
    if (net->cell != SP_CELL_PERIODIC)
        return net->pressure;
    for (int32_t k = 0; k < net->n_bulk; k++)
        sum -= net->springs[k].kp * net->length[k] * net->length[k];
    return sum / (net->dim * volume);
}

/* Sums of entries of a tensor: those of uniaxial strains with themselves and with each other, and of shears. */
typedef struct sums {
    double own, cross, shears;
} sums;

static sums add_up(int dim, int strains, const double c[SP_STRAINS_MAX][SP_STRAINS_MAX]) {
    sums s = {0, 0, 0};
    for (int a = 0; a < strains; a++)
        for (int b = 0; b < strains; b++) {
            if (a == b)
                *(a < dim ? &s.own : &s.shears) += c[a][b];
            else if (a < dim && b < dim)
                s.cross += 0.5 * c[a][b];
        }
    return s;
}

static double bulk_of(int dim, const sums *s, double sign) { return (s->own + sign * 2 * s->cross) / (dim * dim); }

/* Voigt's averages: the isotropic tensor with the same two invariants, c_iijj and c_ijij. */
static double shear_of(int dim, const sums *s, double sign) {
    if (dim == 2)
        return (s->own - sign * 2 * s->cross + 4 * s->shears) / 8;
    return (s->own - sign * s->cross + 3 * s->shears) / 15;
}

/* Entry of the isotropic tensor. */
static double isotropic(int dim, double bulk, double shear, int a, int b) {
    if (a >= dim || b >= dim)
        return a == b ? shear : 0;
    return bulk - 2 * shear / dim + (a == b ? 2 * shear : 0);
}

/* A tensor has more components than c has entries: each shear stands for two. */
static double weight(int dim, int a, int b) { return (a < dim ? 1 : 2) * (b < dim ? 1 : 2); }

static void find_anisotropy(int dim, double p, sp_elasticity *e) {
    double whole = 0, off = 0, error = 0;
    for (int a = 0; a < e->strains; a++)
        for (int b = 0; b < e->strains; b++) {
            const double w = weight(dim, a, b), c = e->c[a][b] + (a != b && a < dim && b < dim ? p : 0);
            const double apart = c - isotropic(dim, e->bulk, e->shear, a, b);
            whole += w * c * c;
            off += w * apart * apart;
            error += w * e->error[a][b] * e->error[a][b];
        }
    e->anisotropy = sqrt(off / whole);
    e->anisotropy_error = 2 * sqrt(error / whole);
}

/* The whole tensor, and its isotropic part. */
void sp_elasticity_from(const sp_network *net, const sp_stiffness *s, sp_elasticity *out) {
    const int dim = net->dim, strains = dim == 3 ? STRAINS_3D : dim == 2 ? STRAINS : 1;
    const int first = dim == 1 ? STRAIN_22 : 0;
    sp_elasticity e = {.strains = strains, .residual = s->residual};
    for (int a = 0; a < SP_STRAINS_MAX; a++)
        for (int b = 0; b < SP_STRAINS_MAX; b++) {
            const bool exists = a < strains && b < strains;
            e.c[a][b] = exists ? s->c[first + a][first + b] : NAN;
            e.error[a][b] = exists ? s->error[first + a][first + b] : NAN;
        }
    e.bulk = e.bulk_error = e.shear = e.shear_error = e.anisotropy = e.anisotropy_error = NAN;
    if (dim > 1) {
        const double p = pressure_at_rest(net, sp_network_volume(net));
        sums all = add_up(dim, strains, (const double(*)[SP_STRAINS_MAX])e.c);
        const sums errors = add_up(dim, strains, (const double(*)[SP_STRAINS_MAX])e.error);
        all.cross += 0.5 * dim * (dim - 1) * p;
        e.bulk = bulk_of(dim, &all, 1);
        e.shear = shear_of(dim, &all, 1);
        e.bulk_error = bulk_of(dim, &errors, 1);
        e.shear_error = shear_of(dim, &errors, -1);
        find_anisotropy(dim, p, &e);
    }
    *out = e;
}

/* Bounds the errors of stresses. The stress a computed from u_b has the error u_a . (K u_b - f_b) over the volume, plus
 * rounding, where u_a is the exact solution for strain a (of K^T if K is not symmetric). A factor 2 covers the second
 * order. What the load does on spins is not balanced, and any force on these spheres may balance it. solutions,
 * stresses: of all strains, [strains][n]; work: [4][n]. */
static void bound_errors(const sp_equilibrium *e, int strain, const double *solutions, const double *stresses,
                         double *work, sp_stiffness *out) {
    const sp_network *net = e->net;
    const int64_t n = sp_network_dofs(net);
    double *rest = work, *ku = work + n, *size = work + 2 * n, sum[STRAINS_3D];
    const double *u = solutions + strain * n;
    const double noise = sp_strain_noise(net);
    sp_strain_rounding(net, strain, u, size, sum);
    sp_strain_load(net, strain, rest);
    sp_network_apply(net, u, ku);
    for (int64_t k = 0; k < n; k++)
        rest[k] -= ku[k];
    for (int a = 0; a < sp_strain_count(net); a++) {
        double off = 0.5 * sp_equilibrium_spin_work(e, rest, 0, stresses + a * n);
        for (int64_t k = 0; k < n; k++)
            off += fabs(stresses[a * n + k]) * (fabs(rest[k]) + noise * size[k]);
        out->error[a][strain] += (2 * off + noise * sum[a]) / sp_strain_volume(net);
    }
}

/* Solves K^T w = (stress functional) for each stress, and bounds the effect of spins on the stresses. A sphere with two
 * contacts spins about the line through them; the only stiffness is due to imbalance of its forces at rest. The
 * solution leaves its spin out, but the springs do not determine it, and the stress depends on it slightly: spin . (f -
 * K^T w). The error allows for a rotation of 1 per unit strain, typical of grains in contact, or for as much as the
 * sphere moves. solutions: of all strains, [strains][n]. */
static sp_status solve_transposed(sp_equilibrium *e, double *f, const double *solutions, double *stresses,
                                  sp_stiffness *out, sp_error *err) {
    const int64_t n = sp_network_dofs(e->net);
    const int strains = sp_strain_count(e->net);
    sp_status status = SP_OK;
    for (int a = 0; a < strains && status == SP_OK; a++) {
        if (!sp_strain_allowed(e->net, a, e->grips))
            continue;
        double *w = stresses + a * n;
        const double scale = sp_strain_load_transposed(e->net, a, f);
        status = sp_equilibrium_weights(e, f, scale, w, err);
        const double *rest = sp_equilibrium_spin_rest(e, f, w);
        for (int b = 0; b < strains && status == SP_OK; b++)
            out->error[a][b] = sp_equilibrium_spin_work(e, rest, 1, solutions + b * n) / sp_strain_volume(e->net);
    }
    return status;
}

/* The least load that counts, over the scale of its terms. In a lattice f is pure rounding error; across a tilted cell
 * distances are differences of larger numbers. */
static double least_load(const sp_network *net) { return net->cell == SP_CELL_PISTON ? 1e-6 : 1e-4; }

static sp_status strain_all(sp_equilibrium *e, double *work, sp_stiffness *out, sp_error *err) {
    const sp_network *net = e->net;
    const int64_t n = sp_network_dofs(net);
    const int strains = sp_strain_count(net);
    double *f = work, *solutions = work + 4 * n, *stresses = net->carried ? solutions + strains * n : solutions;
    for (int a = 0; a < strains; a++) {
        if (!sp_strain_allowed(net, a, e->grips))
            continue;
        double residual = 0, *u = solutions + a * n;
        const double scale = sp_strain_load(net, a, f);
        sp_status status = sp_equilibrium_solve(e, f, scale, u, &residual, err);
        if (status != SP_OK)
            return status;
        const double load = fmax(sp_norm(n, f), least_load(net) * scale);
        if (load > 0 && !(residual < 1e-8 * load))
            return sp_equilibrium_refuse(e, "moduli", load, f, u, err);
        if (load > 0)
            out->residual = fmax(out->residual, residual / load);
        sp_strain_stresses(net, a, u, out);
    }
    if (net->carried) {
        sp_status status = solve_transposed(e, f, solutions, stresses, out, err);
        if (status != SP_OK)
            return status;
    }
    for (int a = 0; a < strains; a++)
        if (sp_strain_allowed(net, a, e->grips))
            bound_errors(e, a, solutions, stresses, work, out);
    for (int b = 0; b < STRAINS_3D; b++) {
        const bool defined = sp_strain_allowed(net, b, e->grips);
        for (int a = 0; a < STRAINS_3D; a++)
            if (!defined || !sp_strain_allowed(net, a, e->grips))
                out->c[a][b] = out->error[a][b] = NAN;
        if (!defined)
            out->wall[b] = NAN;
    }
    return SP_OK;
}

/* A modulus on the diagonal that is 0 within its error belongs to a mechanism. One below 0 is that of prestress that
 * the cell as a whole does not resist, although the grains in it do. If that is the longitudinal modulus along the up
 * axis, the springs carry nothing from wall to wall, or around the cell. */
static sp_status find_mechanisms(const sp_network *net, sp_stiffness *c, sp_error *err) {
    const int up = net->dim == 3 ? STRAIN_33_3D : STRAIN_22;
    if (c->c[up][up] < -c->error[up][up])
        return sp_fail(err, SP_EREFUSED, "the network is unstable under its prestress: its modulus %s is %.2g",
                       net->cell == SP_CELL_PERIODIC ? "along the up axis" : "from wall to wall", c->c[up][up]);
    if (!(c->c[up][up] > c->error[up][up]))
        return sp_fail(err, SP_EREFUSED, "the network is floppy: its modulus %s, %.2g, is 0 within an error of %.2g",
                       net->cell == SP_CELL_PERIODIC ? "along the up axis" : "from wall to wall", c->c[up][up],
                       c->error[up][up]);
    for (int a = 0; a < STRAINS_3D; a++)
        if (fabs(c->c[a][a]) <= c->error[a][a])
            c->c[a][a] = 0;
    return SP_OK;
}

size_t sp_stiffness_work(const sp_network *net) {
    const size_t sets = net->carried ? 2 : 1;
    return (4 + sets * (size_t)sp_strain_count(net)) * (size_t)sp_network_dofs(net);
}

sp_status sp_stiffness_of(sp_equilibrium *e, double *work, sp_stiffness *out, sp_error *err) {
    sp_stiffness c = {0};
    sp_status status = sp_strain_check(e->net, err);
    if (status == SP_OK)
        status = strain_all(e, work, &c, err);
    if (status == SP_OK)
        status = find_mechanisms(e->net, &c, err);
    if (status == SP_OK)
        *out = c;
    return status;
}

static sp_status compute_stiffness(sp_equilibrium *e, sp_stiffness *out, sp_error *err) {
    const size_t size = sp_stiffness_work(e->net);
    double *work = sp_alloc(size, sizeof *work);
    if (!work)
        return sp_fail_memory(err, size * sizeof *work);
    sp_status status = sp_stiffness_of(e, work, out, err);
    sp_free(work);
    return status;
}

sp_status sp_stiffness_make(const sp_network *net, sp_stiffness *out, sp_error *err) {
    sp_equilibrium e = sp_equilibrium_none();
    sp_status status = sp_equilibrium_make(net, &e, err);
    if (status == SP_OK)
        status = compute_stiffness(&e, out, err);
    sp_equilibrium_free(&e);
    return status;
}

/* NAN if the packing gives way to the wave: a modulus below 0. */
static double speed(double modulus, double density) { return density > 0 ? sqrt(modulus / density) : NAN; }

void sp_moduli_from_stiffness(const sp_network *net, double phi3s, const sp_stiffness *s, sp_moduli *out) {
    const bool space = net->dim == 3;
    const int c33 = space ? STRAIN_33_3D : STRAIN_SHEAR; /* longitudinal in 3D, shear in 2D */
    sp_elasticity whole;
    sp_elasticity_from(net, s, &whole);
    sp_moduli m = {.residual = s->residual,
                   .bulk = whole.bulk,
                   .shear = whole.shear,
                   .error_bulk = whole.bulk_error,
                   .error_shear = whole.shear_error};
    const struct {
        double *c, *error;
        int a, b;
    } all[] = {{&m.c11, &m.error11, STRAIN_11, STRAIN_11},       {&m.c12, &m.error12, STRAIN_11, STRAIN_22},
               {&m.c22, &m.error22, STRAIN_22, STRAIN_22},       {&m.c33, &m.error33, c33, c33},
               {&m.c13, &m.error13, STRAIN_11, STRAIN_33_3D},    {&m.c23, &m.error23, STRAIN_22, STRAIN_33_3D},
               {&m.c44, &m.error44, STRAIN_23_3D, STRAIN_23_3D}, {&m.c55, &m.error55, STRAIN_13_3D, STRAIN_13_3D},
               {&m.c66, &m.error66, STRAIN_12_3D, STRAIN_12_3D}};
    for (int k = 0; k < 9; k++) {
        const bool exists = space || k < 4;
        *all[k].c = exists ? s->c[all[k].a][all[k].b] : NAN;
        *all[k].error = exists ? s->error[all[k].a][all[k].b] : NAN;
    }
    m.c_l = speed(space ? m.c33 : m.c22, phi3s);
    m.c_t = speed(space ? 0.5 * (m.c44 + m.c55) : m.c33, phi3s);
    *out = m;
}

sp_status sp_moduli_of(sp_equilibrium *e, double phi3s, sp_moduli *out, sp_error *err) {
    sp_stiffness s;
    sp_status status = compute_stiffness(e, &s, err);
    if (status == SP_OK)
        sp_moduli_from_stiffness(e->net, phi3s, &s, out);
    return status;
}

sp_status sp_elasticity_make(const sp_network *net, double phi3s, sp_moduli *moduli, sp_elasticity *out,
                             sp_error *err) {
    sp_stiffness s;
    sp_status status = sp_stiffness_make(net, &s, err);
    if (status != SP_OK)
        return status;
    if (moduli)
        sp_moduli_from_stiffness(net, phi3s, &s, moduli);
    sp_elasticity_from(net, &s, out);
    return SP_OK;
}

sp_status sp_moduli_make(const sp_network *net, double phi3s, sp_moduli *out, sp_error *err) {
    sp_equilibrium e = sp_equilibrium_none();
    sp_status status = sp_equilibrium_make(net, &e, err);
    if (status == SP_OK)
        status = sp_moduli_of(&e, phi3s, out, err);
    sp_equilibrium_free(&e);
    return status;
}
