/* Bulk averages of Table I of Somfai et al. 2005. */
#include "packing/bulk.h"

#include "base/base.h"
#include "base/vector.h"
#include "numeric/quadrature.h"
#include "packing/contact.h"
#include "packing/geometry.h"

#include <math.h>
#include <sonopack/packing.h>
#include <stddef.h>
#include <string.h>

static const double PI = 3.14159265358979323846;

static bulk bulk_of_ring(const sp_packing *p, double margin) {
    bulk b = {.dim = 2, .centre = 0.5 * p->box[0]};
    b.ring[0] = b.centre - p->box[1] + margin;
    b.ring[1] = b.centre - margin;
    b.volume = b.ring[1] > b.ring[0] ? PI * (b.ring[1] - b.ring[0]) * (b.ring[1] + b.ring[0]) : 0;
    sp_gauss_rule(SP_BULK_NODES, b.node, b.weight);
    return b;
}

bulk sp_bulk_of(const sp_packing *p, double margin) {
    if (p->cell == SP_CELL_RING)
        return bulk_of_ring(p, margin);
    bulk b = {.dim = p->dim, .volume = 1};
    bool empty = false;
    for (int a = 0; a < p->dim; a++) {
        b.bounded[a] = !sp_packing_periodic(p, a);
        b.low[a] = b.bounded[a] ? margin : 0;
        b.high[a] = b.bounded[a] ? p->box[a] - margin : p->box[a];
        b.volume *= b.high[a] - b.low[a];
        empty = empty || !(b.high[a] > b.low[a]);
    }
    if (empty)
        b.volume = 0;
    if (b.bounded[0] + b.bounded[1] + b.bounded[2] > 1) /* there are edges */
        sp_gauss_rule(SP_BULK_NODES, b.node, b.weight);
    return b;
}

static double away_of(const bulk *b, const double x[3]) { return hypot(x[0] - b->centre, x[1] - b->centre); }

bool sp_bulk_has(const bulk *b, const double x[3]) {
    if (b->ring[1] > 0)
        return away_of(b, x) >= b->ring[0] && away_of(b, x) <= b->ring[1];
    for (int a = 0; a < b->dim; a++)
        if (b->bounded[a] && !(x[a] >= b->low[a] && x[a] <= b->high[a]))
            return false;
    return true;
}

/* Whether a contact point is in the bulk. */
static bool has_contact(const bulk *b, const sp_packing *p, const sp_contact *c) {
    double point[3];
    sp_contact_point(p, c, point);
    return sp_bulk_has(b, point);
}

/* Fraction of a disc or ball of radius r at height y that lies below a level. */
static double disc_below(double level, double y, double r) {
    double s = fmax(-1, fmin(1, (level - y) / r));
    return 0.5 + (asin(s) + s * sqrt(1 - s * s)) / PI;
}

static double ball_below(double level, double y, double r) {
    double s = fmax(-1, fmin(1, (level - y) / r));
    return 0.25 * (2 + 3 * s - s * s * s);
}

static double segment_below(double level, double y, double r) { return 0.5 + 0.5 * fmax(-1, fmin(1, (level - y) / r)); }

/* Boundaries across one axis, from the centre of a grain. */
typedef struct slab {
    double low, high;
} slab;

static double between(int dim, const slab *s, double r) {
    if (dim == 3)
        return ball_below(s->high, 0, r) - ball_below(s->low, 0, r);
    if (dim == 2)
        return disc_below(s->high, 0, r) - disc_below(s->low, 0, r);
    return segment_below(s->high, 0, r) - segment_below(s->low, 0, r);
}

/* ---- grains at edges and corners ----------------------------------------------------------------------------------
 * A sum over slices across the first slab, at r sin(angle). It is not smooth where a slice begins to reach an edge of
 * another slab, or a corner of two: there the panels of the sum meet. */

enum { SLABS_MAX = 3, BREAKS_MAX = 2 + 2 * (4 + 4) };

static void add_break(double distance, double r, double *angle, int *n) {
    const double at = distance < r ? acos(distance / r) : 0;
    if (at > angle[0] && at < angle[1])
        angle[(*n)++] = at;
    if (at > 0 && -at > angle[0] && -at < angle[1])
        angle[(*n)++] = -at;
}

/* Angles at which panels begin and end, ascending; how many. */
static int find_breaks(int slabs, const slab *s, double r, double angle[BREAKS_MAX]) {
    int n = 2;
    angle[0] = asin(fmax(-1, fmin(1, s->low / r)));
    angle[1] = asin(fmax(-1, fmin(1, s->high / r)));
    for (int k = 1; k < slabs; k++) {
        add_break(fabs(s[k].low), r, angle, &n);
        add_break(fabs(s[k].high), r, angle, &n);
    }
    for (int k = 0; k < 4 && slabs == SLABS_MAX; k++)
        add_break(hypot(k % 2 ? s[1].low : s[1].high, k / 2 ? s[2].low : s[2].high), r, angle, &n);
    for (int k = 1; k < n; k++)
        for (int m = k; m > 0 && angle[m] < angle[m - 1]; m--) {
            const double less = angle[m];
            angle[m] = angle[m - 1];
            angle[m - 1] = less;
        }
    return n;
}

/* Fraction of a ball, disc or segment (dim 3, 2, 1) within all slabs, which are upright on each other. u^2 (3 - 2 u)
 * makes the powers of 3/2 at the ends of a panel smooth. */
static double within(const bulk *b, int dim, int slabs, const slab *s, double r) {
    double angle[BREAKS_MAX], sum = 0;
    if (slabs < 2)
        return slabs == 0 ? 1 : between(dim, s, r);
    const int n = find_breaks(slabs, s, r, angle);
    for (int m = 1; m < n; m++)
        for (int k = 0; k < SP_BULK_NODES; k++) {
            const double u = 0.5 + 0.5 * b->node[k], wide = angle[m] - angle[m - 1];
            const double c = cos(angle[m - 1] + wide * u * u * (3 - 2 * u));
            sum += b->weight[k] * 3 * u * (1 - u) * wide * (dim == 3 ? 0.75 * c * c * c : 2 / PI * c * c) *
                   within(b, dim - 1, slabs - 1, s + 1, r * c);
        }
    return sum;
}

static double part_of_ring(const bulk *b, int dim, double away, double r) {
    double in[2];
    for (int k = 0; k < 2; k++)
        in[k] = dim == 2 ? sp_disc_in_circle(away, r, b->ring[k])
                         : sp_ball_in_circle(away, r, b->ring[k], b->node, b->weight);
    return in[1] - in[0];
}

static double part(const bulk *b, int dim, const double x[3], double r) {
    if (b->ring[1] > 0)
        return part_of_ring(b, dim, away_of(b, x), r);
    slab cut[SLABS_MAX];
    int slabs = 0;
    for (int a = 0; a < b->dim; a++) {
        const slab s = {b->low[a] - x[a], b->high[a] - x[a]};
        if (b->bounded[a] && (s.low > -r || s.high < r))
            cut[slabs++] = s;
    }
    return within(b, dim, slabs, cut, r);
}

double sp_bulk_ball(const bulk *b, const double x[3], double r) { return part(b, 3, x, r); }

static void sum_fractions(const sp_packing *p, const bulk *b, const uint8_t *rattler, sp_statics *s) {
    double area = 0, volume = 0, carrying = 0;
    for (int32_t i = 0; i < p->n; i++) {
        const double r = p->r[i], *x = p->x + 3 * (size_t)i;
        const double ball = grain_mass(r) * sp_bulk_ball(b, x, r);
        area += p->dim == 2 ? PI * r * r * part(b, 2, x, r) : 0;
        volume += ball;
        carrying += rattler[i] ? 0 : ball;
    }
    s->phi2 = p->dim == 2 ? area / b->volume : NAN;
    s->phi3 = volume / b->volume;
    s->phi3s = carrying / b->volume;
}

double sp_packing_density_of(const sp_packing *p, const uint8_t *rattler, double margin) {
    const bulk b = sp_bulk_of(p, margin);
    double mass = 0;
    for (int32_t i = 0; i < p->n; i++) {
        const double r = p->r[i], all = p->mass ? p->mass[i] : grain_mass(r);
        mass += rattler && rattler[i] ? 0 : all * sp_bulk_ball(&b, p->x + 3 * (size_t)i, r);
    }
    return b.volume > 0 ? mass / b.volume : NAN;
}

sp_status sp_packing_density(const sp_packing *p, double threshold, double margin, double *out, sp_error *err) {
    uint8_t *rattler = sp_alloc((size_t)p->n, 1);
    sp_status status =
        rattler ? sp_packing_rattlers(p, threshold, rattler, NULL, NULL, err) : sp_fail_memory(err, (size_t)p->n);
    if (status == SP_OK)
        *out = sp_packing_density_of(p, rattler, margin);
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
        if (!sp_bulk_has(b, p->x + 3 * (size_t)i))
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

/* Moments (5) and fabric (6) over the carrying contacts of the bulk. */
static void sum_forces(const sp_packing *p, const bulk *b, const uint8_t *carrying, sp_statics *s) {
    double n = 0, f1 = 0, f2 = 0, f3 = 0, fabric = 0, strong = 0, strong_fabric = 0;
    for (int pass = 0; pass < 2; pass++)
        for (int32_t c = 0; c < p->n_contacts; c++) {
            const sp_contact *k = &p->contacts[c];
            if (!carrying[c] || !has_contact(b, p, k))
                continue;
            double point[3], up[3];
            sp_contact_point(p, k, point);
            sp_packing_up(p, point, up);
            const double ny2 = dot3(k->n, up) * dot3(k->n, up);
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

/* sigma_ab = 1/V sum F_a r_b; off the diagonal the mean of ab and ba, which are equal where torques balance. The ratios
 * have the force on a horizontal plane, in a ring on a circle. */
static void sum_stress(const sp_packing *p, const uint8_t *carrying, sp_statics *s) {
    double sum[3][3] = {{0}}, sideways = 0;
    const int up = p->dim - 1;
    const struct {
        double *to;
        int a, b;
    } each[] = {{&s->s_xx, 0, 0}, {&s->s_yy, 1, 1}, {&s->s_zz, 2, 2},
                {&s->s_yz, 1, 2}, {&s->s_xz, 0, 2}, {&s->s_xy, 0, 1}};
    sp_packing_moments(p, carrying, false, sum);
    for (size_t k = 0; k < sizeof each / sizeof *each; k++)
        if (each[k].b < p->dim)
            *each[k].to = 0.5 * (sum[each[k].a][each[k].b] + sum[each[k].b][each[k].a]) / sp_packing_volume(p);
    if (up == 0)
        return;
    if (p->cell == SP_CELL_RING) {
        memset(sum, 0, sizeof sum);
        sp_packing_moments(p, carrying, true, sum);
    }
    for (int a = 0; a < up; a++)
        sideways += sum[a][a] / up;
    s->s1_over_s2 = sideways / sum[up][up];
    s->s12_over_s2 = sum[0][up] / sum[up][up];
    s->s32_over_s2 = up == 2 ? sum[1][up] / sum[up][up] : NAN;
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
        full += ft >= at_limit * contact_mu(p, k) * k->fn;
    }
    return p->friction > 0 ? full / contacts : NAN;
}

sp_status sp_statics_make(const sp_packing *p, double threshold, double margin, sp_statics *out, sp_error *err) {
    const bulk b = sp_bulk_of(p, margin);
    sp_statics s = {NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN};
    uint8_t *rattler = sp_alloc((size_t)p->n, 1), *carrying = sp_alloc((size_t)p->n_contacts, 1);
    sp_status status = rattler && carrying ? SP_OK : sp_fail_memory(err, (size_t)p->n + (size_t)p->n_contacts);
    if (status == SP_OK)
        status = sp_packing_rattlers(p, threshold, rattler, carrying, NULL, err);
    if (status == SP_OK && b.volume > 0) {
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
