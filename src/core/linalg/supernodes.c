/* Orders a sparse symmetric matrix and finds the supernodes of its factor with CHOLMOD. */
#include "linalg/supernodes.h"

#include "base/base.h"
#include "linalg/dissection.h"

#include <cholmod.h>
#include <string.h>

/* CHOLMOD takes 64-bit indices here; an ordering does not read the values. stype -1: lower triangle. */
static cholmod_sparse *copy_pattern(const sp_sparse *a, cholmod_common *common) {
    const size_t n = (size_t)a->n, entries = (size_t)a->p[a->n];
    cholmod_sparse *m = cholmod_l_allocate_sparse(n, n, entries, 1, 1, -1, CHOLMOD_PATTERN, common);
    if (!m)
        return NULL;
    SuiteSparse_long *p = m->p, *i = m->i;
    for (size_t k = 0; k <= n; k++)
        p[k] = a->p[k];
    for (size_t k = 0; k < entries; k++)
        i[k] = a->i[k];
    return m;
}

static sp_status cholmod_failed(const cholmod_common *common, sp_error *err) {
    if (common->status == CHOLMOD_OUT_OF_MEMORY)
        return sp_fail(err, SP_ENOMEM, "CHOLMOD: no memory for the factor");
    if (common->status == CHOLMOD_TOO_LARGE)
        return sp_fail(err, SP_EREFUSED, "CHOLMOD: the factor is too large");
    return sp_fail(err, SP_EFAILED, "CHOLMOD: ordering failed (status %d)", common->status);
}

static sp_status allocate(const sp_sparse *a, const cholmod_factor *l, sp_supernodes *s, sp_error *err) {
    const size_t n = (size_t)a->n, entries = (size_t)a->p[n], count = l->nsuper, rows = l->ssize;
    s->n = a->n;
    s->count = (int64_t)count;
    s->order = sp_alloc(n, sizeof *s->order);
    s->owner = sp_alloc(n, sizeof *s->owner);
    s->first = sp_alloc(count + 1, sizeof *s->first);
    s->rows_at = sp_alloc(count + 1, sizeof *s->rows_at);
    s->value_at = sp_alloc(count + 1, sizeof *s->value_at);
    s->rows = sp_alloc(rows, sizeof *s->rows);
    s->place = sp_alloc(entries, sizeof *s->place);
    s->diagonal = sp_alloc(n, sizeof *s->diagonal);
    if (s->order && s->owner && s->first && s->rows_at && s->value_at && s->rows && s->place && s->diagonal)
        return SP_OK;
    return sp_fail_memory(err, 16 * n + 20 * count + 4 * rows + 8 * entries);
}

static void copy_structure(const cholmod_factor *l, sp_supernodes *s) {
    const SuiteSparse_long *order = l->Perm, *first = l->super, *rows_at = l->pi, *rows = l->s;
    for (int64_t k = 0; k < s->n; k++)
        s->order[k] = (int32_t)order[k];
    for (int64_t q = 0; q < (int64_t)l->ssize; q++)
        s->rows[q] = (int32_t)rows[q];
    for (int64_t k = 0; k <= s->count; k++) {
        s->first[k] = (int32_t)first[k];
        s->rows_at[k] = rows_at[k];
    }
    s->largest_update = (int64_t)l->maxcsize;
    for (int64_t k = 0; k < s->count; k++) {
        const int64_t size = (int64_t)sp_supernode_rows(s, k) * sp_supernode_width(s, k);
        s->value_at[k + 1] = s->value_at[k] + size;
        s->largest_panel = size > s->largest_panel ? size : s->largest_panel;
        for (int32_t c = s->first[k]; c < s->first[k + 1]; c++)
            s->owner[c] = (int32_t)k;
    }
}

/* Index of the entry of the factor at (row, column) in the values. */
static int64_t index_of(const sp_supernodes *s, int32_t row, int32_t column) {
    const int32_t k = s->owner[column], width = sp_supernode_width(s, k);
    const int32_t *rows = s->rows + s->rows_at[k];
    int32_t low = 0, high = sp_supernode_rows(s, k) - 1;
    while (low < high) {
        const int32_t middle = low + (high - low) / 2;
        if (rows[middle] < row)
            low = middle + 1;
        else
            high = middle;
    }
    return s->value_at[k] + (int64_t)low * width + (column - s->first[k]);
}

static sp_status find_places(const sp_sparse *a, sp_supernodes *s, sp_error *err) {
    int32_t *to = sp_alloc((size_t)s->n, sizeof *to); /* row of the factor of a row of A */
    if (!to)
        return sp_fail_memory(err, (size_t)s->n * sizeof *to);
    for (int64_t k = 0; k < s->n; k++)
        to[s->order[k]] = (int32_t)k;
    for (int64_t c = 0; c < a->n; c++) {
        s->diagonal[c] = index_of(s, to[c], to[c]);
        for (int64_t q = a->p[c]; q < a->p[c + 1]; q++) {
            const int32_t x = to[c], y = to[a->i[q]];
            s->place[q] = index_of(s, x > y ? x : y, x > y ? y : x);
        }
    }
    sp_free(to);
    return SP_OK;
}

/* AMD's order, where it takes few operations: looking for a better one takes as long as some 10^9 of them. */
static const double FEW_OPERATIONS = 2e9;

/* The order of nested dissection, with AMD's inside the parts (CAMD), if it takes fewer operations than `l', which is
 * then replaced. */
static sp_status try_dissection(cholmod_sparse *m, const sp_network *net, cholmod_factor **l, cholmod_common *common,
                                sp_error *err) {
    const size_t n = m->nrow;
    const double operations = common->fl;
    SuiteSparse_long *part = sp_alloc(2 * n, sizeof *part), *order = part ? part + n : NULL;
    int32_t *of = sp_alloc((size_t)net->n, sizeof *of);
    sp_status status = part && of ? sp_dissect(net, of, err) : sp_fail_memory(err, 24 * n);
    if (status == SP_OK) {
        for (size_t k = 0; k < n; k++)
            part[k] = of[k / (size_t)net->dof];
        common->method[0].ordering = CHOLMOD_GIVEN;
        cholmod_factor *other =
            cholmod_l_camd(m, NULL, 0, part, order, common) ? cholmod_l_analyze_p(m, order, NULL, 0, common) : NULL;
        if (!other)
            status = cholmod_failed(common, err);
        const bool fewer = other && common->fl < operations;
        cholmod_l_free_factor(fewer ? l : &other, common);
        if (fewer)
            *l = other;
    }
    sp_free(part);
    sp_free(of);
    return status;
}

/* Fraction of zeros in a supernode that is merged from others of together up to 4, 16, 48 columns. */
static const double zeros_allowed[] = {0.2, 0.03, 0.02};

sp_status sp_supernodes_make(const sp_sparse *a, const sp_network *net, sp_supernodes *out, sp_error *err) {
    cholmod_common common;
    sp_supernodes s = {0};
    if (a->n < 1 || a->n >= INT32_MAX)
        return sp_fail(err, SP_EREFUSED, "sparse matrix of order %lld, must be 1 .. 2^31 - 1", (long long)a->n);
    cholmod_l_start(&common);
    common.print = 0;
    common.try_catch = 1; /* CHOLMOD returns errors as a status and prints nothing */
    common.supernodal = CHOLMOD_SUPERNODAL;
    common.nmethods = 1;
    common.method[0].ordering = CHOLMOD_AMD; /* METIS would replace the handlers of SIGTERM and SIGABRT while it runs */
    for (int k = 0; k < 3; k++) /* fewer zeros in merged supernodes than by default: solves are bound by memory */
        common.zrelax[k] = zeros_allowed[k];
    cholmod_sparse *m = copy_pattern(a, &common);
    cholmod_factor *l = m ? cholmod_l_analyze(m, &common) : NULL;
    sp_status status = l ? SP_OK : cholmod_failed(&common, err);
    if (status == SP_OK && net && common.fl > FEW_OPERATIONS)
        status = try_dissection(m, net, &l, &common, err);
    if (status == SP_OK)
        status = allocate(a, l, &s, err);
    if (status == SP_OK) {
        copy_structure(l, &s);
        status = find_places(a, &s, err);
    }
    cholmod_l_free_factor(&l, &common);
    cholmod_l_free_sparse(&m, &common);
    cholmod_l_finish(&common);
    if (status == SP_OK)
        *out = s;
    else
        sp_supernodes_free(&s);
    return status;
}

void sp_supernodes_free(sp_supernodes *s) {
    sp_free(s->order);
    sp_free(s->owner);
    sp_free(s->first);
    sp_free(s->rows_at);
    sp_free(s->value_at);
    sp_free(s->rows);
    sp_free(s->place);
    sp_free(s->diagonal);
    *s = (sp_supernodes){0};
}

void sp_sparse_free(sp_sparse *a) {
    sp_free(a->p);
    sp_free(a->i);
    sp_free(a->x);
    *a = (sp_sparse){0};
}
