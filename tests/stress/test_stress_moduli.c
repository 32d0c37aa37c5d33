/* Moduli of every hard network against quadruple precision: each within the error that is told, or refused. */
#include "stress/exact.h"
#include "stress/networks.h"
#include "stress/record.h"

#include <sonopack/elastic.h>

enum { STRAINED = 6 };

static int strains_of(const sp_network *net) { return net->dim == 3 ? 6 : 3; }

/* The gap that a strain opens at a spring: uniaxial along every axis, then shear (3D: 23, 13, 12). */
static void affine_gap(const sp_network *net, int strain, const sp_spring *s, double length, double out[3]) {
    static const int plane[3][2] = {{0, 0}, {1, 1}, {0, 1}};
    static const int space[6][2] = {{0, 0}, {1, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}};
    const int *field = net->dim == 3 ? space[strain] : plane[strain];
    out[0] = out[1] = out[2] = 0;
    if (net->dim == 1)
        out[0] = strain == 1 ? length * s->n[0] : 0;
    else
        out[field[0]] = length * s->n[field[1]];
}

static quad area_of(const sp_network *net) {
    return (quad)(net->dim > 1 ? net->box[0] : 1) * (net->dim > 2 ? net->box[1] : 1);
}

/* C_ab = (sum k d_a d_b - f_a . K^+ f_b)/V, with f = -B^T k d and the pseudo-inverse from the eigenvectors. */
static void exact_moduli(const sp_network *net, const exact *x, quad c[STRAINED][STRAINED]) {
    const int n = x->n, dof = net->dof, strains = strains_of(net);
    RELEASED quad *f = calloc((size_t)(STRAINED * n), sizeof *f);
    memset(c, 0, sizeof(quad) * STRAINED * STRAINED);
    for (int k = 0; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        sp_rows rows;
        sp_network_rows(net, s, &rows);
        for (int q = 0; q < rows.count; q++) {
            quad gap[STRAINED];
            for (int a = 0; a < strains; a++) {
                double d[3];
                affine_gap(net, a, s, net->length[k], d);
                gap[a] = (quad)rows.gap[q][0] * d[0] + (quad)rows.gap[q][1] * d[1] + (quad)rows.gap[q][2] * d[2];
                for (int b = 0; b <= a; b++)
                    c[a][b] += rows.k[q] * gap[a] * gap[b];
                for (int e = 0; e < rows.width; e++)
                    f[a * n + (e < dof ? s->i : s->j) * dof + e % dof] -= rows.k[q] * gap[a] * rows.b[q][e];
            }
        }
    }
    for (int m = 0; m < n; m++) {
        quad part[STRAINED] = {0};
        if (!(x->lambda[m] > x->lambda[n - 1] * 1e-28L))
            continue;
        for (int a = 0; a < strains; a++)
            for (int k = 0; k < n; k++)
                part[a] += x->e[m * n + k] * f[a * n + k] / quad_sqrt(net->mass[k]);
        for (int a = 0; a < strains; a++)
            for (int b = 0; b <= a; b++)
                c[a][b] -= part[a] * part[b] / x->lambda[m];
    }
    const quad volume = area_of(net) * net->box[net->dim - 1];
    for (int a = 0; a < strains; a++)
        for (int b = 0; b <= a; b++)
            c[b][a] = c[a][b] = c[a][b] / volume;
}

/* Compares every modulus of a network, unless it is refused. Returns the largest error over the largest modulus. */
static double compare(stress_record *r, const char *name, const sp_network *net) {
    sp_moduli m;
    sp_error err = {0};
    const sp_status status = sp_moduli_make(net, NAN, &m, &err);
    if (status != SP_OK) {
        stress_refuse(r, name, "moduli", "moduli", status, &err);
        return 0;
    }
    exact x = exact_solve(net);
    quad want[STRAINED][STRAINED];
    double worst = 0, largest = 0;
    exact_moduli(net, &x, want);
    const struct {
        const char *name;
        double value, error;
        quad want;
    } each[] = {{"C11", m.c11, m.error11, want[0][0]}, {"C12", m.c12, m.error12, want[0][1]},
                {"C22", m.c22, m.error22, want[1][1]}, {"C33", m.c33, m.error33, want[2][2]},
                {"C13", m.c13, m.error13, want[0][2]}, {"C23", m.c23, m.error23, want[1][2]},
                {"C44", m.c44, m.error44, want[3][3]}, {"C55", m.c55, m.error55, want[4][4]},
                {"C66", m.c66, m.error66, want[5][5]}};
    for (int q = 0; q < 9; q++)
        if (!isnan(each[q].value)) {
            const double error = (double)quad_abs(each[q].value - each[q].want), size = fabs((double)each[q].want);
            stress_agree(r, name, "moduli", each[q].name, error, each[q].error, size);
            worst = fmax(worst, error);
            largest = fmax(largest, size);
        }
    exact_free(&x);
    return worst / largest;
}

TEST(test_moduli) {
    stress_record r = stress_open();
    for (int k = 0; k < STRESS_CASES; k++) {
        FREED(sp_network) net = stress_cases[k].make(stress_cases[k].value, 1);
        compare(&r, stress_cases[k].name, &net);
    }
    stress_close(&r);
    assert_int_equal(r.wrong, 0);
}

/* ---- mechanisms ------------------------------------------------------------------------------------------------- */

/* Leaves these grains their first two springs; `share` is the part of their stiffness that is left. */
static sp_network with_two_springs(sp_network net, int32_t first, int32_t step, double share) {
    int32_t kept = 0, bulk = 0;
    RELEASED int *have = calloc((size_t)net.n, sizeof *have);
    for (int32_t k = 0; k < net.n_springs; k++) {
        sp_spring s = net.springs[k];
        const bool own = s.i % step == first, other = s.j >= 0 && s.j % step == first;
        if ((own && have[s.i] == 2) || (other && have[s.j] == 2))
            continue;
        have[s.i] += own;
        if (other)
            have[s.j]++;
        s.kn *= own || other ? share : 1;
        s.kt *= own || other ? share : 1;
        bulk += k < net.n_bulk;
        net.length[kept] = net.length[k];
        net.springs[kept++] = s;
    }
    net.n_springs = kept;
    net.n_bulk = bulk;
    return stress_changed(net);
}
static sp_network spinning(double share, uint64_t seed) {
    return with_two_springs(stress_scattered(3, 0.5, false, seed), 3, 4, share);
}
static sp_network pivoting_disks(double share, uint64_t seed) {
    return with_two_springs(stress_scattered(2, 0.5, false, seed), 1, 2, share);
}
static sp_network smooth_pairs(double share, uint64_t seed) {
    return with_two_springs(stress_scattered(3, 0, false, seed), 13, 27, share);
}

static bool keep_most(const sp_network *net, const sp_spring *s, uint64_t *state) {
    (void)net;
    return s->j < 0 || stress_random(state) < 0.75;
}
static sp_network thinned(double dim, uint64_t seed) {
    sp_network net = stress_scattered((int)dim, 0.5, false, seed);
    stress_cut(&net, keep_most, seed);
    return stress_changed(net);
}

/* Two smooth spheres touch each other, and the same third one through the sides. */
static bool keep_chain(const sp_network *net, const sp_spring *s, uint64_t *state) {
    (void)net;
    (void)state;
    return (s->i != 13 && s->i != 14 && s->j != 13 && s->j != 14) || (s->i >= 12 && s->j >= 12 && s->j <= 14);
}
static sp_network chained(double dim, uint64_t seed) {
    sp_network net = stress_scattered((int)dim, 0, false, seed);
    stress_cut(&net, keep_chain, seed);
    return stress_changed(net);
}

/* Mechanisms of many kinds, none of which the strain drives: every modulus to 1e-9 of the largest. */
TEST(test_mechanisms) {
    static const stress_case cases[] = {{"spinning spheres", spinning, 1, true},
                                        {"spinning spheres, soft", spinning, 1e-6, true},
                                        {"disks with two contacts", pivoting_disks, 1, true},
                                        {"disks with two contacts, soft", pivoting_disks, 1e-5, true},
                                        {"smooth spheres with two contacts", smooth_pairs, 1, true},
                                        {"thinned, 2D", thinned, 2, true},
                                        {"thinned, 3D", thinned, 3, true},
                                        {"a chain of two spheres", chained, 3, true}};
    stress_record r = stress_open();
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++)
        for (uint64_t seed = 1; seed <= 3; seed++) {
            FREED(sp_network) net = cases[k].make(cases[k].value, seed);
            assert_true(compare(&r, cases[k].name, &net) < 1e-9);
        }
    stress_close(&r);
    assert_int_equal(r.wrong, 0);
    assert_true(r.refused <= 4); /* as a whole: nothing resists a strain from wall to wall */
}

RUN_TESTS_WHERE(STRESS_QUAD, NULL, NULL)
