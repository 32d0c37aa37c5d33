/* Measures the run time of modes and moduli. */
#include "cli/bench.h"

#include <math.h>

typedef sp_status (*solver)(const sp_network *, const sp_modes_options *, const sp_modes_range *, sp_modes *,
                            sp_error *);

typedef struct job {
    const sp_network *net;
    bool vectors;
    int64_t lowest; /* 0: all */
    solver solve;   /* NULL: the dense one */
} job;

static sp_status run_modes(const void *data, double *error, sp_error *err) {
    const job *j = data;
    const sp_modes_options o = {.vectors = j->vectors, .source = SP_SOURCE_IMPULSE};
    const sp_modes_range range = j->lowest > 0 ? sp_modes_range_lowest(j->lowest) : sp_modes_range_all();
    sp_modes m = sp_modes_none();
    sp_status status = j->solve ? j->solve(j->net, &o, &range, &m, err) : sp_modes_dense(j->net, &o, &m, err);
    *error = 0;
    for (int64_t k = 0; status == SP_OK && k < m.n; k++)
        if (m.omega[k] > 0)
            *error = fmax(*error, m.error[k] / m.omega[k]);
    sp_modes_free(&m);
    return status;
}

static sp_status run_moduli(const void *data, double *error, sp_error *err) {
    const job *j = data;
    sp_moduli m;
    sp_status status = sp_moduli_make(j->net, NAN, &m, err);
    if (status == SP_OK)
        *error = m.error22 / m.c22;
    return status;
}

enum { DENSE_DOFS = 3000 };

/* The dense solver computes all modes, however many are asked for. */
static sp_status bench_range(const bench_subject *s, const char *name, int64_t lowest, bool vectors, sp_error *err) {
    const struct {
        const char *name;
        solver solve;
        bool dense;
    } ways[] = {{"auto", sp_modes_make, lowest == 0}, {"sparse", sp_modes_sparse, false}, {"dense", NULL, true}};
    sp_status status = SP_OK;
    for (int k = 0; k < 3 && status == SP_OK; k++) {
        const job j = {s->net, vectors, lowest, ways[k].solve};
        if ((lowest > 0 && sp_network_dofs(s->net) < 2 * lowest) || /* there may be zero modes */
            ((ways[k].dense || lowest == 0) && sp_network_dofs(s->net) > DENSE_DOFS))
            continue;
        status = bench_measure(s, &(bench_row){name, ways[k].name, NAN, run_modes, &j}, err);
    }
    return status;
}

sp_status bench_modes(const bench_subject *s, sp_error *err) {
    sp_status status = bench_range(s, "lowest10", 10, true, err);
    if (status == SP_OK)
        status = bench_range(s, "lowest100", 100, true, err);
    if (status == SP_OK)
        status = bench_range(s, "modes", 0, true, err);
    if (status == SP_OK)
        status = bench_range(s, "frequencies", 0, false, err);
    return status;
}

sp_status bench_moduli(const bench_subject *s, sp_error *err) {
    const job j = {.net = s->net};
    return s->net->dim > 2 ? SP_OK : bench_measure(s, &(bench_row){"moduli", "cholesky", NAN, run_moduli, &j}, err);
}
