/* Divides the spectrum between two edges into pieces that threads solve independently of each other. */
#include "base/base.h"
#include "base/pool.h"
#include "linalg/eigen.h"
#include "modes/slices.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

typedef struct piece {
    slice_edge a, b;
    sp_status status;
    sp_error err;
    int64_t factors, solves;
} piece;

typedef struct division {
    slicer *z;
    piece *piece; /* [capacity] ascending */
    int64_t start, count;
    size_t capacity;
    atomic_llong next; /* the next piece to be solved */
} division;

static sp_status add_piece(division *d, slice_edge a, slice_edge b, sp_error *err) {
    if (b.below == a.below)
        return SP_OK;
    piece *larger = sp_grow(d->piece, (size_t)d->count + 1, &d->capacity, sizeof *larger);
    if (!larger)
        return sp_fail_memory(err, ((size_t)d->count + 1) * sizeof *larger);
    d->piece = larger;
    d->piece[d->count++] = (piece){.a = a, .b = b};
    return SP_OK;
}

/* Halves an interval until a piece has few enough modes, or is too narrow for an edge inside. */
static sp_status divide(division *d, slice_edge a, slice_edge b, sp_error *err) {
    const double width = b.sigma - a.sigma;
    if (b.below - a.below <= SP_SLICER_PIECE || width < 1e-6 * fabs(b.sigma) + 1e3 * (a.error + b.error))
        return add_piece(d, a, b, err);
    slice_edge middle;
    sp_status status = sp_slicer_edge(d->z, a.sigma + 0.4 * width, a.sigma + 0.6 * width, &middle, err);
    if (status == SP_OK && (middle.below < a.below || middle.below > b.below))
        status = sp_fail(err, SP_EREFUSED, "%lld modes below omega^2 = %.6g, must be %lld .. %lld",
                         (long long)middle.below, middle.sigma, (long long)a.below, (long long)b.below);
    if (status == SP_OK)
        status = divide(d, a, middle, err);
    return status == SP_OK ? divide(d, middle, b, err) : status;
}

/* Solves a piece, and puts its modes in their place. */
static void solve_piece(const division *d, piece *p) {
    slicer *to = d->z, own = {0};
    bool certain = false;
    p->status = sp_slicer_make(to->net, to->vectors, &own, &p->err);
    if (p->status != SP_OK)
        return;
    own.solver = to->solver;
    p->status = sp_slicer_between(&own, p->a, p->b, &certain, &p->err);
    if (p->status == SP_OK && !certain)
        p->status = sp_fail(&p->err, SP_EREFUSED, "modes lie too near omega^2 = %.6g or %.6g to be counted", p->a.sigma,
                            p->b.sigma);
    const int64_t row = to->front + p->a.below - d->start;
    if (p->status == SP_OK)
        memcpy(to->ritz + row, own.ritz, (size_t)own.found * sizeof *own.ritz);
    if (p->status == SP_OK && to->vectors)
        memcpy(to->vector + row * to->n, own.vector, (size_t)(own.found * to->n) * sizeof *own.vector);
    p->factors = own.factors;
    p->solves = own.solves;
    sp_slicer_free(&own);
}

static void solve_pieces(void *data, int part, int parts) {
    division *d = data;
    (void)part, (void)parts;
    for (int64_t k = atomic_fetch_add(&d->next, 1); k < d->count; k = atomic_fetch_add(&d->next, 1))
        solve_piece(d, &d->piece[k]);
}

static sp_status solve_all(division *d, sp_error *err) {
    sp_pool *pool = NULL;
    sp_status status = sp_pool_make(d->z->threads, &pool, err);
    if (status != SP_OK)
        return status;
    sp_pool_run(pool, solve_pieces, d);
    sp_pool_free(pool);
    for (int64_t k = 0; k < d->count && status == SP_OK; k++) {
        const piece *p = &d->piece[k];
        if (p->status != SP_OK)
            status = sp_fail(err, p->status, "%s", p->err.text);
        d->z->factors += p->factors;
        d->z->solves += p->solves;
    }
    return status;
}

/* Vectors on both sides of an edge come from different searches. The upper ones are made orthogonal to the lower ones,
 * which changes them by less than their errors. */
static void join(const division *d) {
    enum { NEAR = 64 };
    const slicer *z = d->z;
    const int64_t n = z->n;
    double overlap[NEAR];
    for (int64_t k = 1; z->vectors && k < d->count; k++) {
        const int64_t edge = d->piece[k].a.below - d->start, end = d->piece[k].b.below - d->start;
        const int64_t below = edge < NEAR ? edge : NEAR;
        const double *known = z->vector + (z->front + edge - below) * n;
        for (int64_t row = edge; row < edge + NEAR && row < end; row++)
            sp_project_out(n, below, known, z->vector + (z->front + row) * n, overlap);
    }
}

sp_status sp_slicer_pieces(slicer *z, slice_edge a, slice_edge b, sp_error *err) {
    division d = {.z = z, .start = a.below};
    sp_status status = divide(&d, a, b, err);
    if (status == SP_OK)
        status = solve_all(&d, err);
    if (status == SP_OK) {
        join(&d);
        z->found = b.below - a.below;
    }
    sp_free(d.piece);
    return status;
}
