/* Makes Tables I, II, IV and V. */
#include "base/base.h"
#include "paper/counts.h"
#include "paper/paper.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* Reports how many rows of an item agree, and which differs most. */
static void say_agreement(paper *p, int item) {
    int64_t rows = 0, agree = 0, missing = 0;
    const paper_row *worst = NULL;
    for (int64_t k = 0; k < p->rows; k++) {
        const paper_row *r = &p->row[k];
        if (r->item != item)
            continue;
        rows++;
        missing += !isfinite(r->sigma);
        agree += fabs(r->sigma) <= 1;
        if (isfinite(r->sigma) && (!worst || fabs(r->sigma) > fabs(worst->sigma)))
            worst = r;
    }
    sp_paper_say(p, item, "%lld of %lld means lie within one standard deviation of the paper%s.", (long long)agree,
                 (long long)rows, missing > 0 ? ", and some have no value or no known scatter" : "");
    const paper_counts c = sp_paper_count(p->rows, p->row, item, PAPER_SORT_MEANS);
    if (c.judged > 0)
        sp_paper_say(
            p, item,
            "By the standard errors of both means %lld of %lld lie within one, %lld beyond two and %lld beyond "
            "three; chi^2 = %.0f.",
            (long long)c.within1, (long long)c.judged, (long long)c.beyond2, (long long)c.beyond3, c.chi2);
    if (worst)
        sp_paper_say(
            p, item,
            "The largest deviation is that of %s at p = %g: %.4g here, %.4g in the paper, %.2f standard deviations "
            "apart.",
            worst->quantity, worst->p, worst->ours, worst->paper, fabs(worst->sigma));
}

/* ---- samples far off -------------------------------------------------------------------------------------------- */

static int ascending(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The median; sorts x. */
static double median(int64_t n, double *x) {
    qsort(x, (size_t)n, sizeof *x, ascending);
    return 0.5 * (x[(n - 1) / 2] + x[n / 2]);
}

static const double far_off = 8; /* in standard deviations estimated from the median deviation; a probability of 1e-15
                                    for a normal distribution */

/* Reports samples that dominate a mean. A soft spot in a single packing can do so for the body forces. */
static sp_status say_far_off(paper *p, int item, const char *quantity, double pressure, int64_t n, const double *values,
                             sp_error *err) {
    if (n < 5)
        return SP_OK;
    double *x = sp_alloc(2 * (size_t)n, sizeof *x), worst = 0;
    if (!x)
        return sp_fail_memory(err, 2 * (size_t)n * sizeof *x);
    for (int64_t k = 0; k < n; k++)
        x[k] = values[k];
    const double middle = median(n, x);
    double *off = x + n;
    for (int64_t k = 0; k < n; k++)
        off[k] = fabs(values[k] - middle);
    const double sd = 1.4826 * median(n, off);
    int64_t count = 0;
    for (int64_t k = 0; k < n; k++)
        if (fabs(values[k] - middle) > far_off * sd) {
            count++;
            if (fabs(values[k] - middle) > fabs(worst - middle) || count == 1)
                worst = values[k];
        }
    sp_free(x);
    if (count > 0)
        sp_paper_say(p, item,
                     "%s at p = %g: %lld of %lld samples lie more than 8 standard deviations of the others away, the "
                     "farthest at %.3g; the median is %.4g.",
                     quantity, pressure, (long long)count, (long long)n, worst, middle);
    return SP_OK;
}

/* ---- Table IV with the density of the whole box ----------------------------------------------------------------- */

/* The body force on a grain is its volume divided by Phi3*. If Phi3* is that of the whole box, the forces add up to the
 * force on the continuum. The ratios are proportional to its square. */
static sp_status add_box_ratio(const sp_sample *s, const sp_packing *packing, const sp_network *net, void *user,
                               sp_error *err) {
    (void)err;
    double *sum = user, volume = 0; /* sum of squared ratios, and their number */
    for (int32_t i = 0; i < net->n; i++)
        volume += 4 / 3.0 * 3.14159265358979323846 * pow(packing->r[net->grain[i]], 3);
    if (s->have & SP_WANT_STATICS) {
        sum[0] += pow(volume / (packing->box[0] * packing->box[1] * s->statics.phi3s), 2);
        sum[1]++;
    }
    return SP_OK;
}

static sp_status say_box(paper *p, int item, sp_error *err) {
    int64_t rows = 0, agree = 0, before = 0;
    double low = INFINITY, high = 0;
    for (int k = 0; k < PAPER_PRESSURES; k++) {
        double sum[2] = {0};
        sp_status status = sp_paper_walk(p, PAPER_SQUARE, sp_paper_pressure[k], 0, 0, add_box_ratio, sum, err);
        if (status != SP_OK)
            return status;
        low = fmin(low, sum[0] / sum[1]);
        high = fmax(high, sum[0] / sum[1]);
        for (int64_t r = 0; r < p->rows; r++) {
            const paper_row *row = &p->row[r];
            if (row->item != item || row->p < sp_paper_pressure[k] || row->p > sp_paper_pressure[k])
                continue;
            rows++;
            before += fabs(row->sigma) <= 1;
            agree += fabs(row->ours * sum[0] / sum[1] - row->paper) <= row->paper_sd;
        }
    }
    sp_paper_say(
        p, item,
        "The body force on a grain goes as 1/Phi3*. Here that is the bulk's, as everywhere; with that of the whole "
        "box, "
        "loose layers at the walls included, all ratios would be %.3f to %.3f times as large, and %lld of %lld instead "
        "of %lld would agree.",
        low, high, (long long)agree, (long long)rows, (long long)before);
    return SP_OK;
}

sp_status sp_paper_make_table(paper *p, int item, sp_error *err) {
    sp_status status = SP_OK;
    for (int q = 0; q < sp_paper_quantity_count && status == SP_OK; q++) {
        const paper_quantity *quantity = &sp_paper_quantities[q];
        for (int k = 0; k < PAPER_PRESSURES && quantity->item == item && status == SP_OK; k++) {
            const double sd = quantity->sd[k];
            paper_row row = {.item = item,
                             .p = sp_paper_pressure[k],
                             .paper = quantity->mean[k],
                             .paper_sd = sd > 0 ? sd : NAN,
                             .digit = quantity->digit[k],
                             .scatter = sd > 0 ? PAPER_SCATTER_PAPER : PAPER_SCATTER_OURS};
            double *values = NULL;
            int64_t n = 0;
            snprintf(row.quantity, sizeof row.quantity, "%s", quantity->name);
            status = sp_paper_values(p, PAPER_SQUARE, row.p, 0, quantity->part, quantity->ours, &n, &values, err);
            if (status != SP_OK)
                break;
            sp_paper_row_mean(&row, n, values);
            status = sp_paper_add_row(p, row, err);
            if (status == SP_OK)
                status = say_far_off(p, item, quantity->name, row.p, n, values, err);
            sp_free(values);
        }
    }
    if (status == SP_OK)
        say_agreement(p, item);
    return status == SP_OK && item == PAPER_TABLE_4 ? say_box(p, item, err) : status;
}
