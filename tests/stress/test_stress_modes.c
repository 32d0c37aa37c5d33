/* Frequencies of every hard network by every solver against quadruple precision: each lies within its own error, zero
 * modes are zero, what is unstable is refused. */
#include "stress/exact.h"
#include "stress/networks.h"
#include "stress/record.h"

#include <sonopack/modes.h>

/* The row that is worst against its bound stands for all of them. */
static void compare(stress_record *r, const char *network, const char *method, const sp_modes *m, const exact *x) {
    double error = 0, reported = 1, scale = 1, ratio = -1;
    for (int k = 0; k < x->n; k++) {
        const double omega = m->omega[m->n_rattler + k], bound = m->error[m->n_rattler + k];
        const double off = (double)quad_abs(quad_sqrt(quad_abs(x->lambda[k])) - omega); /* growth counts, too */
        const double here = off > 0 ? off / bound : 0;
        if (!(here <= ratio)) {
            ratio = here;
            error = off;
            reported = bound;
            scale = omega > 0 ? omega : (double)quad_sqrt(x->lambda[x->n - 1]);
        }
    }
    stress_agree(r, network, method, "frequencies", error, reported, scale);
}

/* |A e - omega^2 e| over the largest eigenvalue, and the deviation of the vectors from orthonormal ones. */
static void compare_vectors(stress_record *r, const char *network, const char *method, const sp_network *net,
                            const sp_modes *m, const exact *x) {
    const int n = x->n;
    quad *a = exact_matrix(net), residual = 0, defect = 0;
    for (int k = 0; k < n; k++) {
        const double *e = m->vectors + (int64_t)k * n, omega = m->omega[m->n_rattler + k];
        quad squares = 0;
        for (int i = 0; i < n; i++) {
            quad rest = -(quad)omega * omega * e[i];
            for (int j = 0; j < n; j++)
                rest += a[i * n + j] * e[j];
            squares += rest * rest;
        }
        residual = squares > residual ? squares : residual;
        for (int q = k; q < n; q++) {
            quad dot = q == k ? -1 : 0;
            for (int i = 0; i < n; i++)
                dot += (quad)e[i] * m->vectors[(int64_t)q * n + i];
            defect = quad_abs(dot) > defect ? quad_abs(dot) : defect;
        }
    }
    /* both are measured in double precision: with some roundings of n terms */
    const double slack = (8 + sqrt(n)) * DBL_EPSILON;
    stress_agree(r, network, method, "residual", (double)(quad_sqrt(residual) / x->lambda[n - 1]), m->residual + slack,
                 1);
    stress_agree(r, network, method, "orthogonality", (double)defect, m->orthogonality + slack, 1);
    free(a);
}

static void run_dense(stress_record *r, const stress_case *c, const sp_network *net, const exact *x, bool vectors) {
    const sp_modes_options o = {.vectors = vectors, .source = SP_SOURCE_IMPULSE};
    const char *method = vectors ? "dense" : "dense, frequencies";
    RELEASED double *scratch = calloc((size_t)x->n, sizeof *scratch);
    FREED(sp_modes) m = sp_modes_none();
    sp_error err = {0};
    /* amplitudes need both walls */
    const bool walls = sp_network_source(net, SP_SOURCE_IMPULSE, scratch, &err) == SP_OK &&
                       sp_network_detector(net, scratch, &err) == SP_OK;
    if (vectors && !walls)
        return;
    const sp_status status = sp_modes_dense(net, &o, &m, &err);
    if (status != SP_OK) {
        stress_refuse(r, c->name, method, "frequencies", status, &err);
        return;
    }
    compare(r, c->name, method, &m, x);
    if (vectors)
        compare_vectors(r, c->name, method, net, &m, x);
}

/* The exact modes first .. first+count-1 are those of the set, each within its error, and it says that none is missing
 * in what was asked for. */
static void compare_part(stress_record *r, const char *network, const char *what, const sp_modes *m, const exact *x,
                         int first, int count) {
    double ratio = 0, error = 0, reported = 1;
    const int64_t rows = m->n - m->n_rattler;
    stress_agree(r, network, "sparse", what, fabs((double)(rows - count)), (double)m->on_edge, count);
    for (int64_t k = 0; k < rows && rows == count; k++) {
        const double omega = m->omega[m->n_rattler + k], bound = m->error[m->n_rattler + k];
        const double off = (double)quad_abs(quad_sqrt(quad_abs(x->lambda[first + k])) - omega);
        if (!(off / bound <= ratio)) {
            ratio = off / bound;
            error = off;
            reported = bound;
        }
    }
    stress_agree(r, network, "sparse", what, error, reported, (double)quad_sqrt(x->lambda[x->n - 1]));
}

/* All modes, a third of them from below, and a band from the middle, its limits in gaps of the exact spectrum. */
static void run_sparse(stress_record *r, const stress_case *c, const sp_network *net, const exact *x) {
    const sp_modes_options o = {.vectors = false, .source = SP_SOURCE_IMPULSE};
    const int n = x->n;
    int from = n / 4, to = (3 * n) / 4, zeros = 0;
    while (zeros < n && x->lambda[zeros] < x->lambda[n - 1] * 1e-16L)
        zeros++;
    int most = n / 3 > zeros ? n / 3 : zeros < n ? zeros + 1 : n;
    const quad gap = x->lambda[n - 1] * 1e-6L;
    while (from > 0 && x->lambda[from] - x->lambda[from - 1] < gap)
        from--;
    while (to < n && x->lambda[to] - x->lambda[to - 1] < gap)
        to++;
    while (most < n && x->lambda[most] - x->lambda[most - 1] < gap)
        most++;
    const double low = from > 0 ? (double)quad_sqrt((x->lambda[from - 1] + x->lambda[from]) / 2) : 0;
    const double high = to < n ? (double)quad_sqrt((x->lambda[to - 1] + x->lambda[to]) / 2) : HUGE_VAL;
    const struct {
        const char *name;
        sp_modes_range range;
        int first, count;
    } parts[] = {{"all", sp_modes_range_all(), 0, n},
                 {"lowest third", {.lowest = most - zeros, .zero = true}, 0, most},
                 {"band", sp_modes_range_band(low, high), from, to - from}};
    for (int q = 0; q < 3; q++) {
        FREED(sp_modes) m = sp_modes_none();
        sp_error err = {0};
        const sp_status status = sp_modes_sparse(net, &o, &parts[q].range, &m, &err);
        if (status != SP_OK)
            stress_refuse(r, c->name, "sparse", parts[q].name, status, &err);
        else
            compare_part(r, c->name, parts[q].name, &m, x, parts[q].first, parts[q].count);
    }
}

static void run_case(stress_record *r, const stress_case *c, uint64_t seed) {
    FREED(sp_network) net = c->make(c->value, seed);
    FREED(exact) x = exact_solve(&net);
    run_dense(r, c, &net, &x, true);
    run_dense(r, c, &net, &x, false);
    run_sparse(r, c, &net, &x);
}

TEST(test_modes) {
    stress_record r = stress_open();
    for (int k = 0; k < STRESS_CASES; k++)
        run_case(&r, &stress_cases[k], 1);
    stress_close(&r);
    assert_int_equal(r.wrong, 0);
}

RUN_TESTS_WHERE(STRESS_QUAD, NULL, NULL)
