/* What modes and moduli cost. */
#include "cli/bench.h"

#include <math.h>

typedef struct job {
    const sp_network *net;
    bool vectors;
} job;

static sp_status run_dense(const void *data, double *error, sp_error *err) {
    const job *j = data;
    const sp_modes_options o = {.vectors = j->vectors, .source = SP_SOURCE_IMPULSE};
    sp_modes m = sp_modes_none();
    sp_status status = sp_modes_dense(j->net, &o, &m, err);
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

sp_status bench_modes(const bench_subject *s, sp_error *err) {
    const job all = {s->net, true}, bare = {s->net, false};
    if (sp_network_dofs(s->net) > DENSE_DOFS)
        return SP_OK;
    sp_status status = bench_measure(s, &(bench_row){"modes", "dense", NAN, run_dense, &all}, err);
    if (status == SP_OK)
        status = bench_measure(s, &(bench_row){"frequencies", "dense", NAN, run_dense, &bare}, err);
    return status;
}

sp_status bench_moduli(const bench_subject *s, sp_error *err) {
    const job j = {s->net, false};
    return s->net->dim > 2 ? SP_OK : bench_measure(s, &(bench_row){"moduli", "cholesky", NAN, run_moduli, &j}, err);
}
