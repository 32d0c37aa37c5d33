/* Cells that find the grains near a point. */
#include "packing/cell_grid.h"

#include "base/base.h"

#include <math.h>

sp_status sp_cells_make(int dim, int32_t n, double r_max, cells *out, sp_error *err) {
    *out = (cells){.dim = dim, .r_max = r_max, .box = {1, 1, 1}, .periodic = {dim > 1, dim > 2, false}};
    out->next = sp_alloc((size_t)n, sizeof *out->next);
    out->at = sp_alloc((size_t)n, sizeof *out->at);
    out->sorted = sp_alloc((size_t)n, sizeof *out->sorted);
    if (out->next && out->at && out->sorted)
        return SP_OK;
    sp_cells_free(out);
    return sp_fail_memory(err, (size_t)n * (sizeof *out->next + sizeof *out->at + sizeof *out->sorted));
}

void sp_cells_free(cells *c) {
    sp_free(c->head);
    sp_free(c->next);
    sp_free(c->at);
    sp_free(c->sorted);
    sp_free(c->start);
    *c = (cells){0};
}

int sp_cells_octave(const cells *c, double r) {
    int octave = 0;
    for (double limit = 0.5 * c->r_max; r < limit && octave < SP_OCTAVES - 1; limit *= 0.5)
        octave++;
    return octave;
}

static cell_grid make_grid(const cells *c, double range, int64_t grains) {
    cell_grid grid = {.n = {1, 1, 1}, .width = {1, 1, 1}, .used = grains > 0};
    int64_t count = 1;
    for (int a = 0; a < c->dim; a++) {
        const double most = fmin(floor(c->box[a] / range), 1e6);
        grid.n[a] = most > 1 ? (int64_t)most : 1;
        count *= grid.n[a];
    }
    while (count > 8 * grains + 64) { /* thin gas: no need for many more cells than grains */
        int64_t *longest = &grid.n[0];
        for (int a = 1; a < c->dim; a++)
            longest = grid.n[a] > *longest ? &grid.n[a] : longest;
        count = count / *longest * ((*longest + 1) / 2);
        *longest = (*longest + 1) / 2;
    }
    for (int a = 0; a < c->dim; a++)
        grid.width[a] = c->box[a] / (double)grid.n[a];
    return grid;
}

sp_status sp_cells_reset(cells *c, const int64_t population[SP_OCTAVES], double gap, sp_error *err) {
    int64_t count = 0;
    for (int o = 0; o < SP_OCTAVES; o++) {
        c->grid[o] = make_grid(c, 2 * ldexp(c->r_max, -o) + gap, population[o]);
        c->grid[o].first = count;
        count += c->grid[o].used ? c->grid[o].n[0] * c->grid[o].n[1] * c->grid[o].n[2] : 0;
    }
    c->count = count;
    if (count > c->capacity) {
        sp_free(c->head);
        sp_free(c->start);
        c->head = sp_alloc((size_t)count, sizeof *c->head);
        c->start = sp_alloc((size_t)count + 1, sizeof *c->start);
        c->capacity = c->head && c->start ? count : 0;
        if (!c->capacity)
            return sp_fail_memory(err, (size_t)count * (sizeof *c->head + sizeof *c->start));
    }
    for (int64_t k = 0; k < count; k++)
        c->head[k] = -1;
    return SP_OK;
}

/* Positions may be wild or not finite after a motion has blown up. Any cell will do: sp_dynamics_sane detects this
 * later. */
static int64_t place_of(const cell_grid *grid, int a, double x) {
    const double place = floor(x / grid->width[a]);
    return place >= (double)grid->n[a] ? grid->n[a] - 1 : place > 0 ? (int64_t)place : 0;
}

static int64_t cell_of(const cells *c, int octave, const double *x) {
    const cell_grid *grid = &c->grid[octave];
    int64_t cell = 0;
    for (int a = c->dim - 1; a >= 0; a--)
        cell = cell * grid->n[a] + place_of(grid, a, x[a]);
    return grid->first + cell;
}

static void enter(cells *c, int32_t i, int64_t cell) {
    c->next[i] = c->head[cell];
    c->head[cell] = i;
}

void sp_cells_enter(cells *c, int octave, int32_t i, const double *x) { enter(c, i, cell_of(c, octave, x)); }

void sp_cells_locate(cells *c, int octave, int32_t i, const double *x) { c->at[i] = cell_of(c, octave, x); }

void sp_cells_enter_located(cells *c, int32_t n, int64_t first, int64_t last) {
    int32_t place = 0;
    for (int32_t i = n - 1; i >= 0; i--) {
        place += c->at[i] < first;
        if (c->at[i] >= first && c->at[i] < last)
            enter(c, i, c->at[i]);
    }
    for (int64_t cell = first; cell < last; cell++) {
        c->start[cell] = place;
        for (int32_t i = c->head[cell]; i >= 0; i = c->next[i])
            c->sorted[place++] = i;
    }
    if (last == c->count)
        c->start[last] = place;
}

int sp_cells_near(const cells *c, int octave, const double *x, int64_t cell[SP_CELLS_NEAR]) {
    const cell_grid *grid = &c->grid[octave];
    int64_t near[3][3] = {{0}}, count[3] = {1, 1, 1};
    int found = 0;
    for (int a = 0; a < c->dim; a++) {
        const int64_t n = grid->n[a], place = place_of(grid, a, x[a]);
        const bool periodic = c->periodic[a];
        int64_t next = place > 0 ? place - 1 : periodic ? n - 1 : 0;
        count[a] = !periodic ? (place + 1 < n ? place + 1 : n - 1) - next + 1 : n < 3 ? n : 3;
        for (int64_t k = 0; k < count[a]; k++, next = next + 1 < n ? next + 1 : 0)
            near[a][k] = next;
    }
    for (int64_t p = 0; p < count[2]; p++)
        for (int64_t q = 0; q < count[1]; q++)
            for (int64_t r = 0; r < count[0]; r++)
                cell[found++] = grid->first + (near[2][p] * grid->n[1] + near[1][q]) * grid->n[0] + near[0][r];
    return found;
}
