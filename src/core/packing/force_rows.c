/* Layout of the rows of forces. Threads share the grains: each finds the rows of its own in ascending order, and skips
 * blocks of pairs that are not near. */
#include "packing/force_rows.h"

#include "base/base.h"

#include <string.h>

/* row: its index. opposite: 1 for the j of a pair, whose force is opposite, else 0. */
static void add_row(force_rows *f, int32_t i, int32_t row, int32_t opposite, int32_t size) {
    if (f->count[i] < SLOTS) {
        f->slot[SLOTS * (int64_t)i + f->count[i]++] = size * row + opposite;
        return;
    }
    const int32_t node = 2 * row + opposite;
    f->count[i]++;
    f->chain[node] = f->further[i];
    f->further[i] = node;
}

static sp_status rows_alloc(dynamics *d, int64_t rows, sp_error *err) {
    force_rows *f = &d->rows;
    if (rows <= f->capacity)
        return SP_OK;
    const int64_t capacity = rows + rows / 4;
    sp_free(f->row);
    sp_free(f->chain);
    f->row = sp_alloc((size_t)(capacity * d->at.row), sizeof *f->row);
    f->chain = sp_alloc((size_t)(2 * capacity), sizeof *f->chain);
    f->capacity = f->row && f->chain ? capacity : 0;
    return f->capacity ? SP_OK : sp_fail_memory(err, (size_t)capacity * 8 * (size_t)(d->at.row + 1));
}

static void find_spans(void *data, int part, int parts) {
    pair_list *p = &((dynamics *)data)->inner;
    const int32_t blocks = (p->n + SPAN - 1) / SPAN, end = sp_pool_share(blocks, part + 1, parts);
    for (int32_t b = sp_pool_share(blocks, part, parts); b < end; b++) {
        int32_t low = INT32_MAX, high = -1;
        for (int32_t k = SPAN * b; k < p->n && k < SPAN * (b + 1); k++) {
            const int32_t i = p->i[k], j = p->j[k], less = i < j ? i : j, more = i < j ? j : i;
            low = less < low ? less : low;
            high = more > high ? more : high;
        }
        p->span[2 * (int64_t)b] = low;
        p->span[2 * (int64_t)b + 1] = high;
    }
}

/* The rows of the pairs [from, to) that belong to grains [first, last). */
static void assign_pairs(force_rows *f, const pair_list *p, int32_t from, int32_t to, int32_t size, int32_t first,
                         int32_t last) {
    for (int32_t k = from; k < to; k++) {
        if (p->i[k] >= first && p->i[k] < last)
            add_row(f, p->i[k], k, 0, size);
        if (p->j[k] >= first && p->j[k] < last)
            add_row(f, p->j[k], f->other + k, f->both ? 0 : 1, size);
    }
}

static void assign_all_pairs(force_rows *f, const pair_list *p, int32_t size) {
    for (int32_t k = 0; k < p->n; k++) {
        add_row(f, p->i[k], k, 0, size);
        add_row(f, p->j[k], f->other + k, f->both ? 0 : 1, size);
    }
}

static void assign_part(void *data, int part, int parts) {
    dynamics *d = data;
    force_rows *f = &d->rows;
    const pair_list *p = &d->inner;
    const int32_t size = d->at.row, blocks = (p->n + SPAN - 1) / SPAN;
    const int32_t first = sp_pool_share(d->n, part, parts), last = sp_pool_share(d->n, part + 1, parts);
    memset(f->count + first, 0, (size_t)(last - first) * sizeof *f->count);
    for (int32_t i = first; i < last; i++)
        f->further[i] = -1;
    for (int64_t s = SLOTS * (int64_t)first; s < SLOTS * (int64_t)last; s++)
        f->slot[s] = size * f->zero;
    for (int32_t b = 0; b < blocks && parts > 1; b++)
        if (sp_rows_may_touch(p, b, first, last))
            assign_pairs(f, p, SPAN * b, SPAN * (b + 1) < p->n ? SPAN * (b + 1) : p->n, size, first, last);
    if (parts == 1)
        assign_all_pairs(f, p, size);
    for (int side = 0; side < d->walls; side++)
        for (int32_t k = 0; k < d->wall[side].n; k++)
            if (d->wall[side].i[k] >= first && d->wall[side].i[k] < last)
                add_row(f, d->wall[side].i[k], f->wall[side] + k, 0, size);
}

sp_status sp_rows_assign(dynamics *d, sp_error *err) {
    force_rows *f = &d->rows;
    const pair_list *p = &d->inner;
    f->other = f->both ? p->padded : 0;
    f->zero = f->other + p->padded;
    int64_t rows = (int64_t)f->zero + 1;
    for (int side = 0; side < d->walls; side++)
        rows += d->wall[side].n;
    if (rows > INT32_MAX / d->at.row)
        return sp_fail(err, SP_ENOMEM, "%d pairs of neighbours: more than a list can number", p->n);
    sp_status status = rows_alloc(d, rows, err);
    if (status != SP_OK)
        return status;
    for (int side = 0; side < d->walls; side++) {
        f->wall[side] = f->zero;
        f->zero += d->wall[side].n;
    }
    memset(f->row + (int64_t)f->zero * d->at.row, 0, (size_t)d->at.row * sizeof *f->row);
    if (d->pool)
        sp_pool_run(d->pool, find_spans, d);
    sp_pool_run(d->pool, assign_part, d);
    return SP_OK;
}
