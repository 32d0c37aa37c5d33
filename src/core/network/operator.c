/* Builds the compact form of K: order of the grains, blocks, and springs. */
#include "network/operator.h"
#include "base/base.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

/* Networks of up to ONE_BLOCK grains are one block. Larger ones are divided into roughly square blocks of about BLOCK
 * grains. Their vectors fit into the second-level cache, and about 7% of their springs lead to other blocks. */
enum { ONE_BLOCK = 2048, BLOCK = 1024, CHUNK = 128 };

static void spring_set_free(sp_spring_set *s) {
    sp_free(s->first);
    sp_free(s->quads);
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

/* Rotations are measured as displacements of the surface, and a grain has one mass and one moment of inertia. Networks
 * of packings are like that. */
static bool fits(const sp_network *net) {
    for (int64_t k = 0; k < sp_network_dofs(net); k++) {
        const int64_t a = k % net->dof, same = a < net->dim ? a : a - net->dim;
        if (net->mass[k] != net->mass[k - same] || !(net->r[k / net->dof] > 0))
            return false;
    }
    for (int32_t k = 0; k < net->n_springs && net->dof > net->dim; k++) {
        const sp_spring *s = &net->springs[k];
        if (s->ri != net->r[s->i] || (s->j >= 0 && s->rj != net->r[s->j]))
            return false;
    }
    return true;
}

int64_t sp_operator_at(const sp_operator *op, int64_t dof) {
    return op->row_of[dof / op->dof] * (int64_t)op->row + quad_component((int)(dof % op->dof));
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
            op->scale[k * dof + a] = a >= net->dim ? net->r[op->grain[k]] : 1;
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

/* Replaces the numbers of springs of rows by places in the list. Each chunk begins with a quad of its own; first[]
 * has the first quads of the chunks. */
static void number_springs(const sp_operator *op, int64_t *rows, int64_t *first) {
    const int32_t chunks = op->chunk[op->blocks];
    int64_t at = 0;
    for (int32_t c = 0; c < chunks; c++) {
        first[c] = at / 4;
        for (int32_t k = op->chunk_row[c]; k < op->chunk_row[c + 1]; k++) {
            const int64_t count = rows[k];
            rows[k] = at;
            at += count;
        }
        at = (at + 3) / 4 * 4;
    }
    first[chunks] = at / 4;
}

/* Allocates a set and sets its `first`. rows: numbers of springs of the rows, which become places. */
static sp_status allocate_springs(const sp_operator *op, int64_t *rows, sp_spring_set *out, sp_error *err) {
    const size_t chunks = (size_t)op->chunk[op->blocks], size = (size_t)quad_size(op->kind) * sizeof *out->quads;
    out->first = sp_alloc(chunks + 1, sizeof *out->first);
    if (!out->first)
        return sp_fail_memory(err, (chunks + 1) * sizeof *out->first);
    number_springs(op, rows, out->first);
    out->quads = sp_alloc((size_t)out->first[chunks], size);
    return out->quads ? SP_OK : sp_fail_memory(err, (size_t)out->first[chunks] * size);
}

static quad_rows *rows_of(const sp_operator *op, const sp_spring_set *set, int64_t quad) {
    return (quad_rows *)quad_rows_of(op->kind, set->quads + quad * quad_size(op->kind));
}

/* Fills the last quad of each chunk with springs of zero stiffness, which end at row j or, if j < 0, in the chunk. */
static void fill_up(const sp_operator *op, const sp_spring_set *s, int32_t j) {
    for (int32_t c = 0; c < op->chunk[op->blocks]; c++)
        for (int k = 0; k < 4 && s->first[c + 1] > s->first[c]; k++) {
            quad_rows *last = rows_of(op, s, s->first[c + 1] - 1);
            last[k] = op->chunk_row[c] * op->row;
            last[4 + k] = (j < 0 ? op->chunk_row[c] : j) * op->row;
        }
}

/* Stores what a force at rest adds to a spring, as seen from one of its ends. */
static void put_carried(quad_kind kind, const sp_spring *s, const sp_carried *held, bool turned, double *number) {
    const quad_fields f = quad_fields_of(kind);
    const double r[2] = {s->ri, s->rj};
    if (kind.dim == 2) {
        number[4 * f.tilt] = held->turn * (held->ft[1] * s->n[0] - held->ft[0] * s->n[1]);
        return;
    }
    for (int a = 0; a < 3; a++)
        number[4 * (f.ft + a)] = turned ? -held->ft[a] : held->ft[a];
    number[4 * f.over_r] = held->turn;
    for (int end = 0; end < 2; end++)
        number[4 * (f.inverse + end)] = r[end != turned] > 0 ? 0.5 / r[end != turned] : 0;
}

/* Stores spring s as seen from row i. j is the row at its other end, or n for a wall. */
static void put(const sp_operator *op, const sp_spring_set *set, const sp_spring *s, const sp_carried *held, int32_t i,
                int32_t j, bool turned, int64_t at) {
    const quad_fields f = quad_fields_of(op->kind);
    double *number = set->quads + at / 4 * quad_size(op->kind) + at % 4;
    quad_rows *rows = rows_of(op, set, at / 4) + at % 4;
    rows[0] = i * op->row;
    rows[4] = j * op->row;
    for (int a = 0; a < op->kind.dim && op->kind.dim > 1; a++)
        number[4 * (f.n + a)] = turned ? -s->n[a] : s->n[a];
    number[4 * f.kn] = op->kind.dim == 1 ? s->kn * s->n[0] * s->n[0] : s->kn;
    if (op->kind.rotations)
        number[4 * f.kt] = s->kt;
    if (op->kind.prestress)
        number[4 * f.kp] = s->kp;
    if (op->kind.carried)
        put_carried(op->kind, s, held, turned, number);
}

static void assign_springs(const sp_operator *op, assignment *d) {
    fill_up(op, &op->inner, -1);
    fill_up(op, &op->border, op->n);
    for (int32_t k = 0; k < d->net->n_springs; k++) {
        const sp_spring *s = &d->net->springs[k];
        const sp_carried *held = d->net->carried ? &d->net->carried[k] : NULL;
        const int32_t i = op->row_of[s->i], j = s->j < 0 ? op->n : op->row_of[s->j];
        if (j < op->n && d->block[i] == d->block[j]) {
            const bool turned = j < i;
            put(op, &op->inner, s, held, turned ? j : i, turned ? i : j, turned, d->inner[turned ? j : i]++);
            continue;
        }
        put(op, &op->border, s, held, i, j, false, d->border[i]++);
        if (j < op->n)
            put(op, &op->border, s, held, j, i, true, d->border[j]++);
    }
}

/* Lists the neighbouring blocks of each block. With a NULL list they are only counted. */
static int32_t list_adjacent(const sp_operator *op, const assignment *d, int32_t *seen, int32_t *adjacent) {
    int32_t count = 0;
    for (int32_t b = 0; b < op->blocks; b++)
        seen[b] = -1;
    for (int32_t b = 0; b < op->blocks; b++) {
        op->adjacent_first[b] = count;
        for (int64_t k = 4 * op->border.first[op->chunk[b]]; k < 4 * op->border.first[op->chunk[b + 1]]; k++) {
            const int32_t j = rows_of(op, &op->border, k / 4)[4 + k % 4] / op->row;
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
    sp_operator op = {
        .kind = {net->dim, net->dof - net->dim, net->prestress || net->carried, net->carried != NULL, false},
        .dof = net->dof,
        .wide = net->dim > 1 && sp_operator_wide(),
        .row = quad_row(net->dof),
        .n = net->n};
    assignment d = {0};
    if (net->n >= INT32_MAX / op.row) /* quads have places in vectors as integers */
        return sp_fail(err, SP_EREFUSED, "%d grains, must be below %d", (int)net->n, INT32_MAX / op.row);
    if (!fits(net))
        return sp_fail(err, SP_EINVAL, "lever arms must be the radii, and masses of a grain the same along all axes");
    sp_status status = order_grains(net, &op, err);
    if (status == SP_OK)
        status = cut_chunks(&op, err);
    if (status == SP_OK)
        status = set_scale(net, &op, err);
    if (status == SP_OK)
        status = assignment_make(net, &op, &d, err);
    if (status == SP_OK)
        status = allocate_springs(&op, d.inner, &op.inner, err);
    if (status == SP_OK)
        status = allocate_springs(&op, d.border, &op.border, err);
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
