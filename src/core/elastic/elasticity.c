/* The stiffness tensor as a whole: its isotropic part, and how far it is from that. */
#include "base/base.h"
#include "elastic/moduli.h"
#include "network/network_cell.h"

#include <math.h>

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

void sp_elasticity_from_stiffness(const sp_network *net, const sp_stiffness *s, sp_elasticity *out) {
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
