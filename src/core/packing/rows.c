/* Layout of the rows of forces. Threads share the grains: each finds the rows of its own in ascending order, and skips
 * blocks of pairs that are not near. */
#include "packing/rows.h"

#include "base/base.h"

#include <string.h>

/* row: its index */
static void add_row(force_rows *f, int32_t i, int32_t row, int32_t size) {
    if (f->count[i] < SLOTS) {
        f->slot[SLOTS * (int64_t)i + f->count[i]++] = size * row;
        return;
    }
    f->count[i]++;
    f->chain[row] = f->further[i];
    f->further[i] = row;
}

static sp_status rows_alloc(dynamics *d, int64_t rows, sp_error *err) {
    force_rows *f = &d->rows;
    if (rows <= f->capacity)
        return SP_OK;
    const int64_t capacity = rows + rows / 4;
    sp_free(f->row);
    sp_free(f->chain);
    f->row = sp_alloc((size_t)(capacity * d->at.row), sizeof *f->row);
    f->chain = sp_alloc((size_t)capacity, sizeof *f->chain);
    f->capacity = f->row && f->chain ? capacity : 0;
    return f->capacity ? SP_OK : sp_fail_memory(err, (size_t)capacity * (8 * (size_t)d->at.row + 4));
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
    for (int32_t b = 0; b < blocks; b++)
        for (int32_t k = SPAN * b; k < p->n && k < SPAN * (b + 1) && sp_rows_may_touch(p, b, first, last); k++) {
            if (p->i[k] >= first && p->i[k] < last)
                add_row(f, p->i[k], k, size);
            if (p->j[k] >= first && p->j[k] < last)
                add_row(f, p->j[k], f->other + k, size);
        }
    for (int side = 0; side < d->walls; side++)
        for (int32_t k = 0; k < d->wall[side].n; k++)
            if (d->wall[side].i[k] >= first && d->wall[side].i[k] < last)
                add_row(f, d->wall[side].i[k], f->wall[side] + k, size);
}

sp_status sp_rows_assign(dynamics *d, sp_error *err) {
    force_rows *f = &d->rows;
    const pair_list *p = &d->inner;
    int64_t rows = 2 * (int64_t)p->padded + 1;
    for (int side = 0; side < d->walls; side++)
        rows += d->wall[side].n;
    if (rows > INT32_MAX / d->at.row)
        return sp_fail(err, SP_ENOMEM, "%d pairs of neighbours: more than a list can number", p->n);
    sp_status status = rows_alloc(d, rows, err);
    if (status != SP_OK)
        return status;
    f->other = p->padded;
    f->zero = 2 * p->padded;
    for (int side = 0; side < d->walls; side++) {
        f->wall[side] = f->zero;
        f->zero += d->wall[side].n;
    }
    memset(f->row + (int64_t)f->zero * d->at.row, 0, (size_t)d->at.row * sizeof *f->row);
    sp_pool_run(d->pool, find_spans, d);
    sp_pool_run(d->pool, assign_part, d);
    return SP_OK;
}
