/* The cost of the parts of a Chebyshev signal on one packing, and the rate of memory:
 *     signal_parts PACKING THREADS UNTIL
 * One line: grains, threads; milliseconds for the network, for a whole signal at 801 times up to UNTIL (0: none) and
 * for one product of two vectors with every grain awake, each the least of several, in CPU time with one thread and in
 * wall time with more; the bytes that such a product must move, with every number fetched from memory once, and the
 * rate of that; the rates of copying and of a triad over arrays too large for caches, by as many threads, written bytes
 * counted twice as they are fetched first. */
#include "base/base.h"
#include "base/pool.h"
#include "signal/recurrence.h"

#include <math.h>
#include <sonopack/signal.h>
#include <sonopack/study/store.h>
#include <stdio.h>
#include <stdlib.h>

enum { POINTS = 801, STREAM = 1 << 24 };

/* CPU time with one thread, so that other work on the processor does not count; wall time with more. */
static double (*seconds)(void) = sp_clock_cpu;

typedef struct stream {
    double *a, *b, *c;
    bool triad;
} stream;

static void stream_part(void *data, int part, int parts) {
    const stream *s = data;
    double *restrict a = s->a;
    const double *restrict b = s->b, *restrict c = s->c;
    const size_t first = (size_t)STREAM / (size_t)parts * (size_t)part, end = first + (size_t)STREAM / (size_t)parts;
    if (s->triad)
        for (size_t k = first; k < end; k++)
            a[k] = b[k] + 3 * c[k];
    else
        for (size_t k = first; k < end; k++)
            a[k] = b[k];
}

/* Bytes a second. */
static double stream_rate(sp_pool *pool, stream *s, bool triad) {
    double least = HUGE_VAL;
    s->triad = triad;
    for (int run = 0; run < 7; run++) {
        const double start = seconds();
        sp_pool_run(pool, stream_part, s);
        least = fmin(least, seconds() - start);
    }
    return (triad ? 4.0 : 3.0) * sizeof(double) * STREAM / least;
}

static void wake_all(const sp_operator *op, recurrence *r) {
    for (int32_t b = 0; b < op->blocks; b++)
        r->awake[b] = 1;
    for (int64_t k = 0; k < 2 * (int64_t)op->n * op->dof; k++)
        r->u[sp_operator_at(op, k / 2) + k % 2] = 1e-3 * (double)(k % 17);
    r->start[0] = r->start[1] = 1;
    r->doubled = true;
}

static double product_seconds(recurrence *r, int32_t n) {
    const int steps = n > 100000 ? 4 : n > 5000 ? 40 : 400;
    double least = HUGE_VAL;
    for (int run = 0; run < 7; run++) {
        const double start = seconds();
        for (int k = 0; k < steps; k++)
            sp_recurrence_step(r);
        least = fmin(least, (seconds() - start) / steps);
    }
    return least;
}

/* Springs; U and V are read and written, but U is not fetched when it exceeds all caches; masses. */
static double product_bytes(const sp_operator *op, const recurrence *r) {
    const int32_t chunks = op->chunk[op->blocks];
    const double springs =
        (double)(op->inner.first[chunks] + op->border.first[chunks]) * quad_size(op->kind) * sizeof(double);
    const double vectors = (r->past_caches || op->blocks == 1 ? 4 : 5) * (double)op->row * sizeof(double);
    return springs + op->n * (vectors + (op->kind.rotations ? 4.0 : 2.0) * sizeof(double));
}

static double signal_seconds(const sp_network *net, int threads, double until, sp_error *err) {
    sp_signal_options o = sp_signal_options_default();
    double least = HUGE_VAL;
    o.method = SP_SIGNAL_CHEBYSHEV;
    o.until = until;
    o.points = POINTS;
    o.threads = threads;
    for (int run = 0; run < (net->n > 100000 ? 1 : 25); run++) {
        sp_signal s;
        const double start = seconds();
        if (sp_signal_make(net, &o, &s, err) != SP_OK)
            return NAN;
        least = fmin(least, seconds() - start);
        sp_signal_free(&s);
    }
    return least;
}

int main(int argc, char **argv) {
    sp_error err = {0};
    sp_packing p = sp_packing_none();
    sp_network net = sp_network_none();
    sp_operator op = {0};
    recurrence r = {0};
    sp_pool *pool = NULL;
    if (argc != 4)
        return fprintf(stderr, "signal_parts PACKING THREADS UNTIL\n"), 2;
    const int threads = atoi(argv[2]);
    const double until = atof(argv[3]);
    seconds = threads > 1 ? sp_clock_wall : sp_clock_cpu;
    const sp_network_options no = sp_network_options_default();
    stream s = {.a = sp_alloc(STREAM, 8), .b = sp_alloc(STREAM, 8), .c = sp_alloc(STREAM, 8)};
    sp_status status = sp_packing_read(argv[1], &p, &err);
    double network = HUGE_VAL;
    for (int run = 0; run < 5 && status == SP_OK; run++) {
        const double start = seconds();
        sp_network_free(&net);
        status = sp_network_make(&p, &no, &net, &err);
        network = fmin(network, seconds() - start);
    }
    sp_packing_free(&p);
    if (status == SP_OK)
        status = sp_operator_make(&net, &op, &err);
    if (status == SP_OK)
        status = sp_recurrence_make(&op, net.mass, net.omega_bound, threads, &r, &err);
    if (status == SP_OK)
        status = sp_pool_make(threads, &pool, &err);
    if (status != SP_OK || !s.a || !s.b || !s.c)
        return fprintf(stderr, "signal_parts: %s\n", err.text), 1;
    wake_all(&op, &r);
    const double product = product_seconds(&r, net.n), bytes = product_bytes(&op, &r);
    sp_recurrence_free(&r);
    const double signal = until > 0 ? signal_seconds(&net, threads, until, &err) : 0;
    printf("%d\t%d\t%.4g\t%.4g\t%.4g\t%.4g\t%.3g\t%.3g\t%.3g\n", (int)net.n, threads, 1e3 * network, 1e3 * signal,
           1e3 * product, 1e-6 * bytes, 1e-9 * bytes / product, 1e-9 * stream_rate(pool, &s, false),
           1e-9 * stream_rate(pool, &s, true));
    sp_pool_free(pool);
    sp_operator_free(&op);
    sp_network_free(&net);
    sp_free(s.a);
    sp_free(s.b);
    sp_free(s.c);
    return 0;
}
