/* Bulk averages of Table I of Somfai et al. 2005. */
#include "base/base.h"
#include "base/vector.h"
#include "packing/contact.h"

#include <math.h>
#include <sonopack/packing.h>

static const double PI = 3.14159265358979323846;

/* Fraction of a disc or ball of radius r at height y that lies below a level. */
static double disc_below(double level, double y, double r) {
    double s = fmax(-1, fmin(1, (level - y) / r));
    return 0.5 + (asin(s) + s * sqrt(1 - s * s)) / PI;
}

static double ball_below(double level, double y, double r) {
    double s = fmax(-1, fmin(1, (level - y) / r));
    return 0.25 * (2 + 3 * s - s * s * s);
}

typedef struct bulk {
    double low, high; /* heights of its boundaries */
    int up;
} bulk;

static bool in_bulk(const bulk *b, double y) { return y >= b->low && y <= b->high; }

static void sum_fractions(const sp_packing *p, const bulk *b, const uint8_t *rattler, sp_statics *s) {
    double area = 0, volume = 0, carrying = 0;
    for (int32_t i = 0; i < p->n; i++) {
        double r = p->r[i], y = p->x[3 * (size_t)i + (size_t)b->up];
        double ball = grain_mass(r) * (ball_below(b->high, y, r) - ball_below(b->low, y, r));
        area += PI * r * r * (disc_below(b->high, y, r) - disc_below(b->low, y, r));
        volume += ball;
        carrying += rattler[i] ? 0 : ball;
    }
    const double base = sp_packing_wall_area(p) * (b->high - b->low);
    s->phi2 = p->dim == 2 ? area / base : NAN;
    s->phi3 = volume / base;
    s->phi3s = carrying / base;
}

sp_status sp_packing_density(const sp_packing *p, double threshold, double margin, double *out, sp_error *err) {
    const bulk b = {.low = margin, .high = sp_packing_height(p) - margin, .up = p->dim - 1};
    uint8_t *rattler = sp_alloc((size_t)p->n, 1);
    sp_status status =
        rattler ? sp_packing_rattlers(p, threshold, rattler, NULL, NULL, err) : sp_fail_memory(err, (size_t)p->n);
    double mass = 0;
    for (int32_t i = 0; status == SP_OK && i < p->n; i++) {
        const double r = p->r[i], y = p->x[3 * (size_t)i + (size_t)b.up];
        const double all = p->mass ? p->mass[i] : grain_mass(r);
        mass += rattler[i] ? 0 : all * (ball_below(b.high, y, r) - ball_below(b.low, y, r));
    }
    if (status == SP_OK)
        *out = b.high > b.low ? mass / (sp_packing_wall_area(p) * (b.high - b.low)) : NAN;
    sp_free(rattler);
    return status;
}

/* Averages over grains with centres in the bulk, wherever their contacts are. */
static sp_status sum_coordination(const sp_packing *p, const bulk *b, const uint8_t *rattler, const uint8_t *carrying,
                                  sp_statics *s, sp_error *err) {
    int32_t *count = sp_alloc((size_t)p->n, sizeof *count);
    if (!count)
        return sp_fail_memory(err, (size_t)p->n * sizeof *count);
    for (int32_t c = 0; c < p->n_contacts; c++) {
        if (!carrying[c])
            continue;
        count[p->contacts[c].i]++;
        if (p->contacts[c].j >= 0)
            count[p->contacts[c].j]++;
    }
    double grains = 0, loose = 0, contacts = 0;
    for (int32_t i = 0; i < p->n; i++) {
        if (!in_bulk(b, p->x[3 * (size_t)i + (size_t)b->up]))
            continue;
        grains += 1;
        loose += rattler[i];
        contacts += rattler[i] ? 0 : count[i];
    }
    s->zs = contacts / (grains - loose);
    s->f0 = 100.0 * loose / grains;
    sp_free(count);
    return SP_OK;
}

/* Height of a contact point. */
static double contact_height(const sp_packing *p, const sp_contact *c, int up) {
    return p->x[3 * (size_t)c->i + (size_t)up] + c->n[up] * (p->r[c->i] - 0.5 * c->overlap);
}

/* Moments (5) and fabric (6) over the carrying contacts of the bulk. */
static void sum_forces(const sp_packing *p, const bulk *b, const uint8_t *carrying, sp_statics *s) {
    double n = 0, f1 = 0, f2 = 0, f3 = 0, fabric = 0, strong = 0, strong_fabric = 0;
    for (int pass = 0; pass < 2; pass++)
        for (int32_t c = 0; c < p->n_contacts; c++) {
            const sp_contact *k = &p->contacts[c];
            if (!carrying[c] || !in_bulk(b, contact_height(p, k, b->up)))
                continue;
            const double ny2 = k->n[b->up] * k->n[b->up];
            if (pass == 0) {
                n += 1;
                f1 += k->fn;
                f2 += k->fn * k->fn;
                f3 += k->fn * k->fn * k->fn;
                fabric += ny2;
            } else if (k->fn > f1 / n) {
                strong += 1;
                strong_fabric += ny2;
            }
        }
    const double mean = f1 / n;
    s->n_over_p = mean / p->pressure;
    s->z2 = f2 / n / (mean * mean);
    s->z3 = f3 / n / (mean * mean * mean);
    s->f2 = fabric / n;
    s->f2s = strong_fabric / strong;
}

/* sigma_ab = 1/V sum F_a r_b over all carrying contacts, walls included, positive in compression. F is the force of i
 * on j and r points from i to j. Besides the diagonal only b = up is needed: the force on a horizontal plane. */
static void sum_stress(const sp_packing *p, const uint8_t *carrying, sp_statics *s) {
    double diagonal[3] = {0}, on_plane[3] = {0};
    const int up = p->dim - 1;
    for (int32_t c = 0; c < p->n_contacts; c++) {
        const sp_contact *k = &p->contacts[c];
        if (!carrying[c])
            continue;
        double branch = p->r[k->i] - k->overlap + (k->j >= 0 ? p->r[k->j] : 0);
        for (int a = 0; a < p->dim; a++) {
            const double force = k->fn * k->n[a] - k->ft[a];
            diagonal[a] += force * branch * k->n[a];
            on_plane[a] += force * branch * k->n[up];
        }
    }
    if (up == 0)
        return;
    double sideways = 0;
    for (int a = 0; a < up; a++)
        sideways += diagonal[a] / up;
    s->s1_over_s2 = sideways / diagonal[up];
    s->s12_over_s2 = on_plane[0] / diagonal[up];
    s->s32_over_s2 = up == 2 ? on_plane[1] / diagonal[up] : NAN;
}

/* Sliding contacts relax a little below Coulomb's limit. */
static const double at_limit = 0.99;

static double mobilised(const sp_packing *p, const uint8_t *carrying) {
    double contacts = 0, full = 0;
    for (int32_t c = 0; c < p->n_contacts; c++) {
        const sp_contact *k = &p->contacts[c];
        if (!carrying[c])
            continue;
        const double ft = length3(k->ft);
        contacts++;
        full += ft >= at_limit * p->friction * k->fn;
    }
    return p->friction > 0 ? full / contacts : NAN;
}

sp_status sp_statics_make(const sp_packing *p, double threshold, double margin, sp_statics *out, sp_error *err) {
    const bulk b = {.low = margin, .high = sp_packing_height(p) - margin, .up = p->dim - 1};
    sp_statics s = {NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN};
    uint8_t *rattler = sp_alloc((size_t)p->n, 1), *carrying = sp_alloc((size_t)p->n_contacts, 1);
    sp_status status = rattler && carrying ? SP_OK : sp_fail_memory(err, (size_t)p->n + (size_t)p->n_contacts);
    if (status == SP_OK)
        status = sp_packing_rattlers(p, threshold, rattler, carrying, NULL, err);
    if (status == SP_OK && b.high > b.low) {
        sum_fractions(p, &b, rattler, &s);
        sum_forces(p, &b, carrying, &s);
        status = sum_coordination(p, &b, rattler, carrying, &s, err);
    }
    if (status == SP_OK) {
        sum_stress(p, carrying, &s);
        s.mobilised = mobilised(p, carrying);
        *out = s;
    }
    sp_free(carrying);
    sp_free(rattler);
    return status;
}
