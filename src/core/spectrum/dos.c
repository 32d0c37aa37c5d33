/* Density of states, and participation ratios in bins of frequency. */
#include "base/base.h"
#include "base/pool.h"
#include "modes/count.h"
#include "modes/refine.h"
#include "numeric/random.h"
#include "spectrum/moments.h"

#include <float.h>
#include <math.h>
#include <sonopack/spectrum.h>
#include <string.h>

enum { EXACT_DOFS = 3000, VECTORS_MAX = 10000, BINS_MAX = 1000000, MOMENTS_MAX = 10000000, DRAWN = 200000 };

sp_dos_options sp_dos_options_default(void) { return (sp_dos_options){.bins = 100, .seed = 1, .threads = 1}; }

sp_dos sp_dos_none(void) { return (sp_dos){0}; }

void sp_dos_free(sp_dos *d) {
    sp_free(d->edge);
    sp_free(d->density);
    *d = sp_dos_none();
}

static sp_status check(const sp_dos_options *o, sp_error *err) {
    if (o->method != SP_DOS_AUTO && o->method != SP_DOS_EXACT && o->method != SP_DOS_KPM && o->method != SP_DOS_COUNT)
        return sp_fail(err, SP_EINVAL, "density of states: method %d, must be auto, exact, kpm or count",
                       (int)o->method);
    if (o->norm != SP_DOS_GRAIN && o->norm != SP_DOS_ONE && o->norm != SP_DOS_MODES)
        return sp_fail(err, SP_EINVAL, "density of states: norm %d, must be grain, one or modes", (int)o->norm);
    if (o->bins < 1 || o->bins > BINS_MAX)
        return sp_fail(err, SP_EINVAL, "bins = %d, must be 1 .. %d", o->bins, BINS_MAX);
    if (!(o->until >= 0 && isfinite(o->until)))
        return sp_fail(err, SP_EINVAL, "until = %g, must be a frequency, or 0 for the whole spectrum", o->until);
    if (!(o->resolution >= 0 && isfinite(o->resolution)))
        return sp_fail(err, SP_EINVAL, "resolution = %g, must be a width in omega, or 0 for that of a bin",
                       o->resolution);
    if (o->vectors < 0 || o->vectors % 2 != 0 || o->vectors > VECTORS_MAX)
        return sp_fail(err, SP_EINVAL, "vectors = %d, must be even, and 0 (automatic) .. %d", o->vectors, VECTORS_MAX);
    if (o->threads < 1)
        return sp_fail(err, SP_EINVAL, "threads = %d, must be 1 or more", o->threads);
    return SP_OK;
}

static sp_status allocate(const sp_network *net, const sp_dos_options *o, sp_dos *d, sp_error *err) {
    const size_t bins = (size_t)o->bins;
    d->bins = o->bins;
    d->modes = sp_network_dofs(net);
    d->omega_max = sp_network_omega_bound(net);
    if (!(d->omega_max > 0 && isfinite(d->omega_max)))
        return sp_fail(err, SP_EREFUSED, "bound of the spectrum = %g: there are no vibrations", d->omega_max);
    const double until = o->until > 0 ? o->until : d->omega_max;
    const double wanted = o->resolution > 0 ? o->resolution : until / o->bins;
    const double needed = 0.5 * 3.15 * d->omega_max / wanted + 2;
    if (!(needed < MOMENTS_MAX))
        return sp_fail(err, SP_EINVAL, "resolution = %g needs %.3g moments, must be at most %d", wanted, needed,
                       MOMENTS_MAX);
    d->moments = sp_moments_for_width(d->omega_max, wanted);
    d->resolution = sp_moments_width(d->omega_max, d->moments);
    d->edge = sp_alloc(bins + 1, sizeof *d->edge);
    double *all = sp_alloc(6 * bins, sizeof *all);
    d->density = all;
    if (!d->edge || !all)
        return sp_fail_memory(err, (7 * bins + 1) * sizeof *all);
    d->cumulative = all + bins;
    d->smooth = all + 2 * bins;
    d->density_error = all + 3 * bins;
    d->cumulative_error = all + 4 * bins;
    d->smooth_error = all + 5 * bins;
    for (size_t b = 0; b <= bins; b++)
        d->edge[b] = b < bins ? until * (double)b / (double)bins : until;
    return SP_OK;
}

static double middle(const sp_dos *d, int32_t b) { return 0.5 * (d->edge[b] + d->edge[b + 1]); }

/* ---- exact ------------------------------------------------------------------------------------------------------ */

/* Number of modes up to x, and number of those within their error of x. */
static void count_below(const sp_modes *m, double x, double *below, double *doubtful) {
    *below = *doubtful = 0;
    for (int64_t k = m->n_zero; k < m->n; k++) {
        *below += m->omega[k] <= x;
        *doubtful += fabs(m->omega[k] - x) <= m->error[k];
    }
}

/* Bound of the errors of the smooth density: those of the frequencies, |dT_k| <= k |dphi|, and rounding, which the
 * recurrences of T_k and of its sum amplify by k^2 at most, next to phi = 0 and pi. g: Jackson's factors. */
static void bound_smooth(const sp_modes *m, const double *g, sp_dos *d) {
    const double omega = d->omega_max, many = (double)(m->n - m->n_zero);
    double turns = 0, sum = 8 * many * DBL_EPSILON;
    for (int64_t k = m->n_zero; k < m->n; k++) {
        const double s = fmin(m->omega[k] / omega, 1);
        turns += 2 * m->error[k] / (omega * fmax(sqrt(1 - s * s), DBL_EPSILON));
    }
    for (int64_t k = 1; k < d->moments; k++)
        sum += 2 * g[k] * (double)k * (turns + 8 * (double)k * many * DBL_EPSILON);
    for (int32_t b = 0; b < d->bins; b++) {
        const double s = middle(d, b) / omega;
        d->smooth_error[b] = s < 1 ? 2 * sum / (M_PI * omega * sqrt(1 - s * s)) : 0;
    }
}

static sp_status smooth_exact(const sp_modes *m, sp_dos *d, sp_error *err) {
    const size_t n = (size_t)d->moments;
    double *mu = sp_alloc(n, sizeof *mu), *g = sp_alloc(n, sizeof *g);
    sp_status status = mu && g ? SP_OK : sp_fail_memory(err, 2 * n * sizeof *mu);
    if (status != SP_OK)
        goto out;
    sp_moments_jackson(d->moments, g);
    for (int64_t k = m->n_zero; k < m->n; k++) {
        const double s = m->omega[k] / d->omega_max, twice = 2 * (1 - 2 * s * s);
        double here = 1, before = 0.5 * twice;
        for (size_t j = 0; j < n; j++) {
            mu[j] += here;
            const double next = twice * here - before;
            before = here;
            here = next;
        }
    }
    for (int32_t b = 0; b < d->bins; b++)
        d->smooth[b] = sp_moments_density(d->omega_max, d->moments, g, mu, middle(d, b));
    bound_smooth(m, g, d);
out:
    sp_free(g);
    sp_free(mu);
    return status;
}

static sp_status exact(const sp_network *net, sp_dos *d, sp_error *err) {
    const sp_modes_options o = {.vectors = false};
    sp_modes m = sp_modes_none();
    sp_status status = sp_modes_dense(net, &o, &m, err);
    if (status == SP_OK)
        status = smooth_exact(&m, d, err);
    if (status == SP_OK) {
        double before = 0, unsure = 0;
        d->zero = m.zero;
        for (int32_t b = 0; b < d->bins; b++) {
            double below, doubtful;
            count_below(&m, d->edge[b + 1], &below, &doubtful);
            const double width = d->edge[b + 1] - d->edge[b];
            d->density[b] = (below - before) / width;
            d->density_error[b] = (doubtful + unsure) / width;
            d->cumulative[b] = below;
            d->cumulative_error[b] = doubtful;
            before = below;
            unsure = doubtful;
        }
    }
    sp_modes_free(&m);
    return status;
}

/* ---- kernel polynomials ------------------------------------------------------------------------------------------ */

/* The trace of T_k, as the mean of <z|T_k|z> over vectors z of random signs (Hutchinson 1990). */
typedef struct trace {
    const sp_network *net;
    const sp_dos *dos;
    uint64_t seed;
    int32_t pairs;
    double *mu; /* [2 pairs][moments] */
    sp_status *status;
    sp_error *reason;
} trace;

/* Random signs of two vectors, as displacements. Each vector has its own stream of bits, whichever thread draws it. */
static void draw_signs(const sp_network *net, uint64_t seed, int32_t pair, double *out) {
    const int64_t n = sp_network_dofs(net);
    for (int lane = 0; lane < 2; lane++) {
        sp_random stream = sp_random_make(seed, SP_STREAM_TRACE);
        uint64_t bits = 0;
        stream.count = (uint64_t)(2 * pair + lane) << 40;
        for (int64_t k = 0; k < n; k++) {
            if (k % 64 == 0)
                bits = sp_random_bits(&stream);
            out[2 * k + lane] = (bits >> (k % 64) & 1 ? 1 : -1) / sqrt(net->mass[k]);
        }
    }
}

static sp_status one_pair(const trace *t, int32_t q, sp_error *err) {
    const int64_t n = t->dos->moments;
    double *start = sp_alloc(2 * (size_t)sp_network_dofs(t->net), sizeof *start);
    moment_set m = {0};
    if (!start)
        return sp_fail_memory(err, 2 * (size_t)sp_network_dofs(t->net) * sizeof *start);
    draw_signs(t->net, t->seed, q, start);
    sp_status status = sp_moments_make(t->net, n, start, &m, err);
    if (status == SP_OK) {
        memcpy(t->mu + 2 * q * n, m.xx, (size_t)n * sizeof *m.xx);
        memcpy(t->mu + (2 * q + 1) * n, m.yy, (size_t)n * sizeof *m.yy);
    }
    sp_moments_free(&m);
    sp_free(start);
    return status;
}

static void some_pairs(void *data, int part, int parts) {
    const trace *t = data;
    for (int32_t q = part; q < t->pairs && t->status[part] == SP_OK; q += parts)
        t->status[part] = one_pair(t, q, &t->reason[part]);
}

static sp_status find_trace(trace *t, int threads, sp_error *err) {
    sp_pool *pool = NULL;
    const int parts = threads < t->pairs ? threads : t->pairs;
    t->status = sp_alloc((size_t)parts, sizeof *t->status);
    t->reason = sp_alloc((size_t)parts, sizeof *t->reason);
    sp_status status = t->status && t->reason ? sp_pool_make(parts, &pool, err)
                                              : sp_fail_memory(err, (size_t)parts * sizeof *t->reason);
    if (status == SP_OK)
        sp_pool_run(pool, some_pairs, t);
    for (int k = 0; k < parts && status == SP_OK; k++)
        if (t->status[k] != SP_OK) {
            status = t->status[k];
            if (err)
                *err = t->reason[k];
        }
    sp_pool_free(pool);
    sp_free(t->status);
    sp_free(t->reason);
    return status;
}

/* Running mean and variance (Welford 1962). */
typedef struct running {
    double mean, squares;
    int64_t n;
} running;

static void add_value(running *r, double x) {
    const double before = x - r->mean;
    r->n++;
    r->mean += before / (double)r->n;
    r->squares += before * (x - r->mean);
}

static double standard_error(const running *r) { return sqrt(r->squares / (double)(r->n - 1) / (double)r->n); }

static void put_estimates(const trace *t, const double *g, sp_dos *d) {
    const double omega = d->omega_max;
    for (int32_t b = 0; b < d->bins; b++) {
        running density = {0}, cumulative = {0}, smooth = {0};
        for (int32_t v = 0; v < 2 * t->pairs; v++) {
            const double *mu = t->mu + v * d->moments;
            const double low = sp_moments_integral(omega, d->moments, g, mu, d->edge[b]),
                         high = sp_moments_integral(omega, d->moments, g, mu, d->edge[b + 1]);
            add_value(&density, (high - low) / (d->edge[b + 1] - d->edge[b]));
            add_value(&cumulative, high);
            add_value(&smooth, sp_moments_density(omega, d->moments, g, mu, middle(d, b)));
        }
        d->density[b] = density.mean;
        d->cumulative[b] = cumulative.mean;
        d->smooth[b] = smooth.mean;
        d->density_error[b] = standard_error(&density);
        d->cumulative_error[b] = standard_error(&cumulative);
        d->smooth_error[b] = standard_error(&smooth);
    }
}

/* What is known of the zero modes without their number. */
static sp_status known_zeros(const sp_network *net, sp_dos *d, sp_error *err) {
    sp_null_motions known = {0};
    sp_status status = sp_null_motions_make(net, &known, err);
    if (status == SP_OK) {
        d->zero = sp_zeros_sum(net, &known, 0);
        d->zero.mechanisms = d->zero.total = -1;
    }
    sp_null_motions_free(&known);
    return status;
}

static sp_status kpm(const sp_network *net, const sp_dos_options *o, sp_dos *d, sp_error *err) {
    const double automatic = fmin(64, fmax(4, 2 * ceil(0.5 * DRAWN / (double)d->modes)));
    d->vectors = o->vectors > 0 ? o->vectors : (int32_t)automatic;
    trace t = {.net = net, .dos = d, .seed = o->seed, .pairs = d->vectors / 2};
    const size_t n = (size_t)d->moments;
    const double bytes = 8.0 * (double)d->vectors * (double)d->moments;
    if (bytes > 0.5 * sp_memory_limit())
        return sp_fail(err, SP_EREFUSED, "%lld moments of %d vectors need %.3g GB, %.3g are available",
                       (long long)d->moments, d->vectors, 1e-9 * bytes, 1e-9 * sp_memory_limit());
    double *g = sp_alloc(n, sizeof *g);
    t.mu = sp_alloc((size_t)d->vectors, n * sizeof *t.mu);
    sp_status status = g && t.mu ? SP_OK : sp_fail_memory(err, ((size_t)d->vectors + 1) * n * sizeof *g);
    if (status == SP_OK)
        status = find_trace(&t, o->threads, err);
    if (status == SP_OK) {
        sp_moments_jackson(d->moments, g);
        put_estimates(&t, g, d);
        status = known_zeros(net, d, err);
    }
    sp_free(t.mu);
    sp_free(g);
    return status;
}

/* ---- counting ---------------------------------------------------------------------------------------------------- */

/* The histogram by inertia; the smooth density stays that of kernel polynomials. */
static sp_status count_bins(const sp_network *net, sp_dos *d, sp_error *err) {
    counter c = {0};
    int64_t least = 0, most = 0, before = 0, unsure = 0;
    sp_status status = sp_counter_make(net, &c, err);
    if (status == SP_OK)
        status = sp_zero_modes_count(net, &d->zero, err);
    const int64_t zeros = d->zero.total - d->zero.rattlers;
    for (int32_t b = 0; b < d->bins && status == SP_OK; b++) {
        const double width = d->edge[b + 1] - d->edge[b], limit = d->edge[b + 1] * d->edge[b + 1];
        least = most = d->modes; /* above the bound of the spectrum */
        if (limit < c.top)
            status = sp_counter_below(&c, limit, &least, &most, err);
        d->cumulative[b] = (double)(least - zeros);
        d->cumulative_error[b] = (double)(most - least);
        d->density[b] = (double)(least - zeros - before) / width;
        d->density_error[b] = (double)(most - least + unsure) / width;
        before = least - zeros;
        unsure = most - least;
    }
    sp_counter_free(&c);
    return status;
}

static void normalise(const sp_network *net, sp_dos_norm norm, sp_dos *d) {
    const double by = norm == SP_DOS_GRAIN ? net->n : norm == SP_DOS_ONE ? (double)d->modes : 1;
    for (int64_t k = 0; k < 6 * (int64_t)d->bins; k++)
        d->density[k] /= by; /* the six columns are contiguous */
}

sp_status sp_dos_make(const sp_network *net, const sp_dos_options *opt, sp_dos *out, sp_error *err) {
    sp_dos d = sp_dos_none();
    sp_status status = check(opt, err);
    if (status == SP_OK)
        status = sp_network_need_symmetry(net, "a density of states", err);
    if (status == SP_OK)
        status = allocate(net, opt, &d, err);
    if (status == SP_OK) {
        d.method = opt->method;
        if (d.method == SP_DOS_AUTO)
            d.method = d.modes <= EXACT_DOFS ? SP_DOS_EXACT : SP_DOS_KPM;
        status = d.method == SP_DOS_EXACT ? exact(net, &d, err) : kpm(net, opt, &d, err);
        if (status == SP_OK && d.method == SP_DOS_COUNT)
            status = count_bins(net, &d, err);
    }
    if (status == SP_OK) {
        normalise(net, opt->norm, &d);
        *out = d;
    } else {
        sp_dos_free(&d);
    }
    return status;
}

/* ---- participation ratios ---------------------------------------------------------------------------------------- */

sp_status sp_participation(const sp_modes *modes, int32_t bins, double until, sp_participation_bin *out,
                           sp_error *err) {
    if (bins < 1)
        return sp_fail(err, SP_EINVAL, "bins = %d, must be 1 or more", bins);
    if (!(until >= 0 && isfinite(until)))
        return sp_fail(err, SP_EINVAL, "until = %g, must be a frequency, or 0 for the largest", until);
    if (!modes->participation)
        return sp_fail(err, SP_EINVAL, "modes have no vectors, which participation ratios need");
    const double last = until > 0 ? until : modes->n > 0 ? modes->omega[modes->n - 1] : 0;
    if (!(last > 0))
        return sp_fail(err, SP_EREFUSED, "there are no vibrations: all frequencies are 0");
    for (int32_t b = 0; b < bins; b++)
        out[b] = (sp_participation_bin){.low = last * b / bins,
                                        .high = b + 1 < bins ? last * (b + 1) / bins : last,
                                        .mean = NAN,
                                        .sd = NAN,
                                        .least = NAN,
                                        .largest = NAN};
    running now = {0};
    int32_t b = 0;
    for (int64_t k = 0; k < modes->n; k++) { /* frequencies ascend */
        if (!(modes->omega[k] > 0) || modes->omega[k] > last)
            continue;
        for (; modes->omega[k] > out[b].high; b++)
            now = (running){0};
        const double x = modes->participation[k];
        add_value(&now, x);
        out[b].modes = now.n;
        out[b].mean = now.mean;
        out[b].sd = now.n > 1 ? sqrt(now.squares / (double)(now.n - 1)) : NAN;
        out[b].least = now.n > 1 ? fmin(out[b].least, x) : x;
        out[b].largest = now.n > 1 ? fmax(out[b].largest, x) : x;
    }
    return SP_OK;
}
