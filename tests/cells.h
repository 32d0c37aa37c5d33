#ifndef TEST_CELLS_H
#define TEST_CELLS_H
/* Packings in cells without a piston, made by hand: perfect lattices, and random packings without friction at rest, by
 * minimising the energy of Hertz's law in a fixed cell. */

#include "reference.h"

/* ---- lattices --------------------------------------------------------------------------------------------------- */

/* cells[] copies of `count` places along three lattice vectors, equal grains of diameter 1 that are 1 - overlap apart
 * where the places are 1 apart. Row a of `vectors` has zeros behind its a-th number, as the lattice vectors of cells.
 */
static inline sp_packing cells_lattice(int dim, const double vectors[3][3], const int cells[3], int count,
                                       const double (*place)[3], double overlap, double friction) {
    const double scale = 1 - overlap;
    const int copies = cells[0] * cells[1] * (dim == 3 ? cells[2] : 1);
    sp_packing p = sp_packing_none();
    assert_ok(sp_packing_alloc(&p, dim, copies * count, 0, &err));
    p.cell = SP_CELL_PERIODIC;
    for (int a = 0; a < dim; a++)
        p.box[a] = scale * cells[a] * vectors[a][a];
    p.tilt[0] = scale * cells[1] * vectors[1][0];
    p.tilt[1] = dim == 3 ? scale * cells[2] * vectors[2][0] : 0;
    p.tilt[2] = dim == 3 ? scale * cells[2] * vectors[2][1] : 0;
    for (int i = 0; i < p.n; i++) {
        const int copy = i / count, at[3] = {copy % cells[0], copy / cells[0] % cells[1], copy / cells[0] / cells[1]};
        for (int b = 0; b < dim; b++) {
            p.x[3 * i + b] = scale * place[i % count][b];
            for (int a = 0; a < dim; a++)
                p.x[3 * i + b] += scale * at[a] * vectors[a][b];
        }
        sp_packing_wrap(&p, p.x + 3 * (size_t)i);
        p.r[i] = 0.5;
    }
    p.friction = friction;
    p.poisson = 0.2;
    /* tilts by at most half of an edge: other vectors of the same lattice */
    const double yz = dim == 3 ? nearbyint(p.tilt[2] / p.box[1]) : 0;
    p.tilt[2] -= yz * p.box[1];
    p.tilt[1] -= yz * p.tilt[0];
    for (int k = 0; k < 2; k++)
        p.tilt[k] -= nearbyint(p.tilt[k] / p.box[0]) * p.box[0];
    for (int i = 0; i < p.n; i++)
        sp_packing_wrap(&p, p.x + 3 * (size_t)i);
    add_contacts(&p);
    assert_ok(sp_packing_check(&p, &err));
    return p;
}

/* columns x rows; the cell is sheared by `lean` columns over its height, which gives the same lattice. */
static inline sp_packing cells_square(int columns, int rows, int lean, double overlap, double friction) {
    const double vectors[3][3] = {{1}, {0, 1}, {0, 0, 1}}, place[1][3] = {{0.25, 0.25}};
    const int cells[3] = {columns, rows, 1};
    sp_packing p = cells_lattice(2, vectors, cells, 1, place, overlap, friction);
    p.tilt[0] = lean * (1 - overlap);
    for (int i = 0; i < p.n; i++)
        sp_packing_wrap(&p, p.x + 3 * (size_t)i);
    add_contacts(&p);
    assert_ok(sp_packing_check(&p, &err));
    return p;
}

static inline sp_packing cells_triangular(int columns, int rows, double overlap, double friction) {
    const double vectors[3][3] = {{1}, {0.5, 0.5 * sqrt(3)}, {0, 0, 1}}, place[1][3] = {{0.3, 0.2}};
    const int cells[3] = {columns, rows, 1};
    return cells_lattice(2, vectors, cells, 1, place, overlap, friction);
}

/* In its cubic cell of 4 grains. */
static inline sp_packing cells_fcc(int across, double overlap, double friction) {
    const double a = sqrt(2), h = 0.5 * a, vectors[3][3] = {{a}, {0, a}, {0, 0, a}};
    const double place[4][3] = {
        {0.1, 0.1, 0.1}, {0.1 + h, 0.1 + h, 0.1}, {0.1 + h, 0.1, 0.1 + h}, {0.1, 0.1 + h, 0.1 + h}};
    const int cells[3] = {across, across, across};
    return cells_lattice(3, vectors, cells, 4, place, overlap, friction);
}

/* The same in its primitive cell, which is tilted along all axes. */
static inline sp_packing cells_fcc_tilted(int across, double overlap, double friction) {
    const double vectors[3][3] = {{1}, {0.5, sqrt(0.75)}, {0.5, sqrt(1 / 12.0), sqrt(2 / 3.0)}};
    const double place[1][3] = {{0.1, 0.1, 0.1}};
    const int cells[3] = {across, across, across};
    return cells_lattice(3, vectors, cells, 1, place, overlap, friction);
}

/* ---- at rest ---------------------------------------------------------------------------------------------------- */

/* Forces on the grains, [n][3]; returns the energy. */
static inline double cells_forces(const sp_packing *p, double *force) {
    double energy = 0;
    memset(force, 0, 3 * (size_t)p->n * sizeof *force);
    for (int k = 0; k < p->n_contacts; k++) {
        const sp_contact *c = &p->contacts[k];
        for (int a = 0; a < 3; a++) {
            force[3 * c->i + a] -= c->fn * c->n[a];
            if (c->j >= 0)
                force[3 * c->j + a] += c->fn * c->n[a];
        }
        energy += 0.4 * c->fn * c->overlap;
    }
    return energy;
}

/* FIRE (Bitzek et al., Phys. Rev. Lett. 97, 170201, 2006), until the largest force is below `most`. */
static inline void cells_relax(sp_packing *p, double most) {
    const int n = 3 * p->n;
    RELEASED double *v = calloc((size_t)n, sizeof *v), *f = calloc((size_t)n, sizeof *f);
    double h = 0.2, mix = 0.1, largest = 1;
    int since = 0, step = 0;
    for (; step < 200000 && largest > most; step++) {
        double power = 0, vv = 0, ff = 0;
        add_contacts(p);
        cells_forces(p, f);
        largest = 0;
        for (int k = 0; k < n; k++) {
            power += f[k] * v[k];
            vv += v[k] * v[k];
            ff += f[k] * f[k];
            largest = fmax(largest, fabs(f[k]));
        }
        since = power > 0 ? since + 1 : 0;
        for (int k = 0; k < n && ff > 0; k++)
            v[k] = power > 0 ? (1 - mix) * v[k] + mix * f[k] * sqrt(vv / ff) : 0;
        if (power <= 0) {
            h *= 0.5;
            mix = 0.1;
        } else if (since > 5) {
            h = fmin(1.1 * h, 1);
            mix *= 0.99;
        }
        for (int i = 0; i < p->n; i++) {
            for (int a = 0; a < 3; a++) {
                v[3 * i + a] += h * f[3 * i + a];
                p->x[3 * i + a] += h * v[3 * i + a];
            }
            sp_packing_wrap(p, p->x + 3 * (size_t)i);
        }
    }
    assert_true(largest <= most);
    add_contacts(p);
}

/* n grains of two sizes (ratio 1.4) that fill the fraction phi of a cell with edges of the same length, at rest. tilt:
 * of a periodic cell, over its edge. */
static inline sp_packing cells_packing(sp_cell cell, int dim, int n, double phi, const double tilt[3], double friction,
                                       unsigned seed) {
    sp_packing p = sp_packing_none();
    double filled = 0;
    assert_ok(sp_packing_alloc(&p, dim, n, 0, &err));
    srand(seed);
    p.cell = cell;
    p.friction = friction;
    p.poisson = 0.2;
    for (int i = 0; i < n; i++) {
        p.r[i] = 0.5 * (i % 2 ? 1.4 : 1) / 1.2;
        filled += dim == 2 ? 3.14159265358979 * p.r[i] * p.r[i] : grain_mass(p.r[i]);
    }
    for (int a = 0; a < dim; a++)
        p.box[a] = dim == 2 ? sqrt(filled / phi) : cbrt(filled / phi);
    for (int a = 0; a < 3 && tilt; a++)
        p.tilt[a] = tilt[a] * p.box[0];
    for (int i = 0; i < n; i++) {
        for (int a = 0; a < dim; a++)
            p.x[3 * i + a] = p.box[a] * (0.05 + 0.9 * (rand() / (double)RAND_MAX));
        sp_packing_wrap(&p, p.x + 3 * (size_t)i);
    }
    cells_relax(&p, 1e-14);
    assert_ok(sp_packing_check(&p, &err));
    return p;
}

#endif
