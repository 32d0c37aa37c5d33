/* Adds rows for claims in words, and sums values for them. */
#include "paper/claims.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

sp_status sp_paper_add_claim(paper *p, const paper_claim *claim, double ours, double ours_err, sp_error *err,
                             const char *quantity, ...) {
    paper_row row = {.item = PAPER_CLAIMS,
                     .p = claim->p,
                     .paper = claim->limit,
                     .paper_sd = claim->relation == PAPER_EQUAL ? claim->within : NAN,
                     .scatter = PAPER_SCATTER_CLAIM,
                     .relation = claim->relation,
                     .ours = ours,
                     .ours_sd = NAN,
                     .err = ours_err,
                     .samples = claim->samples,
                     .where = claim->where};
    va_list args;
    va_start(args, quantity);
    vsnprintf(row.quantity, sizeof row.quantity, quantity, args);
    va_end(args);
    snprintf(row.note, sizeof row.note, "%s", claim->note);
    return sp_paper_add_row(p, row, err);
}

void sp_paper_sum_add(paper_sum *s, double x) {
    if (!isfinite(x))
        return;
    s->n++;
    s->sum += x;
    s->squares += x * x;
}

double sp_paper_sum_mean(const paper_sum *s) { return s->n > 0 ? s->sum / (double)s->n : NAN; }

double sp_paper_sum_err(const paper_sum *s) {
    const double n = (double)s->n;
    return s->n > 1 ? sqrt(fmax(0, s->squares / n - s->sum / n * (s->sum / n)) / (n - 1)) : NAN;
}
