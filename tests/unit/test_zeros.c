/* Zero modes told apart from each other and from soft modes. */
#include "base/base.h"
#include "modes/refine.h"
#include "reference.h"

#include <sonopack/modes.h>

static sp_network network_of(sp_packing p) {
    sp_network net = default_network(&p);
    sp_packing_free(&p);
    return net;
}

/* All modes by both solvers; the numbers must agree. *softest: lowest frequency above 0. */
static sp_zero_modes count_all(const sp_network *net, double *softest) {
    const sp_modes_options o = sp_modes_options_default();
    const sp_modes_range all = sp_modes_range_all(), few = sp_modes_range_lowest(3);
    sp_modes m[3] = {sp_modes_none(), sp_modes_none(), sp_modes_none()};
    sp_zero_modes alone;
    assert_ok(sp_modes_dense(net, &o, &m[0], &err));
    assert_ok(sp_modes_sparse(net, &o, &all, &m[1], &err));
    assert_ok(sp_modes_sparse(net, &o, &few, &m[2], &err));
    assert_ok(sp_zero_modes_count(net, &alone, &err));
    const sp_zero_modes z = m[0].zero, others[] = {m[1].zero, m[2].zero, alone};
    for (int k = 0; k < 3; k++) {
        assert_int_equal(others[k].rattlers, z.rattlers);
        assert_int_equal(others[k].spins, z.spins);
        assert_int_equal(others[k].rigid, z.rigid);
        assert_int_equal(others[k].mechanisms, z.mechanisms);
        assert_int_equal(others[k].total, z.rattlers + z.spins + z.rigid + z.mechanisms);
    }
    *softest = m[0].omega[m[0].n_zero];
    for (int k = 0; k < 2; k++) {
        const int64_t zeros = m[k].n_zero;
        assert_int_equal(zeros, z.total);
        assert_close(m[k].omega[zeros], *softest, m[k].error[zeros] + m[0].error[m[0].n_zero]);
        assert_true(m[k].omega[zeros] > z.below && m[k].orthogonality < 1e-9);
    }
    assert_int_equal(m[2].n, 3);
    assert_int_equal(m[2].first, z.total);
    assert_close(m[2].omega[0], *softest, m[2].error[0] + m[0].error[m[0].n_zero]);
    for (int k = 0; k < 3; k++)
        sp_modes_free(&m[k]);
    return z;
}

/* Springs between grain i and the next one of a row, or i and a wall. */
static void scale(sp_network *net, int32_t i, int32_t j, double factor) {
    int found = 0;
    for (int32_t k = 0; k < net->n_springs; k++) {
        sp_spring *s = &net->springs[k];
        if ((s->i == i && s->j == j) || (s->i == j && s->j == i)) {
            s->kn *= factor;
            s->kt *= factor;
            found++;
        }
    }
    assert_int_equal(found, 1);
}

/* A piece of a row that hangs on nothing, and one of another row, 50 balls that hangs on two springs as weak as the
 * last digits of the others: omega^2 = 2 k weak/(50 m), if it is no zero mode. */
TEST(test_weak_springs) {
    const double weak[] = {1e-6, 1e-11, 1e-13, 1e-15};
    for (int q = 0; q < 4; q++) {
        FREED(sp_network) net = network_of(chains_packing(2, 225, 1e-4));
        const double k = net.springs[0].kn, mass = net.mass[0];
        double softest;
        scale(&net, 100, 101, 0);
        scale(&net, 150, 151, 0);
        scale(&net, 300, 301, weak[q]);
        scale(&net, 350, 351, weak[q]);
        const sp_zero_modes z = count_all(&net, &softest);
        assert_int_equal(z.rigid, 1);
        assert_int_equal(z.mechanisms, q == 3);
        if (q < 3)
            assert_relative(softest, sqrt(2 * k * weak[q] / (50 * mass)), 1e-4 + 50 * weak[q]);
    }
}

/* How many zero modes there are does not depend on how weak some springs are, as long as they are there. Soft modes and
 * zero modes are then nearer to each other than the errors of an eigensolver. */
TEST(test_weakened) {
    const unsigned seed = 5;
    print_message("seed %u\n", seed);
    for (int trial = 0; trial < 2; trial++) {
        sp_zero_modes z[2];
        double softest[2];
        for (int q = 0; q < 2; q++) {
            FREED(sp_network) net = network_of(reference_packing(REFERENCE("packing_N200_p1e-4.txt")));
            srand(seed + (unsigned)trial);
            for (int32_t k = 0; k < net.n_springs; k++) {
                const int lot = rand() % 100;
                const double factor = lot < 10 ? 0 : lot < 30 && q == 1 ? 1e-8 : 1;
                net.springs[k].kn *= factor;
                net.springs[k].kt *= factor;
            }
            z[q] = count_all(&net, &softest[q]);
        }
        assert_true(z[0].mechanisms > 0);
        assert_int_equal(z[1].total, z[0].total);
        assert_int_equal(z[1].mechanisms, z[0].mechanisms);
        assert_true(softest[1] < 1e-3 * softest[0]);
    }
}

/* Two of the frequencies of a long row are the ends of a spectrum ten thousand wide; nothing of it is zero. */
TEST(test_long_row) {
    enum { BALLS = 10000 };
    FREED(sp_network) net = network_of(chain_packing(BALLS, 1e-4));
    const double omega = 2 * sqrt(net.springs[0].kn / net.mass[0]) * sin(M_PI / (2 * (BALLS + 1)));
    const sp_modes_options o = {.vectors = false};
    const sp_modes_range range = sp_modes_range_lowest(2);
    FREED(sp_modes) m = sp_modes_none();
    assert_ok(sp_modes_sparse(&net, &o, &range, &m, &err));
    assert_int_equal(m.zero.total, 0);
    assert_relative(m.omega[0], omega, 1e-9);
}

/* All rows slide: one rigid motion and 14 mechanisms. One column hangs on weak springs besides, and eigensolvers mix
 * its motion with those of the rows. Many more mechanisms than a slice of the sparse solver holds. */
TEST(test_mixed) {
    enum { ACROSS = 17, UP = 15 };
    for (int q = 0; q < 3; q += SANITIZED_STEP(3)) {
        FREED(sp_network) net = network_of(square_packing(ACROSS, UP, 0));
        const double weak = q == 1 ? 1e-9 : 1e-13;
        double softest;
        if (q > 0) {
            scale(&net, 3, SP_BOTTOM, weak);
            scale(&net, ACROSS * (UP - 1) + 3, SP_TOP, weak);
        }
        const sp_zero_modes z = count_all(&net, &softest);
        assert_int_equal(z.rattlers + z.spins, 0);
        assert_int_equal(z.rigid, 1);
        assert_int_equal(z.mechanisms, UP - 1);
        const double wall = net.springs[net.n_springs - 1].kn, mass = net.mass[0];
        if (q > 0)
            assert_relative(softest, sqrt(2 * wall * weak / (UP * mass)), 1e-4);
    }
    double softest;
    FREED(sp_network) net = network_of(square_packing(3, 120, 0));
    assert_int_equal(count_all(&net, &softest).mechanisms, 119);
}

/* Grains that touch all others and nothing else, around the edge of the periodic box. */
static sp_packing cluster(int dim, int grains, double apart) {
    static const double corner[4][3] = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
    sp_packing p = sp_packing_none();
    assert_ok(sp_packing_alloc(&p, dim, grains, grains * (grains - 1) / 2, &err));
    int count = 0;
    double at[4][3];
    for (int i = 0; i < grains; i++) {
        p.r[i] = 0.5;
        for (int a = 0; a < 3; a++)
            at[i][a] = dim == 3 ? apart / sqrt(8) * corner[i][a]
                       : a == 0 ? apart / sqrt(3) * cos(2 * M_PI * i / 3 + 0.1)
                       : a == 1 ? apart / sqrt(3) * sin(2 * M_PI * i / 3 + 0.1)
                                : 0;
        for (int a = 0; a < dim; a++)
            p.x[3 * i + a] = a == dim - 1 ? 3 + at[i][a] : at[i][a] < 0 ? at[i][a] + 6 : at[i][a];
    }
    for (int i = 0; i < grains; i++)
        for (int j = i + 1; j < grains; j++) {
            sp_contact *c = &p.contacts[count++];
            *c = (sp_contact){.i = i, .j = j, .overlap = 0.05, .fn = 0.01};
            for (int a = 0; a < dim; a++)
                c->n[a] = (at[j][a] - at[i][a]) / apart;
        }
    for (int a = 0; a < 3; a++)
        p.box[a] = a < dim ? 6 : 1;
    p.pressure = 1e-4;
    p.friction = 0.5;
    sp_packing_sort(&p);
    return p;
}

/* A body in space: it moves and turns as a whole, and each of three spheres about the line through its two contacts. If
 * the centres are nearer than the sum of the lever arms, grains that turn with the body slip on each other; of alike
 * grains, a somewhat slower turn does not, which is no rigid motion. */
TEST(test_clusters) {
    const struct {
        int dim, grains;
        double apart;
        int spins, rigid, mechanisms;
    } cases[] = {{2, 3, 1, 0, 3, 0}, {3, 3, 1, 3, 6, 0}, {3, 4, 1, 0, 6, 0}, {2, 3, 0.95, 0, 2, 1}};
    for (size_t q = 0; q < sizeof cases / sizeof *cases; q++) {
        FREED(sp_network) net = network_of(cluster(cases[q].dim, cases[q].grains, cases[q].apart));
        sp_zero_modes z;
        assert_ok(sp_zero_modes_count(&net, &z, &err));
        print_message("%d grains in %d dimensions: %d spins, %d rigid, %d mechanisms\n", cases[q].grains, cases[q].dim,
                      (int)z.spins, (int)z.rigid, (int)z.mechanisms);
        assert_int_equal(z.spins, cases[q].spins);
        assert_int_equal(z.rigid, cases[q].rigid);
        assert_int_equal(z.mechanisms, cases[q].mechanisms);
    }
}

/* Known null motions are orthonormal, and K makes nothing of them. */
TEST(test_null_motions) {
    sp_network nets[] = {network_of(scattered_packing(3, 5, 0.5, 3)), network_of(cluster(3, 3, 1)),
                         network_of(square_packing(5, 4, 0))};
    for (size_t q = 0; q < 3; q++) {
        const sp_network *net = &nets[q];
        const size_t n = (size_t)sp_network_dofs(net);
        FREED(sp_null_motions) z = {0};
        assert_ok(sp_null_motions_make(net, &z, &err));
        const int64_t count = z.spins + z.rigid;
        assert_true(count > 0 || q == 0);
        double *e = sp_alloc((size_t)count, n * sizeof *e), *u = sp_alloc(2 * n, sizeof *u);
        for (int64_t k = 0; k < count; k++) {
            sp_null_motions_vector(net, &z, k, e + (size_t)k * n);
            for (int64_t m = 0; m <= k; m++) {
                double dot = 0;
                for (size_t i = 0; i < n; i++)
                    dot += e[(size_t)k * n + i] * e[(size_t)m * n + i];
                assert_close(dot, k == m, 1e-13);
            }
            for (size_t i = 0; i < n; i++)
                u[i] = e[(size_t)k * n + i] / sqrt(net->mass[i]);
            assert_true(sp_network_energy2(net, u) < 1e-26 * net->omega_bound * net->omega_bound);
            assert_close(sp_null_motions_remove(net, &z, e + (size_t)k * n), 1, 1e-13);
            for (size_t i = 0; i < n; i++)
                assert_close(e[(size_t)k * n + i], 0, 1e-14);
            sp_null_motions_vector(net, &z, k, e + (size_t)k * n);
        }
        sp_free(u);
        sp_free(e);
        sp_network_free(&nets[q]);
    }
}

/* What lies on neither side of the limit is refused. */
TEST(test_undecided) {
    FREED(sp_network) net = network_of(chain_packing(5, 1e-4));
    const double limit = sp_zero_limit(&net);
    int64_t zeros = -1;
    const sp_ritz good[] = {{0, 1e-3 * limit, 0, 1e-3 * limit},
                            {0.1 * limit, 9 * limit, 0, 1e-3 * limit},
                            {20 * limit, 3 * limit, 0, 1e-3 * limit}};
    assert_ok(sp_zeros_count(&net, 3, good, 0, &zeros, &err));
    assert_int_equal(zeros, 2); /* the energy of the second is known better than its place in the spectrum */
    const sp_ritz near[] = {{0, 1e-3 * limit, 0, 1e-3 * limit}, {1.5 * limit, 0.6 * limit, 0, 0.1 * limit}};
    assert_fails(sp_zeros_count(&net, 2, near, 0, &zeros, &err), SP_EREFUSED, "");
    const sp_ritz many[] = {{0.6 * limit, 1e-3 * limit, 0, 0}, {0.6 * limit, 1e-3 * limit, 0, 0}};
    assert_fails(sp_zeros_count(&net, 2, many, 0, &zeros, &err), SP_EREFUSED, "");
    net.prestress = true;
    const sp_ritz below[] = {{-1000 * sp_zero_limit(&net), sp_zero_limit(&net), 0, 0}};
    assert_fails(sp_zeros_count(&net, 1, below, 0, &zeros, &err), SP_EREFUSED, "");
}

TEST(test_bad_input) {
    const sp_modes_options o = {.vectors = true};
    sp_modes m = sp_modes_none();
    for (int q = 0; q < 2; q++) { /* by the dense solver, and by the sparse one: 23 x 10 has 460 */
        const int across = q ? 23 : 5, up = q ? 10 : 15;
        FREED(sp_network) net = network_of(square_packing(across, up, 0));
        const int64_t most = 2 * across * up - up;
        sp_modes_range range = sp_modes_range_lowest(most);
        assert_ok(sp_modes_sparse(&net, &o, &range, &m, &err));
        assert_int_equal(m.n, most);
        sp_modes_free(&m);
        range.lowest++;
        assert_fails(sp_modes_sparse(&net, &o, &range, &m, &err), SP_EINVAL, "");
        assert_fails(sp_modes_make(&net, &o, &range, &m, &err), SP_EINVAL, "");
        range = sp_modes_range_band(0, 1);
        range.zero = true;
        assert_fails(sp_modes_make(&net, &o, &range, &m, &err), SP_EINVAL, "");
        assert_null(m.omega);
    }
}

TEST(test_no_memory) {
    FREED(sp_network) net = network_of(square_packing(7, 5, 0));
    sp_zero_modes z = {.total = -7};
    EACH_ALLOCATION_FAILS(20, sp_zero_modes_count(&net, &z, &err), assert_int_equal(z.total, lacks ? -7 : 5));
}

RUN_TESTS(NULL, NULL)
