/* Products of a tall matrix q with a block of eight columns. A strip of the block is turned, so that a row of it is a
 * vector, and stays in the first cache while all columns of q go by. A general product would pack q first, which costs
 * as much again. */
#include "linalg/block.h"
#include "base/clones.h"

#include <string.h>

enum { STRIP = 256, PART = 64 * STRIP }; /* rows */
typedef double lanes __attribute__((vector_size(8 * SP_BLOCK), aligned(64), may_alias));

static ALWAYS_INLINE void turn(int64_t n, int rows, const double *w, lanes *strip) {
    double *x = (double *)strip;
    for (int r = 0; r < rows; r++)
        for (int c = 0; c < SP_BLOCK; c++)
            x[r * SP_BLOCK + c] = w[c * n + r];
}

static ALWAYS_INLINE void turn_back(int64_t n, int rows, const lanes *strip, double *w) {
    const double *x = (const double *)strip;
    for (int c = 0; c < SP_BLOCK; c++)
        for (int r = 0; r < rows; r++)
            w[c * n + r] = x[r * SP_BLOCK + c];
}

/* sum[k] += q_k . strip, for all columns of q. Four at a time, whose sums do not wait for each other. */
CLONES static void add_dots(int64_t n, const double *q, int64_t count, int rows, const lanes *strip, lanes *sum) {
    int64_t k = 0;
    for (; k + 4 <= count; k += 4) {
        const double *a = q + k * n, *b = a + n, *c = b + n, *d = c + n;
        lanes s = strip[0] * a[0], t = strip[0] * b[0], u = strip[0] * c[0], v = strip[0] * d[0];
        for (int r = 1; r < rows; r++) {
            const lanes x = strip[r];
            s += x * a[r];
            t += x * b[r];
            u += x * c[r];
            v += x * d[r];
        }
        sum[k] += s;
        sum[k + 1] += t;
        sum[k + 2] += u;
        sum[k + 3] += v;
    }
    for (; k < count; k++)
        for (int r = 0; r < rows; r++)
            sum[k] += strip[r] * q[k * n + r];
}

/* strip -= q x. */
CLONES static void subtract(int64_t n, const double *q, int64_t count, int rows, const lanes *x, lanes *strip) {
    int64_t k = 0;
    for (; k + 4 <= count; k += 4) {
        const double *a = q + k * n, *b = a + n, *c = b + n, *d = c + n;
        const lanes s = x[k], t = x[k + 1], u = x[k + 2], v = x[k + 3];
        for (int r = 0; r < rows; r++)
            strip[r] -= (s * a[r] + t * b[r]) + (u * c[r] + v * d[r]);
    }
    for (; k < count; k++)
        for (int r = 0; r < rows; r++)
            strip[r] -= x[k] * q[k * n + r];
}

typedef struct product {
    int64_t n, count;
    const double *q, *w;
    double *to; /* w of a subtraction */
    lanes *x;   /* [parts][count] sums of the parts; [count] factors of a subtraction */
} product;

int64_t sp_block_parts(int64_t n) { return (n + PART - 1) / PART; }

static void dots_of_part(void *data, int share, int shares) {
    const product *p = data;
    lanes strip[STRIP];
    for (int64_t part = share; part < sp_block_parts(p->n); part += shares) {
        lanes *sum = p->x + part * p->count;
        memset(sum, 0, (size_t)p->count * sizeof *sum);
        for (int64_t row = part * PART; row < p->n && row < (part + 1) * PART; row += STRIP) {
            const int rows = p->n - row < STRIP ? (int)(p->n - row) : STRIP;
            turn(p->n, rows, p->w + row, strip);
            add_dots(p->n, p->q + row, p->count, rows, strip, sum);
        }
    }
}

void sp_block_dots(sp_pool *pool, int64_t n, const double *q, int64_t count, const double *w, double *sums,
                   double *out) {
    product p = {.n = n, .count = count, .q = q, .w = w, .x = (lanes *)sums};
    sp_pool_run(pool, dots_of_part, &p);
    for (int64_t part = 1; part < sp_block_parts(n); part++)
        for (int64_t k = 0; k < count; k++)
            p.x[k] += p.x[part * count + k];
    for (int c = 0; c < SP_BLOCK; c++)
        for (int64_t k = 0; k < count; k++)
            out[c * count + k] = sums[k * SP_BLOCK + c];
}

static void subtract_part(void *data, int share, int shares) {
    const product *p = data;
    lanes strip[STRIP];
    for (int64_t row = (int64_t)share * STRIP; row < p->n; row += (int64_t)shares * STRIP) {
        const int rows = p->n - row < STRIP ? (int)(p->n - row) : STRIP;
        turn(p->n, rows, p->to + row, strip);
        subtract(p->n, p->q + row, p->count, rows, p->x, strip);
        turn_back(p->n, rows, strip, p->to + row);
    }
}

void sp_block_subtract(sp_pool *pool, int64_t n, const double *q, int64_t count, const double *sums, double *w) {
    product p = {.n = n, .count = count, .q = q, .to = w, .x = (lanes *)sums};
    sp_pool_run(pool, subtract_part, &p);
}
