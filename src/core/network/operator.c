/* Builds the compact form of K: order of the grains, blocks, and springs. */
#include "network/operator.h"
#include "base/base.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

/* Networks of up to ONE_BLOCK grains are one block. Larger ones are divided into roughly square blocks of about BLOCK
 * grains. Their vectors fit into the second-level cache, and about 7% of their springs lead to other blocks. */
enum { ONE_BLOCK = 2048, BLOCK = 1024, CHUNK = 128, QUAD_ROW = 8 };

static void spring_set_free(sp_spring_set *s) {
    sp_free(s->first);
    sp_free(s->quads);
    sp_free(s->springs);
    sp_free(s->carried);
}

void sp_operator_free(sp_operator *op) {
    sp_free(op->row_of);
    sp_free(op->grain);
    sp_free(op->scale);
    sp_free(op->first);
    sp_free(op->chunk);
    sp_free(op->chunk_row);
    spring_set_free(&op->inner);
    spring_set_free(&op->border);
    sp_free(op->adjacent_first);
    sp_free(op->adjacent);
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
typedef struct assignment {
    const sp_network *net;
    int32_t *block;          /* [n] block of a row */
    int64_t *inner, *border; /* [n] springs of each row: first their number, then the place of the next one */
} assignment;

static void assignment_free(assignment *d) {
    sp_free(d->block);
    sp_free(d->inner);
    sp_free(d->border);
}

static sp_status assignment_make(const sp_network *net, sp_operator *op, assignment *d, sp_error *err) {
    const size_t n = (size_t)net->n;
    *d = (assignment){.net = net};
    op->row_of = sp_alloc(n, sizeof *op->row_of);
    d->block = sp_alloc(n, sizeof *d->block);
    d->inner = sp_alloc(n, sizeof *d->inner);
    d->border = sp_alloc(n, sizeof *d->border);
    if (!op->row_of || !d->block || !d->inner || !d->border)
        return sp_fail_memory(err, n * 24);
    for (int32_t b = 0; b < op->blocks; b++)
        for (int32_t k = op->first[b]; k < op->first[b + 1]; k++) {
            op->row_of[op->grain[k]] = k;
            d->block[k] = b;
        }
    for (int32_t k = 0; k < net->n_springs; k++) {
        const int32_t i = op->row_of[net->springs[k].i], j = net->springs[k].j < 0 ? -1 : op->row_of[net->springs[k].j];
        if (j >= 0 && d->block[i] == d->block[j]) {
            d->inner[i < j ? i : j]++;
            continue;
        }
        d->border[i]++;
        if (j >= 0)
            d->border[j]++;
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

/* Allocates a set and sets its `first`. rows: numbers of springs of the rows, which become places. */
static sp_status allocate_springs(const sp_operator *op, bool carried, int64_t *rows, sp_spring_set *out,
                                  sp_error *err) {
    const size_t chunks = (size_t)op->chunk[op->blocks];
    out->first = sp_alloc(chunks + 1, sizeof *out->first);
    if (!out->first)
        return sp_fail_memory(err, (chunks + 1) * sizeof *out->first);
    number_springs(op, op->quad ? 4 : 1, rows, out->first);
    const size_t n = (size_t)out->first[chunks];
    out->quads = op->quad ? sp_alloc(n, sizeof *out->quads) : NULL;
    out->springs = op->quad ? NULL : sp_alloc(n, sizeof *out->springs);
    out->carried = carried ? sp_alloc(n, sizeof *out->carried) : NULL;
    const bool ok = (out->quads || out->springs) && (out->carried || !carried);
    return ok ? SP_OK : sp_fail_memory(err, n * (sizeof(sp_spring) + sizeof(sp_carried)));
}

/* Fills the last quad of each chunk with springs of zero stiffness, which end at row j or, if j < 0, in the chunk. */
static void fill_up(const sp_operator *op, const sp_spring_set *s, int32_t j) {
    for (int32_t c = 0; c < op->chunk[op->blocks]; c++)
        for (int k = 0; k < 4 && s->first[c + 1] > s->first[c]; k++) {
            sp_quad *last = &s->quads[s->first[c + 1] - 1];
            last->i[k] = op->chunk_row[c];
            last->j[k] = j < 0 ? op->chunk_row[c] : j;
        }
}

/* Stores spring s as seen from row i. j is the row at its other end, or n for a wall. */
static void put(const sp_spring_set *set, const sp_spring *s, const sp_carried *held, int32_t i, int32_t j, bool turned,
                int64_t at) {
    const double sign = turned ? -1 : 1;
    if (set->quads) {
        sp_quad *q = &set->quads[at / 4];
        q->nx[at % 4] = sign * s->n[0];
        q->ny[at % 4] = sign * s->n[1];
        q->kn[at % 4] = s->kn;
        q->kt[at % 4] = s->kt;
        q->i[at % 4] = i;
        q->j[at % 4] = j;
        return;
    }
    sp_spring *t = &set->springs[at];
    *t = *s;
    t->i = i;
    t->j = j;
    for (int a = 0; a < 3; a++)
        t->n[a] = sign * s->n[a];
    t->ri = turned ? s->rj : s->ri;
    t->rj = turned ? s->ri : s->rj;
    if (!held)
        return;
    sp_carried *h = &set->carried[at];
    h->turn = held->turn;
    for (int a = 0; a < 3; a++) /* force on the i of the stored spring */
        h->ft[a] = sign * held->ft[a];
}

static void assign_springs(const sp_operator *op, assignment *d) {
    if (op->quad) {
        fill_up(op, &op->inner, -1);
        fill_up(op, &op->border, op->n);
    }
    for (int32_t k = 0; k < d->net->n_springs; k++) {
        const sp_spring *s = &d->net->springs[k];
        const sp_carried *held = d->net->carried ? &d->net->carried[k] : NULL;
        const int32_t i = op->row_of[s->i], j = s->j < 0 ? op->n : op->row_of[s->j];
        if (j < op->n && d->block[i] == d->block[j]) {
            const bool turned = j < i;
            put(&op->inner, s, held, turned ? j : i, turned ? i : j, turned, d->inner[turned ? j : i]++);
            continue;
        }
        put(&op->border, s, held, i, j, false, d->border[i]++);
        if (j < op->n)
            put(&op->border, s, held, j, i, true, d->border[j]++);
    }
}

static int32_t other_end(const sp_operator *op, int64_t k) {
    return op->quad ? op->border.quads[k / 4].j[k % 4] : op->border.springs[k].j;
}

/* Lists the neighbouring blocks of each block. With a NULL list they are only counted. */
static int32_t list_adjacent(const sp_operator *op, const assignment *d, int32_t *seen, int32_t *adjacent) {
    const int64_t unit = op->quad ? 4 : 1;
    int32_t count = 0;
    for (int32_t b = 0; b < op->blocks; b++)
        seen[b] = -1;
    for (int32_t b = 0; b < op->blocks; b++) {
        op->adjacent_first[b] = count;
        for (int64_t k = unit * op->border.first[op->chunk[b]]; k < unit * op->border.first[op->chunk[b + 1]]; k++) {
            const int32_t j = other_end(op, k);
            if (j == op->n || seen[d->block[j]] == b)
                continue;
            seen[d->block[j]] = b;
            if (adjacent)
                adjacent[count] = d->block[j];
            count++;
        }
    }
    op->adjacent_first[op->blocks] = count;
    return count;
}

static sp_status find_adjacent(sp_operator *op, const assignment *d, sp_error *err) {
    const size_t blocks = (size_t)op->blocks;
    int32_t *seen = sp_alloc(blocks, sizeof *seen);
    op->adjacent_first = sp_alloc(blocks + 1, sizeof *op->adjacent_first);
    if (seen && op->adjacent_first) {
        op->adjacent = sp_alloc((size_t)list_adjacent(op, d, seen, NULL), sizeof *op->adjacent);
        if (op->adjacent)
            list_adjacent(op, d, seen, op->adjacent);
    }
    sp_free(seen);
    return op->adjacent ? SP_OK : sp_fail_memory(err, 3 * blocks * sizeof *seen);
}

sp_status sp_operator_make(const sp_network *net, sp_operator *out, sp_error *err) {
    sp_operator op = {.dim = net->dim, .dof = net->dof, .prestress = net->prestress, .n = net->n};
    assignment d = {0};
    op.quad = fits_quads(net);
    op.wide = op.quad && sp_operator_wide();
    op.row = op.quad ? QUAD_ROW : 2 * net->dof;
    sp_status status = order_grains(net, &op, err);
    if (status == SP_OK)
        status = cut_chunks(&op, err);
    if (status == SP_OK)
        status = set_scale(net, &op, err);
    if (status == SP_OK)
        status = assignment_make(net, &op, &d, err);
    if (status == SP_OK)
        status = allocate_springs(&op, net->carried != NULL, d.inner, &op.inner, err);
    if (status == SP_OK)
        status = allocate_springs(&op, net->carried != NULL, d.border, &op.border, err);
    if (status == SP_OK) {
        assign_springs(&op, &d);
        status = find_adjacent(&op, &d, err);
    }
    assignment_free(&d);
    if (status == SP_OK)
        *out = op;
    else
        sp_operator_free(&op);
    return status;
}
