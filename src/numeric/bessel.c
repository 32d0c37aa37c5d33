/* Downward recurrence J_(m-1) = (2m/x) J_m - J_(m+1) from an order where J is negligible, normalised afterwards by
 * J_0^2 + 2 sum J_m^2 = 1, a sum that cancels nothing; its sign by J_0 + 2 sum J_2k = 1 (Abramowitz and Stegun, 9.1.76
 * and 9.1.46). */
#include "numeric/bessel.h"

#include <math.h>

/* The recurrence starts with this. From it values grow by less than 1e165 (x >= TINY), and neither they nor their
 * squares leave the range of double. */
#define START 1e-140
/* Below this argument two terms of the power series are exact. */
#define TINY 1e-4

/* Arguments are taken LANES at a time: independent chains, CHAINS vectors of two, hide the latency of each. */
enum { CHAINS = 2, LANES = 2 * CHAINS };
typedef double pair __attribute__((vector_size(16)));

int64_t sp_bessel_orders(double x) {
    const int64_t order = (int64_t)(x + 30 + 15 * cbrt(x));
    return order + order % 2;
}

/* J_m(x) = (x/2)^m/m! (1 - (x/2)^2/(m+1) + ...), x < TINY. */
static double first_terms(double x, double power, int64_t m) { return power * (1 - 0.25 * x * x / (double)(m + 1)); }

static void tiny_j(double x, int64_t n, double *j) {
    double power = 1;
    for (int64_t m = 0; m < n; m++) {
        j[m] = power == 0 ? 0 : first_terms(x, power, m);
        power *= 0.5 * x / (double)(m + 1);
    }
}

static double tiny_series(int64_t n, const double *c, int parity, double x) {
    double power = 1, sum = 0;
    for (int64_t m = 0; m < 2 * n && power > 0; m++) {
        if (m % 2 == parity)
            sum += c[m / 2] * first_terms(x, power, m);
        power *= 0.5 * x / (double)(m + 1);
    }
    return sum;
}

void sp_bessel_j(double x, int64_t n, double *j) {
    if (x < TINY) {
        tiny_j(x, n, j);
        return;
    }
    double above = 0, here = START, even = 0, squares = 0;
    int64_t m = sp_bessel_orders(x);
    for (int64_t k = m; k < n; k++)
        j[k] = 0;
    for (; m > 0; m--) {
        if (m < n)
            j[m] = here;
        if (m % 2 == 0)
            even += here;
        squares += here * here;
        const double below = (double)(2 * m) / x * here - above;
        above = here;
        here = below;
    }
    const double scale = copysign(1 / sqrt(here * here + 2 * squares), here + 2 * even);
    if (n > 0)
        j[0] = here;
    for (int64_t k = 0; k < n && k < sp_bessel_orders(x); k++)
        j[k] *= scale;
}

/* Two recurrences at an even order: here = J_m, above = J_(m+1), up to normalisation. 2/x in two parts, the first so
 * short that its products with orders are exact: a rounded 2/x would shift the argument. */
typedef struct recurrence {
    pair here, above, even, squares, series, high, low;
} recurrence;

/* One order down: J_(m-1) from here = J_m and above = J_(m+1), in place of above. */
static inline void step_down(const recurrence *r, int64_t m, const pair *here, pair *above) {
    const double order = (double)m;
    *above = (order * r->high + order * r->low) * *here - *above;
}

/* From even order m down to even order `stop`. */
static inline __attribute__((always_inline)) void descend(recurrence *out, int64_t m, int64_t stop, int64_t n,
                                                          const double *c, int parity) {
    recurrence r[CHAINS];
    for (int q = 0; q < CHAINS; q++)
        r[q] = out[q];
    for (; m > stop; m -= 2) {
        const int64_t k = m / 2; /* J_2k is here, J_(2k-1) is next */
        const double even = parity == 0 && k < n ? c[k] : 0, odd = parity == 1 && k <= n ? c[k - 1] : 0;
        for (int q = 0; q < CHAINS; q++) {
            r[q].even += r[q].here;
            r[q].squares += r[q].here * r[q].here;
            if (parity == 0)
                r[q].series += even * r[q].here;
            step_down(&r[q], m, &r[q].here, &r[q].above);
            r[q].squares += r[q].above * r[q].above;
            if (parity == 1)
                r[q].series += odd * r[q].above;
            step_down(&r[q], m - 1, &r[q].above, &r[q].here);
        }
    }
    for (int q = 0; q < CHAINS; q++)
        out[q] = r[q];
}

static void group_series(int64_t n, const double *c, int parity, const double *x, double *f) {
    recurrence r[CHAINS] = {0};
    int64_t start[LANES];
    for (int l = 0; l < LANES; l++) {
        const double high = (float)(2 / x[l]), head = (float)x[l]; /* 24 bits each: high x head is exact */
        start[l] = sp_bessel_orders(x[l]);
        r[l / 2].high[l % 2] = high;
        r[l / 2].low[l % 2] = ((2 - high * head) - high * (x[l] - head)) / x[l];
    }
    for (int l = LANES - 1; l >= 0; l--) { /* a lane is 0 until its own starting order */
        r[l / 2].here[l % 2] = START;
        const int64_t stop = l > 0 ? start[l - 1] : 0;
        if (parity == 0)
            descend(r, start[l], stop, n, c, 0);
        else
            descend(r, start[l], stop, n, c, 1);
    }
    for (int l = 0; l < LANES; l++) {
        const recurrence *s = &r[l / 2];
        const double j0 = s->here[l % 2], norm = sqrt(j0 * j0 + 2 * s->squares[l % 2]);
        const double sum = s->series[l % 2] + (parity == 0 && n > 0 ? c[0] * j0 : 0);
        f[l] = sum / copysign(norm, j0 + 2 * s->even[l % 2]);
    }
}

void sp_bessel_series(int64_t n, const double *c, int parity, int64_t count, const double *x, double *f) {
    int64_t first = 0;
    for (; first < count && x[first] < TINY; first++)
        f[first] = tiny_series(n, c, parity, x[first]);
    for (; first < count; first += LANES) {
        const int64_t many = count - first < LANES ? count - first : LANES;
        double at[LANES], value[LANES];
        for (int l = 0; l < LANES; l++) /* a last group is filled up with its last argument */
            at[l] = x[first + (l < many ? l : many - 1)];
        group_series(n, c, parity, at, value);
        for (int64_t l = 0; l < many; l++)
            f[first + l] = value[l];
    }
}
