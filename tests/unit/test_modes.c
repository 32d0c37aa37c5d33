#include "base/base.h"
#include "modes/refine.h"
#include "signals.h"

#include <float.h>
#include <sonopack/modes.h>

static sp_modes modes_of(const sp_network *net, bool vectors, sp_source source) {
    const sp_modes_options o = {.vectors = vectors, .source = source};
    sp_modes m = sp_modes_none();
    assert_ok(sp_modes_dense(net, &o, &m, &err));
    return m;
}

/* Zero modes, lowest and highest frequency as the signal files state them (15 digits). */
TEST(test_reference) {
    const struct {
        const char *path;
        int zero;
        double lowest, highest;
    } files[] = {{REFERENCE("packing_N200_p1e-4.txt"), 75, 0.021510778807657, 1.32075118533096},
                 {REFERENCE("packing_N600_p1e-4.txt"), 117, 0.00978025096601649, 1.39444106040785}};
    for (int q = 0; q < 2; q++) {
        FREED(sp_packing) p = reference_packing(files[q].path);
        FREED(sp_network) net = network_of(&p, false);
        FREED(sp_modes) m = modes_of(&net, false, SP_SOURCE_IMPULSE);
        assert_int_equal(m.n, 3 * p.n);
        assert_int_equal(m.n_rattler, files[q].zero);
        assert_int_equal(m.n_zero, files[q].zero);
        for (int64_t k = 0; k < m.n; k++)
            assert_true(k < m.n_zero ? m.omega[k] == 0 : m.omega[k] > 0 && m.omega[k] >= m.omega[k - 1]);
        /* theirs come from a dense solver alone, right to some DBL_EPSILON of the highest squared */
        const double blur = 100 * DBL_EPSILON * files[q].highest * files[q].highest;
        assert_close(m.omega[m.n_zero], files[q].lowest, blur / files[q].lowest + 1e-14);
        assert_close(m.omega[m.n - 1], files[q].highest, 1e-13);
        assert_null(m.vectors);
        assert_true(isnan(m.residual) && isnan(m.orthogonality));
        const double bound = sp_network_omega_bound(&net);
        assert_true(bound >= m.omega[m.n - 1] && bound < 1.06 * m.omega[m.n - 1]);
    }
}

static sp_packing shape_packing(int shape) {
    switch (shape) {
    case 0: return chain_packing(40, 1e-4);
    case 1: return scattered_packing(2, 8, 0.5, 1);
    case 2: return scattered_packing(2, 8, 0, 2);
    case 3: return scattered_packing(3, 4, 0.5, 3);
    case 4: return scattered_packing(3, 4, 0, 4);
    default: return reference_packing(REFERENCE("packing_N200_p1e-4.txt"));
    }
}
enum { SHAPES = 6 };

/* Both ways to the frequencies agree within their bounds, soft modes relative to themselves. */
TEST(test_two_ways) {
    for (int shape = 0; shape < SHAPES; shape++) {
        FREED(sp_packing) p = shape_packing(shape);
        FREED(sp_network) net = network_of(&p, false);
        FREED(sp_modes) whole = modes_of(&net, true, SP_SOURCE_IMPULSE),
                        bare = modes_of(&net, false, SP_SOURCE_IMPULSE);
        assert_int_equal(whole.n, bare.n);
        assert_int_equal(whole.n_zero, bare.n_zero);
        for (int64_t k = 0; k < whole.n; k++) {
            assert_close(bare.omega[k], whole.omega[k], whole.error[k] + bare.error[k]);
            if (k >= whole.n_zero && whole.omega[k] > 1e-3 * whole.omega[whole.n - 1]) {
                assert_relative(bare.omega[k], whole.omega[k], 1e-13);
                assert_true(bare.error[k] < 1e-12 * whole.omega[k] && whole.error[k] < 1e-12 * whole.omega[k]);
            }
        }
        assert_true(whole.residual < 1e-14 && whole.orthogonality < 1e-13);
        assert_true(sp_network_omega_bound(&net) >= whole.omega[whole.n - 1]);
    }
}

/* Vectors are eigenvectors of K, orthonormal, largest part positive; the squares of the frequencies add up to the trace
 * of M^-1 K. */
TEST(test_vectors) {
    for (int shape = 0; shape < SHAPES - 1; shape++) {
        FREED(sp_packing) p = shape_packing(shape);
        FREED(sp_network) net = network_of(&p, false);
        FREED(sp_modes) m = modes_of(&net, true, SP_SOURCE_IMPULSE);
        const int64_t n = m.dofs;
        double *u = calloc(2 * (size_t)n, sizeof *u), *ku = u + n, trace = 0, sum = 0;
        const double top = m.omega[m.n - 1] * m.omega[m.n - 1];
        for (int64_t k = 0; k < n; k++) {
            const double *e = m.vectors + k * n, omega = m.omega[m.n_rattler + k];
            double largest = 0;
            for (int64_t q = 0; q < n; q++) {
                u[q] = e[q] / sqrt(net.mass[q]);
                largest = fabs(e[q]) > fabs(largest) ? e[q] : largest;
            }
            assert_true(largest > 0);
            sp_network_apply(&net, u, ku);
            for (int64_t q = 0; q < n; q++)
                assert_close(ku[q] / sqrt(net.mass[q]), omega * omega * e[q], 100 * DBL_EPSILON * top);
            sum += omega * omega;
        }
        FREED(sp_sparse) a;
        assert_ok(sp_network_assemble(&net, &a, &err));
        for (int64_t q = 0; q < n; q++)
            trace += a.x[a.p[q]] / net.mass[q];
        assert_relative(sum, trace, 1e-13);
        free(u);
    }
}

/* Completeness: sum a_n u_n is the initial displacement, sum a_n omega_n u_n the initial velocity, and b_n what the
 * detector sees of a mode. */
TEST(test_amplitudes) {
    FREED(sp_packing) p = shape_packing(5);
    FREED(sp_network) net = network_of(&p, false);
    const int64_t n = sp_network_dofs(&net);
    double *sent = calloc(3 * (size_t)n, sizeof *sent), *seen = sent + n, *sum = sent + 2 * n;
    const sp_source sources[] = {SP_SOURCE_IMPULSE, SP_SOURCE_VELOCITY, SP_SOURCE_DISPLACEMENT};
    assert_ok(sp_network_detector(&net, seen, &err));
    for (int q = 0; q < 3; q++) {
        FREED(sp_modes) m = modes_of(&net, true, sources[q]);
        assert_ok(sp_network_source(&net, sources[q], sent, &err));
        for (int64_t d = 0; d < n; d++)
            sum[d] = 0;
        for (int64_t k = m.n_rattler; k < m.n; k++) {
            const double *e = m.vectors + (k - m.n_rattler) * n;
            double b = 0;
            for (int64_t d = 0; d < n; d++) {
                const double u = e[d] / sqrt(net.mass[d]);
                sum[d] += m.a[k] * u * (sources[q] == SP_SOURCE_DISPLACEMENT ? 1 : m.omega[k]);
                b += seen[d] * u;
            }
            assert_close(m.b[k], b, 1e-14);
            assert_true(m.participation[k] > 0.9 / net.n && m.participation[k] <= 1);
        }
        for (int64_t d = 0; d < n; d++)
            assert_close(sum[d], sources[q] == SP_SOURCE_DISPLACEMENT ? sent[d] : sent[d] / net.mass[d], 1e-13);
        for (int64_t k = 0; k < m.n_rattler; k++)
            assert_true(m.a[k] == 0 && m.b[k] == 0);
    }
    free(sent);
}

/* Without friction nothing holds the grains along the walls: one floppy mode, found as exactly 0, and modes much softer
 * than sqrt(DBL_EPSILON) of the highest are told from it. */
TEST(test_floppy) {
    sp_packing p = scattered_packing(2, 12, 0, 1);
    sp_network net = network_of(&p, false);
    for (int vectors = 0; vectors < 2; vectors++) {
        FREED(sp_modes) m = modes_of(&net, vectors, SP_SOURCE_IMPULSE);
        assert_int_equal(m.n_rattler, 0);
        assert_int_equal(m.n_zero, 1);
        assert_true(m.omega[0] == 0 && m.error[0] < 1e-7 && m.omega[1] > 0);
        if (vectors)
            assert_true(m.a[0] == 0 && fabs(m.b[0]) < 1e-12); /* moves along the walls: no force on them */
    }
    sp_network_free(&net);
    /* chains side by side, all the same: every frequency many times, and bounds that hold all the same */
    sp_packing_free(&p);
    enum { CHAINS = 5, LONG = 30 };
    p = chains_packing(CHAINS, LONG, 1e-4);
    net = network_of(&p, false);
    for (int vectors = 0; vectors < 2; vectors++) {
        FREED(sp_modes) m = modes_of(&net, vectors, SP_SOURCE_IMPULSE);
        const long double top = 2 * sqrtl((long double)net.springs[0].kn / net.mass[0]);
        for (int64_t k = 0; k < m.n; k++) {
            const double exact =
                (double)(top * sinl((long double)(k / CHAINS + 1) * 3.14159265358979323846264L / (2 * (LONG + 1))));
            assert_close(m.omega[k], exact, m.error[k]);
            assert_true(m.error[k] < 1e-12 * exact);
        }
    }
    sp_network_free(&net);
    sp_packing_free(&p);
}

TEST(test_prestress) {
    sp_packing p = without_tangential(reference_packing(REFERENCE("packing_N200_p1e-4.txt")));
    sp_network net = network_of(&p, true);
    FREED(sp_modes) with = modes_of(&net, true, SP_SOURCE_IMPULSE);
    sp_network_free(&net);
    net = network_of(&p, false);
    FREED(sp_modes) without = modes_of(&net, true, SP_SOURCE_IMPULSE);
    /* compression softens every mode (Weyl: the added term is negative) */
    for (int64_t k = with.n_zero; k < with.n; k++)
        assert_true(with.omega[k] < without.omega[k]);
    assert_true(with.omega[with.n_zero] < 0.99 * without.omega[with.n_zero]);
    sp_network_free(&net);
    sp_packing_free(&p);
    p = scattered_packing(2, 6, 0, 1); /* nothing but prestress acts sideways: unstable */
    net = network_of(&p, true);
    const sp_modes_options o = sp_modes_options_default();
    sp_modes m = sp_modes_none();
    assert_fails(sp_modes_dense(&net, &o, &m, &err), SP_EREFUSED, "omega^2");
    assert_null(m.omega);
    sp_network_free(&net);
    sp_packing_free(&p);
}

TEST(test_participation) {
    enum { N = 60 };
    FREED(sp_packing) p = chain_packing(N, 1e-4);
    FREED(sp_network) net = network_of(&p, false);
    FREED(sp_modes) m = modes_of(&net, true, SP_SOURCE_IMPULSE);
    for (int n = 1; n <= N; n++) /* of w_i = sin^2: 2(N+1)/(3N) */
        assert_relative(m.participation[n - 1], 2.0 * (N + 1) / (3.0 * N), 1e-11);
}

static sp_packing lattice_packing(double friction) {
    sp_pack_spec spec = sp_pack_spec_default();
    sp_packing p = sp_packing_none();
    spec.kind = SP_PACK_TRIANGULAR;
    spec.grains = 256;
    spec.width = 16;
    spec.friction = friction;
    assert_ok(sp_packing_make(&spec, NULL, NULL, &p, &err));
    return p;
}

/* Networks above 400 degrees of freedom: LAPACK's values are not exact enough for soft modes, which the sparse solver
 * finds again; where it refuses, or has too many to find, LAPACK's vectors are refined. All are right to 1e-12. */
TEST(test_frequencies_alone) {
    for (int shape = 0; shape < 5; shape++) {
        FREED(sp_packing) p = shape == 0   ? reference_packing(REFERENCE("packing_N200_p1e-4.txt"))
                              : shape == 1 ? chain_packing(500, 1e-4)
                              : shape == 2 ? lattice_packing(0.5)
                              : shape == 3 ? lattice_packing(0)
                                           : chains_packing(25, 20, 1e-4);
        FREED(sp_network) net = network_of(&p, false);
        assert_true(sp_network_dofs(&net) > 400);
        FREED(sp_modes) m = modes_of(&net, false, SP_SOURCE_IMPULSE), v = modes_of(&net, true, SP_SOURCE_IMPULSE);
        assert_int_equal(m.n, v.n);
        assert_int_equal(m.n_zero, v.n_zero);
        assert_int_equal(m.solver, SP_SOLVER_DENSE);
        for (int64_t k = 0; k < m.n; k++) {
            assert_close(m.omega[k], v.omega[k], m.error[k] + v.error[k]);
            assert_true(m.omega[k] == 0 || m.error[k] < 1.01e-12 * m.omega[k]);
        }
    }
}

static void lack_memory(const sp_network *net, bool vectors, int least) {
    FREED(sp_modes) m = sp_modes_none();
    const sp_modes_options how = {.vectors = vectors, .source = SP_SOURCE_IMPULSE};
    EACH_ALLOCATION_FAILS(least, sp_modes_dense(net, &how, &m, &err), assert_true(!lacks || !m.omega));
}

TEST(test_refusals) {
    sp_packing p = chain_packing(20001, 1e-4);
    sp_network net = network_of(&p, false);
    const sp_modes_options o = sp_modes_options_default();
    sp_modes m = sp_modes_none();
    assert_fails(sp_modes_dense(&net, &o, &m, &err), SP_EREFUSED, "20001");
    sp_network_free(&net);
    sp_packing_free(&p);
    p = chain_packing(12, 1e-4);
    net = network_of(&p, false);
    lack_memory(&net, false, 8);
    lack_memory(&net, true, 8);
    sp_network_free(&net);
    sp_packing_free(&p);
    p = chain_packing(401, 1e-4);
    net = network_of(&p, false);
    lack_memory(&net, false, 30);
    sp_network_free(&net);
    sp_packing_free(&p);
}

RUN_TESTS(NULL, NULL)
