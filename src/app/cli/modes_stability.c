/* Fills the table of sonopack modes --stability: whether any motion of the network grows. */
#include "cli/modes.h"

#include <math.h>

static const char *const verdicts[] = {
    [SP_MODES_STABLE] = "stable", [SP_MODES_UNSTABLE] = "unstable", [SP_MODES_UNDECIDED] = "undecided"};

static double known(int64_t count) { return count < 0 ? NAN : (double)count; }

sp_status modes_stability(const sp_packing *p, const sp_network *net, sp_table *t, sp_error *err) {
    sp_stability s = {0};
    cli_writer w = {.table = t, .err = err, .status = sp_stability_make(p, net, &s, err)};
    cli_columns(&w, SP_COLUMN_TEXT, "verdict", "", NULL);
    cli_columns(&w, SP_COLUMN_NUMBER, "negative", "", "flutter", "", "zero", "", "softest", "E* / (rho d^2)", "growth",
                MODES_FREQUENCY, "growth_bound", MODES_FREQUENCY, "error", "E* / (rho d^2)", NULL);
    cli_value(&w, "pressure", p->pressure);
    cli_comment(&w, "method = %s", s.dense ? "dense" : "counts");
    cli_comment(&w, "degrees_of_freedom = %lld", (long long)s.dofs);
    cli_comment(&w, "skew = %.3g", s.skew);
    cli_comment(&w, "balance = %.3g", s.balance);
    if (s.unbalanced > 0)
        cli_comment(&w,
                    "%lld of the motions that grow are within balance: the forces at rest are as much off theirs, see "
                    "packing.tolerance and network.threshold",
                    (long long)s.unbalanced);
    cli_comment(&w, "%s: no motion grows faster than exp(%.3g t)", verdicts[s.verdict], s.growth_bound);
    if (w.status == SP_OK)
        w.status = sp_table_add_row(t, err, verdicts[s.verdict], known(s.negative), known(s.flutter), known(s.zero),
                                    s.softest, s.growth, s.growth_bound, s.error);
    return w.status;
}
