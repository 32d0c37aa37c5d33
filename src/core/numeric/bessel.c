/* Bessel functions by the downward recurrence J_(m-1) = (2m/x) J_m - J_(m+1). It starts at an order where J is
 * negligible and is normalised by J_0^2 + 2 sum J_m^2 = 1, a sum without cancellation. The sign follows from J_0 + 2
 * sum J_2k = 1 (Abramowitz and Stegun, 9.1.76 and 9.1.46). */
#include "numeric/bessel.h"

#include "base/clones.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

/* First value of the recurrence. Values grow by less than 1e165 (x >= TINY), so they and their squares stay in the
 * range of double. */
#define START 1e-140
/* For smaller arguments two terms of the power series are exact. */
#define TINY 1e-4

/* LANES arguments are processed together: CHAINS independent vectors of WIDTH hide the latency of each. */
enum { WIDTH = 8, CHAINS = 2, LANES = WIDTH * CHAINS };
typedef double v8 __attribute__((vector_size(8 * WIDTH)));

/* Cube root to 1e-4: a third of the exponent and two Newton steps. */
static double cube_root(double x) {
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    bits = bits / 3 + UINT64_C(0x2a9f7893782da1ce);
    double root;
    memcpy(&root, &bits, sizeof root);
    for (int k = 0; k < 2; k++)
        root -= (root - x / (root * root)) / 3;
    return root;
}

int64_t sp_bessel_orders(double x) {
    const int64_t order = (int64_t)(x + 30 + 15 * cube_root(x));
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

static double tiny_series(int64_t n, int64_t columns, const double *c, int parity, double x) {
    double power = 1, sum = 0;
    for (int64_t m = 0; m < 2 * n && power > 0; m++) {
        if (m % 2 == parity)
            sum += c[m / 2 * columns] * first_terms(x, power, m);
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

/* Recurrences at an even order: here = J_m and above = J_(m+1), up to normalisation. 2/x is split in two parts. The
 * first is so short that its products with orders are exact; a rounded 2/x would shift the argument. */
typedef struct recurrence {
    v8 here[CHAINS], above[CHAINS], even[CHAINS], squares[CHAINS], series[CHAINS], high[CHAINS], low[CHAINS];
} recurrence;

/* Use of the values: summed with coefficients, or stored in a table. */
typedef struct purpose {
    int64_t n;
    int parity;
    const double *c; /* [n], or NULL */
    double *table;   /* [n][LANES], or NULL */
} purpose;

static ALWAYS_INLINE void take(const purpose *p, int64_t k, const v8 *value, v8 *series) {
    if (k < 0 || k >= p->n)
        return;
    for (int q = 0; q < CHAINS; q++) {
        if (p->c)
            series[q] += p->c[k] * value[q];
        else
            *(v8 *)(p->table + k * LANES + q * WIDTH) = value[q];
    }
}

/* Descends from even order m to even order `stop`. Local variables let the compiler use registers. */
static ALWAYS_INLINE void descend(recurrence *r, int64_t m, int64_t stop, int parity, const purpose *p) {
    v8 here[CHAINS], above[CHAINS], even[CHAINS], squares[CHAINS], series[CHAINS];
    for (int q = 0; q < CHAINS; q++) {
        here[q] = r->here[q];
        above[q] = r->above[q];
        even[q] = r->even[q];
        squares[q] = r->squares[q];
        series[q] = r->series[q];
    }
    for (; m > stop; m -= 2) {
        const double order = (double)m, next = (double)(m - 1);
        if (parity == 0)
            take(p, m / 2, here, series);
        for (int q = 0; q < CHAINS; q++) {
            even[q] += here[q];
            squares[q] += here[q] * here[q];
            above[q] = (order * r->high[q] + order * r->low[q]) * here[q] - above[q];
            squares[q] += above[q] * above[q];
        }
        if (parity == 1)
            take(p, m / 2 - 1, above, series);
        for (int q = 0; q < CHAINS; q++)
            here[q] = (next * r->high[q] + next * r->low[q]) * above[q] - here[q];
    }
    for (int q = 0; q < CHAINS; q++) {
        r->here[q] = here[q];
        r->above[q] = above[q];
        r->even[q] = even[q];
        r->squares[q] = squares[q];
        r->series[q] = series[q];
    }
}

/* Runs the recurrences of a group of arguments down to J_0, and finds their normalisation. */
static ALWAYS_INLINE void run_group(const double *x, const purpose *p, recurrence *r, double *norm) {
    int64_t start[LANES];
    *r = (recurrence){0};
    for (int l = 0; l < LANES; l++) {
        const double high = (float)(2 / x[l]), head = (float)x[l]; /* 24 bits each, so that high x head is exact */
        start[l] = sp_bessel_orders(x[l]);
        r->high[l / WIDTH][l % WIDTH] = high;
        r->low[l / WIDTH][l % WIDTH] = ((2 - high * head) - high * (x[l] - head)) / x[l];
    }
    for (int l = LANES - 1; l >= 0; l--) { /* a lane is 0 above its own starting order */
        r->here[l / WIDTH][l % WIDTH] = START;
        const int64_t stop = l > 0 ? start[l - 1] : 0;
        if (p->parity == 0)
            descend(r, start[l], stop, 0, p);
        else
            descend(r, start[l], stop, 1, p);
    }
    if (p->parity == 0)
        take(p, 0, r->here, r->series);
    for (int l = 0; l < LANES; l++) {
        const double j0 = r->here[l / WIDTH][l % WIDTH], squares = r->squares[l / WIDTH][l % WIDTH];
        norm[l] = copysign(sqrt(j0 * j0 + 2 * squares), j0 + 2 * r->even[l / WIDTH][l % WIDTH]);
    }
}

CLONES static void group_series(const double *x, const purpose *p, double *f) {
    recurrence r;
    double norm[LANES];
    run_group(x, p, &r, norm);
    for (int l = 0; l < LANES; l++)
        f[l] = r.series[l / WIDTH][l % WIDTH] / norm[l];
}

/* Sums rows 0 .. n-1 of the table for `columns` series at once: c[k][columns], f[columns][LANES]. */
static ALWAYS_INLINE void table_sums(int64_t n, int64_t columns, int many, const double *c, const double *table,
                                     const double *norm, double *f) {
    enum { MOST = 4 };
    v8 sum[MOST][CHAINS] = {0};
    for (int64_t k = n - 1; k >= 0; k--) /* small ones first, as for a single series */
        for (int q = 0; q < CHAINS; q++) {
            const v8 value = *(const v8 *)(table + k * LANES + q * WIDTH);
            for (int s = 0; s < many; s++)
                sum[s][q] += c[k * columns + s] * value;
        }
    for (int s = 0; s < many; s++)
        for (int l = 0; l < LANES; l++)
            f[s * LANES + l] = sum[s][l / WIDTH][l % WIDTH] / norm[l];
}

CLONES static void group_series_many(const double *x, int64_t columns, const double *c, const purpose *p, double *f) {
    recurrence r;
    double norm[LANES];
    run_group(x, p, &r, norm);
    const int64_t reached = sp_bessel_orders(x[LANES - 1]) / 2 + (p->parity == 0), n = reached < p->n ? reached : p->n;
    int64_t s = 0;
    for (; s + 4 <= columns; s += 4)
        table_sums(n, columns, 4, c + s, p->table, norm, f + s * LANES);
    for (; s < columns; s++)
        table_sums(n, columns, 1, c + s, p->table, norm, f + s * LANES);
}

/* Copies the next LANES arguments. An incomplete group is filled with its last argument. Returns the number copied. */
static int64_t take_group(int64_t count, const double *x, double *at) {
    const int64_t many = count < LANES ? count : LANES;
    for (int64_t l = 0; l < LANES; l++)
        at[l] = x[l < many ? l : many - 1];
    return many;
}

void sp_bessel_series(int64_t n, const double *c, int parity, int64_t count, const double *x, double *f) {
    const purpose p = {.n = n, .parity = parity, .c = c};
    int64_t first = 0, many;
    for (; first < count && x[first] < TINY; first++)
        f[first] = tiny_series(n, 1, c, parity, x[first]);
    for (; first < count; first += many) {
        double at[LANES], value[LANES];
        many = take_group(count - first, x + first, at);
        group_series(at, &p, value);
        for (int64_t l = 0; l < many; l++)
            f[first + l] = value[l];
    }
}

int64_t sp_bessel_scratch(int64_t n, int64_t columns) { return LANES * (n + columns); }

void sp_bessel_series_many(int64_t n, int64_t columns, const double *c, int parity, int64_t count, const double *x,
                           double *f, int64_t stride, double *scratch) {
    const purpose p = {.n = n, .parity = parity, .table = scratch};
    double *value = scratch + LANES * n;
    int64_t first = 0, many;
    for (; first < count && x[first] < TINY; first++)
        for (int64_t s = 0; s < columns; s++)
            f[s * stride + first] = tiny_series(n, columns, c + s, parity, x[first]);
    for (; first < count; first += many) {
        double at[LANES];
        many = take_group(count - first, x + first, at);
        group_series_many(at, columns, c, &p, value);
        for (int64_t s = 0; s < columns; s++)
            for (int64_t l = 0; l < many; l++)
                f[s * stride + first + l] = value[s * LANES + l];
    }
}

/* ---- Airy functions ---------------------------------------------------------------------------------------------- */

enum { EDGE = 9, TERMS = 26, ASYMPTOTIC = 30 };

/* Ai and Ai' at the integers -EDGE .. EDGE, from the power series at 0 with 40 digits. */
static const double at_integer[2 * EDGE + 1][2] = {
    {-0.022133721547341403674, -0.97566398092633159471},   {-0.052705050356386202622, 0.93556093819830655103},
    {0.18428083525050563728, -0.77100816841012654773},     {-0.32914517362982310523, 0.34593548728134289493},
    {0.35076100902411431979, 0.32719281855444313679},      {-0.070265532949289515099, -0.7906285753685813803},
    {-0.37881429367765807435, 0.31458376921659881365},     {0.22740742820168557599, 0.61825902074169104141},
    {0.5355608832923521188, -0.010160567116645209395},     {0.35502805388781723926, -0.25881940379280679841},
    {0.13529241631288141552, -0.15914744129679321279},     {0.034924130423274379135, -0.053090384433653631704},
    {0.0065911393574607191443, -0.011912976705951318474},  {0.00095156385120480187362, -0.0019586409502041789001},
    {0.00010834442813607441735, -0.000247413890868462476}, {9.9476943602528895702e-6, -0.000024765200397034954754},
    {7.4921288639971670808e-7, -2.0081508947387919912e-6}, {4.6922076160992316256e-8, -1.3414392979067865743e-7},
    {2.4711684308724898433e-9, -7.4806413896589464128e-9},
};

static void taylor(double x, double *ai, double *slope) {
    const double centre = round(x), h = x - centre;
    const double *known = at_integer[(int)centre + EDGE];
    double a[TERMS] = {known[0], known[1], 0.5 * centre * known[0]};
    for (int k = 3; k < TERMS; k++)
        a[k] = (centre * a[k - 2] + a[k - 3]) / (k * (k - 1));
    double value = 0, derivative = 0;
    for (int k = TERMS - 1; k > 0; k--) {
        value = value * h + a[k];
        derivative = derivative * h + k * a[k];
    }
    *ai = value * h + a[0];
    *slope = derivative;
}

/* Sums of the terms u_k/zeta^k and v_k/zeta^k with even and with odd k. For the oscillating functions every second term
 * of each changes its sign. */
typedef struct asymptotic {
    double u[2], v[2];
} asymptotic;

static asymptotic sums(double zeta, bool oscillating) {
    asymptotic s = {.u = {1, 0}, .v = {1, 0}};
    double u = 1;
    for (int k = 1; k < ASYMPTOTIC; k++) {
        u *= (6.0 * k - 5) * (6.0 * k - 3) * (6.0 * k - 1) / (216.0 * k * (2.0 * k - 1) * zeta);
        const double sign = oscillating && k % 4 >= 2 ? -1 : 1;
        s.u[k % 2] += sign * u;
        s.v[k % 2] += sign * u * (6.0 * k + 1) / (1 - 6.0 * k);
    }
    return s;
}

void sp_airy(double x, double *ai, double *slope) {
    const double size = fabs(x);
    if (size <= EDGE) {
        taylor(x, ai, slope);
        return;
    }
    const double zeta = 2 * size * sqrt(size) / 3, root = sqrt(sqrt(size));
    const asymptotic s = sums(zeta, x < 0);
    if (x > 0) {
        const double decay = 0.5 * M_2_SQRTPI / 2 * exp(-zeta);
        *ai = decay / root * (s.u[0] - s.u[1]);
        *slope = -decay * root * (s.v[0] - s.v[1]);
        return;
    }
    const double c = cos(zeta - M_PI_4), q = sin(zeta - M_PI_4);
    *ai = 0.5 * M_2_SQRTPI / root * (c * s.u[0] + q * s.u[1]);
    *slope = 0.5 * M_2_SQRTPI * root * (q * s.v[0] - c * s.v[1]);
}
