/* Quadrature on an interval. */
#include "numeric/quadrature.h"

#include <math.h>

void sp_gauss_rule(int n, double *node, double *weight) {
    for (int k = 0; k < n; k++) {
        double x = cos(M_PI * (k + 0.75) / (n + 0.5)), slope = 1;
        for (int step = 0; step < 20; step++) {
            double p = 1, before = 0;
            for (int m = 1; m <= n; m++) {
                const double next = ((2 * m - 1) * x * p - (m - 1) * before) / m;
                before = p;
                p = next;
            }
            slope = n * (x * p - before) / (x * x - 1);
            x -= p / slope;
        }
        node[k] = x;
        weight[k] = 2 / ((1 - x * x) * slope * slope);
    }
}
