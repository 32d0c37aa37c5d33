/* Moduli of cells without a piston: the whole tensor against closed forms and against energies of strained cells. */
#include "cells.h"
#include "elastic/strain.h"

#include <sonopack/elastic.h>

static const double tilted[3] = {0.3, -0.2, 0.4};

/* Threshold 0: a contact that carries little may still be stiff. */
static sp_network network_of(const sp_packing *p, bool prestress) {
    return network_by(p, (sp_network_options){.prestress = prestress});
}

static sp_elasticity elasticity_of(const sp_packing *p, bool prestress) {
    FREED(sp_network) net = network_of(p, prestress);
    sp_elasticity e;
    sp_moduli m;
    assert_ok(sp_elasticity_make(&net, 0.5, &m, &e, &err));
    assert_int_equal(e.strains, p->dim == 3 ? 6 : 3);
    assert_true(e.residual < 1e-8);
    assert_true(m.c11 == e.c[0][0] && m.c22 == e.c[1][1] && m.c12 == e.c[0][1] && m.c33 == e.c[2][2]);
    for (int a = 0; a < e.strains; a++)
        for (int b = 0; b < e.strains; b++) { /* each is measured by itself */
            assert_close(e.c[a][b], e.c[b][a], 1e-12 * e.c[0][0]);
            assert_true(e.error[a][b] < 1e-10 * e.c[0][0]);
        }
    return e;
}

/* ---- lattices --------------------------------------------------------------------------------------------------- */

/* k_n of the equal contacts of a lattice with this overlap, and its distance between neighbours. */
static double stiffness(double overlap) { return contact_normal_stiffness(contact_stiffness(0.5, 0.5), overlap); }

static void assert_tensor(const sp_elasticity *e, const double *expected, double tolerance) {
    for (int a = 0; a < e->strains; a++)
        for (int b = 0; b < e->strains; b++)
            assert_close(e->c[a][b], expected[a * e->strains + b], tolerance * expected[0]);
}

/* Square, smooth: columns and rows by themselves. With friction the shear stiffness is k_t/2: grains turn. The same
 * lattice in cells that lean by a column over their height. */
TEST(square_lattice) {
    const double overlap = 1e-7, k = stiffness(overlap), kt = k * contact_eta(0.2);
    for (int lean = -2; lean <= 2; lean++) {
        sp_packing p = cells_square(5, 4, lean, overlap, 0.3);
        const sp_elasticity e = elasticity_of(&p, false);
        const double c[] = {k, 0, 0, 0, k, 0, 0, 0, 0.5 * kt};
        assert_tensor(&e, c, 1e-6);
        assert_relative(e.bulk, 0.5 * k, 1e-6);
        assert_relative(e.shear, 0.25 * (k + kt), 1e-6);
        /* eigenvalues of the deviator: k and k_t, of the isotropic part twice their mean */
        assert_relative(e.anisotropy, sqrt(0.5) * (k - kt) / sqrt(2 * k * k + kt * kt), 1e-5);
        sp_packing_free(&p);
        p = cells_square(8, 8, lean, 0.01, 0); /* smooth: loads are rounding errors, and there are mechanisms */
        const sp_elasticity smooth = elasticity_of(&p, false);
        assert_close(smooth.c[2][2], 0, 1e-12 * smooth.c[0][0]);
        assert_relative(smooth.c[1][1], stiffness(0.01), 1e-9);
        sp_packing_free(&p);
    }
}

/* Isotropic: C11 = 3 sqrt(3)/4 k, C12 = C33 = sqrt(3)/4 k. */
TEST(triangular_lattice) {
    const double overlap = 0.01, k = 0.25 * sqrt(3) * stiffness(overlap);
    for (int rows = 3; rows <= 6; rows++) { /* tilts of 0 and of half a column, to both sides */
        FREED(sp_packing) p = cells_triangular(5, rows, overlap, 0);
        const sp_elasticity e = elasticity_of(&p, false);
        const double c[] = {3 * k, k, 0, k, 3 * k, 0, 0, 0, k};
        assert_tensor(&e, c, 1e-12);
        assert_relative(e.bulk, 2 * k, 1e-12);
        assert_relative(e.shear, k, 1e-12);
        assert_close(e.anisotropy, 0, 1e-12);
        assert_close(e.bulk, 2 * k, e.bulk_error + 1e-15 * k);
    }
}

/* Springs between neighbours in a cube of edge a: C11 = 2 k/a, C12 = C44 = k/a. The tilted primitive cell is turned:
 * its invariants are the same. */
TEST(fcc_lattice) {
    const double overlap = 0.01, k = stiffness(overlap) / (sqrt(2) * (1 - overlap));
    const double c[36] = {2 * k, k, k, 0, 0, 0, k, 2 * k, k, 0, 0, 0, k, k, 2 * k, 0, 0, 0,
                          0,     0, 0, k, 0, 0, 0, 0,     0, 0, k, 0, 0, 0, 0,     0, 0, k};
    FREED(sp_packing) cube = cells_fcc(3, overlap, 0), turned = cells_fcc_tilted(4, overlap, 0);
    const sp_elasticity e[2] = {elasticity_of(&cube, false), elasticity_of(&turned, false)};
    assert_tensor(&e[0], c, 1e-12);
    assert_true(fabs(turned.tilt[0]) > 0.1 && fabs(turned.tilt[1]) > 0.1 && fabs(turned.tilt[2]) > 0.1);
    for (int q = 0; q < 2; q++) {
        assert_relative(e[q].bulk, 4 * k / 3, 1e-12);
        assert_relative(e[q].shear, 0.8 * k, 1e-12);
        assert_relative(e[q].anisotropy, 0.2, 1e-12);
    }
}

/* The same lattice under a piston whose walls are like grains: one spring more up, one row of length less. */
TEST(piston_and_periodic) {
    const double overlap = 1e-6, across = 1 - overlap, height = 4 * across + 1 - 2 * overlap;
    FREED(sp_packing) p = cells_square(6, 5, 0, overlap, 0.3), piston = cells_square(6, 5, 0, overlap, 0.3);
    piston.cell = SP_CELL_PISTON;
    piston.wall = SP_WALL_GRAIN;
    piston.box[1] = height;
    for (int i = 0; i < piston.n; i++)
        piston.x[3 * i + 1] += 0.5 - overlap - 0.25 * across;
    add_contacts(&piston);
    FREED(sp_network) net = network_of(&piston, false);
    sp_moduli m;
    assert_ok(sp_moduli_make(&net, 0.5, &m, &err));
    const sp_elasticity e = elasticity_of(&p, false);
    assert_relative(m.c22, e.c[1][1] * height / (6 * across), 1e-5);
    assert_relative(m.c11, e.c[0][0] * 5 * across / height, 1e-5);
}

/* ---- strained cells --------------------------------------------------------------------------------------------- */

/* A copy whose cell has lattice vectors f times those of p, at rest. */
static sp_packing deformed(const sp_packing *p, const double f[3][3]) {
    sp_packing q = sp_packing_none();
    assert_ok(sp_packing_alloc(&q, p->dim, p->n, 0, &err));
    q.cell = p->cell;
    q.poisson = p->poisson;
    memcpy(q.r, p->r, (size_t)p->n * sizeof *q.r);
    const double a[3][3] = {{p->box[0]}, {p->tilt[0], p->box[1]}, {p->tilt[1], p->tilt[2], p->box[2]}};
    double v[3][3] = {{0}};
    for (int k = 0; k < 3; k++)
        for (int b = 0; b < 3; b++)
            for (int c = 0; c < 3; c++)
                v[k][b] += f[b][c] * a[k][c];
    for (int k = 0; k < 3; k++)
        q.box[k] = v[k][k];
    q.tilt[0] = v[1][0];
    q.tilt[1] = v[2][0];
    q.tilt[2] = v[2][1];
    for (int i = 0; i < p->n; i++)
        for (int b = 0; b < 3; b++)
            for (int c = 0; c < 3; c++)
                q.x[3 * i + b] += f[b][c] * p->x[3 * i + c];
    cells_relax(&q, 1e-15);
    assert_int_equal(q.n_contacts, p->n_contacts); /* else a smaller strain is needed */
    for (int k = 0; k < q.n_contacts; k++) {
        assert_int_equal(q.contacts[k].i, p->contacts[k].i);
        assert_int_equal(q.contacts[k].j, p->contacts[k].j);
    }
    return q;
}

/* dE/df_ij of the energy at rest: the sum of F_i times the branch vector before the strain. */
static void gradient(const sp_packing *q, const double f[3][3], double out[3][3]) {
    double inverse[3][3] = {{0}}; /* f is 1 plus entries above the diagonal and on it, one at a time */
    memset(out, 0, 9 * sizeof(double));
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++)
            inverse[a][b] = a == b ? 1 / f[a][a] : -f[a][b] / f[b][b] / f[a][a];
    for (int k = 0; k < q->n_contacts; k++) {
        const sp_contact *c = &q->contacts[k];
        const double length = q->r[c->i] + q->r[c->j] - c->overlap;
        for (int a = 0; a < 3; a++)
            for (int b = 0; b < 3; b++)
                for (int d = 0; d < 3; d++)
                    out[a][b] -= c->fn * c->n[a] * inverse[b][d] * length * c->n[d];
    }
}

/* The whole tensor with prestress is the second derivative of the energy of relaxed cells by the displacement gradient,
 * and K the change of the pressure with the volume: both by central differences of relaxed packings. */
TEST(energies_of_strained_cells) {
    static const int along[2][6] = {{0, 1, 0}, {0, 1, 2, 1, 0, 0}}, of[2][6] = {{0, 1, 1}, {0, 1, 2, 2, 2, 1}};
    const double step = 2e-6;
    for (int dim = 2; dim <= 3; dim++) {
        FREED(sp_packing) p = cells_packing(SP_CELL_PERIODIC, dim, dim == 2 ? 24 : 30, dim == 2 ? 0.95 : 0.75,
                                            dim == 2 ? (double[3]){-0.2} : tilted, 0, 11);
        const sp_elasticity e = elasticity_of(&p, true), plain = elasticity_of(&p, false);
        const double volume = sp_packing_volume(&p);
        double worst = 0, least = 0;
        for (int b = 0; b < e.strains; b++) {
            double change[3][3] = {{0}};
            for (int sign = -1; sign <= 1; sign += 2) {
                double f[3][3] = {{1}, {0, 1}, {0, 0, 1}}, g[3][3];
                f[along[dim - 2][b]][of[dim - 2][b]] += sign * step;
                FREED(sp_packing) q = deformed(&p, (const double(*)[3])f);
                gradient(&q, (const double(*)[3])f, g);
                for (int k = 0; k < 9; k++)
                    change[k / 3][k % 3] += sign * g[k / 3][k % 3] / (2 * step * volume);
            }
            for (int a = 0; a < e.strains; a++) {
                worst = fmax(worst, fabs(change[along[dim - 2][a]][of[dim - 2][a]] - e.c[a][b]) / e.c[0][0]);
                least = fmax(least, fabs(plain.c[a][b] - e.c[a][b]) / e.c[0][0]);
            }
        }
        assert_true(worst < 1e-6);
        assert_true(least > 1e-2); /* the prestress is not small here */
        /* no grain can move at a fixed cell, but the cell of the second would like to shear: that is no mechanism */
        assert_true(dim == 2 ? e.c[2][2] > 0 : e.c[3][3] < -0.05 * e.c[0][0]);
        double pressure[2];
        for (int k = 0; k < 2; k++) {
            const double s = 1 + (k ? step : -step), f[3][3] = {{s}, {0, s}, {0, 0, dim == 3 ? s : 1}};
            FREED(sp_packing) q = deformed(&p, f);
            pressure[k] = q.pressure;
        }
        assert_relative(e.bulk, (pressure[0] - pressure[1]) / (2 * step * dim), 1e-6);
    }
}

/* The full contact law at a small strain gives what the linear springs give, with friction, in periodic cells and
 * boxes; a larger strain changes contacts. */
TEST(finite_strains) {
    for (int q = 0; q < 4; q++) {
        const int dim = 2 + q / 2;
        FREED(sp_packing) p = cells_packing(q % 2 ? SP_CELL_BOX : SP_CELL_PERIODIC, dim, 24, dim == 2 ? 0.95 : 0.75,
                                            NULL, 0.4, 13 + (unsigned)q);
        FREED(sp_network) net = network_of(&p, false);
        sp_finite_strain_options o = sp_finite_strain_options_default();
        sp_finite_strain s;
        sp_moduli m;
        sp_elasticity e;
        o.turning = false;
        o.strain = 1e-8;
        assert_ok(sp_elasticity_make(&net, NAN, &m, &e, &err));
        assert_ok(sp_moduli_finite_strain(&p, &net, NAN, &o, &s, &err));
        assert_relative(s.moduli.c11, m.c11, 1e-5);
        assert_relative(s.moduli.c22, m.c22, 1e-5);
        assert_relative(s.moduli.c33, m.c33, 1e-5);
        assert_relative(dim == 3 ? s.moduli.c66 : s.moduli.c12, dim == 3 ? m.c66 : m.c12, 1e-5);
        assert_close(e.c[0][1], e.c[1][0], 1e-12 * e.c[0][0]); /* boxes, too */
        assert_true(e.bulk > 0 && e.shear > 0 && isnan(m.c_l));
    }
}

/* Rattlers and what floats do no harm; a cell that nothing crosses is floppy; probes need two walls. */
TEST(refusals) {
    FREED(sp_packing) p = cells_packing(SP_CELL_PERIODIC, 2, 30, 0.9, NULL, 0, 17),
                      piece = cells_triangular(5, 6, 0.01, 0);
    sp_network net = network_of(&p, false);
    const sp_probe probe = {SP_PROBE_SINE, 1};
    sp_probe_moduli measured;
    assert_fails(sp_moduli_probe(&net, 0.5, 1, &probe, NULL, &measured, &err), SP_EREFUSED, "piston");
    sp_network_free(&net);
    piece.box[0] *= 2;
    piece.box[1] *= 2;
    add_contacts(&piece);
    net = network_of(&piece, false);
    sp_elasticity e;
    assert_fails(sp_elasticity_make(&net, 0.5, NULL, &e, &err), SP_EREFUSED, "floppy");
    sp_network_free(&net);
}

RUN_TESTS(NULL, NULL)
