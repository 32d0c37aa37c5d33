/* Moduli with prestress of compressed packings, in every cell and dimension, with and without friction, against dense
 * solutions: what nothing resists is no part of them. */
#include "base/vector.h"
#include "dense.h"
#include "elastic/strain.h"
#include "linalg/eigen.h"
#include "making.h"

#include <sonopack/elastic.h>

/* The least vectors with the least residuals: from the eigenvectors v of A^T A that have a length. */
typedef struct inverse {
    int64_t n, zeros;
    double *a, *v, *w;
} inverse;

static inverse inverse_of(const sp_network *net) {
    inverse s = {.n = sp_network_dofs(net), .a = dense_of(net)};
    s.v = calloc((size_t)(s.n * s.n), sizeof *s.v);
    s.w = calloc((size_t)s.n, sizeof *s.w);
    for (int64_t c = 0; c < s.n; c++)
        for (int64_t b = 0; b < s.n; b++)
            s.v[c * s.n + b] = sp_dot(s.n, s.a + c * s.n, s.a + b * s.n);
    assert_ok(sp_eigen_all(s.n, s.v, s.w, &err));
    while (s.zeros < s.n && s.w[s.zeros] < 1e-14 * s.w[s.n - 1])
        s.zeros++;
    return s;
}

static void inverse_free(inverse *s) {
    free(s->a);
    free(s->v);
    free(s->w);
}

/* u += A^+ (f - A u), some times. */
static void solve(const inverse *s, const double *f, double *u) {
    RELEASED double *rest = calloc((size_t)s->n, sizeof *rest), *load = calloc((size_t)s->n, sizeof *load);
    for (int pass = 0; pass < 4; pass++) {
        memcpy(rest, f, (size_t)s->n * sizeof *rest);
        for (int64_t c = 0; c < s->n; c++)
            for (int64_t r = 0; r < s->n; r++)
                rest[r] -= s->a[c * s->n + r] * u[c];
        for (int64_t c = 0; c < s->n; c++)
            load[c] = sp_dot(s->n, s->a + c * s->n, rest);
        for (int64_t k = s->zeros; k < s->n; k++) {
            const double *v = s->v + k * s->n, size = sp_dot(s->n, v, load) / s->w[k];
            for (int64_t c = 0; c < s->n; c++)
                u[c] += v[c] * size;
        }
    }
}

/* Every modulus agrees within its error or rounding: twice the error, since the least vectors may turn a sphere with
 * two contacts by more than it moves. Returns the number of motions that nothing resists. */
static int64_t assert_moduli(const sp_network *net) {
    const int64_t n = sp_network_dofs(net);
    const int strains = sp_strain_count(net);
    double *f = calloc((size_t)n, sizeof *f), scale = 0;
    inverse dense = inverse_of(net);
    sp_stiffness s, want = {0};
    assert_ok(sp_stiffness_make(net, &s, &err));
    assert_true(s.residual < 1e-8);
    for (int b = 0; b < strains; b++) {
        RELEASED double *u = calloc((size_t)n, sizeof *u);
        sp_strain_load(net, b, f);
        solve(&dense, f, u);
        sp_strain_stresses(net, b, u, &want);
        scale = fmax(scale, want.c[b][b]);
    }
    for (int a = 0; a < strains; a++)
        for (int b = 0; b < strains; b++)
            if (!isnan(s.c[a][b])) {
                assert_close(s.c[a][b], want.c[a][b], 2 * fmax(s.error[a][b], 1e-12 * scale));
                assert_true(s.error[a][b] < 5e-3 * scale);
            }
    free(f);
    inverse_free(&dense);
    return dense.zeros;
}

static sp_pack_spec spec_of(int dim, sp_cell cell, double friction) {
    const bool piston = cell == SP_CELL_PISTON;
    sp_pack_spec spec = spheres(dim == 3 && !piston ? 140 : 60, dim == 2 ? 8 : 4.8, friction, 7);
    spec.dim = dim;
    spec.cell = cell;
    spec.protocol = SP_PROTOCOL_QUICK;
    spec.diameter_min = 0.9;
    spec.diameter_max = 1.1;
    return spec;
}

/* In a periodic cell the whole moves, and spheres with two contacts spin wherever there is friction. */
TEST(test_every_cell) {
    static const sp_cell cell[] = {SP_CELL_PISTON, SP_CELL_PERIODIC, SP_CELL_BOX};
    static const double friction[] = {0, 0.3, 1};
    int64_t spinning = 0;
    for (int q = 2 % SANITIZED_STEP(3); q < 36; q += SANITIZED_STEP(3)) {
        const bool prestress = q % 2, space = q / 2 % 2, rough = q / 4 % 3 > 0, periodic = q / 12 == 1;
        const sp_pack_spec spec = spec_of(space ? 3 : 2, cell[q / 12], friction[q / 4 % 3]);
        FREED(sp_packing) p = make_packing(&spec);
        sp_network_options o = sp_network_options_default();
        FREED(sp_network) net = sp_network_none();
        o.prestress = prestress;
        assert_ok(sp_network_make(&p, &o, &net, &err));
        const int64_t zeros = assert_moduli(&net);
        assert_true(zeros >= (periodic ? spec.dim : 0));
        spinning += periodic && space && rough && prestress ? zeros - 3 : 0;
    }
    assert_true(spinning > 0);
}

RUN_TESTS(NULL, NULL)
