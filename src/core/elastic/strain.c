/* Loads and stresses of imposed affine strains. */
#include "elastic/strain.h"

#include "network/rows.h"

#include <float.h>
#include <math.h>

/* The affine field u_along = x_of. */
typedef struct field {
    int along, of;
} field;

static field field_of(const sp_network *net, int strain) {
    static const field plane[] = {{0, 0}, {1, 1}, {0, 1}};
    static const field space[] = {{0, 0}, {1, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}};
    if (net->dim == 1)
        return (field){0, 0};
    return net->dim == 2 ? plane[strain] : space[strain];
}

int sp_strain_count(const sp_network *net) { return net->dim == 3 ? STRAINS_3D : STRAINS; }

bool sp_strain_allowed(const sp_network *net, int strain, bool grips) {
    if (net->dim == 1)
        return strain == STRAIN_22;
    const field s = field_of(net, strain);
    return grips || s.along == s.of || s.of != net->dim - 1;
}

double sp_strain_area(const sp_network *net) {
    return net->dim == 1 ? 1 : net->dim == 2 ? net->box[0] : net->box[0] * net->box[1];
}

double sp_strain_volume(const sp_network *net) { return sp_strain_area(net) * net->box[net->dim - 1]; }

double sp_strain_noise(const sp_network *net) { return DBL_EPSILON * (16 + sqrt((double)net->n_springs)); }

void sp_strain_gap(const sp_network *net, int strain, const double n[3], double length, double out[3]) {
    const field f = field_of(net, strain);
    out[0] = out[1] = out[2] = 0;
    out[f.along] = length * n[f.of];
}

static double dot3(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static double row_gap(const sp_rows *rows, int q, const double affine_gap[3]) { return dot3(rows->gap[q], affine_gap); }

static double load(const sp_network *net, int strain, bool transposed, double *f) {
    double squares = 0;
    for (int64_t k = 0; k < sp_network_dofs(net); k++)
        f[k] = 0;
    for (int32_t k = 0; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        double gap[3];
        sp_rows rows;
        sp_network_rows(net, s, &rows);
        sp_strain_gap(net, strain, s->n, net->length[k], gap);
        for (int q = 0; q < rows.count; q++) {
            const double force = rows.k[q] * row_gap(&rows, q, gap);
            squares += force * force;
            for (int a = 0; a < rows.width; a++)
                f[sp_strain_place(net, s, a)] -= force * rows.b[q][a];
        }
        sp_turns turns;
        sp_network_turns(net, k, &turns);
        for (int q = 0; q < turns.count; q++) {
            const double force = dot3(transposed ? turns.left_gap[q] : turns.right_gap[q], gap);
            for (int a = 0; a < turns.width; a++)
                f[sp_strain_place(net, s, a)] -= force * (transposed ? turns.right[q][a] : turns.left[q][a]);
        }
    }
    return sqrt(squares);
}

double sp_strain_load(const sp_network *net, int strain, double *f) { return load(net, strain, false, f); }

void sp_strain_load_transposed(const sp_network *net, int strain, double *f) { load(net, strain, true, f); }

/* Adds the contribution of spring k's tangential force at rest to the stresses times the volume. */
static void add_turns(const sp_network *net, int32_t k, double gap[STRAINS_3D][3], int strain, const double *u,
                      double sum[STRAINS_3D], double *wall) {
    const sp_spring *s = &net->springs[k];
    sp_turns turns;
    sp_network_turns(net, k, &turns);
    for (int q = 0; q < turns.count; q++) {
        double stretch = dot3(turns.right_gap[q], gap[strain]);
        for (int a = 0; a < turns.width; a++)
            stretch += turns.right[q][a] * u[sp_strain_place(net, s, a)];
        for (int b = 0; b < sp_strain_count(net); b++)
            sum[b] += stretch * dot3(turns.left_gap[q], gap[b]);
        if (s->j == SP_TOP)
            *wall += stretch * turns.left_gap[q][net->dim - 1];
    }
}

/* Adds the magnitudes of these terms, for sp_strain_rounding. */
static void add_turns_sizes(const sp_network *net, int32_t k, double gap[STRAINS_3D][3], int strain, const double *u,
                            int strains, double *size, double *sum) {
    const sp_spring *s = &net->springs[k];
    sp_turns turns;
    sp_network_turns(net, k, &turns);
    for (int q = 0; q < turns.count; q++) {
        double stretch = 0;
        for (int a = 0; a < 3 && strain >= 0 && strains > 0; a++)
            stretch += fabs(turns.right_gap[q][a] * gap[strain][a]);
        for (int a = 0; a < turns.width; a++)
            stretch += fabs(turns.right[q][a] * u[sp_strain_place(net, s, a)]);
        for (int a = 0; a < turns.width; a++)
            size[sp_strain_place(net, s, a)] += fabs(turns.left[q][a]) * stretch;
        for (int b = 0; b < strains; b++)
            for (int a = 0; a < 3; a++)
                sum[b] += stretch * fabs(turns.left_gap[q][a] * gap[b][a]);
    }
}

void sp_strain_stresses(const sp_network *net, int strain, const double *u, sp_stiffness *out) {
    const int strains = sp_strain_count(net);
    double sum[STRAINS_3D] = {0}, wall = 0;
    for (int32_t k = 0; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        double gap[STRAINS_3D][3];
        sp_rows rows;
        sp_network_rows(net, s, &rows);
        for (int b = 0; b < strains; b++)
            sp_strain_gap(net, b, s->n, net->length[k], gap[b]);
        for (int q = 0; q < rows.count; q++) {
            double stretch = row_gap(&rows, q, gap[strain]);
            for (int a = 0; a < rows.width; a++)
                stretch += rows.b[q][a] * u[sp_strain_place(net, s, a)];
            for (int b = 0; b < strains; b++)
                sum[b] += rows.k[q] * stretch * row_gap(&rows, q, gap[b]);
            if (s->j == SP_TOP)
                wall += rows.k[q] * stretch * rows.gap[q][net->dim - 1];
        }
        if (net->carried)
            add_turns(net, k, gap, strain, u, sum, &wall);
    }
    for (int b = 0; b < strains; b++)
        out->c[b][strain] = sum[b] / sp_strain_volume(net);
    out->wall[strain] = wall / sp_strain_area(net);
}

void sp_strain_rounding(const sp_network *net, int strain, const double *u, double *size, double *sum) {
    const int strains = sum ? sp_strain_count(net) : 0;
    for (int b = 0; b < strains; b++)
        sum[b] = 0;
    for (int64_t k = 0; k < sp_network_dofs(net); k++)
        size[k] = 0;
    for (int32_t k = 0; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        double gap[STRAINS_3D][3], along[STRAINS_3D];
        sp_rows rows;
        sp_network_rows(net, s, &rows);
        for (int b = 0; b < strains; b++)
            sp_strain_gap(net, b, s->n, net->length[k], gap[b]);
        for (int q = 0; q < rows.count; q++) {
            for (int b = 0; b < strains; b++)
                along[b] = fabs(rows.gap[q][0] * gap[b][0]) + fabs(rows.gap[q][1] * gap[b][1]) +
                           fabs(rows.gap[q][2] * gap[b][2]);
            double stretch = strain < 0 || !sum ? 0 : along[strain];
            for (int a = 0; a < rows.width; a++)
                stretch += fabs(rows.b[q][a] * u[sp_strain_place(net, s, a)]);
            for (int a = 0; a < rows.width; a++)
                size[sp_strain_place(net, s, a)] += fabs(rows.k[q] * rows.b[q][a]) * stretch;
            for (int b = 0; b < strains; b++)
                sum[b] += fabs(rows.k[q]) * stretch * along[b];
        }
        if (net->carried)
            add_turns_sizes(net, k, gap, strain, u, strains, size, sum);
    }
}
