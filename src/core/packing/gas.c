/* The initial gas: each grain is put at random positions until it overlaps no other (random sequential addition). */
#include "base/base.h"
#include "numeric/random.h"
#include "packing/prepare.h"

#include <math.h>
#include <string.h>

static const double PI = 3.14159265358979323846;

enum { MOST_TRIES = 1000000, MOST_ATTEMPTS = 10, MOST_LEVELS = 64 };

/* Grains within a factor of two in size, with cells at least as wide as the largest of them. Levels with larger grains
 * are filled first, because small grains would leave no space for large ones. */
typedef struct gas_level {
    int32_t grains;
    double r_max;
    int n[3]; /* cells along each axis */
    double width[3];
    int32_t *head; /* first grain of each cell; -1: none */
} gas_level;

typedef struct gas {
    int dim, up, levels;
    double box[3];
    const double *r;
    double *x;
    int32_t *next;  /* next grain of the same level in the cell; -1: none */
    int32_t *order; /* [n] by level, and by index within each */
    uint8_t *level_of;
    gas_level level[MOST_LEVELS];
} gas;

static int cell_along(const gas_level *level, int axis, double x) {
    const int cell = (int)(x / level->width[axis]);
    return cell < level->n[axis] ? cell : level->n[axis] - 1; /* x / width may round up to n */
}

/* Squared distance with periodic boundaries. */
static inline double distance2(const gas *g, const int dim, const double *a, const double *b) {
    double sum = 0;
    for (int k = 0; k < dim; k++) {
        double d = a[k] - b[k];
        if (k < dim - 1)
            d -= g->box[k] * nearbyint(d / g->box[k]);
        sum += d * d;
    }
    return sum;
}

static inline bool overlaps_in_cell(const gas *g, const int dim, int32_t i, int32_t j) {
    for (; j >= 0; j = g->next[j]) {
        const double reach = g->r[i] + g->r[j];
        if (distance2(g, dim, g->x + 3 * (size_t)i, g->x + 3 * (size_t)j) < reach * reach)
            return true;
    }
    return false;
}

static inline bool overlaps_level(const gas *g, const int dim, const gas_level *level, int32_t i) {
    int low[3] = {0}, high[3] = {0};
    for (int k = 0; k < dim; k++) {
        const int cell = cell_along(level, k, g->x[3 * (size_t)i + (size_t)k]), n = level->n[k];
        const bool periodic = k < dim - 1;
        low[k] = periodic || cell > 0 ? cell - 1 : 0;
        high[k] = periodic || cell + 1 < n ? cell + 1 : n - 1;
        if (periodic && n < 3) {
            low[k] = 0;
            high[k] = n - 1;
        }
    }
    for (int c = low[2]; c <= high[2]; c++)
        for (int b = low[1]; b <= high[1]; b++)
            for (int a = low[0]; a <= high[0]; a++) {
                const int *n = level->n;
                const size_t ca = (size_t)((a + n[0]) % n[0]), cb = (size_t)((b + n[1]) % n[1]), cc = (size_t)c;
                if (overlaps_in_cell(g, dim, i, level->head[(cc * (size_t)n[1] + cb) * (size_t)n[0] + ca]))
                    return true;
            }
    return false;
}

static inline bool overlaps(const gas *g, const int dim, int last, int32_t i) {
    for (int l = 0; l <= last; l++)
        if (g->level[l].grains > 0 && overlaps_level(g, dim, &g->level[l], i))
            return true;
    return false;
}

static void enter(gas *g, gas_level *level, int32_t i) {
    size_t cell = 0;
    for (int k = g->dim - 1; k >= 0; k--)
        cell = cell * (size_t)level->n[k] + (size_t)cell_along(level, k, g->x[3 * (size_t)i + (size_t)k]);
    g->next[i] = level->head[cell];
    level->head[cell] = i;
}

/* Assigns the grains to levels and finds the order of placing. */
static void sort_levels(gas *g, int32_t n, double r_max) {
    int32_t at[MOST_LEVELS + 1] = {0};
    for (int32_t i = 0; i < n; i++) {
        int l = 0;
        for (double limit = 0.5 * r_max; g->r[i] < limit && l < MOST_LEVELS - 1; limit *= 0.5)
            l++;
        g->level_of[i] = (uint8_t)l;
        g->level[l].grains++;
        g->level[l].r_max = fmax(g->level[l].r_max, g->r[i]);
        g->levels = l + 1 > g->levels ? l + 1 : g->levels;
    }
    for (int l = 0; l < g->levels; l++)
        at[l + 1] = at[l] + g->level[l].grains;
    for (int32_t i = 0; i < n; i++)
        g->order[at[g->level_of[i]]++] = i;
}

/* At most as many cells as grains, however small these are. */
static sp_status make_cells(gas *g, gas_level *level, sp_error *err) {
    double volume = 1;
    for (int k = 0; k < g->dim; k++)
        volume *= g->box[k];
    const double side = fmax(2 * level->r_max, pow(volume / level->grains, 1.0 / g->dim));
    size_t cells = 1;
    for (int k = 0; k < 3; k++) {
        level->n[k] = k < g->dim ? (int)fmax(1, floor(g->box[k] / side)) : 1;
        level->width[k] = k < g->dim ? g->box[k] / level->n[k] : 1;
        cells *= (size_t)level->n[k];
    }
    level->head = sp_alloc(cells, sizeof *level->head);
    if (!level->head)
        return sp_fail_memory(err, cells * sizeof *level->head);
    memset(level->head, 0xff, cells * sizeof *level->head);
    return SP_OK;
}

static sp_status place(gas *g, const sp_pack_spec *spec, sp_random *stream, int32_t i, sp_error *err) {
    const int l = g->level_of[i];
    double *x = g->x + 3 * (size_t)i;
    int tries = 0;
    bool taken;
    do {
        if (++tries > MOST_TRIES)
            return sp_fail(err, SP_EFAILED,
                           "packing.gas_fraction = %g: must be less, there is no room for grain %d of the starting gas",
                           spec->gas_fraction, i);
        for (int k = 0; k < g->dim; k++) {
            const double u = sp_random_uniform(stream);
            x[k] = k < g->up ? g->box[k] * u : g->r[i] + (g->box[k] - 2 * g->r[i]) * u;
        }
        taken = g->dim == 2 ? overlaps(g, 2, l, i) : overlaps(g, 3, l, i);
    } while (taken);
    enter(g, &g->level[l], i);
    return SP_OK;
}

static double gas_height(const sp_pack_spec *spec, const double *r, double r_max) {
    const bool flat = spec->dim == 2;
    double volume = 0;
    for (int32_t i = 0; i < spec->grains; i++)
        volume += flat ? PI * r[i] * r[i] : 4.0 / 3.0 * PI * r[i] * r[i] * r[i];
    const double floor_area = flat ? spec->width : spec->width * spec->depth;
    return fmax(volume / (spec->gas_fraction * floor_area),
                4 * r_max); /* at least enough for the largest grain if there are few */
}

double sp_gas_memory(const sp_pack_spec *spec) {
    return (double)spec->grains * (3 * sizeof(int32_t) + sizeof(uint8_t)) + MOST_LEVELS * sizeof(gas_level);
}

/* Places all grains. */
static sp_status fill(gas *g, const sp_pack_spec *spec, sp_random *stream, sp_error *err) {
    sp_status status = SP_OK;
    for (int l = 0; l < g->levels && status == SP_OK; l++)
        if (g->level[l].grains > 0)
            status = make_cells(g, &g->level[l], err);
    for (int32_t k = 0; k < spec->grains && status == SP_OK; k++)
        status = place(g, spec, stream, g->order[k], err);
    for (int l = 0; l < g->levels; l++) {
        sp_free(g->level[l].head);
        g->level[l].head = NULL;
    }
    return status;
}

sp_status sp_gas_make(const sp_pack_spec *spec, const double *r, double *x, double *height, sp_error *err) {
    const size_t n = (size_t)spec->grains;
    double r_max = 0;
    for (size_t i = 0; i < n; i++)
        r_max = fmax(r_max, r[i]);
    double h = gas_height(spec, r, r_max);
    gas g = {.dim = spec->dim, .up = spec->dim - 1, .box = {spec->width, spec->depth, 1}, .r = r, .x = x};
    g.next = sp_alloc(n, sizeof *g.next);
    g.order = sp_alloc(n, sizeof *g.order);
    g.level_of = sp_alloc(n, sizeof *g.level_of);
    sp_status status = SP_EFAILED;
    if (!g.next || !g.order || !g.level_of) {
        status = sp_fail_memory(err, n * 9);
        goto out;
    }
    sort_levels(&g, spec->grains, r_max);
    sp_random stream = sp_random_make(spec->seed, SP_STREAM_GAS);
    /* walls exclude some volume, so a few layers of a thin gas may need a higher box */
    const int attempts = spec->gas_fraction <= (spec->dim == 2 ? 0.45 : 0.3) ? MOST_ATTEMPTS : 1;
    for (int attempt = 0; attempt < attempts && status == SP_EFAILED; attempt++) {
        h *= attempt > 0 ? 1.1 : 1;
        g.box[g.up] = h;
        status = fill(&g, spec, &stream, err);
    }
    if (status == SP_OK)
        *height = h;
out:
    sp_free(g.level_of);
    sp_free(g.order);
    sp_free(g.next);
    return status;
}
