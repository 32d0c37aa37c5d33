/* Nested dissection: separators separate, are small, and give factors of the same matrix. */
#include "base/base.h"
#include "linalg/dissection.h"
#include "linalg/ldl.h"
#include "test.h"

#include <sonopack/network.h>

typedef struct cloud {
    int dim, n;
    sp_cell cell;
    double box[3], tilt[3];
} cloud;

static double uniform(void) { return rand() / (RAND_MAX + 1.0); }

/* Distance of two grains, of nearest images along axes that wrap. */
static void separation(const sp_network *net, const double *a, const double *b, double d[3]) {
    const double *l = net->box, *t = net->tilt;
    const double vector[3][3] = {{l[0], 0, 0}, {t[0], l[1], 0}, {t[1], t[2], l[2]}};
    for (int k = 0; k < 3; k++)
        d[k] = k < net->dim ? b[k] - a[k] : 0;
    for (int k = net->dim - 1; k >= 0; k--) {
        const bool wraps = net->cell == SP_CELL_PERIODIC || (net->cell == SP_CELL_PISTON && k < net->dim - 1);
        const double turns = wraps ? round(d[k] / l[k]) : 0;
        for (int c = 0; c < 3; c++)
            d[c] -= turns * vector[k][c];
    }
}

/* Random places; springs join those that are less than 1 apart, with 7 or 12 neighbours in the mean. */
static sp_network make_cloud(const cloud *of) {
    sp_network net = sp_network_none();
    net.dim = of->dim;
    net.dof = of->dim == 2 ? 3 : 6;
    net.n = of->n;
    net.cell = of->cell;
    memcpy(net.box, of->box, sizeof net.box);
    memcpy(net.tilt, of->tilt, sizeof net.tilt);
    net.x = sp_alloc((size_t)of->n, 3 * sizeof *net.x);
    net.springs = sp_alloc((size_t)of->n, 20 * sizeof *net.springs);
    assert_true(net.x && net.springs);
    for (int k = 0; k < of->n; k++)
        for (int a = 0; a < of->dim; a++)
            net.x[3 * k + a] = of->box[a] * uniform();
    for (int i = 0; i < of->n; i++)
        for (int j = i + 1; j < of->n; j++) {
            double d[3];
            separation(&net, net.x + 3 * i, net.x + 3 * j, d);
            const double r = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
            if (r >= 1)
                continue;
            assert_true(net.n_bulk < 20 * of->n);
            net.springs[net.n_bulk++] = (sp_spring){.i = i,
                                                    .j = j,
                                                    .n = {d[0] / r, d[1] / r, d[2] / r},
                                                    .kn = 1 + uniform(),
                                                    .kt = 1,
                                                    .ri = r / 2,
                                                    .rj = r / 2};
        }
    net.n_springs = net.n_bulk;
    return net;
}

static void free_cloud(sp_network *net) {
    sp_free(net->x);
    sp_free(net->springs);
}

/* The tree of elimination of the parts: after each, the parts that are joined to it, directly or by parts before it,
 * lie on one way to the root. Returns its height; that of an order without separators is the number of parts. */
static int height_of(const sp_network *net, const int32_t *part, int parts) {
    RELEASED bool *joined = calloc((size_t)parts * (size_t)parts, 1);
    RELEASED int *height = calloc((size_t)parts, sizeof *height);
    int highest = 0;
    for (int k = 0; k < net->n_bulk; k++) {
        const int a = part[net->springs[k].i], b = part[net->springs[k].j];
        joined[(a < b ? a : b) * parts + (a < b ? b : a)] = true;
    }
    for (int a = 0; a < parts; a++) {
        int next = a + 1;
        while (next < parts && !joined[a * parts + next])
            next++;
        highest = height[a] > highest ? height[a] : highest;
        if (next == parts)
            continue;
        height[next] = height[a] + 1 > height[next] ? height[a] + 1 : height[next];
        for (int b = next + 1; b < parts; b++)
            joined[next * parts + b] |= joined[a * parts + b];
    }
    return highest;
}

static void check(const cloud *of) {
    sp_network net = make_cloud(of);
    RELEASED int32_t *part = malloc((size_t)of->n * sizeof *part), *again = malloc((size_t)of->n * sizeof *again);
    int parts = 0, largest = 0;
    assert_ok(sp_dissect(&net, part, &err));
    assert_ok(sp_dissect(&net, again, &err));
    assert_memory_equal(part, again, (size_t)of->n * sizeof *part);
    for (int k = 0; k < of->n; k++)
        parts = part[k] + 1 > parts ? part[k] + 1 : parts;
    RELEASED int *size = calloc((size_t)parts, sizeof *size);
    for (int k = 0; k < of->n; k++) {
        assert_in_range(part[k], 0, parts - 1);
        size[part[k]]++;
    }
    for (int k = 0; k < parts; k++) {
        assert_true(size[k] > 0);
        largest = size[k] > largest ? size[k] : largest;
    }
    const int height = height_of(&net, part, parts);
    print_message("%dD, cell %d: %d grains, %d parts, height %d, largest %d\n", of->dim, of->cell, of->n, parts, height,
                  largest);
    /* halves of halves, down to 100 grains; ends may be unequal */
    assert_true(height <= 2 * log2(of->n / 100.0) + 2);
    /* two cuts across, each a layer that is about one grain thick */
    assert_true(largest <= fmax(100, 2.2 * pow(of->n, 1 - 1.0 / of->dim)));
    free_cloud(&net);
}

TEST(test_separators) {
    srand(7);
    for (int cell = SP_CELL_PISTON; cell <= SP_CELL_BOX; cell++) {
        check(&(cloud){2, 4000, (sp_cell)cell, {42, 42, 1}, {0}});
        check(&(cloud){2, 1500, (sp_cell)cell, {8, 84, 1}, {0}}); /* tall */
        check(&(cloud){3, 3000, (sp_cell)cell, {10, 10, 10}, {0}});
        check(&(cloud){3, 2000, (sp_cell)cell, {5, 20, 7}, {0}});
    }
    check(&(cloud){2, 2000, SP_CELL_PERIODIC, {30, 30, 1}, {11, 0, 0}});
    check(&(cloud){3, 2000, SP_CELL_PERIODIC, {8.7, 8.7, 8.7}, {3, -2, 4}});
}

/* A lattice, whose places tie; grains in one place; grains without contacts; a star, whose hub is the only separator.
 */
TEST(test_strange_shapes) {
    enum { N = 1600 };
    static double x[3 * N];
    static sp_spring spring[2 * N];
    int32_t part[N];
    sp_network net = {.dim = 2, .dof = 2, .n = N, .x = x, .springs = spring, .cell = SP_CELL_BOX, .box = {40, 40, 1}};
    for (int shape = 0; shape < 4; shape++) {
        net.n_bulk = 0;
        for (int k = 0; k < N; k++) {
            x[3 * k] = shape == 1 ? 3 : k % 40;
            x[3 * k + 1] = shape == 1 ? 3 : k / 40;
            if (shape == 2)
                continue;
            if (shape == 3 ? k != 820 : k % 40 < 39)
                spring[net.n_bulk++] = (sp_spring){.i = k, .j = shape == 3 ? 820 : k + 1};
            if (shape < 2 && k / 40 < 39)
                spring[net.n_bulk++] = (sp_spring){.i = k, .j = k + 40};
        }
        memset(part, 0xff, sizeof part);
        assert_ok(sp_dissect(&net, part, &err));
        int top = 0;
        for (int k = 0; k < N; k++) {
            assert_in_range(part[k], 0, N);
            top = part[k] > top ? part[k] : top;
        }
        if (shape == 0)
            assert_true(top > 20 && height_of(&net, part, top + 1) <= 10);
        if (shape == 3)
            assert_true(part[820] >= 1);
    }
}

TEST(test_factors) {
    srand(9);
    sp_network net = make_cloud(&(cloud){3, 2500, SP_CELL_PERIODIC, {9.4, 9.4, 9.4}, {0}});
    FREED(sp_sparse) a;
    sp_ldl *f[2];
    assert_ok(sp_network_assemble(&net, &a, &err));
    RELEASED double *b = malloc(SP_LDL_LANES * (size_t)a.n * sizeof *b);
    double *x[2];
    for (int64_t k = 0; k < SP_LDL_LANES * a.n; k++)
        b[k] = uniform();
    for (int k = 0; k < 2; k++) {
        x[k] = malloc(SP_LDL_LANES * (size_t)a.n * sizeof *b);
        assert_ok(sp_ldl_make(&a, k ? &net : NULL, &f[k], &err));
        assert_ok(sp_ldl_factor(f[k], 3.1, &err));
        sp_ldl_solve(f[k], b, x[k]);
    }
    assert_int_equal(sp_ldl_negative(f[0]), sp_ldl_negative(f[1]));
    assert_true(sp_ldl_error(f[0]) != sp_ldl_error(f[1])); /* another order */
    double most = 0, worst = 0;
    for (int64_t k = 0; k < SP_LDL_LANES * a.n; k++) {
        most = fmax(most, fabs(x[0][k]));
        worst = fmax(worst, fabs(x[0][k] - x[1][k]));
    }
    print_message("%lld modes below, solutions differ by %.2g of the largest\n", (long long)sp_ldl_negative(f[0]),
                  worst / most);
    assert_true(worst < 1e-8 * most);
    for (int threads = 2; threads < 5; threads += SANITIZED_STEP(3)) { /* the same bits */
        sp_ldl *shared;
        assert_ok(sp_ldl_make(&a, &net, &shared, &err));
        assert_ok(sp_ldl_share(shared, threads, &err));
        assert_ok(sp_ldl_factor(shared, 3.1, &err));
        sp_ldl_solve(shared, b, x[0]);
        assert_memory_equal(x[0], x[1], SP_LDL_LANES * (size_t)a.n * sizeof *b);
        assert_true(sp_ldl_error(shared) == sp_ldl_error(f[1]));
        sp_ldl_free(shared);
    }
    for (int k = 0; k < 2; k++) {
        sp_ldl_free(f[k]);
        free(x[k]);
    }
    free_cloud(&net);
}

TEST(test_no_memory) {
    srand(10);
    sp_network net = make_cloud(&(cloud){2, 300, SP_CELL_BOX, {12, 12, 1}, {0}});
    int32_t part[300];
    sp_status status = SP_ENOMEM;
    for (int k = 0; status != SP_OK; k++) {
        sp_error err = {0};
        sp_alloc_fail_after(k);
        status = sp_dissect(&net, part, &err);
        sp_alloc_fail_after(-1);
        assert_true(k < 10 && (status == SP_OK || status == SP_ENOMEM));
    }
    free_cloud(&net);
}

RUN_TESTS(NULL, NULL)
