/* Reproduces the paper: makes the ensembles, then the items, then the table and the report. */
#include "base/base.h"
#include "paper/counts.h"
#include "paper/paper.h"

#include <string.h>

sp_paper_options sp_paper_options_default(void) {
    return (sp_paper_options){.samples = PAPER_SAMPLES, .jobs = 1, .threads = 1, .figures = "svg"};
}

static bool has_rows(int item) {
    for (int k = 0; k < sp_paper_items[item].needs; k++)
        if (!sp_paper_items[item].need[k].drawn)
            return true;
    return false;
}

static sp_status make_items(paper *p, sp_error *err) {
    sp_status status = SP_OK;
    int wanted = 0, made = 0;
    for (int item = 0; item < SP_PAPER_ITEMS; item++)
        wanted += sp_paper_wants(p, item);
    for (int item = 0; item < SP_PAPER_ITEMS && status == SP_OK; item++) {
        if (!sp_paper_wants(p, item))
            continue;
        const double done = p->cost_done / p->cost;
        status = sp_paper_tell(p, sp_paper_items[item].name, done + (1 - done) * made++ / wanted, err);
        if (status == SP_OK && (p->opt->folder || has_rows(item)))
            status = sp_paper_items[item].make(p, item, err);
    }
    return status;
}

static sp_status check(const sp_paper_options *opt, sp_error *err) {
    if (opt->samples < 1 || opt->samples > 100000)
        return sp_fail(err, SP_EINVAL, "samples = %d: 1 to 100000", opt->samples);
    if (opt->jobs < 1 || opt->jobs > 4096)
        return sp_fail(err, SP_EINVAL, "jobs = %d: 1 to 4096", opt->jobs);
    if (opt->items >> SP_PAPER_ITEMS)
        return sp_fail(err, SP_EINVAL, "items = %#x: %d items", opt->items, SP_PAPER_ITEMS);
    if (!opt->figures ||
        (strcmp(opt->figures, "svg") != 0 && strcmp(opt->figures, "png") != 0 && strcmp(opt->figures, "pdf") != 0))
        return sp_fail(err, SP_EINVAL, "figures: must be svg, png or pdf");
    return SP_OK;
}

sp_status sp_paper_reproduce(sp_store *store, const sp_paper_options *opt, sp_paper_watch watch, void *user,
                             sp_table *out, sp_error *err) {
    sp_status status = check(opt, err);
    if (status != SP_OK)
        return status;
    paper p = {.opt = opt, .store = store, .watch = watch, .user = user, .begun = sp_clock_wall()};
    if (opt->folder)
        status = sp_paper_report_begin(&p, err);
    if (status == SP_OK)
        status = sp_paper_collect(&p, err);
    if (status == SP_OK)
        status = make_items(&p, err);
    sp_table t = sp_table_none();
    if (status == SP_OK)
        status = sp_paper_rows_table(p.rows, p.row, &t, err);
    if (status == SP_OK)
        status = sp_paper_add_counts(p.rows, p.row, &t, err);
    if (status == SP_OK && opt->folder)
        status = sp_paper_report(&p, err);
    for (int e = 0; e < PAPER_ENSEMBLES; e++)
        sp_free(p.set[e].sample);
    for (int item = 0; item < SP_PAPER_ITEMS; item++)
        sp_text_free(&p.section[item].text);
    sp_free(p.row);
    if (status != SP_OK) {
        sp_table_free(&t);
        return status;
    }
    *out = t;
    return SP_OK;
}
