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
    quad *f = calloc((size_t)(STRAINED * n), sizeof *f);
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
    free(f);
}

static void test_moduli(void **state) {
    (void)state;
    stress_record r = stress_open();
    for (int k = 0; k < STRESS_CASES; k++) {
        const stress_case *c = &stress_cases[k];
        sp_network net = c->make(c->value, 1);
        sp_moduli m;
        sp_error err = {0};
        const sp_status status = sp_moduli_make(&net, NAN, &m, &err);
        if (status != SP_OK) {
            stress_refuse(&r, c->name, "moduli", "moduli", status, &err);
        } else {
            exact x = exact_solve(&net);
            quad want[STRAINED][STRAINED];
            exact_moduli(&net, &x, want);
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
                if (!isnan(each[q].value))
                    stress_agree(&r, c->name, "moduli", each[q].name, (double)quad_abs(each[q].value - each[q].want),
                                 each[q].error, fabs((double)each[q].want));
            exact_free(&x);
        }
        sp_network_free(&net);
    }
    stress_close(&r);
    assert_int_equal(r.wrong, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_moduli)};
    if (!STRESS_QUAD)
        return 77;
    return cmocka_run_group_tests(tests, NULL, NULL);
}
