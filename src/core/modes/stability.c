/* Decides whether a network is stable, by discs around all eigenvalues or by counts of those of the symmetric part. */
#include "base/base.h"
#include "modes/count.h"
#include "network/spins.h"

#include <math.h>
#include <sonopack/modes.h>
#include <stdlib.h>

/* ---- forces that do not balance ------------------------------------------------------------------------------- */

/* Adds the force F and the torque R n x F of a contact on grain i (sign 1) or j (sign -1) of radius r. */
static void add_contact(const sp_contact *c, double sign, double r, double sum[6]) {
    for (int a = 0; a < 3; a++) {
        const int b = (a + 1) % 3, g = (a + 2) % 3;
        sum[a] += sign * (c->ft[a] - c->fn * c->n[a]);
        sum[3 + a] += r * (c->n[b] * c->ft[g] - c->n[g] * c->ft[b]);
    }
}

/* Imbalance of the forces at rest, as it affects eigenvalues. */
typedef struct imbalance {
    double balance; /* of the worst grain */
    int64_t spins;  /* number of spheres with two contacts at rest, which spin with omega^2 near 0 */
    double spin;    /* imbalance of the worst of them */
} imbalance;

/* A sphere is at rest if its net force is below this fraction of p. Contacts too weak to carry (network.threshold) are
 * not counted. */
static const double AT_REST = 1e-3;

/* A floppy motion of a grain has omega^2 = 0 only if its forces balance: the terms of K that cancel then are forces
 * over m R and torques over the moment of inertia. Finds the largest net values. */
static sp_status find_imbalance(const sp_packing *p, const sp_network *net, imbalance *out, sp_error *err) {
    double(*sum)[6] = sp_alloc((size_t)net->n, sizeof *sum);
    sp_spin *spin = NULL;
    sp_status status = sum ? SP_OK : sp_fail_memory(err, (size_t)net->n * sizeof *sum);
    if (status == SP_OK)
        status = sp_spins_make(net, &spin, err);
    for (int32_t k = 0; k < net->n_springs && status == SP_OK; k++) {
        const sp_spring *s = &net->springs[k];
        add_contact(&p->contacts[s->contact], 1, s->ri, sum[s->i]);
        if (s->j >= 0)
            add_contact(&p->contacts[s->contact], -1, s->rj, sum[s->j]);
    }
    *out = (imbalance){0};
    for (int32_t i = 0; i < net->n && net->prestress && status == SP_OK; i++) {
        const double *f = sum[i], r = net->r[i], mass = net->mass[(int64_t)i * net->dof];
        const double force = sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]);
        const double torque = sqrt(f[3] * f[3] + f[4] * f[4] + f[5] * f[5]);
        const double turned = net->dof > net->dim ? (force * r + torque) / (0.4 * mass * r * r) : 0;
        double axis[3];
        out->balance = fmax(out->balance, fmax(force / (mass * r), turned));
        if (spin && sp_spin_axis(&spin[i], axis) && force + torque / r <= AT_REST * net->pressure) {
            out->spins++;
            out->spin = fmax(out->spin, turned);
        }
    }
    sp_free(spin);
    sp_free(sum);
    return status;
}

/* |Im sqrt(z)|, the growth rate of a motion with omega^2 = z. */
static double growth_of(double re, double im) { return sqrt(fmax(0, 0.5 * (hypot(re, im) - re))); }

/* ---- discs ---------------------------------------------------------------------------------------------------- */

/* A connected component of the union of all discs. */
typedef struct part {
    int64_t discs, above; /* number of discs; those with centres above the real axis */
    double low, high;     /* extent along the real axis */
    double nearest;       /* smallest |im| - radius: distance from the real axis */
    double farthest;      /* largest distance from the real axis */
    double size;          /* largest distance from 0 */
    double growth;        /* upper bound of the growth rate */
    double certain;       /* lower bound of the growth rate */
} part;

static void add_disc(part *to, const sp_discs *d, size_t k) {
    const double re = d->re[k], im = d->im[k], radius = d->radius[k], off = fabs(im);
    if (to->discs == 0)
        *to = (part){.low = INFINITY, .high = -INFINITY, .nearest = INFINITY, .certain = INFINITY};
    to->discs++;
    to->above += im > 0;
    to->low = fmin(to->low, re - radius);
    to->high = fmax(to->high, re + radius);
    to->nearest = fmin(to->nearest, off - radius);
    to->farthest = fmax(to->farthest, off + radius);
    to->size = fmax(to->size, hypot(re, im) + radius);
    /* growth increases with |im| and decreases with re */
    to->growth = fmax(to->growth, growth_of(re - radius, off + radius));
    to->certain = fmin(to->certain, growth_of(re + radius, fmax(0, off - radius)));
}

/* Classifies a component. A single disc that touches the real axis contains a real eigenvalue: with a complex one it
 * would contain its conjugate too. */
static void classify(const part *q, sp_stability *s) {
    s->growth_bound = fmax(s->growth_bound, q->discs == 1 && q->nearest <= 0 && q->low > 0 ? 0 : q->growth);
    if (q->nearest <= 0 && q->low <= 0 && q->high >= 0 && q->size <= 2 * s->error) {
        s->zero += q->discs;
        return;
    }
    s->softest = fmin(s->softest, q->low);
    if (q->discs == 1 && q->nearest <= 0 && q->low > 0)
        return;
    const bool off = q->nearest > 0, within = q->size <= s->balance + 2 * s->error;
    if (!off && !(q->discs == 1 && q->high < 0)) {
        s->verdict = SP_MODES_UNDECIDED;
        return;
    }
    const int64_t motions = off ? q->above : 1;
    s->flutter += off ? motions : 0;
    s->negative += off ? 0 : motions;
    s->unbalanced += within ? motions : 0;
    s->growth = fmax(s->growth, q->certain);
}

static int by_size(const void *a, const void *b) {
    const part *x = a, *y = b;
    return (x->size > y->size) - (x->size < y->size);
}

/* Spins first: the smallest components count as spins if the imbalance of their forces explains them. */
static void classify_parts(int64_t n, part *parts, const imbalance *r, sp_stability *s) {
    int64_t spins = r->spins;
    qsort(parts, (size_t)n, sizeof *parts, by_size);
    for (int64_t k = 0; k < n; k++) {
        const part *q = &parts[k];
        if (q->discs == 0)
            continue;
        if (q->discs <= spins && q->size <= r->spin + 2 * s->error) {
            spins -= q->discs;
            s->zero += q->discs;
            s->growth_bound = fmax(s->growth_bound, sqrt(q->size));
        } else {
            spins = 0; /* the others are larger */
            classify(q, s);
        }
    }
    if (s->negative + s->flutter > s->unbalanced)
        s->verdict = SP_MODES_UNSTABLE;
    else if (s->unbalanced > 0)
        s->verdict = SP_MODES_UNDECIDED;
}

static sp_status classify_discs(const sp_discs *all, const imbalance *r, sp_stability *s, sp_error *err) {
    const size_t n = (size_t)all->n;
    int64_t *owner = sp_alloc(n, sizeof *owner);
    part *parts = sp_alloc(n, sizeof *parts);
    sp_status status = owner && parts ? sp_discs_connect(all, owner, err) : sp_fail_memory(err, n * sizeof *parts);
    s->error = 0;
    for (size_t k = 0; k < n && status == SP_OK; k++) {
        add_disc(&parts[owner[k]], all, k);
        s->error = fmax(s->error, all->radius[k]);
    }
    if (status == SP_OK) {
        s->softest = INFINITY;
        classify_parts((int64_t)n, parts, r, s);
    }
    sp_free(owner);
    sp_free(parts);
    return status;
}

static sp_status by_discs(const sp_network *net, const imbalance *r, sp_stability *s, sp_error *err) {
    sp_discs d = {0};
    sp_status status = sp_network_discs(net, NULL, NULL, false, &d, err);
    if (status == SP_OK)
        status = classify_discs(&d, r, s, err);
    s->dense = true;
    sp_discs_free(&d);
    return status;
}

/* ---- counts --------------------------------------------------------------------------------------------------- */

/* Counts the eigenvalues below *sigma + *error. Moves *sigma slightly if a pivot vanishes. */
static sp_status count_below(const counter *c, double *sigma, int64_t *below, double *error, sp_error *err) {
    sp_status status = SP_EREFUSED;
    for (int k = 0; k < 8 && status == SP_EREFUSED; k++, *sigma *= status == SP_EREFUSED ? 1.01 : 1)
        status = sp_ldl_factor(c->ldl, *sigma, err);
    if (status == SP_OK) {
        *below = sp_ldl_negative(c->ldl);
        *error = sp_ldl_error(c->ldl) + c->noise;
    }
    return status;
}

/* Finds the smallest eigenvalue above `from`, as a lower bound within 1%; `already` eigenvalues lie below `from` >
 * 0. */
static sp_status find_next(const counter *c, double from, double top, int64_t already, double *out, sp_error *err) {
    double low = from, high = from, error;
    int64_t below = already;
    sp_status status = SP_OK;
    while (below <= already && high < top && status == SP_OK) {
        low = high;
        high *= 4;
        status = count_below(c, &high, &below, &error, err);
    }
    while (high > 1.01 * low && status == SP_OK) {
        double middle = sqrt(low * high);
        status = count_below(c, &middle, &below, &error, err);
        if (below > already)
            high = middle;
        else
            low = middle;
    }
    *out = low;
    return status;
}

/* Finds a lower bound -*delta of all eigenvalues, within 10%; *delta is at least `from`. */
static sp_status find_bottom(const counter *c, double from, double *delta, sp_error *err) {
    double low = 0, high = from, error = 0;
    int64_t below = 1;
    sp_status status = SP_OK;
    while (below > 0 && status == SP_OK) {
        double sigma = -high;
        status = count_below(c, &sigma, &below, &error, err);
        high = -sigma;
        if (below > 0) {
            low = high;
            high *= 4;
        }
    }
    while (low > 0 && high > 1.1 * low && status == SP_OK) {
        double sigma = -sqrt(low * high);
        status = count_below(c, &sigma, &below, &error, err);
        if (below > 0)
            low = -sigma;
        else
            high = -sigma;
    }
    *delta = high + error;
    return status;
}

/* Finds the smallest distance from 0 at which counts are reliable: 1e4 times the noise, or more if pivots are small. */
static sp_status find_rounding(const counter *c, double most, double *rounding, sp_error *err) {
    double error = 0;
    int64_t below = 0;
    *rounding = 1e4 * c->noise;
    for (most = fmax(most, *rounding); *rounding <= most; *rounding = fmax(4 * *rounding, 2 * error)) {
        double sigma = -*rounding;
        sp_status status = count_below(c, &sigma, &below, &error, err);
        if (status != SP_OK || error < *rounding)
            return status;
    }
    return sp_fail(err, SP_EREFUSED, "eigenvalues near 0 cannot be counted: the factor has an error of %.2g", error);
}

/* Counts of eigenvalues below -window and up to +window. */
typedef struct around {
    double window, error;
    int64_t below, up;
} around;

static sp_status count_around(const counter *c, double window, around *out, sp_error *err) {
    double sigma = -window, high = window, error = 0;
    *out = (around){.window = window};
    sp_status status = count_below(c, &sigma, &out->below, &out->error, err);
    if (status == SP_OK)
        status = count_below(c, &high, &out->up, &error, err);
    out->error = fmax(out->error, error);
    out->window = -sigma;
    return status;
}

/* Finds the window in which eigenvalues count as zero: rounding errors, or the imbalance of spins if only spins lie
 * there. */
static sp_status find_zeros(const counter *c, const imbalance *r, double rounding, around *zero, sp_error *err) {
    around wide;
    sp_status status = count_around(c, rounding, zero, err);
    if (status != SP_OK || r->spins == 0 || r->spin <= rounding)
        return status;
    status = count_around(c, r->spin, &wide, err);
    if (status == SP_OK && wide.up - wide.below <= r->spins)
        *zero = wide;
    return status;
}

static sp_status classify_counts(const counter *c, const imbalance *r, sp_stability *s, sp_error *err) {
    double rounding = 0, delta = 0, error = 0;
    int64_t beyond = 0;
    around zero = {0};
    sp_status status = find_rounding(c, s->balance, &rounding, err);
    if (status == SP_OK)
        status = find_zeros(c, r, rounding, &zero, err);
    if (status == SP_OK)
        status = find_bottom(c, zero.window, &delta, err);
    if (status != SP_OK)
        return status;
    s->error = zero.error;
    if (s->skew > 0) {
        s->verdict = SP_MODES_UNDECIDED;
        s->growth_bound = growth_of(-delta, s->skew);
        return SP_OK;
    }
    double sigma = -fmax(s->balance, zero.window);
    status = count_below(c, &sigma, &beyond, &error, err);
    s->flutter = 0;
    s->negative = zero.below;
    s->unbalanced = zero.below - beyond;
    s->verdict = beyond > 0 ? SP_MODES_UNSTABLE : zero.below > 0 ? SP_MODES_UNDECIDED : SP_MODES_STABLE;
    s->growth_bound = sqrt(delta);
    s->zero = zero.up - zero.below;
    if (zero.below > 0) /* the lower bound is known to 10% */
        s->growth = sqrt(fmax(fmax(zero.window, (delta - zero.error) / 1.11) - zero.error, 0));
    return status == SP_OK ? find_next(c, zero.window, 2 * c->top, zero.up, &s->softest, err) : status;
}

static sp_status by_counts(const sp_network *net, const imbalance *r, sp_stability *s, sp_error *err) {
    counter c = {0};
    s->negative = s->flutter = s->unbalanced = s->zero = -1;
    s->softest = NAN;
    sp_status status = sp_counter_make(net, &c, err);
    if (status == SP_OK)
        status = classify_counts(&c, r, s, err);
    sp_counter_free(&c);
    return status;
}

sp_status sp_stability_make(const sp_packing *p, const sp_network *net, sp_stability *out, sp_error *err) {
    sp_stability s = {.verdict = SP_MODES_STABLE, .dofs = sp_network_dofs(net), .skew = sp_network_skew(net)};
    if (p->n != net->n_all || p->dim != net->dim)
        return sp_fail(err, SP_EINVAL, "a packing of %d grains and a network of %d, must be of the same packing", p->n,
                       net->n_all);
    imbalance r;
    sp_status status = find_imbalance(p, net, &r, err);
    s.balance = r.balance;
    if (status == SP_OK)
        status = net->carried && s.dofs <= SP_STABILITY_MAX ? by_discs(net, &r, &s, err) : by_counts(net, &r, &s, err);
    if (status == SP_OK)
        *out = s;
    return status;
}
