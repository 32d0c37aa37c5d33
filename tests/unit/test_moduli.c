#include "base/base.h"
#include "dense.h"
#include "elastic/strain.h"
#include "linalg/eigen.h"
#include "reference.h"

#include <sonopack/elastic.h>

static sp_network network_of(const sp_packing *p, bool sliding_free) {
    return network_with(p, .sliding_free = sliding_free);
}

/* C is symmetric although each entry is measured by itself; the wall feels the stress; the solves are exact. Smooth
 * walls cannot shear: what needs it is withheld, the rest is there, though the whole may float sideways. */
TEST(test_symmetric) {
    for (int q = 0; q < 6; q++) {
        const bool smooth = q % 3 == 2;
        FREED(sp_packing) p = q == 0   ? reference_packing(REFERENCE("packing_N200_p1e-4.txt"))
                              : q == 1 ? reference_packing(REFERENCE("packing_N600_p1e-4.txt"))
                              : q < 4  ? scattered_packing(2, smooth ? 12 : 8, smooth ? 0 : 0.5, 1)
                                       : scattered_packing(3, 5, smooth ? 0 : 0.5, 1);
        const int up = p.dim - 1, strains = p.dim == 3 ? STRAINS_3D : STRAINS;
        FREED(sp_network) net = network_of(&p, false);
        sp_stiffness s;
        sp_moduli m;
        assert_ok(sp_stiffness_make(&net, &s, &err));
        const double scale = fmax(s.c[0][0], s.c[up][up]);
        for (int a = 0; a < strains; a++) {
            if (smooth && (p.dim == 3 ? a == STRAIN_23_3D || a == STRAIN_13_3D : a == STRAIN_SHEAR)) {
                assert_true(isnan(s.c[a][a]) && isnan(s.c[a][0]) && isnan(s.c[0][a]) && isnan(s.wall[a]));
                continue;
            }
            assert_true(s.error[a][a] < 1e-7 * scale);
            /* smooth grains near cubic places hardly resist shear */
            assert_true(s.c[a][a] > (smooth ? -s.error[a][a] : 0));
            for (int b = 0; b < strains; b++)
                if (!isnan(s.c[a][b])) {
                    assert_close(s.c[a][b], s.c[b][a], 1e-12 * scale);
                    assert_true(a == b || smooth || s.c[a][b] * s.c[a][b] < s.c[a][a] * s.c[b][b]);
                }
            assert_close(s.wall[a], s.c[up][a], 1e-10 * scale);
        }
        assert_ok(sp_moduli_make(&net, 0.5, &m, &err));
        assert_true(m.c11 == s.c[0][0] && m.c22 == s.c[1][1] && m.c12 == s.c[0][1]);
        assert_relative(m.c_l * m.c_l * 0.5, s.c[up][up], 1e-14); /* Eq. (8) */
        if (p.dim == 3) {
            assert_true(m.c33 == s.c[2][2] && m.c66 == s.c[5][5] && m.c13 == s.c[0][2] && m.c23 == s.c[1][2]);
            assert_true(smooth ? isnan(m.c44) && isnan(m.c55) : m.c44 == s.c[3][3] && m.c55 == s.c[4][4]);
        } else
            assert_true(smooth ? isnan(m.c33) : m.c33 == s.c[STRAIN_SHEAR][STRAIN_SHEAR]);
        if (smooth)
            assert_true(isnan(m.c_t));
        else
            assert_relative(m.c_t * m.c_t * 0.5, p.dim == 3 ? 0.5 * (m.c44 + m.c55) : m.c33, 1e-14);
    }
}

/* A sphere with two contacts turns about the line through them: K is singular, the moduli are those of a sphere that
 * next to nothing more holds. Nor does a sphere of soft contacts make K more singular than one of stiff ones. */
TEST(test_pivots) {
    for (int soft = 0; soft < 2; soft++) {
        FREED(sp_packing) p = scattered_packing(3, 4, 0.5, 1);
        FREED(sp_network) net = network_of(&p, false), held = network_of(&p, false);
        sp_moduli m, expected;
        int springs = 0, at = 0;
        for (int k = 0; k < net.n_springs; k++) {
            sp_spring *s = &held.springs[k];
            const bool own = s->i == 21 || s->j == 21, third = own && springs++ >= 2;
            const double stiffness = own ? soft ? 1e-6 : 1 : 1;
            s->kn *= third ? 1e-9 * stiffness : stiffness;
            s->kt *= third ? 1e-9 * stiffness : stiffness;
            if (!third) {
                net.length[at] = net.length[k];
                net.springs[at++] = *s;
            }
        }
        assert_true(springs > 2);
        net.n_bulk -= net.n_springs - at;
        net.n_springs = at;
        assert_ok(sp_moduli_make(&held, 0.5, &expected, &err));
        assert_ok(sp_moduli_make(&net, 0.5, &m, &err));
        assert_true(m.residual < 1e-12);
        const double got[] = {m.c11, m.c33, m.c13, m.c55, m.c66};
        const double want[] = {expected.c11, expected.c33, expected.c13, expected.c55, expected.c66};
        for (int q = 0; q < 5; q++)
            assert_relative(got[q], want[q], 1e-7);
    }
}

/* ---- against dense matrices ------------------------------------------------------------------------------------- */

/* x = A^-1 x by elimination with row exchanges; overwrites a. */
static void eliminate(int64_t n, double *a, double *x) {
    for (int64_t c = 0; c < n; c++) {
        int64_t best = c;
        for (int64_t r = c; r < n; r++)
            best = fabs(a[c * n + r]) > fabs(a[c * n + best]) ? r : best;
        for (int64_t k = c; k < n; k++) {
            const double swap = a[k * n + c];
            a[k * n + c] = a[k * n + best];
            a[k * n + best] = swap;
        }
        const double swap = x[c];
        x[c] = x[best];
        x[best] = swap;
        for (int64_t r = c + 1; r < n; r++) {
            const double factor = a[c * n + r] / a[c * n + c];
            for (int64_t k = c + 1; k < n; k++)
                a[k * n + r] -= factor * a[k * n + c];
            x[r] -= factor * x[c];
        }
    }
    for (int64_t c = n - 1; c >= 0; c--) {
        x[c] /= a[c * n + c];
        for (int64_t r = 0; r < c; r++)
            x[r] -= a[c * n + r] * x[c];
    }
}

/* A tangential force of this fraction of the normal one at every contact, along some direction. */
static void add_friction(sp_packing *p, double fraction) {
    for (int k = 0; k < p->n_contacts; k++) {
        sp_contact *c = &p->contacts[k];
        const double along[3] = {-c->n[1], c->n[0], 0}, size = hypot(c->n[0], c->n[1]);
        for (int a = 0; a < 2 && size > 0.1; a++)
            c->ft[a] = (k % 2 ? fraction : -fraction) * c->fn * along[a] / size;
    }
}

/* Forces that are carried along make K nonsymmetric. Every C is that of elimination, within its error. */
TEST(test_nonsymmetric) {
    for (int q = 0; q < 6; q++) {
        const double fraction[] = {0.01, 0.1, 0.4};
        FREED(sp_packing) p = scattered_packing(q < 3 ? 2 : 3, q < 3 ? 6 : 3, 0.5, (unsigned)q + 1);
        sp_network_options o = sp_network_options_default();
        FREED(sp_network) net = sp_network_none();
        sp_stiffness s, want = {0};
        o.prestress = true;
        add_friction(&p, fraction[q % 3]);
        assert_ok(sp_network_make(&p, &o, &net, &err));
        assert_true(sp_network_skew(&net) > 1e-4);
        assert_ok(sp_stiffness_make(&net, &s, &err));
        assert_true(s.residual < 1e-13);
        const int64_t n = sp_network_dofs(&net);
        double *u = calloc((size_t)n, sizeof *u), scale = 0, skew = 0;
        for (int b = 0; b < sp_strain_count(&net); b++) {
            RELEASED double *a = dense_of(&net);
            sp_strain_load(&net, b, u);
            eliminate(n, a, u);
            sp_strain_stresses(&net, b, u, &want);
            scale = fmax(scale, want.c[b][b]);
        }
        for (int a = 0; a < sp_strain_count(&net); a++)
            for (int b = 0; b < sp_strain_count(&net); b++) {
                assert_close(s.c[a][b], want.c[a][b], 1e-12 * scale);
                assert_close(s.c[a][b], want.c[a][b], s.error[a][b]);
                assert_true(s.error[a][b] < 1e-9 * scale);
                skew = fmax(skew, fabs(s.c[a][b] - s.c[b][a]));
            }
        assert_true(skew > 1e-6 * scale); /* the part that is not symmetric counts */
        free(u);
    }
}

/* The least eigenvalue of a symmetric K, with its vector. */
static double softest(const sp_network *net, double *vector) {
    const int64_t n = sp_network_dofs(net);
    RELEASED double *a = dense_of(net), *w = calloc((size_t)n, sizeof *w);
    assert_ok(sp_eigen_all(n, a, w, &err));
    const double least = w[0];
    memcpy(vector, a, (size_t)n * sizeof *vector);
    return least;
}

static void set_prestress(sp_network *net, int grain, double stiffness) {
    for (int k = 0; k < net->n_springs; k++)
        if (net->springs[k].i == grain || net->springs[k].j == grain)
            net->springs[k].kp = -stiffness;
}

/* Prestress that just cancels the stiffness of a motion that the strain drives: the moduli do not exist, and the reason
 * names the grain that moves. */
TEST(test_load_on_a_mechanism) {
    enum { GRAIN = 14 };
    FREED(sp_packing) p = scattered_packing(2, 6, 0.5, 1);
    FREED(sp_network) net = network_of(&p, false);
    const int64_t n = sp_network_dofs(&net);
    double *vector = calloc((size_t)n, sizeof *vector), low = 0, high = 10;
    sp_moduli m;
    char name[16];
    net.prestress = true;
    set_prestress(&net, GRAIN, high);
    assert_true(softest(&net, vector) < 0);
    assert_fails(sp_moduli_make(&net, 0.5, &m, &err), SP_EREFUSED, "");
    for (int turn = 0; turn < 60; turn++) {
        set_prestress(&net, GRAIN, 0.5 * (low + high));
        *(softest(&net, vector) < 0 ? &high : &low) = 0.5 * (low + high);
    }
    set_prestress(&net, GRAIN, 0.99 * low); /* far enough from it they do */
    assert_ok(sp_moduli_make(&net, 0.5, &m, &err));
    set_prestress(&net, GRAIN, low);
    assert_true(fabs(softest(&net, vector)) < 1e-14);
    snprintf(name, sizeof name, "%d", GRAIN);
    assert_true(fabs(vector[3 * GRAIN]) + fabs(vector[3 * GRAIN + 1]) + fabs(vector[3 * GRAIN + 2]) > 0.5);
    assert_fails(sp_moduli_make(&net, 0.5, &m, &err), SP_EREFUSED, name);
    free(vector);
}

/* Table II at p = 1e-4: 600 grains, mean and standard deviation of 30 samples; ours is one. */
TEST(test_table) {
    FREED(sp_packing) p = reference_packing(REFERENCE("packing_N600_p1e-4.txt"));
    FREED(sp_network) net = network_of(&p, false);
    sp_moduli m;
    assert_ok(sp_moduli_make(&net, 0.52, &m, &err));
    assert_close(m.c11, 1.35e-2, 4 * 0.09e-2);
    assert_close(m.c12, 6.8e-3, 4 * 0.4e-3);
    assert_close(m.c22, 1.88e-2, 4 * 0.08e-2);
    assert_close(m.c33, 4.0e-3, 4 * 0.5e-3);
}

/* N + 1 equal springs in a row: C22 = K H/(N + 1). */
TEST(test_chain) {
    FREED(sp_packing) p = chain_packing(25, 1e-4);
    FREED(sp_network) net = network_of(&p, false);
    sp_moduli m;
    assert_ok(sp_moduli_make(&net, NAN, &m, &err));
    assert_relative(m.c22, net.springs[0].kn * p.box[0] / 26, 1e-12);
    assert_true(isnan(m.c11) && isnan(m.c12) && isnan(m.c33) && isnan(m.c_l) && isnan(m.c_t));
}

/* Where every contact of a grain slides it turns freely: no stiffness, and no reason to refuse. */
TEST(test_free_rotation) {
    FREED(sp_packing) p = scattered_packing(2, 8, 0.5, 1);
    for (int k = 0; k < p.n_contacts; k++) {
        sp_contact *c = &p.contacts[k];
        if (c->i != 20 && c->j != 20)
            continue;
        c->ft[0] = -0.5 * c->fn * c->n[1];
        c->ft[1] = 0.5 * c->fn * c->n[0];
    }
    FREED(sp_network) net = network_of(&p, true), stick = network_of(&p, false);
    sp_moduli m, hard;
    assert_ok(sp_moduli_make(&net, 0.5, &m, &err));
    assert_ok(sp_moduli_make(&stick, 0.5, &hard, &err));
    assert_true(m.c22 < hard.c22 && m.c33 < hard.c33); /* springs taken away soften */
}

/* What hangs loose makes K singular, but carries no stress: the moduli are those without it. */
TEST(test_floppy_parts) {
    FREED(sp_packing) p = scattered_packing(2, 6, 0.5, 1);
    FREED(sp_network) net = network_of(&p, false), bare = network_of(&p, false);
    sp_moduli m, expected;
    for (int k = 0; k < net.n_springs; k++) {
        sp_spring *s = &net.springs[k], *b = &bare.springs[k];
        const bool pair = s->i == 14 && s->j == 15, one = s->i == 14 || s->j == 14 || s->i == 15 || s->j == 15;
        if (one) /* grains 14 and 15 touch each other alone, if at all */
            s->kn = s->kt = pair ? s->kn : 0;
        if (one) /* or they are held by next to nothing */
            b->kn = b->kt = 1e-9 * b->kn;
    }
    assert_ok(sp_moduli_make(&bare, 0.5, &expected, &err));
    assert_ok(sp_moduli_make(&net, 0.5, &m, &err));
    assert_relative(m.c11, expected.c11, 1e-6);
    assert_relative(m.c12, expected.c12, 1e-6);
    assert_relative(m.c22, expected.c22, 1e-6);
    assert_relative(m.c33, expected.c33, 1e-6);
    assert_true(m.residual < 1e-8);
}

static void fail_every_allocation(const sp_network *net) {
    sp_moduli m;
    EACH_ALLOCATION_FAILS(5, sp_moduli_make(net, 0.5, &m, &err), );
}

TEST(test_refusals) {
    sp_moduli m;
    sp_packing p = scattered_packing(2, 6, 0.5, 1);
    sp_network net = network_of(&p, false);
    net.n_springs = net.n_bulk; /* no walls */
    assert_fails(sp_moduli_make(&net, 0.5, &m, &err), SP_EREFUSED, "0");
    sp_network_free(&net);
    net = network_of(&p, false);
    for (int k = 0; k < net.n_springs; k++)
        if (net.springs[k].j == SP_TOP) /* the top wall touches, but nothing leads there */
            for (int l = 0; l < net.n_springs; l++)
                if (l != k && (net.springs[l].i == net.springs[k].i || net.springs[l].j == net.springs[k].i))
                    net.springs[l].kn = net.springs[l].kt = 0;
    assert_fails(sp_moduli_make(&net, 0.5, &m, &err), SP_EREFUSED, "");
    sp_network_free(&net);
    net = network_of(&p, false);
    for (int k = 0; k < net.n_bulk; k++) /* either half holds on to its wall */
        if ((net.springs[k].i < 18) != (net.springs[k].j < 18))
            net.springs[k].kn = net.springs[k].kt = 0;
    assert_fails(sp_moduli_make(&net, 0.5, &m, &err), SP_EREFUSED, "");
    sp_network_free(&net);
    net = network_of(&p, false);
    fail_every_allocation(&net);
    sp_network_free(&net);
    sp_packing_free(&p);
    p = scattered_packing(3, 3, 0.5, 1);
    add_friction(&p, 0.1);
    sp_network_options o = sp_network_options_default();
    o.prestress = true;
    assert_ok(sp_network_make(&p, &o, &net, &err));
    fail_every_allocation(&net);
    sp_network_free(&net);
    sp_packing_free(&p);
}

RUN_TESTS(NULL, NULL)
