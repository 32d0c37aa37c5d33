/* Explicit Runge-Kutta steps. */
#include "numeric/ode.h"

#include "base/base.h"

#include <math.h>
#include <stddef.h>

enum { STAGES = 7 };

sp_status sp_ode_make(int64_t n, sp_ode_slope *slope, void *user, sp_ode *out, sp_error *err) {
    double *scratch = sp_alloc((size_t)n * (STAGES + 1), sizeof *scratch);
    if (!scratch)
        return sp_fail_memory(err, (size_t)n * (STAGES + 1) * sizeof *scratch);
    *out = (sp_ode){.n = n, .slope = slope, .user = user, .scratch = scratch};
    return SP_OK;
}

void sp_ode_free(sp_ode *ode) {
    sp_free(ode->scratch);
    ode->scratch = NULL;
}

void sp_ode_step4(sp_ode *ode, double t, double h, const double *y, double *to) {
    const int64_t n = ode->n;
    double *k1 = ode->scratch, *k2 = k1 + n, *k3 = k2 + n, *k4 = k3 + n, *at = k4 + n;
    ode->slope(t, y, k1, ode->user);
    for (int64_t i = 0; i < n; i++)
        at[i] = y[i] + 0.5 * h * k1[i];
    ode->slope(t + 0.5 * h, at, k2, ode->user);
    for (int64_t i = 0; i < n; i++)
        at[i] = y[i] + 0.5 * h * k2[i];
    ode->slope(t + 0.5 * h, at, k3, ode->user);
    for (int64_t i = 0; i < n; i++)
        at[i] = y[i] + h * k3[i];
    ode->slope(t + h, at, k4, ode->user);
    for (int64_t i = 0; i < n; i++)
        to[i] = y[i] + h / 6 * (k1[i] + 2 * (k2[i] + k3[i]) + k4[i]);
}

/* Nodes and weights. The last row of weights gives the solution of order 5; `difference` is that row minus the one of
 * order 4. */
static const double node[STAGES] = {0, 1 / 5.0, 3 / 10.0, 4 / 5.0, 8 / 9.0, 1, 1};
static const double weight[STAGES][STAGES - 1] = {
    {0, 0, 0, 0, 0, 0},
    {1 / 5.0, 0, 0, 0, 0, 0},
    {3 / 40.0, 9 / 40.0, 0, 0, 0, 0},
    {44 / 45.0, -56 / 15.0, 32 / 9.0, 0, 0, 0},
    {19372 / 6561.0, -25360 / 2187.0, 64448 / 6561.0, -212 / 729.0, 0, 0},
    {9017 / 3168.0, -355 / 33.0, 46732 / 5247.0, 49 / 176.0, -5103 / 18656.0, 0},
    {35 / 384.0, 0, 500 / 1113.0, 125 / 192.0, -2187 / 6784.0, 11 / 84.0}};
static const double difference[STAGES] = {71 / 57600.0,      0,          -71 / 16695.0, 71 / 1920.0,
                                          -17253 / 339200.0, 22 / 525.0, -1 / 40.0};

double sp_ode_step5(sp_ode *ode, double t, double h, const double *y, const double *scale, double *to) {
    const int64_t n = ode->n;
    double *k = ode->scratch, *at = k + STAGES * n, worst = 0;
    for (int s = 0; s < STAGES; s++) {
        double *point = s == STAGES - 1 ? to : at;
        for (int64_t i = 0; i < n; i++) {
            double sum = 0;
            for (int q = 0; q < s; q++)
                sum += weight[s][q] * k[q * n + i];
            point[i] = y[i] + h * sum;
        }
        ode->slope(t + node[s] * h, point, k + s * n, ode->user);
    }
    for (int64_t i = 0; i < n; i++) {
        double sum = 0;
        for (int s = 0; s < STAGES; s++)
            sum += difference[s] * k[s * n + i];
        double error = fabs(h * sum) / (scale[i] + fabs(y[i]));
        if (!(error <= worst))
            worst = error; /* keeps NAN */
    }
    return worst;
}

double sp_ode_factor(double error) {
    if (!isfinite(error))
        return 0.1;
    return error > 0 ? fmin(5, fmax(0.2, 0.9 * pow(error, -0.2))) : 5;
}
