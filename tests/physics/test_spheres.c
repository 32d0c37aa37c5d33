/* Packings in three dimensions: at rest, sound, a function of scene and seed alone, and with the zero modes that
 * mechanics gives them. Their statistics are in test_spheres_long.c. */
#include "making.h"

#include "base/base.h"

#include <sonopack/modes.h>
#include <sonopack/packing.h>

/* The default tolerance 1e-6 p bounds |F|/(p d^2) of a grain by 1e-6 m: largest m is 0.9 unless the sizes are wide.
 * The motion that it leaves, v < 1e-8, changes F_n by less than 1e-4 of the weakest carrying contact in a step. */
static void assert_spheres_at_rest(const sp_packing *p) {
    double largest = 0, mean = 0;
    for (int32_t i = 0; i < p->n; i++) {
        largest = fmax(largest, p->r[i]);
        mean += 2 * p->r[i] / p->n;
    }
    assert_at_rest(p, fmax(1, 4.2 * pow(largest, 3) / (mean * mean)), 1e-4);
}

TEST(test_rest) {
    const double pressure[] = {1e-4, 1e-4, 1e-5}, friction[] = {0.5, 0, 0.1};
    for (int k = 0; k < 3; k++) {
        sp_pack_spec spec = spheres(80, 5, friction[k], 300 + (uint64_t)k);
        spec.pressure = pressure[k];
        spec.poisson = k == 2 ? 0.3 : 0;
        FREED(sp_packing) p = make_packing(&spec);
        assert_spheres_at_rest(&p);
        /* 80 x pi/6 x 1.04/(25 phi), phi from 0.5 to 0.7, and loose layers at two walls */
        assert_true(p.box[0] == 5 && p.box[1] == 5);
        assert_true(p.box[2] > 2.4 && p.box[2] < 4);
    }
}

/* A box that is no square, unequal and equal grains, no friction limit. */
TEST(test_odd_spheres) {
    sp_pack_spec spec[4] = {spheres(60, 5, 0.5, 1), spheres(50, 5, 1e6, 2), spheres(40, 5, 0.3, 3),
                            spheres(2, 5, 0.5, 4)};
    spec[0].depth = 6.5;
    spec[1].diameter_min = spec[1].diameter_max = 1;
    spec[2].sizes = SP_SIZES_BIDISPERSE;
    spec[2].diameter_min = 0.5;
    spec[2].diameter_max = 1.2;
    for (int k = 0; k < 4; k++) {
        FREED(sp_packing) p = make_packing(&spec[k]);
        assert_spheres_at_rest(&p);
        assert_true(p.box[1] == (spec[k].depth > 0 ? spec[k].depth : spec[k].width));
    }
}

TEST(test_determinism) {
    const sp_pack_spec spec = spheres(60, 5, 0.5, 5);
    const sp_pack_hooks hooks = {.threads = 2};
    FREED(sp_packing) p = make_packing(&spec), q = sp_packing_none();
    assert_ok(sp_packing_make_with(&spec, &hooks, &q, &err));
    assert_int_equal(p.n_contacts, q.n_contacts);
    assert_true(p.steps == q.steps);
    assert_memory_equal(p.x, q.x, (size_t)p.n * 24);
    assert_memory_equal(p.r, q.r, (size_t)p.n * 8);
    assert_memory_equal(p.contacts, q.contacts, (size_t)p.n_contacts * sizeof *p.contacts);
}

/* A tangential force lies in its contact's plane. */
TEST(test_tangential_forces) {
    const sp_pack_spec spec = spheres(60, 5, 0.5, 8);
    FREED(sp_packing) p = make_packing(&spec);
    int32_t large = 0;
    for (int32_t c = 0; c < p.n_contacts; c++) {
        const sp_contact *k = &p.contacts[c];
        double along = 0, size = 0;
        for (int a = 0; a < 3; a++) {
            along += k->ft[a] * k->n[a];
            size += k->ft[a] * k->ft[a];
        }
        large += sqrt(size) > 0.1 * k->fn;
        assert_true(fabs(along) <= 1e-8 * fmax(sqrt(size), 1e-4 * p.pressure));
    }
    assert_true(large > p.n_contacts / 10);
}

/* Grains of the network with two springs only. */
static int32_t count_bridges(const sp_network *net) {
    int32_t *springs = sp_alloc((size_t)net->n, sizeof *springs), bridges = 0;
    for (int32_t s = 0; s < net->n_springs; s++) {
        springs[net->springs[s].i]++;
        if (net->springs[s].j >= 0)
            springs[net->springs[s].j]++;
    }
    for (int32_t i = 0; i < net->n; i++)
        bridges += springs[i] == 2;
    sp_free(springs);
    return bridges;
}

/* With friction a grain that is held at two points turns freely about the line through them. Without friction the
 * whole packing slides freely along the smooth walls, and nothing else does. */
TEST(test_zero_modes) {
    int32_t seen = 0;
    for (uint64_t seed = 1; seed <= 3; seed++) {
        sp_pack_spec spec = spheres(100, 5, seed == 3 ? 0 : 0.5, seed);
        spec.tolerance = 1e-4 * spec.pressure;
        FREED(sp_packing) p = make_packing(&spec);
        FREED(sp_network) net = sp_network_none();
        FREED(sp_modes) modes = sp_modes_none();
        const sp_network_options options = sp_network_options_default();
        const sp_modes_options all = sp_modes_options_default();
        assert_ok(sp_network_make(&p, &options, &net, &err));
        assert_int_equal(net.dof, seed == 3 ? 3 : 6);
        assert_ok(sp_modes_dense(&net, &all, &modes, &err));
        const int32_t bridges = count_bridges(&net);
        assert_int_equal(modes.n_rattler, net.dof * net.rattlers);
        assert_int_equal(modes.n_zero - modes.n_rattler, seed == 3 ? 2 : bridges);
        seen += seed == 3 ? 0 : bridges;
    }
    assert_true(seen > 0);
}

RUN_TESTS(NULL, NULL)
