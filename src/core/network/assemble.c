/* Assembles K as a sparse matrix. */
#include "base/base.h"
#include "network/rows.h"

#include <stdlib.h>

/* Neighbours of each grain g, ascending and each once: list[start[g] .. start[g+1]-1]. For the lower triangle only
 * those of higher index; for the whole matrix all of them and the grain itself. */
typedef struct neighbours {
    bool whole;
    int64_t *start;
    int32_t *list;
} neighbours;

static int by_index(const void *a, const void *b) {
    const int32_t x = *(const int32_t *)a, y = *(const int32_t *)b;
    return (x > y) - (x < y);
}

static sp_status find_neighbours(const sp_network *net, neighbours *nb, sp_error *err) {
    const size_t n = (size_t)net->n, most = nb->whole ? n + 2 * (size_t)net->n_bulk : (size_t)net->n_bulk;
    nb->start = sp_alloc(n + 2, sizeof *nb->start);
    nb->list = sp_alloc(most, sizeof *nb->list);
    if (!nb->start || !nb->list)
        return sp_fail_memory(err, (n + 2) * sizeof *nb->start + most * sizeof *nb->list);
    /* counts are stored two places ahead, so that filling moves start[g+1] to the end of row g */
    for (int32_t k = 0; k < net->n_bulk; k++) {
        const sp_spring *s = &net->springs[k];
        nb->start[(s->i < s->j ? s->i : s->j) + 2]++;
        nb->start[(s->i < s->j ? s->j : s->i) + 2] += nb->whole;
    }
    for (size_t g = 2; g < n + 2; g++)
        nb->start[g] += nb->start[g - 1] + nb->whole;
    for (int32_t k = 0; k < net->n_bulk; k++) {
        const sp_spring *s = &net->springs[k];
        const int32_t low = s->i < s->j ? s->i : s->j, high = s->i < s->j ? s->j : s->i;
        nb->list[nb->start[low + 1]++] = high;
        if (nb->whole)
            nb->list[nb->start[high + 1]++] = low;
    }
    for (int32_t g = 0; nb->whole && g < net->n; g++)
        nb->list[nb->start[g + 1]++] = g;
    int64_t kept = 0, begin = 0;
    for (size_t g = 0; g < n; g++) {
        const int64_t end = nb->start[g + 1], first = kept;
        qsort(nb->list + begin, (size_t)(end - begin), sizeof *nb->list, by_index);
        for (int64_t k = begin; k < end; k++)
            if (kept == first || nb->list[kept - 1] != nb->list[k])
                nb->list[kept++] = nb->list[k];
        begin = end;
        nb->start[g + 1] = kept;
    }
    return SP_OK;
}

/* Index of the first entry of grain g's rows in column b of grain h. In the lower triangle g > h, and the rows of h
 * itself begin with the diagonal at p. */
static int64_t block_start(const neighbours *nb, const sp_sparse *m, int dof, int32_t g, int64_t column) {
    const int64_t h = column / dof, b = column % dof;
    int64_t low = nb->start[h], high = nb->start[h + 1] - 1;
    while (low < high) {
        const int64_t middle = low + (high - low) / 2;
        if (nb->list[middle] < g)
            low = middle + 1;
        else
            high = middle;
    }
    return m->p[column] + (nb->whole ? 0 : dof - b) + (low - nb->start[h]) * dof;
}

static void make_pattern(const sp_network *net, const neighbours *nb, sp_sparse *m) {
    const int dof = net->dof;
    int64_t at = 0;
    for (int32_t h = 0; h < net->n; h++)
        for (int b = 0; b < dof; b++) {
            m->p[(int64_t)h * dof + b] = at;
            for (int a = b; a < dof && !nb->whole; a++)
                m->i[at++] = (int64_t)h * dof + a;
            for (int64_t k = nb->start[h]; k < nb->start[h + 1]; k++)
                for (int a = 0; a < dof; a++)
                    m->i[at++] = (int64_t)nb->list[k] * dof + a;
        }
    m->p[m->n] = at;
}

/* Entry (a, b) of the contribution of a spring's tangential force at rest, or of its symmetric part. */
static double added(const sp_turns *t, bool whole, int a, int b) {
    double sum = 0;
    for (int q = 0; q < t->count; q++)
        sum += whole ? t->left[q][a] * t->right[q][b]
                     : 0.5 * (t->left[q][a] * t->right[q][b] + t->right[q][a] * t->left[q][b]);
    return sum;
}

/* Adds B^T diag(k) B of a spring, and the contribution of its tangential force at rest. */
static void add_spring(const sp_network *net, const neighbours *nb, int32_t k, sp_sparse *m) {
    const sp_spring *s = &net->springs[k];
    const int dof = net->dof;
    const int32_t grain[2] = {s->i, s->j};
    sp_rows rows;
    sp_turns turns;
    sp_network_rows(net, s, &rows);
    sp_network_turns(net, k, &turns);
    for (int a = 0; a < rows.width; a++)
        for (int b = 0; b < rows.width; b++) {
            const int32_t g = grain[a / dof], h = grain[b / dof];
            const int64_t column = (int64_t)h * dof + b % dof;
            if (!nb->whole && (g < h || (g == h && a < b)))
                continue;
            double sum = 0;
            for (int q = 0; q < rows.count; q++)
                sum += rows.k[q] * (rows.b[q][a] * rows.b[q][b]);
            sum += added(&turns, nb->whole, a, b);
            m->x[g == h && !nb->whole ? m->p[column] + a - b : block_start(nb, m, dof, g, column) + a % dof] += sum;
        }
}

static sp_status assemble(const sp_network *net, bool whole, sp_sparse *out, sp_error *err) {
    sp_sparse m = {.n = sp_network_dofs(net)};
    neighbours nb = {whole, NULL, NULL};
    sp_status status = find_neighbours(net, &nb, err);
    if (status != SP_OK)
        goto out;
    const int64_t dof = net->dof, own = whole ? 0 : net->n * dof * (dof + 1) / 2;
    const int64_t entries = own + nb.start[net->n] * dof * dof;
    m.p = sp_alloc((size_t)m.n + 1, sizeof *m.p);
    m.i = sp_alloc((size_t)entries, sizeof *m.i);
    m.x = sp_alloc((size_t)entries, sizeof *m.x);
    if (!m.p || !m.i || !m.x) {
        status = sp_fail_memory(err, (size_t)entries * 16 + (size_t)m.n * 8);
        goto out;
    }
    make_pattern(net, &nb, &m);
    for (int32_t k = 0; k < net->n_springs; k++)
        add_spring(net, &nb, k, &m);
out:
    sp_free(nb.start);
    sp_free(nb.list);
    if (status == SP_OK)
        *out = m;
    else
        sp_sparse_free(&m);
    return status;
}

sp_status sp_network_assemble(const sp_network *net, sp_sparse *out, sp_error *err) {
    return assemble(net, false, out, err);
}

sp_status sp_network_assemble_whole(const sp_network *net, sp_sparse *out, sp_error *err) {
    return assemble(net, true, out, err);
}
