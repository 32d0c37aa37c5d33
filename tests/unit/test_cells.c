/* Cells without a piston: zero modes, places of sources and detectors, statics. */
#include "base/base.h"
#include "cells.h"
#include "packing/bulk.h"

#include <sonopack/modes.h>

static const double tilted[3] = {0.3, -0.2, 0.4};

static sp_network network_of(const sp_packing *p, bool prestress) { return network_with(p, .prestress = prestress); }

/* Four packings: both dimensions, with and without friction, in tilted cells. */
enum { PACKINGS = 4 };
static sp_packing packing(int k) {
    return cells_packing(SP_CELL_PERIODIC, 2 + k / 2, k < 2 ? 40 : 48, k < 2 ? 0.9 : 0.7,
                         k < 2 ? (double[3]){0.3} : tilted, k % 2 ? 0.3 : 0, 1 + (unsigned)k);
}

TEST(packings_are_at_rest) {
    for (int k = 0; k < PACKINGS; k++) {
        FREED(sp_packing) p = packing(k);
        sp_audit a;
        assert_ok(sp_packing_audit(&p, 1e-4, &a, &err));
        assert_true(a.force_residual < 1e-9 && a.wall_residual < 1e-12 && a.missing == 0);
    }
}

/* ---- zero modes ------------------------------------------------------------------------------------------------- */

/* Translations of the cell are all that springs do not resist: with friction no rotation is free, since the cell cannot
 * turn. Dense and sparse solvers, counts and null motions agree. */
TEST(translations_are_free) {
    for (int k = 0; k < 2 * PACKINGS; k++) {
        FREED(sp_packing) p = packing(k / 2);
        FREED(sp_network) net = network_of(&p, k % 2);
        const sp_modes_options o = sp_modes_options_default();
        const sp_modes_range all = sp_modes_range_all(), few = sp_modes_range_lowest(4);
        FREED(sp_modes) dense = sp_modes_none(), sparse = sp_modes_none(), low = sp_modes_none();
        sp_zero_modes z;
        assert_ok(sp_zero_modes_count(&net, &z, &err));
        assert_int_equal(z.rigid, p.dim);
        assert_int_equal(z.mechanisms, 0);
        assert_int_equal(z.spins, 0);
        assert_ok(sp_modes_dense(&net, &o, &dense, &err));
        assert_ok(sp_modes_sparse(&net, &o, &all, &sparse, &err));
        assert_ok(sp_modes_sparse(&net, &o, &few, &low, &err));
        assert_int_equal(dense.n_zero, z.total);
        assert_int_equal(sparse.n_zero, z.total);
        assert_int_equal(low.first, z.total);
        for (int q = 0; q < 4; q++) {
            const double omega = dense.omega[dense.n_zero + q];
            assert_true(omega > 1e-3);
            assert_close(low.omega[q], omega, 1e-9);
            assert_close(sparse.omega[sparse.n_zero + q], omega, 1e-9);
        }
        assert_true(isnan(dense.a[0]) && isnan(dense.b[0])); /* no walls */
    }
}

/* A box holds its grains. A piece of a lattice that floats in a periodic cell turns, too. */
TEST(boxes_hold_and_pieces_turn) {
    for (int dim = 2; dim <= 3; dim++) {
        FREED(sp_packing) box = cells_packing(SP_CELL_BOX, dim, 40, dim == 2 ? 0.95 : 0.75, NULL, 0, 5);
        FREED(sp_packing) piece = dim == 2 ? cells_triangular(5, 6, 0.01, 0) : cells_fcc(3, 0.01, 0);
        sp_network net = network_of(&box, false);
        sp_zero_modes z;
        assert_true(net.n_springs - net.n_bulk > 2 * dim);
        assert_ok(sp_zero_modes_count(&net, &z, &err));
        assert_int_equal(z.rigid + z.mechanisms + z.spins, 0);
        sp_network_free(&net);
        for (int a = 0; a < dim; a++)
            piece.box[a] *= 2; /* far from its images, across which the piece is cut */
        add_contacts(&piece);
        net = network_of(&piece, false);
        assert_ok(sp_zero_modes_count(&net, &z, &err));
        assert_int_equal(z.rigid, dim == 2 ? 3 : 6);
        for (int i = 0; i < piece.n; i++) { /* the cut goes through it */
            piece.x[3 * i] -= 2;
            sp_packing_wrap(&piece, piece.x + 3 * (size_t)i);
        }
        add_contacts(&piece);
        sp_network_free(&net);
        net = network_of(&piece, false);
        assert_ok(sp_zero_modes_count(&net, &z, &err));
        assert_int_equal(z.rigid, dim == 2 ? 3 : 6);
        sp_network_free(&net);
    }
}

/* ---- places ----------------------------------------------------------------------------------------------------- */

/* A plane moves the grains of its layer, across the period, and nothing else; in every kind of cell. */
TEST(planes_are_sources) {
    for (int cell = 0; cell < 3; cell++) {
        FREED(sp_packing) p = cells_packing((sp_cell)cell, 2, 40, 0.95, NULL, 0.3, 6);
        FREED(sp_network) net = network_of(&p, false);
        const int64_t n = sp_network_dofs(&net);
        RELEASED double *out = malloc((size_t)n * sizeof *out);
        for (int kind = SP_SOURCE_IMPULSE; kind <= SP_SOURCE_DISPLACEMENT; kind++) {
            const sp_place at = {.kind = SP_PLACE_PLANE, .height = 0.2};
            int moved = 0, around = 0;
            assert_ok(sp_network_source_at(&net, (sp_source)kind, &at, out, &err));
            for (int64_t k = 0; k < n; k++) {
                const double y = net.x[3 * (k / net.dof) + 1];
                const bool above = y >= 0.2 - 0.5 && y < 0.7, image = p.cell == SP_CELL_PERIODIC && y >= p.box[1] - 0.3;
                const bool in = k % net.dof == 1 && (above || image);
                assert_close(out[k], !in ? 0 : kind == SP_SOURCE_VELOCITY ? net.mass[k] : 1, 0);
                moved += in;
                around += in && image;
            }
            assert_true(moved > 2 && (around > 0) == (p.cell == SP_CELL_PERIODIC));
        }
    }
}

TEST(walls_are_refused) {
    FREED(sp_packing) p = packing(1);
    sp_network net = network_of(&p, false);
    double *out = malloc((size_t)sp_network_dofs(&net) * sizeof *out);
    const sp_place places[] = {{.kind = SP_PLACE_WALL}, {.kind = SP_PLACE_PART, .to = 1}};
    for (int k = 0; k < 2; k++) {
        assert_fails(sp_network_source_at(&net, SP_SOURCE_IMPULSE, &places[k], out, &err), SP_EREFUSED,
                     "bottom plane:Y");
        assert_fails(sp_network_detector_at(&net, &places[k], out, &err), SP_EREFUSED, "top plane:Y");
    }
    const double heights[] = {-0.1, NAN, INFINITY, p.box[1]};
    for (int k = 0; k < 4; k++) {
        const sp_place at = {.kind = SP_PLACE_PLANE, .height = heights[k]};
        assert_fails(sp_network_detector_at(&net, &at, out, &err), SP_EINVAL, "plane 0");
        assert_fails(sp_network_source_at(&net, SP_SOURCE_IMPULSE, &at, out, &err), SP_EINVAL, "plane 0");
    }
    free(out);
    sp_network_free(&net);
    sp_packing thin = cells_square(5, 8, 0, 1e-4, 0); /* rows at 0.25, 1.25, ... */
    thin.box[1] *= 2;                                 /* a gap above them */
    add_contacts(&thin);
    net = network_of(&thin, false);
    out = malloc((size_t)sp_network_dofs(&net) * sizeof *out);
    const sp_place gap = {.kind = SP_PLACE_PLANE, .height = 12};
    assert_fails(sp_network_source_at(&net, SP_SOURCE_IMPULSE, &gap, out, &err), SP_EREFUSED, "12");
    free(out);
    sp_network_free(&net);
    sp_packing_free(&thin);
}

/* ---- statics ---------------------------------------------------------------------------------------------------- */

/* Nothing is left out of a periodic cell; its stress has the pressure as its mean. */
TEST(statics_of_the_cell) {
    for (int k = 0; k < PACKINGS; k++) {
        FREED(sp_packing) p = packing(k);
        sp_statics s, wide;
        assert_ok(sp_statics_make(&p, 1e-4, 3, &s, &err));
        assert_ok(sp_statics_make(&p, 1e-4, 1e3, &wide, &err));
        assert_true(s.phi3 == wide.phi3 && s.zs == wide.zs);
        assert_relative(p.dim == 2 ? s.phi2 : s.phi3, p.dim == 2 ? 0.9 : 0.7, 1e-12);
        assert_relative(s.s_xx + s.s_yy + (p.dim == 3 ? s.s_zz : 0), p.dim * p.pressure, 1e-9);
        assert_true(p.dim == 3 || (isnan(s.s_zz) && isnan(s.s_yz) && isnan(s.s_xz)));
        assert_relative(s.s12_over_s2, (p.dim == 3 ? s.s_xz : s.s_xy) / (p.dim == 3 ? s.s_zz : s.s_yy), 1e-9);
        assert_true(s.zs > (p.friction > 0 ? 2 : 2 * p.dim) && s.zs < 4 * p.dim);
        int bonds = 0, rattlers = 0;
        RELEASED uint8_t *carrying = malloc((size_t)p.n_contacts);
        assert_ok(sp_packing_rattlers(&p, 1e-4, NULL, carrying, &rattlers, &err));
        for (int c = 0; c < p.n_contacts; c++)
            bonds += carrying[c];
        assert_relative(s.zs, 2.0 * bonds / (p.n - rattlers), 1e-12);
    }
}

/* Shares of grains at the edges and corners of the bulk of a box: halves of halves by symmetry, else by Monte Carlo. */
TEST(bulk_of_a_box) {
    FREED(sp_packing) p = cells_packing(SP_CELL_BOX, 3, 20, 0.6, NULL, 0, 8);
    const bulk b = sp_bulk_of(&p, 0.5);
    const double r = 0.4, edge = p.box[0] - 1, middle = 0.5 * p.box[0];
    assert_relative(b.volume, edge * edge * edge, 1e-12);
    const double places[][3] = {{0.5, 0.5, 0.5}, {0.5, middle, 0.5}, {middle, middle, 0.5}, {middle, middle, middle}};
    const double parts[] = {0.125, 0.25, 0.5, 1};
    for (int k = 0; k < 4; k++)
        assert_close(sp_bulk_ball(&b, places[k], r), parts[k], 1e-14);
    const double off[3] = {0.6, 0.45, 0.7};
    int inside = 0, all = 0;
    for (int dim = 2; dim <= 3; dim++)
        for (int place = 0; place < 20; place++) { /* the parts on all sides of planes through a ball are all of it */
            const double x[3] = {0.3 * sin(place), 0.35 * sin(2 * place + 1), dim == 3 ? 0.4 * sin(3 * place + 2) : 0};
            double whole = 0;
            for (int side = 0; side < 1 << dim; side++) {
                bulk part = b;
                part.dim = dim;
                for (int a = 0; a < dim; a++) {
                    part.low[a] = side >> a & 1 ? 0 : -9;
                    part.high[a] = side >> a & 1 ? 9 : 0;
                }
                whole += sp_bulk_ball(&part, x, r);
            }
            assert_close(whole, 1, 1e-13);
        }
    srand(9);
    for (int k = 0; k < 400000; k++) {
        double x[3], square = 0;
        for (int a = 0; a < 3; a++) {
            x[a] = r * (2.0 * rand() / RAND_MAX - 1);
            square += x[a] * x[a];
            x[a] += off[a];
        }
        all += square < r * r;
        inside += square < r * r && sp_bulk_has(&b, x);
    }
    assert_close(sp_bulk_ball(&b, off, r), inside / (double)all, 4e-3);
}

RUN_TESTS(NULL, NULL)
