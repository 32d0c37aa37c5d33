#ifndef TEST_SIGNALS_H
#define TEST_SIGNALS_H
/* What tests of signals share: a network with the usual options, and how far two signals are apart. */
#include "base/base.h"
#include "reference.h"

#include <sonopack/signal.h>

static inline sp_network network_of(const sp_packing *p, bool prestress) {
    sp_network_options o = sp_network_options_default();
    sp_network net = sp_network_none();
    o.prestress = prestress;
    assert_ok(sp_network_make(p, &o, &net, &err));
    return net;
}

static inline double peak_of(int n, const double *f) {
    double peak = 0;
    for (int k = 0; k < n; k++)
        peak = fmax(peak, fabs(f[k]));
    return peak;
}

static inline double difference(int n, const double *f, const double *g) {
    double worst = 0;
    for (int k = 0; k < n; k++)
        worst = fmax(worst, fabs(f[k] - g[k]));
    return worst;
}

/* Every allocation fails once, more than `least`: nothing is left behind. p: of dynamics, else NULL. */
static inline void lacks_memory(const sp_packing *p, const sp_network *net, const sp_signal_options *o, int least) {
    sp_signal s = sp_signal_none();
    EACH_ALLOCATION_FAILS(least, sp_signal_compute(p, net, o, &s, &err), assert_true(!lacks || !s.f),
                          sp_signal_free(&s));
}

#endif
