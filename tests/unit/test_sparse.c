/* Parts of spectra by the sparse solver, against all modes by the dense one. */
#include "base/base.h"
#include "modes/slices.h"
#include "reference.h"

#include <float.h>
#include <sonopack/modes.h>

static sp_network network_of(sp_packing p, bool prestress) {
    sp_network net = network_with(&p, .prestress = prestress);
    sp_packing_free(&p);
    return net;
}

enum { SHAPES = 11 };
static sp_network shape(int k) {
    switch (k) {
    case 0: return network_of(chain_packing(450, 1e-4), false);
    case 1: return network_of(scattered_packing(2, 12, 0.5, 1), false);
    case 2: return network_of(scattered_packing(2, 15, 0, 2), false); /* floppy */
    case 3: return network_of(scattered_packing(3, 5, 0.5, 3), false);
    case 4: return network_of(scattered_packing(3, 6, 0, 4), false);
    case 5: return network_of(reference_packing(REFERENCE("packing_N200_p1e-4.txt")), false);
    case 6: return network_of(without_tangential(reference_packing(REFERENCE("packing_N200_p1e-4.txt"))), true);
    case 7: return network_of(copies_of(scattered_packing(2, 9, 0.5, 5), 2), false);
    case 8: return network_of(copies_of(chain_packing(30, 1e-4), 20), false);
    case 9: return network_of(square_packing(14, 11, 0.5), false);
    default: return network_of(square_packing(17, 15, 0), false); /* every row and column slides: many zero modes */
    }
}

static sp_modes dense_of(const sp_network *net) {
    const sp_modes_options o = sp_modes_options_default();
    sp_modes m = sp_modes_none();
    assert_ok(sp_modes_dense(net, &o, &m, &err));
    return m;
}

/* How much of e lies in the dense solver's modes within `apart` of omega. */
static double share(const sp_modes *all, const double *e, double omega, double apart) {
    double sum = 0;
    for (int64_t k = all->n_rattler; k < all->n; k++) {
        if (fabs(all->omega[k] - omega) > apart)
            continue;
        const double *f = all->vectors + (k - all->n_rattler) * all->dofs;
        double part = 0;
        for (int64_t q = 0; q < all->dofs; q++)
            part += e[q] * f[q];
        sum += part * part;
    }
    return sum;
}

/* Rows of `part` are rows part->first .. of `all`, within both bounds, which are good ones. */
static void assert_part(const sp_modes *all, const sp_modes *part) {
    const double top = all->omega[all->n - 1];
    for (int64_t k = 0; k < part->n; k++) {
        const int64_t row = part->first + k;
        assert_true(row < all->n);
        assert_close(part->omega[k], all->omega[row], part->error[k] + all->error[row]);
        if (all->omega[row] > 1e-6 * top)
            assert_close(part->error[k], 0, 1e-10 * part->omega[k]);
        else
            assert_true(part->omega[k] == 0 && part->error[k] < 1e-6 * top);
        if (part->vectors && k >= part->n_rattler && k % 5 == 0) {
            const double *e = part->vectors + (k - part->n_rattler) * part->dofs;
            const double found = share(all, e, all->omega[row], 1e-5 * top);
            assert_true(found > 1 - 1e-6);
        }
    }
    if (part->vectors && part->n > part->n_rattler)
        assert_true(part->residual < 1e-10 && part->orthogonality < 1e-9);
}

static sp_modes_solver solver; /* of the present test */

static void assert_zeros(const sp_modes *all, const sp_modes *part) {
    assert_int_equal(part->zero.rattlers, all->zero.rattlers);
    assert_int_equal(part->zero.spins, all->zero.spins);
    assert_int_equal(part->zero.rigid, all->zero.rigid);
    assert_int_equal(part->zero.mechanisms, all->zero.mechanisms);
    assert_int_equal(part->zero.total, all->n_zero);
    assert_true(part->zero.below == all->zero.below);
}

static void check_lowest(const sp_network *net, const sp_modes *all, int64_t count, bool vectors, bool zero) {
    const sp_modes_options o = {.vectors = vectors, .solver = solver};
    sp_modes_range range = sp_modes_range_lowest(count);
    FREED(sp_modes) m = sp_modes_none();
    range.zero = zero;
    assert_ok(sp_modes_sparse(net, &o, &range, &m, &err));
    assert_int_equal(m.solver, solver == SP_SOLVER_AUTO ? SP_SOLVER_LANCZOS : solver);
    assert_int_equal(m.n, count + (zero ? all->n_zero : 0));
    assert_int_equal(m.n_rattler, zero ? all->n_rattler : 0);
    assert_int_equal(m.n_zero, zero ? all->n_zero : 0);
    assert_int_equal(m.first, zero ? 0 : all->n_zero);
    assert_zeros(all, &m);
    assert_part(all, &m);
    assert_true(m.certified_from == 0 && m.certified_to >= m.omega[m.n - 1] - 1e-9);
    if (m.first + m.n < all->n)
        assert_true(m.certified_to <= all->omega[m.first + m.n] + all->error[m.first + m.n]);
}

static void check_all(const sp_network *net, const sp_modes *all, bool vectors) {
    const sp_modes_options o = {.vectors = vectors, .solver = solver};
    const sp_modes_range range = sp_modes_range_all();
    FREED(sp_modes) m = sp_modes_none();
    assert_ok(sp_modes_sparse(net, &o, &range, &m, &err));
    assert_int_equal(m.n, all->n);
    assert_int_equal(m.n_zero, all->n_zero);
    assert_zeros(all, &m);
    assert_part(all, &m);
}

static void check_band(const sp_network *net, const sp_modes *all, double from, double to, bool vectors) {
    const sp_modes_options o = {.vectors = vectors, .solver = solver};
    const sp_modes_range range = sp_modes_range_band(from, to);
    FREED(sp_modes) m = sp_modes_none();
    int64_t below = 0, inside = 0, edge = 0;
    assert_ok(sp_modes_sparse(net, &o, &range, &m, &err));
    for (int64_t k = 0; k < all->n; k++) {
        edge += fabs(all->omega[k] - from) <= all->error[k] || fabs(all->omega[k] - to) <= all->error[k];
        below += all->omega[k] + all->error[k] < from;
        inside += all->omega[k] + all->error[k] >= from && all->omega[k] - all->error[k] <= to;
    }
    if (edge == 0 && m.on_edge == 0) {
        if (m.n != inside || m.first != below)
            fail_msg("band %.17g : %.17g: %lld modes after %lld, expected %lld after %lld", from, to, (long long)m.n,
                     (long long)m.first, (long long)inside, (long long)below);
    } else /* within its error of a limit a mode may be in or out, but is told of */
        assert_true(llabs(m.n - inside) <= edge + m.on_edge);
    assert_zeros(all, &m);
    assert_part(all, &m);
    if (m.n > 0) {
        assert_true(m.certified_from <= m.omega[0] + m.error[0]);
        assert_true(m.certified_to >= m.omega[m.n - 1] - m.error[m.n - 1]);
    }
}

static void check_parts(sp_modes_solver by) {
    solver = by;
    const unsigned seed = 11;
    print_message("seed %u\n", seed);
    srand(seed);
    for (int k = 0; k < SHAPES; k += SANITIZED_STEP(3) * (by == SP_SOLVER_ARPACK ? 2 : 1)) {
        FREED(sp_network) net = shape(k);
        FREED(sp_modes) all = dense_of(&net);
        const double top = all.omega[all.n - 1];
        check_lowest(&net, &all, 1, true, false);
        check_lowest(&net, &all, 17, k % 2, true);
        check_lowest(&net, &all, 60, !(k % 2), false);
        check_lowest(&net, &all, 210, k % 2, k % 3 == 0);
        check_all(&net, &all, k % 2);
        for (int q = 0; q < 3; q++) {
            const double x = 1.05 * top * rand() / RAND_MAX, y = x + 0.2 * top * rand() / RAND_MAX + 1e-9;
            check_band(&net, &all, x, y, q % 2);
        }
        /* limits right beside modes, at the ends of the spectrum, and beyond them */
        int64_t some = all.n - 40; /* one that stands alone */
        while (some > 10 && all.omega[some] - all.omega[some - 1] < 1e-6 * top)
            some--;
        check_band(&net, &all, all.omega[some] * (1 - 1e-9), all.omega[some] * (1 + 1e-9), true);
        check_band(&net, &all, all.omega[some] * (1 + 1e-12), all.omega[all.n - 5] * (1 - 1e-12), true);
        check_band(&net, &all, 0, 0.1 * top, true);
        check_band(&net, &all, 0.97 * top, HUGE_VAL, false);
        check_band(&net, &all, 1.2 * top, 1.3 * top, true);
        check_band(&net, &all, 1.2 * top, HUGE_VAL, false);
    }
}

TEST(test_parts) { check_parts(SP_SOLVER_AUTO); }

TEST(test_parts_by_arpack) { check_parts(SP_SOLVER_ARPACK); }

/* A limit that is a mode's own frequency: the mode is in, and told of. */
TEST(test_on_the_edge) {
    FREED(sp_network) net = shape(5);
    FREED(sp_modes) all = dense_of(&net), m = sp_modes_none();
    const sp_modes_options o = {.vectors = true};
    const int64_t some = all.n_rattler + 100;
    const sp_modes_range range = sp_modes_range_band(all.omega[some], all.omega[some + 7]);
    assert_ok(sp_modes_sparse(&net, &o, &range, &m, &err));
    assert_int_equal(m.first, some);
    assert_int_equal(m.n, 8);
    assert_int_equal(m.on_edge, 2);
}

/* Amplitudes do not depend on the solver: a b of a mode that stands alone. */
TEST(test_amplitudes) {
    FREED(sp_network) net = shape(5);
    FREED(sp_modes) all = dense_of(&net), m = sp_modes_none();
    const sp_modes_options o = {.vectors = true};
    const sp_modes_range range = sp_modes_range_lowest(50);
    assert_ok(sp_modes_sparse(&net, &o, &range, &m, &err));
    for (int64_t k = 0; k < m.n; k++) {
        assert_close(m.a[k], all.a[m.first + k], 1e-8);
        assert_close(m.b[k], all.b[m.first + k], 1e-8);
        assert_relative(m.participation[k], all.participation[m.first + k], 1e-6);
    }
}

TEST(test_refusals) {
    sp_network net = shape(5);
    const sp_modes_options o = sp_modes_options_default();
    FREED(sp_modes) m = sp_modes_none();
    const sp_modes_range bad[] = {{-1, 0, HUGE_VAL, false},
                                  {sp_network_dofs(&net) + 1, 0, HUGE_VAL, false},
                                  {1000000000000, 0, HUGE_VAL, true},
                                  {0, 1, 1, false},
                                  {0, 2, 1, false},
                                  {0, -0.1, 1, false},
                                  {0, NAN, 1, false},
                                  {0, 0, NAN, false},
                                  {0, 1, 2, true}, /* a band has its zero modes or it has not */
                                  {0, INFINITY, INFINITY, false}};
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        assert_fails(sp_modes_sparse(&net, &o, &bad[k], &m, &err), SP_EINVAL, "");
        assert_fails(sp_modes_make(&net, &o, &bad[k], &m, &err), SP_EINVAL, "");
        assert_null(m.omega);
    }
    sp_network_free(&net);
    /* nothing but prestress acts sideways: unstable */
    net = network_of(scattered_packing(2, 15, 0, 1), true);
    const sp_modes_range few = sp_modes_range_lowest(5);
    assert_fails(sp_modes_sparse(&net, &o, &few, &m, &err), SP_EREFUSED, "omega^2");
    sp_network_free(&net);
    /* one grain, and others too few for a sparse solver */
    net = network_of(chain_packing(1, 1e-4), false);
    const sp_modes_range one = sp_modes_range_lowest(1);
    assert_ok(sp_modes_make(&net, &o, &one, &m, &err));
    assert_int_equal(m.n, 1);
    sp_network_free(&net);
}

TEST(test_no_memory) {
    FREED(sp_network) net = shape(0);
    const sp_modes_range ranges[] = {sp_modes_range_lowest(3), sp_modes_range_band(0.2, 0.21)};
    for (int q = 0; q < 2; q++) {
        const sp_modes_options how = {.vectors = true};
        sp_modes m = sp_modes_none();
        EACH_ALLOCATION_FAILS(20, sp_modes_sparse(&net, &how, &ranges[q], &m, &err), assert_true(!lacks || !m.omega),
                              sp_modes_free(&m));
    }
}

/* All modes of a chain, in pieces: omega_n = omega_max sin(n pi/(2(N+1))), bit for bit the same with any
 * number of threads, and vectors of two pieces as orthogonal as those of one. */
static void check_pieces(bool vectors) {
    enum { N = 1300 };
    const double pi = 3.14159265358979323846;
    FREED(sp_network) net = network_of(chain_packing(N, 1e-4), false);
    sp_modes m[2] = {sp_modes_none(), sp_modes_none()};
    for (int q = 0; q < 2; q++) {
        const sp_modes_options how = {.vectors = vectors, .threads = q == 0 ? 1 : 3};
        const sp_modes_range all = sp_modes_range_all();
        assert_ok(sp_modes_sparse(&net, &how, &all, &m[q], &err));
        assert_int_equal(m[q].n, N);
        assert_int_equal(m[q].solver, SP_SOLVER_LANCZOS);
        assert_true(m[q].certified_from == 0 && isinf(m[q].certified_to));
    }
    assert_memory_equal(m[0].omega, m[1].omega, N * sizeof(double));
    assert_memory_equal(m[0].error, m[1].error, N * sizeof(double));
    assert_true(m[0].factors == m[1].factors && m[0].solves == m[1].solves);
    const double top = 2 * sqrt(net.springs[0].kn / net.mass[0]);
    for (int n = 1; n <= N; n++) {
        const double exact = top * sin(n * pi / (2 * (N + 1)));
        /* springs and masses of a packing are equal to some roundings, which move a frequency by as many */
        assert_close(m[0].omega[n - 1], exact, m[0].error[n - 1] + 1e-14 * exact);
        assert_true(m[0].error[n - 1] < 1e-9 * exact);
    }
    if (vectors) {
        assert_memory_equal(m[0].vectors, m[1].vectors, (size_t)m[0].dofs * N * sizeof(double));
        assert_true(m[0].orthogonality < 1e-9);
    }
    for (int q = 0; q < 2; q++)
        sp_modes_free(&m[q]);
}

TEST(test_pieces) {
    check_pieces(false);
    check_pieces(true);
}

RUN_TESTS(NULL, NULL)
