#include "signal/modal.h"
#include "base/base.h"

#include <float.h>
#include <math.h>
#include <sonopack/modes.h>

/* Leaves room for 5 times what is seen. */
#define BACKWARD 1.0

/* Error of the sum at the last time. Every frequency's own error turns its phase, independently of the others; the
 * solver's backward error, some DBL_EPSILON of A, acts like a shift at the top of the spectrum; sine and sum are
 * rounded. */
static double modal_error(const sp_modes *m, double omega, double last) {
    double phases = 0, squares = 0;
    for (int64_t row = 0; row < m->n; row++) {
        const double ab = fabs(m->a[row] * m->b[row]), turn = fmin(2, m->error[row] * last);
        phases += ab * ab * turn * turn;
        squares += ab * ab;
    }
    return 2 * sqrt(phases) + BACKWARD * DBL_EPSILON * (1 + omega * last) * sqrt(squares);
}

sp_status sp_signal_by_modes(const sp_network *net, const sp_signal_options *opt, sp_signal *s, sp_error *err) {
    sp_modes m = sp_modes_none();
    const sp_modes_options how = {.vectors = true, .source = opt->source};
    sp_status status = sp_modes_dense(net, &how, &m, err);
    if (status != SP_OK)
        return status;
    for (int32_t l = 0; l < s->n; l++) {
        double sum = 0;
        for (int64_t row = m.n_rattler; row < m.n; row++) {
            const double phase = m.omega[row] * s->t[l];
            sum += m.a[row] * m.b[row] * (opt->source == SP_SOURCE_DISPLACEMENT ? cos(phase) : sin(phase));
        }
        s->f[l] = sum;
    }
    s->error = modal_error(&m, sp_network_omega_bound(net), s->t[s->n - 1]);
    sp_modes_free(&m);
    return SP_OK;
}
