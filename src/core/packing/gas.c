/* The initial gas: each grain is put at random positions until it overlaps no other (random sequential addition). */
#include "base/base.h"
#include "numeric/random.h"
#include "packing/cells.h"
#include "packing/prepare.h"

#include <math.h>

static const double PI = 3.14159265358979323846;

enum { MOST_TRIES = 1000000, MOST_ATTEMPTS = 10 };

typedef struct gas {
    const sp_pack_spec *spec;
    const sp_pack_hooks *hooks; /* may be NULL */
    const double *r;
    double *x;
    cells cells;
    int32_t placed;
} gas;

/* Squared distance with periodic boundaries. */
static inline double distance2(const cells *c, const int dim, const double *a, const double *b) {
    double sum = 0;
    for (int k = 0; k < dim; k++) {
        double d = a[k] - b[k];
        if (c->periodic[k])
            d -= c->box[k] * nearbyint(d / c->box[k]);
        sum += d * d;
    }
    return sum;
}

/* Whether grain i overlaps a grain of the octave. Compiled for both dimensions. */
static inline bool overlaps_octave(const gas *g, const int dim, int octave, int32_t i) {
    const double *x = g->x + 3 * (size_t)i;
    int64_t cell[SP_CELLS_NEAR];
    const int count = sp_cells_near(&g->cells, octave, x, cell);
    for (int k = 0; k < count; k++)
        for (int32_t j = g->cells.head[cell[k]]; j >= 0; j = g->cells.next[j]) {
            const double reach = g->r[i] + g->r[j];
            if (distance2(&g->cells, dim, x, g->x + 3 * (size_t)j) < reach * reach)
                return true;
        }
    return false;
}

static bool overlaps(const gas *g, int octave, int32_t i) {
    for (int o = 0; o <= octave; o++)
        if (g->cells.grid[o].used && (g->cells.dim == 2 ? overlaps_octave(g, 2, o, i) : overlaps_octave(g, 3, o, i)))
            return true;
    return false;
}

static sp_status place(gas *g, sp_random *stream, int octave, int32_t i, sp_error *err) {
    const int up = g->cells.dim - 1;
    const double *box = g->cells.box;
    double *x = g->x + 3 * (size_t)i;
    int tries = 0;
    do {
        if (++tries > MOST_TRIES)
            return sp_fail(err, SP_EFAILED,
                           "packing.gas_fraction = %g: must be less, there is no room for grain %d of the starting gas",
                           g->spec->gas_fraction, i);
        for (int k = 0; k <= up; k++) {
            const double u = sp_random_uniform(stream);
            x[k] = g->cells.periodic[k] ? box[k] * u : g->r[i] + (box[k] - 2 * g->r[i]) * u;
        }
    } while (overlaps(g, octave, i));
    sp_cells_enter(&g->cells, octave, i, x);
    g->placed++;
    return SP_OK;
}

/* Every some thousand grains: millions take half a minute. */
static sp_status report(const gas *g, sp_error *err) {
    const sp_pack_hooks *hooks = g->hooks;
    if (!hooks || !hooks->watch || g->placed % 8192 != 0)
        return SP_OK;
    const sp_pack_progress progress = {.phase = "placing", .height = g->cells.box[g->cells.dim - 1]};
    if (hooks->watch(&progress, hooks->user))
        return SP_OK;
    return sp_fail(err, SP_EINTERRUPTED, "stopped after %d grains had been placed", g->placed);
}

/* Height at the gas fraction, but enough for the largest grain if there are few. */
static double gas_height(const sp_pack_spec *spec, const double *r, double r_max) {
    const bool flat = spec->dim == 2;
    double volume = 0;
    for (int32_t i = 0; i < spec->grains; i++)
        volume += flat ? PI * r[i] * r[i] : 4.0 / 3.0 * PI * r[i] * r[i] * r[i];
    const double floor_area = flat ? spec->width : spec->width * spec->depth;
    return fmax(volume / (spec->gas_fraction * floor_area), 4 * r_max);
}

/* Places all grains, larger octaves first, because small grains would leave no space for large ones. */
static sp_status fill(gas *g, sp_random *stream, sp_error *err) {
    const int32_t n = g->spec->grains;
    g->placed = 0;
    int64_t population[SP_OCTAVES] = {0};
    for (int32_t i = 0; i < n; i++)
        population[sp_cells_octave(&g->cells, g->r[i])]++;
    sp_status status = sp_cells_reset(&g->cells, population, 0, err);
    for (int o = 0; o < SP_OCTAVES; o++)
        for (int32_t i = 0; i < n && population[o] > 0 && status == SP_OK; i++)
            if (sp_cells_octave(&g->cells, g->r[i]) == o) {
                status = place(g, stream, o, i, err);
                if (status == SP_OK)
                    status = report(g, err);
            }
    return status;
}

sp_status sp_gas_make(const sp_pack_spec *spec, const double *r, double *x, double *height, sp_error *err) {
    return sp_gas_make_watched(spec, NULL, r, x, height, err);
}

sp_status sp_gas_make_watched(const sp_pack_spec *spec, const sp_pack_hooks *hooks, const double *r, double *x,
                              double *height, sp_error *err) {
    const int up = spec->dim - 1;
    double r_max = 0;
    for (int32_t i = 0; i < spec->grains; i++)
        r_max = fmax(r_max, r[i]);
    gas g = {.spec = spec, .hooks = hooks, .r = r, .x = x};
    sp_status status = sp_cells_make(spec->dim, spec->grains, r_max, &g.cells, err);
    if (status != SP_OK)
        return status;
    for (int a = 0; a < spec->dim && spec->cell != SP_CELL_PISTON; a++)
        g.cells.periodic[a] = spec->cell == SP_CELL_PERIODIC;
    double *box = g.cells.box;
    box[0] = spec->width;
    box[1] = spec->depth;
    box[up] = gas_height(spec, r, r_max);
    sp_random stream = sp_random_make(spec->seed, SP_STREAM_GAS);
    /* walls exclude some volume, so a few layers of a thin gas may need a higher box */
    const int attempts = spec->gas_fraction <= (spec->dim == 2 ? 0.45 : 0.3) ? MOST_ATTEMPTS : 1;
    status = fill(&g, &stream, err);
    for (int attempt = 1; attempt < attempts && status == SP_EFAILED; attempt++) {
        box[up] *= 1.1;
        status = fill(&g, &stream, err);
    }
    if (status == SP_OK)
        *height = box[up];
    sp_cells_free(&g.cells);
    return status;
}
