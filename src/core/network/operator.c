/* Builds the compact form of K: order of the grains, blocks, and springs. */
#include "network/operator.h"
#include "base/base.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

/* Networks of up to ONE_BLOCK grains are one block. Larger ones are divided into roughly square blocks of about BLOCK
 * grains. Their vectors fit into the second-level cache, and about 7% of their springs lead to other blocks. */
enum { ONE_BLOCK = 2048, BLOCK = 1024, CHUNK = 128, QUAD_ROW = 8 };

void sp_operator_free(sp_operator *op) {
    sp_free(op->row_of);
    sp_free(op->grain);
    sp_free(op->scale);
    sp_free(op->first);
    sp_free(op->chunk);
    sp_free(op->chunk_row);
    sp_free(op->two);
    sp_free(op->one);
    sp_free(op->two_quads);
    sp_free(op->one_quads);
    sp_free(op->two_springs);
    sp_free(op->one_springs);
    sp_free(op->two_carried);
    sp_free(op->one_carried);
    sp_free(op->beside_first);
    sp_free(op->beside);
    *op = (sp_operator){0};
}

/* Whether the network fits sp_quad: two translations with the same mass and one rotation per grain, and lever arms
 * equal to the radius. */
static bool fits_quads(const sp_network *net) {
    if (net->dim != 2 || net->dof != 3 || net->prestress || net->carried)
        return false;
    for (int32_t k = 0; k < net->n; k++)
        if (!(net->r[k] > 0) || net->mass[3 * (int64_t)k] != net->mass[3 * (int64_t)k + 1])
            return false;
    for (int32_t k = 0; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        if (s->ri != net->r[s->i] || (s->j >= 0 && s->rj != net->r[s->j]))
            return false;
    }
    return true;
}

typedef struct placed {
    double at;
    int32_t grain;
} placed;

static int by_place(const void *a, const void *b) {
    const placed *x = a, *y = b;
    if (x->at != y->at)
        return x->at < y->at ? -1 : 1;
    return (x->grain > y->grain) - (x->grain < y->grain);
}

static void sort_along(const sp_network *net, int axis, placed *list, int32_t n) {
    for (int32_t k = 0; k < n; k++)
        list[k].at = net->x[3 * (int64_t)list[k].grain + axis];
    qsort(list, (size_t)n, sizeof *list, by_place);
}

/* The grains are divided into horizontal bands of equal numbers of grains, and each band into blocks along x. */
static int32_t count_bands(const sp_network *net, int32_t blocks) {
    double bands = 1;
    if (net->dim == 1)
        bands = blocks;
    else if (net->dim == 2)
        bands = sqrt(blocks * net->box[1] / net->box[0]);
    else
        bands = cbrt(blocks * net->box[2] / net->box[0] * net->box[2] / net->box[1]);
    return bands >= 1 ? (int32_t)fmin(round(bands), blocks) : 1;
}

static int32_t part_of(int32_t n, int32_t part, int32_t parts) { return (int32_t)((int64_t)n * part / parts); }

static sp_status order_grains(const sp_network *net, sp_operator *op, sp_error *err) {
    const int32_t wanted = net->n <= ONE_BLOCK ? 1 : (net->n + BLOCK - 1) / BLOCK;
    const int32_t bands = count_bands(net, wanted), across = (wanted + bands - 1) / bands;
    placed *list = sp_alloc((size_t)net->n, sizeof *list);
    op->grain = sp_alloc((size_t)net->n, sizeof *op->grain);
    op->first = sp_alloc((size_t)bands * (size_t)across + 1, sizeof *op->first);
    if (!list || !op->grain || !op->first) {
        sp_free(list);
        return sp_fail_memory(err, (size_t)net->n * (sizeof *list + sizeof *op->grain));
    }
    for (int32_t k = 0; k < net->n; k++)
        list[k].grain = k;
    sort_along(net, net->dim - 1, list, net->n);
    for (int32_t b = 0; b < bands; b++) {
        const int32_t begin = part_of(net->n, b, bands), count = part_of(net->n, b + 1, bands) - begin;
        if (across > 1)
            sort_along(net, 0, list + begin, count);
        for (int32_t c = 0; c < across; c++) {
            const int32_t end = begin + part_of(count, c + 1, across);
            if (end > op->first[op->blocks])
                op->first[++op->blocks] = end;
        }
    }
    for (int32_t k = 0; k < net->n; k++)
        op->grain[k] = list[k].grain;
    for (int32_t b = 0; b < op->blocks; b++)
        op->largest = op->first[b + 1] - op->first[b] > op->largest ? op->first[b + 1] - op->first[b] : op->largest;
    sp_free(list);
    return SP_OK;
}

static sp_status cut_chunks(sp_operator *op, sp_error *err) {
    const size_t most = (size_t)op->n / CHUNK + (size_t)op->blocks;
    op->chunk = sp_alloc((size_t)op->blocks + 1, sizeof *op->chunk);
    op->chunk_row = sp_alloc(most + 1, sizeof *op->chunk_row);
    if (!op->chunk || !op->chunk_row)
        return sp_fail_memory(err, (most + (size_t)op->blocks + 2) * sizeof *op->chunk);
    for (int32_t b = 0; b < op->blocks; b++) {
        const int32_t rows = op->first[b + 1] - op->first[b], chunks = (rows + CHUNK - 1) / CHUNK;
        for (int32_t c = 0; c < chunks; c++)
            op->chunk_row[op->chunk[b] + c] = op->first[b] + part_of(rows, c, chunks);
        op->chunk[b + 1] = op->chunk[b] + chunks;
    }
    op->chunk_row[op->chunk[op->blocks]] = op->n;
    return SP_OK;
}

static sp_status set_scale(const sp_network *net, sp_operator *op, sp_error *err) {
    const int64_t dof = net->dof;
    op->scale = sp_alloc((size_t)net->n * (size_t)dof, sizeof *op->scale);
    if (!op->scale)
        return sp_fail_memory(err, (size_t)net->n * (size_t)dof * sizeof *op->scale);
    for (int64_t k = 0; k < net->n; k++)
        for (int64_t a = 0; a < dof; a++)
            op->scale[k * dof + a] = op->quad && a >= net->dim ? net->r[op->grain[k]] : 1;
    return SP_OK;
}

/* Used while springs are assigned to blocks. */
typedef struct dealing {
    const sp_network *net;
    int32_t *block;     /* [n] block of a row */
    int64_t *two, *one; /* [n] springs of each row: first their number, then the place of the next one */
} dealing;

static void dealing_free(dealing *d) {
    sp_free(d->block);
    sp_free(d->two);
    sp_free(d->one);
}

static sp_status dealing_make(const sp_network *net, sp_operator *op, dealing *d, sp_error *err) {
    const size_t n = (size_t)net->n;
    *d = (dealing){.net = net};
    op->row_of = sp_alloc(n, sizeof *op->row_of);
    d->block = sp_alloc(n, sizeof *d->block);
    d->two = sp_alloc(n, sizeof *d->two);
    d->one = sp_alloc(n, sizeof *d->one);
    if (!op->row_of || !d->block || !d->two || !d->one)
        return sp_fail_memory(err, n * 24);
    for (int32_t b = 0; b < op->blocks; b++)
        for (int32_t k = op->first[b]; k < op->first[b + 1]; k++) {
            op->row_of[op->grain[k]] = k;
            d->block[k] = b;
        }
    for (int32_t k = 0; k < net->n_springs; k++) {
        const int32_t i = op->row_of[net->springs[k].i], j = net->springs[k].j < 0 ? -1 : op->row_of[net->springs[k].j];
        if (j >= 0 && d->block[i] == d->block[j]) {
            d->two[i < j ? i : j]++;
            continue;
        }
        d->one[i]++;
        if (j >= 0)
            d->one[j]++;
    }
    return SP_OK;
}

/* Replaces the numbers of springs of rows by places in the list. Each chunk begins at a multiple of `unit`; first[]
 * gives the chunks' beginnings in units. */
static void number_springs(const sp_operator *op, int64_t unit, int64_t *rows, int64_t *first) {
    const int32_t chunks = op->chunk[op->blocks];
    int64_t at = 0;
    for (int32_t c = 0; c < chunks; c++) {
        first[c] = at / unit;
        for (int32_t k = op->chunk_row[c]; k < op->chunk_row[c + 1]; k++) {
            const int64_t count = rows[k];
            rows[k] = at;
            at += count;
        }
        at = (at + unit - 1) / unit * unit;
    }
    first[chunks] = at / unit;
}

/* Allocates at least one entry, so that the pointers are not NULL. */
static sp_status allocate_carried(sp_operator *op, size_t two, size_t one, sp_error *err) {
    op->two_carried = sp_alloc(two + 1, sizeof *op->two_carried);
    op->one_carried = sp_alloc(one + 1, sizeof *op->one_carried);
    return op->two_carried && op->one_carried ? SP_OK : sp_fail_memory(err, (two + one) * sizeof(sp_carried));
}

static sp_status allocate_springs(sp_operator *op, dealing *d, sp_error *err) {
    const int64_t unit = op->quad ? 4 : 1;
    const size_t chunks = (size_t)op->chunk[op->blocks];
    op->two = sp_alloc(chunks + 1, sizeof *op->two);
    op->one = sp_alloc(chunks + 1, sizeof *op->one);
    if (!op->two || !op->one)
        return sp_fail_memory(err, 2 * (chunks + 1) * sizeof *op->two);
    number_springs(op, unit, d->two, op->two);
    number_springs(op, unit, d->one, op->one);
    const size_t two = (size_t)op->two[chunks], one = (size_t)op->one[chunks];
    if (op->quad) {
        op->two_quads = sp_alloc(two, sizeof *op->two_quads);
        op->one_quads = sp_alloc(one, sizeof *op->one_quads);
        return op->two_quads && op->one_quads ? SP_OK : sp_fail_memory(err, (two + one) * sizeof(sp_quad));
    }
    op->two_springs = sp_alloc(two, sizeof *op->two_springs);
    op->one_springs = sp_alloc(one, sizeof *op->one_springs);
    if (!op->two_springs || !op->one_springs)
        return sp_fail_memory(err, (two + one) * sizeof(sp_spring));
    return d->net->carried ? allocate_carried(op, two, one, err) : SP_OK;
}

/* Fills the last quad of each chunk with springs of zero stiffness. */
static void fill_up(const sp_operator *op) {
    for (int32_t c = 0; c < op->chunk[op->blocks]; c++)
        for (int k = 0; k < 4; k++) {
            if (op->two[c + 1] > op->two[c]) {
                sp_quad *last = &op->two_quads[op->two[c + 1] - 1];
                last->i[k] = last->j[k] = op->chunk_row[c];
            }
            if (op->one[c + 1] > op->one[c]) {
                sp_quad *last = &op->one_quads[op->one[c + 1] - 1];
                last->i[k] = op->chunk_row[c];
                last->j[k] = op->n;
            }
        }
}

/* Stores spring s as seen from row i. j is the row at its other end, or n for a wall. */
static void put(const sp_operator *op, const sp_spring *s, const sp_carried *held, int32_t i, int32_t j, bool turned,
                bool both, int64_t at) {
    const double sign = turned ? -1 : 1;
    if (op->quad) {
        sp_quad *q = (both ? op->two_quads : op->one_quads) + at / 4;
        q->nx[at % 4] = sign * s->n[0];
        q->ny[at % 4] = sign * s->n[1];
        q->kn[at % 4] = s->kn;
        q->kt[at % 4] = s->kt;
        q->i[at % 4] = i;
        q->j[at % 4] = j;
        return;
    }
    sp_spring *t = (both ? op->two_springs : op->one_springs) + at;
    *t = *s;
    t->i = i;
    t->j = j;
    for (int a = 0; a < 3; a++)
        t->n[a] = sign * s->n[a];
    t->ri = turned ? s->rj : s->ri;
    t->rj = turned ? s->ri : s->rj;
    if (!held)
        return;
    sp_carried *h = (both ? op->two_carried : op->one_carried) + at;
    h->turn = held->turn;
    for (int a = 0; a < 3; a++) /* force on the i of the stored spring */
        h->ft[a] = sign * held->ft[a];
}

static void deal_springs(const sp_operator *op, dealing *d) {
    if (op->quad)
        fill_up(op);
    for (int32_t k = 0; k < d->net->n_springs; k++) {
        const sp_spring *s = &d->net->springs[k];
        const sp_carried *held = d->net->carried ? &d->net->carried[k] : NULL;
        const int32_t i = op->row_of[s->i], j = s->j < 0 ? op->n : op->row_of[s->j];
        if (j < op->n && d->block[i] == d->block[j]) {
            const bool turned = j < i;
            put(op, s, held, turned ? j : i, turned ? i : j, turned, true, d->two[turned ? j : i]++);
            continue;
        }
        put(op, s, held, i, j, false, false, d->one[i]++);
        if (j < op->n)
            put(op, s, held, j, i, true, false, d->one[j]++);
    }
}

static int32_t other_end(const sp_operator *op, int64_t k) {
    return op->quad ? op->one_quads[k / 4].j[k % 4] : op->one_springs[k].j;
}

/* Lists the neighbouring blocks of each block. With a NULL list they are only counted. */
static int32_t list_beside(const sp_operator *op, const dealing *d, int32_t *seen, int32_t *beside) {
    const int64_t unit = op->quad ? 4 : 1;
    int32_t count = 0;
    for (int32_t b = 0; b < op->blocks; b++)
        seen[b] = -1;
    for (int32_t b = 0; b < op->blocks; b++) {
        op->beside_first[b] = count;
        for (int64_t k = unit * op->one[op->chunk[b]]; k < unit * op->one[op->chunk[b + 1]]; k++) {
            const int32_t j = other_end(op, k);
            if (j == op->n || seen[d->block[j]] == b)
                continue;
            seen[d->block[j]] = b;
            if (beside)
                beside[count] = d->block[j];
            count++;
        }
    }
    op->beside_first[op->blocks] = count;
    return count;
}

static sp_status find_beside(sp_operator *op, const dealing *d, sp_error *err) {
    const size_t blocks = (size_t)op->blocks;
    int32_t *seen = sp_alloc(blocks, sizeof *seen);
    op->beside_first = sp_alloc(blocks + 1, sizeof *op->beside_first);
    if (seen && op->beside_first) {
        op->beside = sp_alloc((size_t)list_beside(op, d, seen, NULL), sizeof *op->beside);
        if (op->beside)
            list_beside(op, d, seen, op->beside);
    }
    sp_free(seen);
    return op->beside ? SP_OK : sp_fail_memory(err, 3 * blocks * sizeof *seen);
}

sp_status sp_operator_make(const sp_network *net, sp_operator *out, sp_error *err) {
    sp_operator op = {.dim = net->dim, .dof = net->dof, .prestress = net->prestress, .n = net->n};
    dealing d = {0};
    op.quad = fits_quads(net);
    op.wide = op.quad && sp_operator_wide();
    op.row = op.quad ? QUAD_ROW : 2 * net->dof;
    sp_status status = order_grains(net, &op, err);
    if (status == SP_OK)
        status = cut_chunks(&op, err);
    if (status == SP_OK)
        status = set_scale(net, &op, err);
    if (status == SP_OK)
        status = dealing_make(net, &op, &d, err);
    if (status == SP_OK)
        status = allocate_springs(&op, &d, err);
    if (status == SP_OK) {
        deal_springs(&op, &d);
        status = find_beside(&op, &d, err);
    }
    dealing_free(&d);
    if (status == SP_OK)
        *out = op;
    else
        sp_operator_free(&op);
    return status;
}
