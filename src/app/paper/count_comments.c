/* Writes counts of agreement and systematic differences as comments of a table. */
#include "paper/counts.h"
#include "paper/paper.h"

#include <math.h>

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
