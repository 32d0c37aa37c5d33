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

/* ---- as comments ------------------------------------------------------------------------------------------------ */

static sp_status add_count(const char *name, const paper_counts *c, sp_table *t, sp_error *err) {
    if (c->values + c->missing == 0)
        return SP_OK;
    return sp_table_add_comment(t, err,
                                "count: %s values %lld agree %lld missing %lld judged %lld within1 %lld beyond2 %lld "
                                "beyond3 %lld chi2 %.1f chi2_without_rounding %.1f",
                                name, (long long)c->values, (long long)c->agree, (long long)c->missing,
                                (long long)c->judged, (long long)c->within1, (long long)c->beyond2,
                                (long long)c->beyond3, c->chi2, c->chi2_bare);
}

static sp_status add_families(int64_t n, const paper_row *rows, sp_table *t, sp_error *err) {
    sp_status status = SP_OK;
    for (int64_t at = 0; at < n && status == SP_OK;) {
        const paper_family f = sp_paper_family_next(n, rows, &at);
        if (sp_paper_is_systematic(&f))
            status = sp_table_add_comment(
                t, err, "systematic: %s %s, %s at all %lld pressures, %+.1f%% to %+.1f%%, together %+.1f errors",
                sp_paper_item_name(f.first->item), f.first->quantity,
                f.side > 0   ? "high"
                : f.side < 0 ? "low"
                             : "off on both sides",
                (long long)f.values, 100 * f.low, 100 * f.high, f.together);
    }
    return status;
}

sp_status sp_paper_add_counts(int64_t n, const paper_row *rows, sp_table *t, sp_error *err) {
    sp_status status = SP_OK;
    for (int item = 0; item < SP_PAPER_ITEMS && status == SP_OK; item++) {
        const paper_counts c = sp_paper_count(n, rows, item, PAPER_SORT_MEANS);
        status = add_count(sp_paper_item_name(item), &c, t, err);
    }
    const paper_counts means = sp_paper_count(n, rows, -1, PAPER_SORT_MEANS),
                       stated = sp_paper_count(n, rows, -1, PAPER_SORT_STATED);
    if (status == SP_OK)
        status = add_count("tables", &means, t, err);
    if (status == SP_OK)
        status = add_count("stated", &stated, t, err);
    const paper_claims c = sp_paper_count_claims(n, rows);
    if (status == SP_OK && c.claims > 0)
        status = sp_table_add_comment(t, err, "claims: %lld hold %lld contradicted %lld undecided %lld missing %lld",
                                      (long long)c.claims, (long long)c.hold, (long long)c.contradicted,
                                      (long long)c.undecided, (long long)c.missing);
    return status == SP_OK ? add_families(n, rows, t, err) : status;
}
