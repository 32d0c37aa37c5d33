/* Givens rotations, and one-sided Jacobi rotations (Hestenes 1958), which find small singular values accurately. */
#include "network/svd.h"

#include <float.h>
#include <math.h>

enum { MOST = SP_SVD_MAX };

void sp_svd_add(sp_svd *t, double row[MOST]) {
    for (int c = 0; c < t->n; c++) {
        double *own = t->r[c];
        const double size = hypot(own[c], row[c]);
        if (row[c] == 0)
            continue;
        const double cosine = own[c] / size, sine = row[c] / size;
        for (int k = c; k < t->n; k++) {
            const double a = own[k], b = row[k];
            own[k] = cosine * a + sine * b;
            row[k] = cosine * b - sine * a;
        }
    }
}

double sp_svd_least(const sp_svd *t) {
    double inverse[MOST][MOST] = {{0}}, squares = 0;
    for (int c = 0; c < t->n; c++)
        for (int r = c; r >= 0; r--) {
            double sum = r == c;
            for (int k = r + 1; k <= c; k++)
                sum -= t->r[r][k] * inverse[k][c];
            if (t->r[r][r] == 0)
                return 0;
            inverse[r][c] = sum / t->r[r][r];
            squares += inverse[r][c] * inverse[r][c];
        }
    return isfinite(squares) ? 1 / sqrt(squares) : 0;
}

/* Makes columns p and q of g orthogonal; returns whether they were not. */
static int rotate(int n, double g[MOST][MOST], double v[MOST][MOST], int p, int q, double tiny) {
    double pp = 0, qq = 0, pq = 0;
    for (int k = 0; k < n; k++) {
        pp += g[p][k] * g[p][k];
        qq += g[q][k] * g[q][k];
        pq += g[p][k] * g[q][k];
    }
    if (fabs(pq) <= 4 * DBL_EPSILON * sqrt(pp * qq) || fabs(pq) <= tiny)
        return 0;
    const double tau = (qq - pp) / (2 * pq), tangent = copysign(1, tau) / (fabs(tau) + hypot(1, tau));
    const double cosine = 1 / hypot(1, tangent), sine = cosine * tangent;
    for (int k = 0; k < n; k++) {
        const double a = g[p][k], b = g[q][k], x = v[p][k], y = v[q][k];
        g[p][k] = cosine * a - sine * b;
        g[q][k] = sine * a + cosine * b;
        v[p][k] = cosine * x - sine * y;
        v[q][k] = sine * x + cosine * y;
    }
    return 1;
}

void sp_svd_values(const sp_svd *t, double value[MOST], double v[MOST][MOST]) {
    const int n = t->n;
    double g[MOST][MOST] = {{0}}, squares = 0; /* columns of R v */
    for (int c = 0; c < n; c++)
        for (int k = 0; k < n; k++) {
            g[c][k] = k <= c ? t->r[k][c] : 0;
            v[c][k] = k == c;
            squares += g[c][k] * g[c][k];
        }
    for (int sweep = 0, turned = 1; sweep < 30 && turned; sweep++) {
        turned = 0;
        for (int p = 0; p < n; p++)
            for (int q = p + 1; q < n; q++)
                turned += rotate(n, g, v, p, q, DBL_EPSILON * DBL_EPSILON * squares);
    }
    for (int c = 0; c < n; c++) {
        value[c] = 0;
        for (int k = 0; k < n; k++)
            value[c] += g[c][k] * g[c][k];
        value[c] = sqrt(value[c]);
    }
}
