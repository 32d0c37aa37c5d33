/* Counts how many values agree with the paper, and finds systematic differences. */
#include "paper/counts.h"

#include "paper/reproduce.h"
#include <math.h>
#include <string.h>

static bool is_of(const paper_row *row, int item, paper_sort sort) {
    const bool mean = row->scatter == PAPER_SCATTER_PAPER || row->scatter == PAPER_SCATTER_OURS;
    return (item < 0 || row->item == item) && !sp_paper_is_claim(row) && mean == (sort == PAPER_SORT_MEANS);
}

paper_counts sp_paper_count(int64_t n, const paper_row *rows, int item, paper_sort sort) {
    paper_counts c = {0};
    for (int64_t k = 0; k < n; k++) {
        const paper_row *row = &rows[k];
        if (!is_of(row, item, sort))
            continue;
        c.missing += !isfinite(row->sigma);
        c.values += isfinite(row->sigma);
        c.agree += fabs(row->sigma) <= 1;
        if (!isfinite(row->deviation_err))
            continue;
        const double off = fabs(row->deviation_err);
        c.judged++;
        c.within1 += off <= 1;
        c.beyond2 += off > 2;
        c.beyond3 += off > 3;
        c.chi2 += off * off;
        c.chi2_bare += row->combined * row->combined;
    }
    if (sort == PAPER_SORT_STATED) /* the precision of a wording is not a standard deviation */
        c.chi2 = c.chi2_bare = NAN;
    return c;
}

paper_claims sp_paper_count_claims(int64_t n, const paper_row *rows) {
    paper_claims c = {0};
    for (int64_t k = 0; k < n; k++) {
        if (!sp_paper_is_claim(&rows[k]))
            continue;
        c.claims++;
        c.hold += strcmp(rows[k].verdict, "holds") == 0;
        c.contradicted += strcmp(rows[k].verdict, "contradicted") == 0;
        c.undecided += strcmp(rows[k].verdict, "undecided") == 0;
        c.missing += strcmp(rows[k].verdict, "missing") == 0;
    }
    return c;
}

/* ---- families --------------------------------------------------------------------------------------------------- */

paper_family sp_paper_family_next(int64_t n, const paper_row *rows, int64_t *at) {
    paper_family f = {.first = &rows[*at], .least = INFINITY, .low = INFINITY, .high = -INFINITY};
    int64_t above = 0, below = 0;
    double sum = 0;
    for (; *at < n; (*at)++) {
        const paper_row *row = &rows[*at];
        if (row->item != f.first->item || strcmp(row->quantity, f.first->quantity) != 0)
            break;
        if (sp_paper_is_claim(row) || !isfinite(row->deviation_err))
            continue;
        const double ratio = row->ours / row->paper - 1;
        f.values++;
        above += row->deviation_err > 0;
        below += row->deviation_err < 0;
        sum += row->deviation_err;
        f.least = fmin(f.least, fabs(row->deviation_err));
        f.low = fmin(f.low, ratio);
        f.high = fmax(f.high, ratio);
    }
    f.side = above == f.values ? 1 : below == f.values ? -1 : 0;
    f.together = f.values > 0 ? sum / sqrt((double)f.values) : NAN;
    return f;
}

bool sp_paper_is_systematic(const paper_family *f) {
    if (f->values < 3)
        return false;
    return f->side != 0 ? fabs(f->together) > 3 : f->least > 2;
}
