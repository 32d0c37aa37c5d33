/* Tables I, II, IV and V. */
#include "base/base.h"
#include "paper/paper.h"

#include <math.h>
#include <stdio.h>

/* How many rows of an item agree, and which does worst. */
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
    paper_say(p, item, "%lld of %lld means lie within one standard deviation of the paper%s.", (long long)agree,
              (long long)rows, missing > 0 ? ", and some have no value or no known scatter" : "");
    if (worst)
        paper_say(
            p, item,
            "The largest deviation is that of %s at p = %g: %.4g here, %.4g in the paper, %.2f standard deviations "
            "apart.",
            worst->quantity, worst->p, worst->ours, worst->paper, fabs(worst->sigma));
}

sp_status paper_make_table(paper *p, int item, sp_error *err) {
    sp_status status = SP_OK;
    for (int q = 0; q < paper_quantity_count && status == SP_OK; q++) {
        const paper_quantity *quantity = &paper_quantities[q];
        for (int k = 0; k < PAPER_PRESSURES && quantity->item == item && status == SP_OK; k++) {
            const double sd = quantity->sd[k];
            paper_row row = {.item = item,
                             .p = paper_pressure[k],
                             .paper = quantity->mean[k],
                             .paper_sd = sd > 0 ? sd : NAN,
                             .scatter = sd > 0 ? PAPER_SCATTER_PAPER : PAPER_SCATTER_OURS};
            double *values = NULL;
            int64_t n = 0;
            snprintf(row.quantity, sizeof row.quantity, "%s", quantity->name);
            status = paper_values(p, PAPER_SQUARE, row.p, 0, quantity->part, quantity->ours, &n, &values, err);
            if (status != SP_OK)
                break;
            paper_row_mean(&row, n, values);
            sp_free(values);
            status = paper_add_row(p, row, err);
        }
    }
    if (status == SP_OK)
        say_agreement(p, item);
    return status;
}
