/* Finds all frequencies of a large network: counts divide the spectrum into pieces, and threads share these. */
#include "modes/pieces.h"
#include "base/base.h"
#include "base/pool.h"
#include "modes/rows.h"
#include "modes/slices.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

enum { PIECE = 512 }; /* modes in a piece at most: some slices, which cost more than the edges and the analysis */

typedef struct piece {
    slice_edge a, b;
    sp_status status;
    sp_error err;
    int64_t factors, solves;
} piece;

typedef struct division {
    const sp_network *net;
    slicer edges; /* finds the edges of the pieces */
    piece *piece; /* [capacity] ascending */
    int64_t count;
    size_t capacity;
    sp_ritz *ritz;     /* [dofs] null motions, then the modes of all pieces */
    int64_t front;     /* null motions */
    atomic_llong next; /* the next piece to be solved */
} division;

bool sp_modes_is_large(const sp_network *net) {
    enum { FLAT = 5000, SOLID = 8000 }; /* degrees of freedom; factors fill faster in three dimensions */
    return sp_network_dofs(net) > (net->dim > 2 ? SOLID : FLAT);
}

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
    if (b.below - a.below <= PIECE || width < 1e-6 * fabs(b.sigma) + 1e3 * (a.error + b.error))
        return add_piece(d, a, b, err);
    slice_edge middle;
    sp_status status = sp_slicer_edge(&d->edges, a.sigma + 0.4 * width, a.sigma + 0.6 * width, &middle, err);
    if (status == SP_OK && (middle.below < a.below || middle.below > b.below))
        status = sp_fail(err, SP_EREFUSED, "%lld modes below omega^2 = %.6g, must be %lld .. %lld",
                         (long long)middle.below, middle.sigma, (long long)a.below, (long long)b.below);
    if (status == SP_OK)
        status = divide(d, a, middle, err);
    return status == SP_OK ? divide(d, middle, b, err) : status;
}

static void solve_piece(const division *d, piece *p) {
    slicer z = {0};
    bool certain = false;
    p->status = sp_slicer_make(d->net, false, &z, &p->err);
    if (p->status != SP_OK)
        return;
    z.solver = SP_SOLVER_LANCZOS;
    p->status = sp_slicer_between(&z, p->a, p->b, &certain, &p->err);
    if (p->status == SP_OK && !certain)
        p->status = sp_fail(&p->err, SP_EREFUSED, "modes lie too near omega^2 = %.6g or %.6g to be counted", p->a.sigma,
                            p->b.sigma);
    if (p->status == SP_OK)
        memcpy(d->ritz + d->front + p->a.below, z.ritz, (size_t)z.found * sizeof *z.ritz);
    p->factors = z.factors;
    p->solves = z.solves;
    sp_slicer_free(&z);
}

static void solve_pieces(void *data, int part, int parts) {
    division *d = data;
    (void)part, (void)parts;
    for (int64_t k = atomic_fetch_add(&d->next, 1); k < d->count; k = atomic_fetch_add(&d->next, 1))
        solve_piece(d, &d->piece[k]);
}

static sp_status solve_all(division *d, int threads, sp_error *err) {
    sp_pool *pool = NULL;
    sp_status status = sp_pool_make(threads > 1 ? threads : 1, &pool, err);
    if (status != SP_OK)
        return status;
    sp_pool_run(pool, solve_pieces, d);
    sp_pool_free(pool);
    for (int64_t k = 0; k < d->count && status == SP_OK; k++)
        if (d->piece[k].status != SP_OK)
            status = sp_fail(err, d->piece[k].status, "%s", d->piece[k].err.text);
    return status;
}

static sp_status tabulate(const division *d, sp_source source, sp_modes *out, sp_error *err) {
    sp_mode_pairs set = {
        .count = sp_network_dofs(d->net), .ritz = d->ritz, .rattlers = (int64_t)d->net->rattlers * d->net->dof};
    sp_status status = sp_zeros_count(d->net, d->edges.modes, d->ritz + d->front, 0, &set.zeros, err);
    if (status != SP_OK)
        return status;
    set.zero = sp_zeros_sum(d->net, &d->edges.null, set.zeros);
    set.zeros += d->front;
    status = sp_modes_tabulate(d->net, source, &set, out, err);
    if (status != SP_OK)
        return status;
    out->solver = SP_SOLVER_LANCZOS;
    out->certified_to = HUGE_VAL;
    out->factors = d->edges.factors;
    for (int64_t k = 0; k < d->count; k++) {
        out->factors += d->piece[k].factors;
        out->solves += d->piece[k].solves;
    }
    return SP_OK;
}

sp_status sp_modes_in_pieces(const sp_network *net, const sp_modes_options *opt, sp_modes *out, sp_error *err) {
    const int64_t n = sp_network_dofs(net);
    division d = {.net = net};
    slice_edge bottom;
    sp_status status = sp_slicer_make(net, false, &d.edges, err);
    if (status == SP_OK)
        status = sp_slicer_bottom(&d.edges, 1e-3 * sp_slicer_guess(&d.edges, PIECE), &bottom, err);
    if (status == SP_OK)
        status = divide(&d, bottom, sp_slicer_top(&d.edges), err);
    if (status == SP_OK) {
        d.front = n - d.edges.modes;
        d.ritz = sp_alloc((size_t)n, sizeof *d.ritz);
        for (int64_t k = 0; d.ritz && k < d.front; k++)
            d.ritz[k] = sp_slicer_null(&d.edges);
        status = d.ritz ? solve_all(&d, opt->threads, err) : sp_fail_memory(err, (size_t)n * sizeof *d.ritz);
    }
    if (status == SP_OK)
        status = tabulate(&d, opt->source, out, err);
    sp_free(d.ritz);
    sp_free(d.piece);
    sp_slicer_free(&d.edges);
    return status;
}
