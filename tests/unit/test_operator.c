/* The compact operator against sp_network_apply, for all kinds of networks and any number of blocks. */
#include "base/base.h"
#include "carried.h"
#include "network/operator.h"
#include "reference.h"

#include <float.h>

typedef struct kind {
    const char *name;
    sp_packing p;
    bool prestress;
    int least, most; /* blocks */
} kind;

static sp_network network_of(const kind *k) { return network_with(&k->p, .prestress = k->prestress); }

/* Rows are a permutation of the grains, blocks and chunks follow each other, and blocks beside each other say so
 * mutually. */
static void check_order(const kind *k, const sp_operator *op) {
    RELEASED bool *seen = calloc((size_t)op->n, sizeof *seen);
    if (op->blocks < k->least || op->blocks > k->most)
        fail_msg("%s: %d blocks, expected %d .. %d", k->name, op->blocks, k->least, k->most);
    for (int row = 0; row < op->n; row++) {
        assert_false(seen[op->grain[row]]);
        seen[op->grain[row]] = true;
        assert_int_equal(op->row_of[op->grain[row]], row);
    }
    assert_int_equal(op->first[0], 0);
    assert_int_equal(op->first[op->blocks], op->n);
    for (int b = 0; b < op->blocks; b++) {
        assert_true(op->first[b + 1] > op->first[b] && op->first[b + 1] - op->first[b] <= op->largest);
        assert_int_equal(op->chunk_row[op->chunk[b]], op->first[b]);
        assert_int_equal(op->chunk_row[op->chunk[b + 1]], op->first[b + 1]);
        for (int q = op->adjacent_first[b]; q < op->adjacent_first[b + 1]; q++) {
            const int other = op->adjacent[q];
            bool mutual = false;
            for (int s = op->adjacent_first[other]; s < op->adjacent_first[other + 1]; s++)
                mutual = mutual || op->adjacent[s] == b;
            assert_true(mutual && other != b);
        }
    }
}

static void forces_of(const sp_operator *op, const double *u, double *force) {
    memset(force, 0, (size_t)op->n * (size_t)op->row * sizeof *force);
    for (int b = 0; b < op->blocks; b++)
        for (int c = op->chunk[b]; c < op->chunk[b + 1]; c++)
            sp_operator_force(op, b, c, u, force + (ptrdiff_t)op->first[b] * op->row);
}

static void check_forces(const kind *k, const sp_network *net, sp_operator *op) {
    const int64_t n = sp_network_dofs(net);
    const size_t size = ((size_t)op->n + 1) * (size_t)op->row;
    RELEASED double *u = calloc(2 * (size_t)n, sizeof *u), *ku = calloc((size_t)n, sizeof *ku);
    double *in = sp_alloc(size, sizeof *in), *out = sp_alloc(size, sizeof *out), *plain = sp_alloc(size, sizeof *plain);
    for (int64_t q = 0; q < 2 * n; q++)
        u[q] = 2.0 * rand() / RAND_MAX - 1;
    for (int lane = 0; lane < 2; lane++)
        for (int64_t q = 0; q < n; q++) {
            const int64_t row = op->row_of[q / op->dof], a = q % op->dof;
            in[sp_operator_at(op, q) + lane] = u[lane * n + q] * op->scale[row * op->dof + a];
        }
    forces_of(op, in, out);
    for (int lane = 0; lane < 2; lane++) {
        double largest = 0;
        if (op->kind.transposed)
            sp_network_apply_transposed(net, u + lane * n, ku);
        else
            sp_network_apply(net, u + lane * n, ku);
        for (int64_t q = 0; q < n; q++)
            largest = fmax(largest, fabs(ku[q]));
        for (int64_t q = 0; q < n; q++) {
            const int64_t row = op->row_of[q / op->dof], a = q % op->dof;
            const double force = out[sp_operator_at(op, q) + lane] * op->scale[row * op->dof + a];
            /* a few roundings of each of some ten springs */
            if (!(fabs(force - ku[q]) <= 50 * DBL_EPSILON * largest))
                fail_msg("%s: force %g, expected %g (largest %g)", k->name, force, ku[q], largest);
        }
    }
    if (op->wide) {
        op->wide = false;
        forces_of(op, in, plain);
        assert_memory_equal(out, plain, size * sizeof *out);
    }
    sp_free(plain);
    sp_free(out);
    sp_free(in);
}

TEST(test_forces) {
    kind all[] = {{"one ball", chain_packing(1, 1e-4), false, 1, 1},
                  {"chain", chain_packing(40, 1e-4), false, 1, 1},
                  {"long chain", chain_packing(5000, 1e-4), false, 4, 6},
                  {"2D", scattered_packing(2, 7, 0.5, 1), false, 1, 1},
                  {"2D, two grains wide", scattered_packing(2, 2, 0.5, 1), false, 1, 1},
                  {"2D, large", scattered_packing(2, 70, 0.5, 1), false, 4, 9},
                  {"2D with prestress, large", scattered_packing(2, 60, 0.5, 1), true, 3, 6},
                  {"2D without friction, large", scattered_packing(2, 60, 0, 2), false, 3, 6},
                  {"3D", scattered_packing(3, 4, 0.5, 3), false, 1, 1},
                  {"3D, large", scattered_packing(3, 14, 0.5, 3), false, 2, 5},
                  {"3D without friction, large", scattered_packing(3, 14, 0, 4), true, 2, 5},
                  {"2D with prestress, no friction", scattered_packing(2, 20, 0, 5), true, 1, 1},
                  {"2D with tangential forces", carried_packing(2, 52, 0.4, 43), true, 2, 4},
                  {"3D with prestress", scattered_packing(3, 6, 0.5, 3), true, 1, 1},
                  {"3D without friction", scattered_packing(3, 5, 0, 4), false, 1, 1},
                  {"3D with tangential forces", carried_packing(3, 14, 0.4, 43), true, 2, 5},
                  {"reference", reference_packing(REFERENCE("packing_N600_p1e-4.txt")), false, 1, 1}};
    srand(7);
    for (size_t q = 0; q < sizeof all / sizeof *all; q++) {
        FREED(sp_network) net = network_of(&all[q]);
        FREED(sp_operator) op = {0};
        assert_ok(sp_operator_make(&net, &op, &err));
        check_order(&all[q], &op);
        check_forces(&all[q], &net, &op);
        op.kind.transposed = true;
        check_forces(&all[q], &net, &op);
        sp_packing_free(&all[q].p);
    }
}

/* More grains than integers can number in a vector. */
TEST(test_too_many) {
    kind k = {"chain", chain_packing(3, 1e-4), false, 1, 1};
    FREED(sp_network) net = network_of(&k);
    const int32_t n = net.n;
    sp_operator op = {0};
    sp_error err = {0};
    net.n = INT32_MAX / 2;
    assert_int_equal(sp_operator_make(&net, &op, &err), SP_EREFUSED);
    net.n = n;
    sp_packing_free(&k.p);
}

/* Lever arms that are not the radii, and masses that differ between axes or rotations, are refused. */
TEST(test_refusals) {
    for (int which = 0; which < 4; which++) {
        kind k = {"levers", scattered_packing(which == 3 ? 3 : 2, 4, 0.5, 5), false, 1, 1};
        FREED(sp_network) net = network_of(&k);
        sp_operator op = {0};
        sp_error err = {0};
        if (which == 0)
            net.springs[3].rj *= 1.5;
        else if (which == 1)
            net.springs[2].ri *= 1.5;
        else
            net.mass[which == 2 ? 3 : 11] *= 2;
        assert_int_equal(sp_operator_make(&net, &op, &err), SP_EINVAL);
        assert_null(op.first);
        sp_packing_free(&k.p);
    }
}

TEST(test_no_memory) {
    kind k = {"chain", chain_packing(3000, 1e-4), false, 2, 4};
    FREED(sp_network) net = network_of(&k);
    sp_operator op = {0};
    EACH_ALLOCATION_FAILS(12, sp_operator_make(&net, &op, &err), assert_true(!lacks || !op.first),
                          sp_operator_free(&op));
    sp_packing_free(&k.p);
}

RUN_TESTS(NULL, NULL)
