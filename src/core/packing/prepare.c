/* Size distributions of the grains, and the initial gas. */
#include "packing/prepare.h"

#include "base/base.h"
#include "numeric/random.h"
#include "packing/cell_grid.h"
#include "packing/types.h"

#include <math.h>

static const double PI = 3.14159265358979323846, LN2 = 0.69314718055994530942;
static const double FARTHEST = 8; /* in standard deviations from the median; beyond this, fewer than one draw in 1e14 */

/* exp and log for sizes. Those of the C library differ in their last bits between machines, which would give different
 * packings. These two use only operations that are rounded alike everywhere, and are accurate to about 1e-16. */
static double same_exp(double x) {
    const double k = nearbyint(x / LN2), rest = x - k * LN2;
    double sum = 1;
    for (int n = 18; n > 0; n--) /* |rest| < 0.35 */
        sum = 1 + rest / n * sum;
    return ldexp(sum, (int)k);
}

static double same_log(double x) {
    int k;
    double m = frexp(x, &k);
    if (m < 0.70710678118654752440) {
        m *= 2;
        k--;
    }
    const double t = (m - 1) / (m + 1); /* |t| < 0.172, ln m = 2 artanh t */
    double sum = 0;
    for (int n = 27; n > 0; n -= 2)
        sum = sum * t * t + 1.0 / n;
    return k * LN2 + 2 * t * sum;
}

/* ln of the median, for which the mean of the unrestricted distribution is the unit of length. */
static double log_median(const sp_pack_spec *s) { return -0.5 * s->size_spread * s->size_spread; }

void sp_sizes_limits(const sp_pack_spec *s, double *low, double *high) {
    *low = s->diameter_min;
    *high = s->diameter_max;
    if (s->sizes == SP_SIZES_LIST || s->sizes == SP_SIZES_TYPES) {
        const bool list = s->sizes == SP_SIZES_LIST;
        const double *all = list ? s->diameters : s->types.diameter;
        const int32_t count = !all   ? 0
                              : list ? (s->grains < s->diameter_count ? s->grains : s->diameter_count)
                                     : s->types.diameters;
        *low = INFINITY;
        *high = 0;
        for (int32_t i = 0; i < count; i++) {
            *low = fmin(*low, all[i]);
            *high = fmax(*high, all[i]);
        }
    } else if (*low == 0 && *high == 0) {
        const bool ordered = s->kind != SP_PACK_PISTON && s->kind != SP_PACK_MINIMUM;
        *low = ordered && s->sizes == SP_SIZES_UNIFORM ? 1.0 : 0.8;
        *high = ordered && s->sizes == SP_SIZES_UNIFORM ? 1.0 : 1.2;
        if (s->sizes == SP_SIZES_LOGNORMAL) {
            *low = same_exp(log_median(s) - 3 * s->size_spread);
            *high = same_exp(log_median(s) + 3 * s->size_spread);
        }
    }
}

/* Probability of a normal variable between a and b, computed from the nearer tail to keep its digits. */
static double normal_part(double a, double b) {
    return a > 0 ? 0.5 * (erfc(a * sqrt(0.5)) - erfc(b * sqrt(0.5)))
                 : 0.5 * (erfc(-b * sqrt(0.5)) - erfc(-a * sqrt(0.5)));
}

double sp_sizes_within(const sp_pack_spec *s) {
    const double m = log_median(s), w = s->size_spread;
    if (w == 0)
        return s->diameter_min <= 1 && s->diameter_max >= 1 ? 1 : 0;
    return normal_part((log(s->diameter_min) - m) / w, (log(s->diameter_max) - m) / w);
}

/* <d^k> of a lognormal distribution with limits: the normal distribution of ln d, shifted by k times the spread. */
static double lognormal_moment(const sp_pack_spec *s, int k) {
    const double m = log_median(s), w = s->size_spread;
    if (w == 0)
        return 1;
    if (s->diameter_min == s->diameter_max)
        return pow(s->diameter_max, k);
    const double a = (log(s->diameter_min) - m) / w, b = (log(s->diameter_max) - m) / w;
    return exp(k * m + 0.5 * k * k * w * w) * normal_part(a - k * w, b - k * w) / normal_part(a, b);
}

double sp_sizes_moment(const sp_pack_spec *s, int k) {
    const double a = s->diameter_min, b = s->diameter_max;
    double sum = 0;
    switch (s->sizes) {
    case SP_SIZES_UNIFORM: /* (b^(k+1) - a^(k+1)) / ((k+1) (b - a)), also for equal limits */
        for (int i = 0; i <= k; i++)
            sum += pow(a, i) * pow(b, k - i);
        return sum / (k + 1);
    case SP_SIZES_BIDISPERSE: return (1 - s->large_fraction) * pow(a, k) + s->large_fraction * pow(b, k);
    case SP_SIZES_LOGNORMAL: return lognormal_moment(s, k);
    case SP_SIZES_LIST:
        for (int32_t i = 0; i < s->grains && i < s->diameter_count; i++)
            sum += pow(s->diameters[i], k);
        return sum / s->grains;
    case SP_SIZES_TYPES:
        for (int t = 0; t < s->types.fractions && t < s->types.diameters; t++)
            sum += s->types.fraction[t] * pow(s->types.diameter[t], k);
        return sum;
    }
    return NAN;
}

double sp_sizes_mean_area(const sp_pack_spec *s) { return PI / 4 * sp_sizes_moment(s, 2); }
double sp_sizes_mean_volume(const sp_pack_spec *s) { return PI / 6 * sp_sizes_moment(s, 3); }

static void draw_uniform(const sp_pack_spec *s, sp_random *stream, double *r) {
    for (int32_t i = 0; i < s->grains; i++)
        r[i] = 0.5 * (s->diameter_min + (s->diameter_max - s->diameter_min) * sp_random_uniform(stream));
}

/* Gives the nearest whole number of grains to the large fraction, at random indices. */
static void draw_bidisperse(const sp_pack_spec *s, sp_random *stream, double *r) {
    uint64_t large = (uint64_t)floor(s->large_fraction * s->grains + 0.5);
    for (int32_t i = 0; i < s->grains; i++) {
        const bool one = sp_random_below(stream, (uint64_t)(s->grains - i)) < large;
        r[i] = 0.5 * (one ? s->diameter_max : s->diameter_min);
        large -= one;
    }
}

/* Rejection from the rectangle around the normal density between the limits, which is as fast in a tail as in the
 * middle. */
static void draw_lognormal(const sp_pack_spec *s, sp_random *stream, double *r) {
    const double m = log_median(s), w = s->size_spread, low = s->diameter_min, high = s->diameter_max;
    double a = 0, b = 0;
    if (w > 0 && low < high) {
        a = fmax(-FARTHEST, (same_log(low) - m) / w);
        b = fmin(FARTHEST, (same_log(high) - m) / w);
    }
    const double top = a > 0 ? a : b < 0 ? b : 0; /* position of the maximum */
    for (int32_t i = 0; i < s->grains; i++) {
        double z;
        do
            z = a + (b - a) * sp_random_uniform(stream);
        while (sp_random_uniform(stream) >= same_exp(0.5 * (top * top - z * z)));
        r[i] = 0.5 * fmin(fmax(same_exp(m + w * z), low), high);
    }
}

static void draw_types(const sp_pack_spec *s, double *r) {
    sp_type_draw draw = sp_types_begin(s);
    for (int32_t i = 0; i < s->grains; i++)
        r[i] = 0.5 * s->types.diameter[sp_types_next(&draw)];
}

bool sp_sizes_alike(const sp_pack_spec *spec) { return spec->diameter_max < 1.2 * spec->diameter_min; }

void sp_radii_draw(const sp_pack_spec *s, double *r) {
    sp_random stream = sp_random_make(s->seed, SP_STREAM_DIAMETERS);
    switch (s->sizes) {
    case SP_SIZES_UNIFORM: draw_uniform(s, &stream, r); break;
    case SP_SIZES_BIDISPERSE: draw_bidisperse(s, &stream, r); break;
    case SP_SIZES_LOGNORMAL: draw_lognormal(s, &stream, r); break;
    case SP_SIZES_LIST:
        for (int32_t i = 0; i < s->grains; i++)
            r[i] = 0.5 * s->diameters[i];
        break;
    case SP_SIZES_TYPES: draw_types(s, r); break;
    }
}

/* ---- the gas: random sequential addition ------------------------------------------------------------------------- */

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
