/* The paper on the tapped column: its items, and their reproduction. */
#include "paper/blackmore.h"
#include "base/base.h"

#include <string.h>

static const blackmore_item items[SP_PAPER_COLUMN_ITEMS] = {
    {"errata", "Errata",
     "Equations (1) to (48). A row an error: what is printed or follows from what is printed, and what is right.",
     sp_blackmore_make_errata, 0.02},
    {"fig1", "Fig. 1. Trajectories of five and of ten particles",
     "The particles over four taps, as two pictures without numbers; their positions when they have settled after each "
     "tap, at .99T, 1.99T, ..., and the evolution of the linear density are what is asked for.",
     sp_blackmore_make_fig1, 0.05},
    {"fig2", "Fig. 2. The two continua beside the lattice",
     "Surfaces of the long-wave and of the BSR model for the ten particles of Fig. 1, very close to one another and in "
     "good qualitative agreement with the lattice; two pictures without numbers.",
     sp_blackmore_make_fig2, 0.15},
    {"symbols", "Equations (35) and (37) as printed",
     "The long-wave equation, said to be solved with central differences, equal steps of 0.01 in time and in space.",
     sp_blackmore_make_symbols, 0.02},
    {"chaos", "Theorem 1. Chaos",
     "For sufficiently large amplitudes there is chaos, and for sufficiently small periods, too; a theorem without an "
     "example.",
     sp_blackmore_make_chaos, 0.6},
    {"claims", "Claims and theorems",
     "Integrable Hamiltonian systems with solitons, cycles of arbitrarily large period, good choices of the "
     "parameters, "
     "trends after many taps, a hybrid scheme: said without a number.",
     sp_blackmore_make_claims, 0.16}};

static bool is_item(int item) { return item >= 0 && item < SP_PAPER_COLUMN_ITEMS; }
const char *sp_paper_column_item_name(int item) { return is_item(item) ? items[item].name : NULL; }

double sp_paper_column_item_seconds(int item, bool drawn) {
    static const double seconds[SP_PAPER_COLUMN_ITEMS][2] = {{0, 0},    {0, 0.06},    {0.24, 0.8},
                                                             {0, 0.01}, {2.62, 4.88}, {2.34, 2.34}};
    return is_item(item) ? seconds[item][drawn] : 0;
}

sp_paper_column_options sp_paper_column_options_default(void) {
    return (sp_paper_column_options){.threads = 1, .figures = "svg"};
}

/* ---- all of it -------------------------------------------------------------------------------------------------- */

static sp_status make_items(blackmore *p, sp_error *err) {
    sp_status status = SP_OK;
    double all = 0;
    for (int item = 0; item < SP_PAPER_COLUMN_ITEMS; item++)
        all += sp_blackmore_is_selected(p, item) ? items[item].share : 0;
    for (int item = 0; item < SP_PAPER_COLUMN_ITEMS && status == SP_OK; item++) {
        if (!sp_blackmore_is_selected(p, item))
            continue;
        p->item_share = items[item].share / all;
        p->step = items[item].name;
        status = sp_blackmore_progress(p, 0, err);
        if (status == SP_OK)
            status = items[item].make(p, err);
        if (status == SP_OK && p->failed)
            status = sp_fail_memory(err, 2 * p->capacity * sizeof *p->row);
        p->item_at += p->item_share;
    }
    return status;
}

static sp_status check(const sp_paper_column_options *opt, sp_error *err) {
    if (opt->threads < 1 || opt->threads > 4096)
        return sp_fail(err, SP_EINVAL, "threads = %d: 1 to 4096", opt->threads);
    if (opt->items >> SP_PAPER_COLUMN_ITEMS)
        return sp_fail(err, SP_EINVAL, "items = %#x: %d items", opt->items, SP_PAPER_COLUMN_ITEMS);
    if (!opt->figures ||
        (strcmp(opt->figures, "svg") != 0 && strcmp(opt->figures, "png") != 0 && strcmp(opt->figures, "pdf") != 0))
        return sp_fail(err, SP_EINVAL, "figures: must be svg, png or pdf");
    return SP_OK;
}

sp_status sp_paper_column_reproduce(const sp_paper_column_options *opt, sp_paper_watch watch, void *user, sp_table *out,
                                    sp_error *err) {
    sp_status status = check(opt, err);
    if (status != SP_OK)
        return status;
    blackmore p = {.opt = opt, .items = items, .watch = watch, .user = user, .begun = sp_clock_wall()};
    if (opt->folder)
        status = sp_paper_page_unfinished(opt->folder, err);
    if (status == SP_OK)
        status = make_items(&p, err);
    sp_table t = sp_table_none();
    if (status == SP_OK)
        status = sp_blackmore_rows_table(&p, -1, &t, err);
    if (status == SP_OK && opt->folder)
        status = sp_blackmore_report(&p, err);
    for (int item = 0; item < SP_PAPER_COLUMN_ITEMS; item++)
        sp_text_free(&p.section[item].text);
    sp_free(p.row);
    if (status == SP_OK)
        *out = t;
    else
        sp_table_free(&t);
    return status;
}
