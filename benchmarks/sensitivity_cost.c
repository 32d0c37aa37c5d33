/* What a gradient of the arrival costs, in signals:
 *     sensitivity_cost PACKING [REPEATS]
 * One line: grains, contacts; milliseconds of user CPU for the signal in the whole window; that of the signal up to its
 * first front over it; then, over it, the gradient of t_10 by k_n and k_t of all contacts (with the signal), by masses
 * too, and by everything. Each is the median over alternating runs. */
#include "base/base.h"

#include <sonopack/sensitivity.h>
#include <sonopack/study/store.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>

enum { MOST = 101, SIGNALS = 2, KINDS = 5 };

static double user_seconds(void) {
    struct rusage r;
    getrusage(RUSAGE_SELF, &r);
    return (double)r.ru_utime.tv_sec + 1e-6 * (double)r.ru_utime.tv_usec;
}

static int by_size(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *x, int n) {
    qsort(x, (size_t)n, sizeof *x, by_size);
    return x[n / 2];
}

static sp_status signal_once(const sp_network *net, bool front, double *seconds, sp_error *err) {
    sp_signal_options o = sp_signal_options_default();
    sp_signal s = sp_signal_none();
    o.method = SP_SIGNAL_CHEBYSHEV;
    o.until = sp_signal_window(net->box[net->dim - 1], net->pressure);
    o.points = 2000;
    o.front = front;
    *seconds = -user_seconds();
    const sp_status status = sp_signal_make(net, &o, &s, err);
    *seconds += user_seconds();
    sp_signal_free(&s);
    return status;
}

static sp_status gradient_once(const sp_network *net, const sp_packing *p, unsigned parameters, double *seconds,
                               sp_error *err) {
    sp_sensitivity_options o = sp_sensitivity_options_default();
    sp_front_gradient g;
    o.parameters = parameters;
    o.packing = p;
    *seconds = -user_seconds();
    const sp_status status = sp_sensitivity_front(net, &o, SP_FRONT_T10, &g, err);
    *seconds += user_seconds();
    if (status == SP_OK)
        sp_front_gradient_free(&g);
    return status;
}

int main(int count, char **word) {
    static const unsigned by[KINDS] = {0, 0, SP_BY_KN | SP_BY_KT, SP_BY_KN | SP_BY_KT | SP_BY_MASS,
                                       SP_BY_KN | SP_BY_KT | SP_BY_MASS | SP_BY_RADIUS | SP_BY_POSITION};
    static double seconds[KINDS][MOST];
    const int repeats = count > 2 ? atoi(word[2]) : 11;
    const sp_network_options options = sp_network_options_default();
    sp_packing p = sp_packing_none();
    sp_network net = sp_network_none();
    sp_error err = {0};
    if (count < 2 || repeats < 1 || repeats > MOST) {
        fprintf(stderr, "usage: sensitivity_cost PACKING [REPEATS]\n");
        return 2;
    }
    sp_status status = sp_packing_read(word[1], &p, &err);
    if (status == SP_OK)
        status = sp_network_make(&p, &options, &net, &err);
    for (int r = 0; r < repeats && status == SP_OK; r++)
        for (int k = 0; k < KINDS && status == SP_OK; k++)
            status = k < SIGNALS ? signal_once(&net, k == 1, &seconds[k][r], &err)
                                 : gradient_once(&net, &p, by[k], &seconds[k][r], &err);
    if (status == SP_OK) {
        double m[KINDS];
        for (int k = 0; k < KINDS; k++)
            m[k] = median(seconds[k], repeats);
        printf("%d\t%d\t%.3g", net.n, net.n_springs, 1e3 * m[0]);
        for (int k = 1; k < KINDS; k++)
            printf("\t%.2f", m[k] / m[0]);
        printf("\n");
    } else {
        fprintf(stderr, "%s\n", err.text);
    }
    sp_network_free(&net);
    sp_packing_free(&p);
    return status == SP_OK ? 0 : 1;
}
