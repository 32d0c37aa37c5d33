#include "cli/modes_stability.h"

#include "base/base.h"

#include <math.h>

static const char *const verdicts[] = {
    [SP_MODES_STABLE] = "stable", [SP_MODES_UNSTABLE] = "unstable", [SP_MODES_UNDECIDED] = "undecided"};

static double known(int64_t count) { return count < 0 ? NAN : (double)count; }

static sp_status add_comments(const sp_packing *p, const sp_stability *s, sp_table *t, sp_error *err) {
    char number[SP_NUMBER_TEXT];
    sp_status status = sp_table_add_comment(t, err, "pressure = %s", sp_number_text(p->pressure, number));
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "method = %s", s->dense ? "dense" : "counts");
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "degrees_of_freedom = %lld", (long long)s->dofs);
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "skew = %.3g", s->skew);
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "balance = %.3g", s->balance);
    if (status == SP_OK && s->unbalanced > 0)
        status =
            sp_table_add_comment(t, err,
                                 "%lld of the motions that grow are within balance: the forces at rest are as much "
                                 "off theirs, see packing.tolerance and network.threshold",
                                 (long long)s->unbalanced);
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "%s: no motion grows faster than exp(%.3g t)", verdicts[s->verdict],
                                      s->growth_bound);
    return status;
}

sp_status cli_stability(const sp_packing *p, const sp_network *net, sp_table *t, sp_error *err) {
    static const char *const names[] = {"negative", "flutter", "zero", "softest", "growth", "growth_bound", "error"};
    static const char *const units[] = {
        "", "", "", "E* / (rho d^2)", "sqrt(E* / rho)/d", "sqrt(E* / rho)/d", "E* / (rho d^2)"};
    const int count = sizeof names / sizeof *names;
    sp_stability s;
    sp_status status = sp_stability_make(p, net, &s, err);
    if (status == SP_OK)
        status = sp_table_add_column(t, "verdict", "", SP_CELL_TEXT, err);
    for (int k = 0; k < count && status == SP_OK; k++)
        status = sp_table_add_column(t, names[k], units[k], SP_CELL_NUMBER, err);
    if (status == SP_OK)
        status = add_comments(p, &s, t, err);
    if (status == SP_OK)
        status = sp_table_add_row(t, err, verdicts[s.verdict], known(s.negative), known(s.flutter), known(s.zero),
                                  s.softest, s.growth, s.growth_bound, s.error);
    return status;
}
