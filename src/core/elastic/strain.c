/* Loads and stresses of imposed affine strains. Without walls the cell takes the strain: the images of grains move. */
#include "elastic/strain.h"

#include "base/vector.h"
#include "network/network_cell.h"
#include "network/rows.h"
#include "packing/geometry.h"

#include <float.h>
#include <math.h>

/* The affine field u_along = x_of. */
typedef struct axes {
    int along, of;
} axes;

static axes axes_of(const sp_network *net, int strain) {
    static const axes plane[] = {{0, 0}, {1, 1}, {0, 1}};
    static const axes space[] = {{0, 0}, {1, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}};
    if (net->dim == 1)
        return (axes){0, 0};
    return net->dim == 2 ? plane[strain] : space[strain];
}

int sp_strain_count(const sp_network *net) { return net->dim == 3 ? STRAINS_3D : STRAINS; }

bool sp_strain_allowed(const sp_network *net, int strain, bool grips) {
    if (net->dim == 1)
        return strain == STRAIN_22;
    if (strain >= sp_strain_count(net))
        return false;
    const axes s = axes_of(net, strain);
    return grips || s.along == s.of || s.of != net->dim - 1;
}

double sp_strain_area(const sp_network *net) {
    return net->dim == 1 ? 1 : net->dim == 2 ? net->box[0] : net->box[0] * net->box[1];
}

double sp_strain_volume(const sp_network *net) { return sp_network_volume(net); }

sp_status sp_strain_check(const sp_network *net, sp_error *err) {
    return net->prestress ? sp_cell_need_flat(net->cell, "a strain under prestress, which would bend them,", err)
                          : SP_OK;
}

double sp_strain_noise(const sp_network *net) { return DBL_EPSILON * (16 + sqrt((double)net->n_springs)); }

void sp_strain_displacement(const sp_network *net, int strain, const double n[3], double length, double out[3]) {
    const axes f = axes_of(net, strain);
    out[0] = out[1] = out[2] = 0;
    out[f.along] = length * n[f.of];
}

static double sizes3(const double a[3], const double b[3]) {
    return fabs(a[0] * b[0]) + fabs(a[1] * b[1]) + fabs(a[2] * b[2]);
}

/* A spring's contribution k left right^T to K. The gaps replace left and right for an affine displacement. */
typedef struct term {
    double k;
    const double *left, *right, *left_gap, *right_gap;
} term;

/* All terms of one spring: its rows, then those of its tangential force at rest. */
typedef struct terms {
    sp_rows rows;
    sp_turns turns;
    int count, width;
    term at[SP_ROWS_MAX + SP_TURNS_MAX];
} terms;

static void terms_of(const sp_network *net, int32_t k, terms *t) {
    sp_network_rows(net, &net->springs[k], &t->rows);
    sp_network_turns(net, k, &t->turns);
    t->count = 0;
    t->width = t->rows.width;
    for (int q = 0; q < t->rows.count; q++)
        t->at[t->count++] = (term){t->rows.k[q], t->rows.b[q], t->rows.b[q], t->rows.gap[q], t->rows.gap[q]};
    for (int q = 0; q < t->turns.count; q++)
        t->at[t->count++] = (term){1, t->turns.left[q], t->turns.right[q], t->turns.left_gap[q], t->turns.right_gap[q]};
}

static double load(const sp_network *net, int strain, bool transposed, double *f) {
    double squares = 0;
    terms t;
    for (int64_t k = 0; k < sp_network_dofs(net); k++)
        f[k] = 0;
    for (int32_t k = 0; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        double gap[3];
        terms_of(net, k, &t);
        sp_strain_displacement(net, strain, s->n, net->length[k], gap);
        for (int q = 0; q < t.count; q++) {
            const double force = t.at[q].k * dot3(transposed ? t.at[q].left_gap : t.at[q].right_gap, gap);
            squares += q < t.rows.count ? force * force : 0;
            for (int a = 0; a < t.width; a++)
                f[sp_strain_index(net, s, a)] -= force * (transposed ? t.at[q].right[a] : t.at[q].left[a]);
        }
    }
    return sqrt(squares);
}

double sp_strain_load(const sp_network *net, int strain, double *f) { return load(net, strain, false, f); }

double sp_strain_load_transposed(const sp_network *net, int strain, double *f) { return load(net, strain, true, f); }

void sp_strain_stresses(const sp_network *net, int strain, const double *u, sp_stiffness *out) {
    const int strains = sp_strain_count(net);
    double sum[STRAINS_3D] = {0}, wall = 0;
    terms t;
    for (int32_t k = 0; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        double gap[STRAINS_3D][3];
        terms_of(net, k, &t);
        for (int b = 0; b < strains; b++)
            sp_strain_displacement(net, b, s->n, net->length[k], gap[b]);
        for (int q = 0; q < t.count; q++) {
            double stretch = dot3(t.at[q].right_gap, gap[strain]);
            for (int a = 0; a < t.width; a++)
                stretch += t.at[q].right[a] * u[sp_strain_index(net, s, a)];
            for (int b = 0; b < strains; b++)
                sum[b] += t.at[q].k * stretch * dot3(t.at[q].left_gap, gap[b]);
            if (s->j == SP_TOP)
                wall += t.at[q].k * stretch * t.at[q].left_gap[net->dim - 1];
        }
    }
    for (int b = 0; b < strains; b++)
        out->c[b][strain] = sum[b] / sp_strain_volume(net);
    out->wall[strain] = net->cell == SP_CELL_PERIODIC || net->cell == SP_CELL_RING ? NAN : wall / sp_strain_area(net);
}

void sp_strain_part_of(const sp_network *net, int32_t spring, int strain, const double *u, sp_strain_part *out) {
    const sp_spring *s = &net->springs[spring];
    terms t;
    double gap[STRAINS_3D][3];
    terms_of(net, spring, &t);
    for (int b = 0; b < sp_strain_count(net); b++) {
        sp_strain_displacement(net, b, s->n, net->length[spring], gap[b]);
        out->stress[b] = out->size[b] = out->affine[b] = 0;
    }
    for (int q = 0; q < t.count; q++) {
        const term *e = &t.at[q];
        double stretch = dot3(e->right_gap, gap[strain]), size = sizes3(e->right_gap, gap[strain]);
        for (int a = 0; a < t.width; a++) {
            const double moved = e->right[a] * u[sp_strain_index(net, s, a)];
            stretch += moved;
            size += fabs(moved);
        }
        for (int b = 0; b < sp_strain_count(net); b++) {
            const double lever = dot3(e->left_gap, gap[b]);
            out->stress[b] += e->k * stretch * lever;
            out->size[b] += fabs(e->k) * size * sizes3(e->left_gap, gap[b]);
            out->affine[b] += fabs(e->k) * lever * lever;
        }
    }
}

void sp_strain_rounding(const sp_network *net, int strain, const double *u, double *size, double *sum) {
    const int strains = sum ? sp_strain_count(net) : 0;
    terms t;
    for (int b = 0; b < strains; b++)
        sum[b] = 0;
    for (int64_t k = 0; k < sp_network_dofs(net); k++)
        size[k] = 0;
    for (int32_t k = 0; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        double gap[STRAINS_3D][3];
        terms_of(net, k, &t);
        for (int b = 0; b < strains; b++)
            sp_strain_displacement(net, b, s->n, net->length[k], gap[b]);
        for (int q = 0; q < t.count; q++) {
            const term *e = &t.at[q];
            double stretch = strain < 0 || !sum ? 0 : sizes3(e->right_gap, gap[strain]);
            for (int a = 0; a < t.width; a++)
                stretch += fabs(e->right[a] * u[sp_strain_index(net, s, a)]);
            for (int a = 0; a < t.width; a++)
                size[sp_strain_index(net, s, a)] += fabs(e->k * e->left[a]) * stretch;
            for (int b = 0; b < strains; b++)
                sum[b] += fabs(e->k) * stretch * sizes3(e->left_gap, gap[b]);
        }
    }
}
