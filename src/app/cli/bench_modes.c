/* Measures the run time of modes and moduli. */
#include "cli/bench.h"

#include <math.h>

typedef struct job {
    const sp_network *net;
    bool vectors;
    int64_t lowest; /* 0: all */
    sp_modes_solver solver;
} job;

static sp_status run_modes(const void *data, double *error, sp_error *err) {
    const job *j = data;
    const sp_modes_options o = {.vectors = j->vectors, .source = SP_SOURCE_IMPULSE, .solver = j->solver};
    const sp_modes_range range = j->lowest > 0 ? sp_modes_range_lowest(j->lowest) : sp_modes_range_all();
    sp_modes m = sp_modes_none();
    sp_status status = sp_modes_make(j->net, &o, &range, &m, err);
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
    static const sp_modes_solver solvers[] = {SP_SOLVER_AUTO, SP_SOLVER_LANCZOS, SP_SOLVER_ARPACK, SP_SOLVER_DENSE};
    const int64_t dofs = sp_network_dofs(s->net);
    sp_status status = SP_OK;
    for (int k = 0; k < 4 && status == SP_OK; k++) {
        const job j = {s->net, vectors, lowest, solvers[k]};
        const bool dense = solvers[k] == SP_SOLVER_DENSE || lowest == 0, few = dofs < 4 * lowest;
        if (dense ? dofs > DENSE_DOFS || lowest > dofs : few)
            continue;
        status = bench_measure(s, &(bench_row){name, cli_solver_names[solvers[k]], NAN, run_modes, &j}, err);
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
