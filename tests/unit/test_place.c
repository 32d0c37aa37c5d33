/* Places of sources and detectors: the parts make the whole, and momentum is balanced. */
#include "carried.h"
#include "cells.h"

#include <sonopack/network.h>
#include <sonopack/signal.h>

static sp_network network_of(sp_packing *p, bool prestress) {
    sp_network net = network_by(p, (sp_network_options){.prestress = prestress});
    sp_packing_free(p);
    return net;
}

static double *random_vector(const sp_network *net, unsigned seed) {
    double *u = malloc((size_t)sp_network_dofs(net) * sizeof *u);
    srand(seed);
    for (int64_t k = 0; k < sp_network_dofs(net); k++)
        u[k] = rand() / (double)RAND_MAX - 0.5;
    return u;
}

static double seen(const sp_network *net, const sp_place *at, const double *u) {
    double *row = malloc((size_t)sp_network_dofs(net) * sizeof *row), sum = 0;
    assert_ok(sp_network_detector_at(net, at, row, &err));
    for (int64_t k = 0; k < sp_network_dofs(net); k++)
        sum += row[k] * u[k];
    free(row);
    return sum;
}

/* The force on all that lies above a plane: what comes through the plane, less what goes on to the top wall, or in a
 * periodic cell through its lowest plane. */
static void planes_balance(sp_packing p, bool prestress, bool shear) {
    FREED(sp_network) net = network_of(&p, prestress);
    RELEASED double *u = random_vector(&net, 7), *ku = malloc((size_t)sp_network_dofs(&net) * sizeof *ku);
    const int axis = shear ? 0 : net.dim - 1;
    const sp_place top = {.kind = net.cell == SP_CELL_PERIODIC ? SP_PLACE_PLANE : SP_PLACE_WALL, .shear = shear};
    double scale = 0;
    sp_network_apply(&net, u, ku);
    for (int64_t k = 0; k < sp_network_dofs(&net); k++)
        scale += fabs(ku[k]);
    for (int part = 1; part < 8; part++) {
        const sp_place plane = {.kind = SP_PLACE_PLANE, .shear = shear, .height = part * net.box[net.dim - 1] / 8};
        double force = 0;
        for (int32_t i = 0; i < net.n; i++)
            if (net.x[3 * i + net.dim - 1] > plane.height)
                force -= ku[(int64_t)i * net.dof + axis];
        assert_close(seen(&net, &plane, u) - seen(&net, &top, u), force, 1e-15 * scale);
        if (net.dim > 1)
            assert_close(sp_network_plane_height(&net, plane.height), plane.height, 0.5);
    }
}

TEST(momentum_is_balanced) {
    for (int prestress = 0; prestress < 2; prestress++)
        for (int dim = 2; dim <= 3; dim++) {
            planes_balance(scattered_packing(dim, 5, 0.5, 3), prestress, false);
            planes_balance(scattered_packing(dim, 5, 0.5, 4), prestress, true);
            planes_balance(scattered_packing(dim, 5, 0, 5), prestress, false);
            planes_balance(carried_packing(dim, 5, 0.4, 6), prestress, false);
            planes_balance(carried_packing(dim, 5, 0.4, 7), prestress, true);
            for (int k = 0; k < 4; k++)
                planes_balance(cells_packing(SP_CELL_PERIODIC, dim, dim == 2 ? 40 : 48, dim == 2 ? 0.9 : 0.7,
                                             (double[3]){0.3, dim == 2 ? 0 : -0.2, dim == 2 ? 0 : 0.4}, k % 2 ? 0.3 : 0,
                                             1 + (unsigned)k),
                               prestress, k / 2);
        }
    planes_balance(chain_packing(9, 1e-4), false, false);
}

TEST(parts_make_the_whole) {
    sp_packing p = scattered_packing(2, 6, 0.5, 11);
    FREED(sp_network) net = network_of(&p, false);
    RELEASED double *u = random_vector(&net, 12);
    for (int shear = 0; shear < 2; shear++) {
        const sp_place whole = {.shear = shear};
        const double cut = 0.37 * net.box[0];
        const sp_place left = {.kind = SP_PLACE_PART, .shear = shear, .to = cut};
        const sp_place right = {.kind = SP_PLACE_PART, .shear = shear, .from = cut, .to = net.box[0]};
        const double all = seen(&net, &whole, u);
        double grains = 0;
        assert_close(seen(&net, &left, u) + seen(&net, &right, u), all, 1e-14);
        for (int32_t k = net.n_bulk; k < net.n_springs; k++)
            if (net.springs[k].j == SP_TOP) {
                const sp_place one = {.kind = SP_PLACE_GRAIN, .shear = shear, .grain = net.grain[net.springs[k].i]};
                grains += seen(&net, &one, u);
            }
        assert_close(grains, all, 1e-14);
    }
}

/* A disc sees what the grains within its radius see, those across the period too; one over the corner has four parts.
 */
TEST(discs) {
    sp_packing p = scattered_packing(3, 5, 0.5, 21);
    FREED(sp_network) net = network_of(&p, false);
    RELEASED double *u = random_vector(&net, 22);
    const sp_place at[] = {{.kind = SP_PLACE_DISC, .x = 2, .y = 2.5, .diameter = 3},
                           {.kind = SP_PLACE_DISC, .shear = true, .diameter = 3.5}};
    for (int d = 0; d < 2; d++) {
        double sum = 0;
        int in = 0, out = 0;
        for (int32_t k = net.n_bulk; k < net.n_springs; k++) {
            const double *x = net.x + 3 * net.springs[k].i;
            const sp_place one = {.kind = SP_PLACE_GRAIN, .shear = at[d].shear, .grain = net.grain[net.springs[k].i]};
            if (net.springs[k].j != SP_TOP)
                continue;
            bool inside = false;
            for (int image = 0; image < 9; image++)
                inside = inside || hypot(x[0] - at[d].x + (image % 3 - 1) * net.box[0],
                                         x[1] - at[d].y + (image / 3 - 1) * net.box[1]) <= at[d].diameter / 2;
            sum += inside ? seen(&net, &one, u) : 0;
            in += inside;
            out += !inside;
        }
        assert_true(in > 2 && out > 2);
        assert_close(seen(&net, &at[d], u), sum, 1e-14);
    }
    const sp_place bad[] = {{.kind = SP_PLACE_DISC, .x = -1, .y = 1, .diameter = 2},
                            {.kind = SP_PLACE_DISC, .x = 1, .y = 1e3, .diameter = 2},
                            {.kind = SP_PLACE_DISC, .x = NAN, .y = 1, .diameter = 2},
                            {.kind = SP_PLACE_DISC, .x = 1, .y = 1, .diameter = 1e3},
                            {.kind = SP_PLACE_DISC, .x = 1, .y = 1, .diameter = NAN}};
    for (int k = 0; k < 5; k++)
        assert_fails(sp_network_detector_at(&net, &bad[k], u, &err), SP_EINVAL, "disc");
    char text[SP_PLACE_TEXT];
    sp_place back;
    assert_ok(sp_place_read(sp_place_text(&at[1], false, text), false, &back, NULL, &err));
    assert_true(back.kind == SP_PLACE_DISC && back.shear && back.diameter == 3.5);
}

/* A grain inside: the net force on it; as a source a unit of momentum. */
TEST(grains_inside) {
    sp_packing p = scattered_packing(2, 6, 0.5, 13);
    FREED(sp_network) net = network_of(&p, true);
    const int64_t n = sp_network_dofs(&net);
    RELEASED double *u = random_vector(&net, 14), *ku = malloc((size_t)n * sizeof *ku);
    sp_network_apply(&net, u, ku);
    int32_t inside = -1;
    for (int32_t i = 0; i < net.n; i++)
        if (fabs(net.x[3 * i + 1] - 0.5 * net.box[1]) < 0.6)
            inside = i;
    for (int shear = 0; shear < 2; shear++) {
        const sp_place at = {.kind = SP_PLACE_GRAIN, .shear = shear, .grain = net.grain[inside]};
        const int64_t dof = (int64_t)inside * net.dof + (shear ? 0 : 1);
        assert_close(seen(&net, &at, u), -ku[dof], 1e-14);
        const sp_source kinds[] = {SP_SOURCE_IMPULSE, SP_SOURCE_VELOCITY, SP_SOURCE_DISPLACEMENT};
        for (int q = 0; q < 3; q++) {
            assert_ok(sp_network_source_at(&net, kinds[q], &at, ku, &err));
            for (int64_t k = 0; k < n; k++)
                assert_close(ku[k], k != dof ? 0 : q == 1 ? net.mass[dof] : 1, 0);
        }
        sp_network_apply(&net, u, ku);
    }
}

/* A wall that moves along x pushes its grains and turns them: force balance of a single grain on the wall. */
TEST(shear_turns) {
    sp_packing p = scattered_packing(2, 5, 0.5, 15);
    FREED(sp_network) net = network_of(&p, false);
    RELEASED double *out = malloc((size_t)sp_network_dofs(&net) * sizeof *out);
    const sp_place at = {.shear = true};
    assert_ok(sp_network_source_at(&net, SP_SOURCE_IMPULSE, &at, out, &err));
    for (int32_t k = net.n_bulk; k < net.n_springs; k++) {
        const sp_spring *s = &net.springs[k];
        if (s->j != SP_BOTTOM)
            continue;
        assert_relative(out[3 * s->i], s->kt, 1e-15);
        assert_close(out[3 * s->i + 1], 0, 0);
        /* the wall below drags the grain's lowest point to the right: it turns against the clock */
        assert_relative(out[3 * s->i + 2], s->kt * s->ri, 1e-15);
    }
}

TEST(wrong_places) {
    sp_packing p = scattered_packing(2, 5, 0, 17), chain = chain_packing(4, 1e-4);
    FREED(sp_network) net = network_of(&p, false), row = network_of(&chain, false);
    RELEASED double *out = malloc((size_t)sp_network_dofs(&net) * sizeof *out);
    const double heights[] = {0, -1, NAN, INFINITY, net.box[1]};
    for (int k = 0; k < 5; k++) {
        const sp_place at = {.kind = SP_PLACE_PLANE, .height = heights[k]};
        assert_fails(sp_network_detector_at(&net, &at, out, &err), SP_EINVAL, "0");
    }
    const sp_place bad[] = {{.kind = SP_PLACE_PART, .from = 2, .to = 1},
                            {.kind = SP_PLACE_PART, .from = NAN, .to = 1},
                            {.kind = SP_PLACE_PART, .from = -1, .to = 1},
                            {.kind = SP_PLACE_PART, .to = 1e3}};
    for (int k = 0; k < 4; k++)
        assert_fails(sp_network_detector_at(&net, &bad[k], out, &err), SP_EINVAL, "interval");
    const sp_place empty = {.kind = SP_PLACE_PART, .to = 1e-9};
    assert_fails(sp_network_detector_at(&net, &empty, out, &err), SP_EREFUSED, "");
    const sp_place shear = {.shear = true};
    assert_fails(sp_network_detector_at(&net, &shear, out, &err), SP_EREFUSED, "friction");
    assert_fails(sp_network_source_at(&net, SP_SOURCE_IMPULSE, &shear, out, &err), SP_EREFUSED, "friction");
    assert_fails(sp_network_source_at(&row, SP_SOURCE_IMPULSE, &shear, out, &err), SP_EINVAL, "");
    const sp_place far = {.kind = SP_PLACE_GRAIN, .grain = 1000}, none = {.kind = SP_PLACE_GRAIN, .grain = -1};
    assert_fails(sp_network_detector_at(&net, &far, out, &err), SP_EINVAL, "1000");
    assert_fails(sp_network_detector_at(&net, &none, out, &err), SP_EINVAL, "-1");
}

RUN_TESTS(NULL, NULL)
