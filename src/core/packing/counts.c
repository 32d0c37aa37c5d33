/* Histograms of contacts: Figs. 1(c) and 2 of Somfai et al. 2005. */
#include "base/base.h"
#include "packing/bulk.h"
#include "packing/contact.h"

#include <math.h>
#include <sonopack/counts.h>

#define PI          3.14159265358979323846
#define VALUE_WIDTH 0.1        /* bin width, in units of the mean */
#define EQUAL       (1 + 1e-9) /* a force equal to the mean up to rounding is not above it */

sp_contact_counts sp_contact_counts_none(void) { return (sp_contact_counts){0}; }

/* Histograms of one packing, as numbers of contacts. */
typedef struct own_counts {
    double n, strong;
    double mean_force, mean_stiffness;
    double all[SP_ANGLE_BINS], strong_of[SP_ANGLE_BINS], weak_of[SP_ANGLE_BINS];
    double force[SP_VALUE_BINS + 1], stiffness[SP_VALUE_BINS + 1]; /* last entry: beyond the bins */
} own_counts;

/* Whether the contact joins two grains and its point lies in the bulk. */
static bool counts(const sp_packing *p, const sp_contact *k, const bulk *b) {
    return k->j >= 0 && sp_bulk_has_contact(b, p, k);
}

/* n and -n are equivalent. Bins are centred at 0, 5, ... degrees, where lattices have their bonds. In three dimensions
 * the angle is that of elevation above the horizontal, and the bins are wider: few directions are nearly upright. */
static int bins_of(int dim) { return dim == 3 ? SP_ELEVATION_BINS : SP_ANGLE_BINS; }

static int angle_bin(const sp_packing *p, const sp_contact *k) {
    const int bins = bins_of(p->dim);
    const double angle = p->dim == 3 ? asin(fmin(1, fabs(k->n[2]))) : atan2(k->n[1], k->n[0]); /* -pi .. pi */
    return (int)(floor(angle / PI * bins + 0.5) + bins) % bins;
}

/* Part of isotropic directions in a bin. In three dimensions bin b and bins - b are on both sides of the vertical and
 * hold the same contacts. */
static double isotropic_part(int dim, int b) {
    if (dim != 3)
        return 1.0 / SP_ANGLE_BINS;
    const int to_level = b <= SP_ELEVATION_BINS / 2 ? b : SP_ELEVATION_BINS - b;
    const double low = (to_level - 0.5) * PI / SP_ELEVATION_BINS, high = (to_level + 0.5) * PI / SP_ELEVATION_BINS;
    return sin(fmin(high, 0.5 * PI)) - sin(fmax(low, 0));
}

static int value_bin(double value, double mean) {
    const double bin = value / mean / VALUE_WIDTH;
    return bin < SP_VALUE_BINS ? (int)bin : SP_VALUE_BINS;
}

static void count_all(const sp_packing *p, const uint8_t *carrying, double margin, own_counts *own) {
    const bulk b = sp_bulk_of(p, margin);
    for (int pass = 0; pass < 2; pass++) {
        for (int32_t c = 0; c < p->n_contacts; c++) {
            const sp_contact *k = &p->contacts[c];
            if (!carrying[c] || !counts(p, k, &b))
                continue;
            if (pass == 0) {
                own->n += 1;
                own->mean_force += k->fn;
                own->mean_stiffness += contact_kn(p, k);
                continue;
            }
            const bool strong = k->fn > EQUAL * own->mean_force;
            own->force[value_bin(k->fn, own->mean_force)] += 1;
            own->stiffness[value_bin(contact_kn(p, k), own->mean_stiffness)] += 1;
            own->strong += strong;
            if (p->dim == 1)
                continue;
            own->all[angle_bin(p, k)] += 1;
            (strong ? own->strong_of : own->weak_of)[angle_bin(p, k)] += 1;
        }
        if (pass == 0 && own->n > 0) {
            own->mean_force /= own->n;
            own->mean_stiffness /= own->n;
        }
    }
}

static double counted(int dim, const double *bins, int b) {
    return dim == 3 && b > SP_ELEVATION_BINS / 2 ? bins[SP_ELEVATION_BINS - b] : bins[b];
}

static void add_angles(sp_angle_counts *to, int dim, double n, const double *bins) {
    if (!(n > 0))
        return;
    to->packings++;
    to->contacts += n;
    for (int b = 0; b < bins_of(dim); b++) {
        const double density = counted(dim, bins, b) / (n * isotropic_part(dim, b));
        to->sum[b] += density;
        to->squares[b] += density * density;
    }
}

static void add_values(sp_value_counts *to, double n, const double *bins) {
    for (int b = 0; b < SP_VALUE_BINS; b++) {
        const double density = bins[b] / (n * VALUE_WIDTH);
        to->sum[b] += density;
        to->squares[b] += density * density;
    }
    to->beyond += bins[SP_VALUE_BINS] / n;
}

static sp_status refuse(const sp_packing *p, double margin, sp_error *err) {
    for (int a = p->dim - 1; a >= 0; a--)
        if (!sp_packing_periodic(p, a) && p->box[a] <= 2 * margin)
            return sp_fail(err, SP_EREFUSED, "%s %g is too small for a bulk %g from both walls, must be above %g",
                           a == p->dim - 1 ? "height" : "width", p->box[a], margin, 2 * margin);
    return sp_fail(err, SP_EREFUSED, "no contact between grains carries a force at least %g from both walls", margin);
}

sp_status sp_contact_counts_add(sp_contact_counts *c, const sp_packing *p, double threshold, double margin,
                                sp_error *err) {
    if (!(margin >= 0 && isfinite(margin)))
        return sp_fail(err, SP_EINVAL, "margin = %g, must be a distance from the walls, 0 or above", margin);
    if (c->dim != 0 && c->dim != p->dim)
        return sp_fail(err, SP_EINVAL, "a packing in %d dimensions after one in %d, must be of one kind", p->dim,
                       c->dim);
    own_counts *own = sp_alloc(1, sizeof *own);
    uint8_t *carrying = sp_alloc((size_t)p->n_contacts, 1);
    sp_status status = own && carrying ? SP_OK : sp_fail_memory(err, sizeof *own + (size_t)p->n_contacts);
    if (status == SP_OK)
        status = sp_packing_rattlers(p, threshold, NULL, carrying, NULL, err);
    if (status == SP_OK)
        count_all(p, carrying, margin, own);
    if (status == SP_OK && own->n == 0)
        status = refuse(p, margin, err);
    if (status == SP_OK) {
        c->dim = p->dim;
        c->packings++;
        c->contacts += own->n;
        add_angles(&c->all, p->dim, own->n, own->all);
        add_angles(&c->strong, p->dim, own->strong, own->strong_of);
        add_angles(&c->weak, p->dim, own->n - own->strong, own->weak_of);
        add_values(&c->force, own->n, own->force);
        add_values(&c->stiffness, own->n, own->stiffness);
    }
    sp_free(carrying);
    sp_free(own);
    return status;
}

/* ---- tables ----------------------------------------------------------------------------------------------------- */

static double mean_of(double sum, int64_t n) { return n > 0 ? sum / (double)n : NAN; }

/* Standard error of the mean over packings. */
static double error_of(double sum, double squares, int64_t n) {
    if (n < 2)
        return NAN;
    const double mean = sum / (double)n;
    return sqrt(fmax(0, squares / (double)n - mean * mean) / (double)(n - 1));
}

static sp_status begin(const sp_contact_counts *c, int columns, const char *const *names, sp_table *t, sp_error *err) {
    if (c->packings == 0)
        return sp_fail(err, SP_EREFUSED, "no packing was counted");
    sp_status status = SP_OK;
    for (int k = 0; k < columns && status == SP_OK; k++)
        status = sp_table_add_column(t, names[k], "", SP_COLUMN_NUMBER, err);
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "packings = %lld", (long long)c->packings);
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "contacts = %.0f", c->contacts);
    return status;
}

sp_status sp_contact_angles_table(const sp_contact_counts *c, sp_table *out, sp_error *err) {
    static const char *const names[] = {"angle", "all", "all_err", "strong", "strong_err", "weak", "weak_err"};
    const sp_angle_counts *of[] = {&c->all, &c->strong, &c->weak};
    if (c->packings > 0 && c->dim == 1)
        return sp_fail(err, SP_EREFUSED,
                       "directions of contacts are counted in 2 or 3 dimensions, the packings have %d", c->dim);
    sp_table t = sp_table_none();
    sp_status status = begin(c, 7, names, &t, err);
    if (status == SP_OK)
        status = sp_table_add_comment(&t, err, "dimension = %d", c->dim);
    if (status == SP_OK)
        status = sp_table_add_comment(&t, err,
                                      "density of contact directions over that of isotropic ones; angle%s in "
                                      "degrees from the walls, n and -n are the same",
                                      c->dim == 3 ? " of elevation, whatever the direction along the walls," : "");
    if (status == SP_OK)
        status = sp_table_add_comment(&t, err, "strong_part = %.6g", c->strong.contacts / c->contacts);
    const int bins = bins_of(c->dim);
    for (int b = 0; b < bins && status == SP_OK; b++) {
        double row[7] = {180.0 * b / bins};
        for (int k = 0; k < 3; k++) {
            row[1 + 2 * k] = mean_of(of[k]->sum[b], of[k]->packings);
            row[2 + 2 * k] = error_of(of[k]->sum[b], of[k]->squares[b], of[k]->packings);
        }
        status = sp_table_add_numbers(&t, row, err);
    }
    if (status == SP_OK)
        *out = t;
    else
        sp_table_free(&t);
    return status;
}

sp_status sp_contact_values_table(const sp_contact_counts *c, sp_table *out, sp_error *err) {
    static const char *const names[] = {"x", "forces", "forces_err", "stiffnesses", "stiffnesses_err"};
    const sp_value_counts *of[] = {&c->force, &c->stiffness};
    sp_table t = sp_table_none();
    sp_status status = begin(c, 5, names, &t, err);
    if (status == SP_OK)
        status = sp_table_add_comment(
            &t, err, "densities of normal forces and stiffnesses over their means; areas 1, x is the middle of a bin");
    if (status == SP_OK)
        status = sp_table_add_comment(&t, err, "beyond = %.6g", mean_of(c->force.beyond, c->packings));
    int last = 1;
    for (int b = 0; b < SP_VALUE_BINS; b++)
        if (c->force.sum[b] > 0 || c->stiffness.sum[b] > 0)
            last = b;
    for (int b = 0; b <= last && status == SP_OK; b++) {
        double row[5] = {VALUE_WIDTH * (b + 0.5)};
        for (int k = 0; k < 2; k++) {
            row[1 + 2 * k] = mean_of(of[k]->sum[b], c->packings);
            row[2 + 2 * k] = error_of(of[k]->sum[b], of[k]->squares[b], c->packings);
        }
        status = sp_table_add_numbers(&t, row, err);
    }
    if (status == SP_OK)
        *out = t;
    else
        sp_table_free(&t);
    return status;
}
