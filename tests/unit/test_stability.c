/* Verdicts of stability: discs around eigenvalues, counts, and networks made to diverge and to flutter. */
#include "carried.h"
#include "making.h"

#include "linalg/discs.h"
#include "linalg/eigen.h"

#include <sonopack/modes.h>

/* ---- discs ---------------------------------------------------------------------------------------------------- */

/* All entries of an n x n matrix by columns, as a sparse one. */
static sp_sparse dense_of(int64_t n, const double *a) {
    sp_sparse s = {.n = n};
    s.p = sp_alloc((size_t)n + 1, sizeof *s.p);
    s.i = sp_alloc((size_t)(n * n), sizeof *s.i);
    s.x = sp_alloc((size_t)(n * n), sizeof *s.x);
    for (int64_t c = 0; c < n; c++) {
        s.p[c + 1] = n * (c + 1);
        for (int64_t r = 0; r < n; r++) {
            s.i[n * c + r] = r;
            s.x[n * c + r] = a[n * c + r];
        }
    }
    return s;
}

/* Q^-1 B Q with B of known eigenvalues: real ones, and pairs, near each other and far. Q = 1 + a strictly triangular
 * matrix of integers, and so is its inverse: the product is exact. */
TEST(test_discs) {
    enum { N = 12 };
    double b[N][N] = {{0}}, q[N][N] = {{0}}, inverse[N][N] = {{0}}, half[N][N] = {{0}}, a[N * N] = {0};
    double re[N], im[N];
    srand(3);
    for (int k = 0; k < N; k++) {
        re[k] = k < 4 ? k / 4.0 - 0.5 : k / 2;
        im[k] = k < 4 ? 0 : (k % 2 ? -1 : 1) * ldexp(1, -k / 2);
        b[k][k] = re[k];
        if (im[k] > 0) {
            b[k][k + 1] = im[k];
            b[k + 1][k] = -im[k];
        }
        q[k][k] = 1;
        if (k + 1 < N) /* one diagonal beside that of ones: powers of it make the inverse */
            q[k][k + 1] = k % 3 - 1;
    }
    for (int r = N - 1; r >= 0; r--)
        for (int c = 0; c < N; c++)
            inverse[r][c] = (r == c) - (r + 1 < N ? q[r][r + 1] * inverse[r + 1][c] : 0);
    for (int r = 0; r < N; r++)
        for (int c = 0; c < N; c++)
            for (int k = 0; k < N; k++)
                half[r][c] += b[r][k] * q[k][c];
    for (int r = 0; r < N; r++)
        for (int c = 0; c < N; c++)
            for (int k = 0; k < N; k++)
                a[N * c + r] += inverse[r][k] * half[k][c];
    sp_sparse s = dense_of(N, a);
    sp_discs d;
    assert_ok(sp_discs_make(&s, NULL, NULL, false, &d, &err));
    for (int k = 0; k < N; k++) {
        int held = 0;
        for (int m = 0; m < N; m++)
            held += hypot(d.re[m] - re[k], d.im[m] - im[k]) <= d.radius[m];
        assert_int_equal(held, 1);
        assert_true(d.radius[k] < 1e-10);
    }
    sp_discs_free(&d);
    sp_sparse_free(&s);
    const double jordan[] = {1, 0, 1, 1}; /* one eigenvector */
    s = dense_of(2, jordan);
    assert_ok(sp_discs_make(&s, NULL, NULL, false, &d, &err));
    for (int k = 0; k < 2; k++)
        assert_true(hypot(d.re[k] - 1, d.im[k]) <= d.radius[k]);
    sp_discs_free(&d);
    sp_sparse_free(&s);
}

/* ---- verdicts ------------------------------------------------------------------------------------------------- */

static sp_stability stability_of(const sp_packing *p, const sp_network *net) {
    sp_stability s;
    assert_ok(sp_stability_make(p, net, &s, &err));
    return s;
}

/* Eigenvalues by LAPACK without vectors of ours: how many below -margin, and pairs with |im| above. */
static void count_plainly(const sp_network *net, double margin, int64_t *negative, int64_t *pairs, double *growth) {
    FREED(sp_sparse) k;
    assert_ok(sp_network_assemble_whole(net, &k, &err));
    const int64_t n = k.n;
    double *a = sp_alloc((size_t)(n * n), sizeof *a), *v = sp_alloc((size_t)(n * n), sizeof *v);
    double *re = sp_alloc((size_t)n, sizeof *re), *im = sp_alloc((size_t)n, sizeof *im);
    for (int64_t c = 0; c < n; c++)
        for (int64_t q = k.p[c]; q < k.p[c + 1]; q++)
            a[c * n + k.i[q]] = k.x[q] / net->mass[k.i[q]];
    assert_ok(sp_eigen_general(n, a, re, im, v, &err));
    *negative = *pairs = 0;
    *growth = 0;
    for (int64_t q = 0; q < n; q++) {
        *negative += im[q] == 0 && re[q] < -margin;
        *pairs += im[q] > margin;
        if (im[q] > margin || re[q] < -margin)
            *growth = fmax(*growth, sqrt(0.5 * (hypot(re[q], im[q]) - re[q])));
    }
    sp_free(a);
    sp_free(v);
    sp_free(re);
    sp_free(im);
}

/* Springs in general position under tangential forces of any size: from stable to flutter and divergence. */
TEST(test_verdicts) {
    int64_t seen[3] = {0}, flutter = 0;
    for (int q = 0; q < 12; q++) {
        const double share = (const double[]){0.05, 2, 8}[q % 3];
        FREED(sp_packing) p = carried_packing(2 + q / 6, q / 6 ? 3 : 5, share, 70 + (unsigned)q);
        FREED(sp_network) net = carried_network(&p);
        sp_stability s;
        for (int k = 0; k < net.n_springs; k++)
            net.springs[k].kp = 0;               /* only the tangential forces push */
        for (int c = 0; c < p.n_contacts; c++) { /* what is scattered is no equilibrium: taken for one */
            p.contacts[c].fn = 0;
            memset(p.contacts[c].ft, 0, sizeof p.contacts[c].ft);
        }
        assert_ok(sp_stability_make(&p, &net, &s, &err));
        int64_t negative, pairs;
        double growth;
        count_plainly(&net, 3 * s.error, &negative, &pairs, &growth);
        assert_true(s.dense && s.error < 1e-5);
        assert_true(s.growth <= growth * (1 + 1e-6) + 1e-9 && s.growth_bound >= growth * (1 - 1e-6));
        assert_true(s.flutter == pairs && s.negative == negative);
        assert_true((s.verdict == SP_MODES_UNSTABLE) == (s.negative + s.flutter > 0));
        seen[s.verdict]++;
        flutter += s.flutter;
    }
    print_message("stable %d unstable %d undecided %d, %d complex pairs\n", (int)seen[0], (int)seen[1], (int)seen[2],
                  (int)flutter);
    assert_true(seen[SP_MODES_STABLE] > 0 && seen[SP_MODES_UNSTABLE] > 0 && flutter > 0);
}

/* A packing in three dimensions: stable, its spheres with two contacts spin freely; by counts of the symmetric springs
 * too, whose softest eigenvalue is that of the table of modes. */
TEST(test_packed) {
    sp_pack_spec spec = sp_pack_spec_default();
    FREED(sp_packing) p = sp_packing_none();
    spec.dim = 3;
    spec.grains = 100;
    spec.width = 5;
    spec.seed = 4;
    assert_ok(sp_packing_make(&spec, NULL, NULL, &p, &err));
    sp_network_options o = sp_network_options_default();
    sp_network net = sp_network_none();
    int64_t spins = 0;
    for (int prestress = 0; prestress < 2; prestress++) {
        o.prestress = prestress;
        assert_ok(sp_network_make(&p, &o, &net, &err));
        const sp_stability s = stability_of(&p, &net);
        assert_int_equal(s.verdict, SP_MODES_STABLE);
        assert_true(s.dense == (prestress == 1) && s.negative == 0 && s.flutter == 0 && s.growth == 0);
        assert_true(s.zero > 0 && (prestress == 0 || s.zero == spins));
        assert_true(s.growth_bound < 1e-3 && s.softest > 0);
        spins = s.zero;
        if (!prestress) {
            const sp_modes_options m = {.vectors = false};
            FREED(sp_modes) modes = sp_modes_none();
            assert_ok(sp_modes_dense(&net, &m, &modes, &err));
            assert_int_equal(modes.n_zero - modes.n_rattler, s.zero);
            assert_close(s.softest / (modes.omega[modes.n_zero] * modes.omega[modes.n_zero]), 1, 0.02);
        }
        sp_network_free(&net);
    }
}

/* Nothing but prestress acts sideways: it diverges, as counts of a symmetric matrix tell; the growth is known to 10%.
 */
TEST(test_counts) {
    FREED(sp_packing) p = scattered_packing(2, 6, 0, 1);
    for (int c = 0; c < p.n_contacts; c++)
        p.pressure = 1;
    sp_network_options o = {.threshold = 0, .prestress = true};
    FREED(sp_network) net = sp_network_none();
    assert_ok(sp_network_make(&p, &o, &net, &err));
    for (int32_t k = 0; k < net.n_springs; k++)
        net.springs[k].kp *= 30; /* far beyond what forces off balance might do */
    const sp_stability s = stability_of(&p, &net);
    int64_t negative, beyond, pairs;
    double growth;
    count_plainly(&net, s.balance, &beyond, &pairs, &growth);
    assert_int_equal(s.negative - s.unbalanced, beyond);
    count_plainly(&net, 1e-8, &negative, &pairs, &growth);
    assert_int_equal(pairs, 0);
    assert_true(!s.dense && s.negative == negative && s.negative > 0 && s.verdict == SP_MODES_UNSTABLE);
    assert_true(s.growth <= growth && s.growth > 0.8 * growth && s.growth_bound >= growth);
}

/* Contacts left out that carry a good part of the force: the forces of the others do not balance, and motions that grow
 * by no more than that explains leave it undecided, counted as they are. None but a few spins are taken for zero. */
TEST(test_unbalanced) {
    for (int dim = 2; dim <= 3; dim++) {
        sp_pack_spec spec = dim == 2 ? sp_pack_spec_default() : spheres(100, 4.8, 0.5, 23);
        spec.protocol = SP_PROTOCOL_QUICK;
        spec.pressure = dim == 2 ? 1e-4 : 1e-3;
        if (dim == 2) {
            spec.grains = 80;
            spec.width = 7;
            spec.friction = 0;
            spec.seed = 3;
        }
        FREED(sp_packing) p = make_packing(&spec);
        sp_network_options o = sp_network_options_default();
        FREED(sp_network) net = sp_network_none();
        int64_t negative, pairs;
        double growth;
        o.prestress = true;
        o.threshold = dim == 2 ? 0.3 : 1;
        assert_ok(sp_network_make(&p, &o, &net, &err));
        const sp_stability s = stability_of(&p, &net);
        count_plainly(&net, 1e-8 + s.error, &negative, &pairs, &growth);
        print_message("%dD: negative %d, pairs %d, within %d, zero %d, growth %g\n", dim, (int)s.negative,
                      (int)s.flutter, (int)s.unbalanced, (int)s.zero, growth);
        assert_true(s.dense == (dim == 3) && s.verdict == SP_MODES_UNDECIDED);
        assert_true(s.negative > 0 && s.negative == negative && s.flutter == pairs);
        assert_int_equal(s.unbalanced, s.negative + s.flutter);
        assert_true(s.zero <= (dim == 2 ? 1 : 12) && s.growth <= growth && s.growth > 0.8 * growth);
        assert_true(s.growth_bound >= growth);
    }
}

/* A column of disks, upright, which buckles. With a tangential force at one contact that nothing balances it is plainly
 * unstable while that force is little, and undecided once it might do as much; the springs grow alike, and their stiff
 * motions are never taken for zero. */
TEST(test_column) {
    enum { N = 20 };
    FREED(sp_packing) chain = chain_packing(N, 0.002), p = sp_packing_none();
    assert_ok(sp_packing_alloc(&p, 2, N, N + 1, &err));
    memcpy(p.r, chain.r, N * sizeof *p.r);
    memcpy(p.contacts, chain.contacts, (N + 1) * sizeof *p.contacts);
    for (int i = 0; i < N; i++) {
        p.x[3 * i] = 1;
        p.x[3 * i + 1] = chain.x[3 * i];
    }
    for (int c = 0; c <= N; c++) {
        p.contacts[c].n[1] = p.contacts[c].n[0];
        p.contacts[c].n[0] = 0;
    }
    p.box[0] = 2;
    p.box[1] = chain.box[0];
    p.box[2] = 1;
    p.pressure = 0.001;
    p.friction = 0.5;
    p.wall = chain.wall;
    for (int k = 0; k < 2; k++) {
        int64_t negative, pairs;
        double growth;
        p.contacts[0].ft[0] = k ? 1e-3 : 1e-6;
        FREED(sp_network) net = carried_network(&p);
        const sp_stability s = stability_of(&p, &net);
        count_plainly(&net, 1e-9, &negative, &pairs, &growth);
        assert_true(s.dense && s.verdict == (k ? SP_MODES_UNDECIDED : SP_MODES_UNSTABLE));
        assert_true(s.negative + s.flutter > 10 && s.negative == negative && s.flutter == pairs && s.zero <= 1);
        assert_true((s.unbalanced == s.negative + s.flutter) == (k == 1));
        assert_close(s.growth, growth, 1e-6);
        assert_true(s.growth_bound >= growth * (1 - 1e-9));
    }
}

RUN_TESTS(NULL, NULL)
