/* The paper on the tapped column: its items, and their reproduction from rows to report. */
#include "paper/blackmore.h"
#include "base/base.h"

#include <sonopack/figure/plot.h>
#include <sonopack/version.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

const blackmore_item sp_blackmore_items[SP_PAPER_COLUMN_ITEMS] = {
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
const char *sp_paper_column_item_name(int item) { return is_item(item) ? sp_blackmore_items[item].name : NULL; }
const char *sp_paper_column_item_title(int item) { return is_item(item) ? sp_blackmore_items[item].title : NULL; }

sp_paper_column_options sp_paper_column_options_default(void) {
    return (sp_paper_column_options){.threads = 1, .figures = "svg"};
}

bool sp_blackmore_wants(const tapped *p, int item) { return p->opt->items == 0 || p->opt->items >> item & 1; }

sp_status sp_blackmore_tell(tapped *p, double done, sp_error *err) {
    sp_paper_progress progress = {.what = "the column",
                                  .fraction = p->item_at + p->item_share * done,
                                  .seconds = sp_clock_wall() - p->begun,
                                  .seconds_left = NAN};
    if (progress.fraction > 0.02)
        progress.seconds_left = progress.seconds * (1 - progress.fraction) / progress.fraction;
    if (!p->watch || p->watch(&progress, p->user))
        return SP_OK;
    return sp_fail(err, SP_EINTERRUPTED, "stopped at %.0f%%", 100 * progress.fraction);
}

sp_tapped_spec sp_blackmore_column(int32_t particles) {
    sp_tapped_spec c = sp_tapped_spec_default();
    c.particles = particles;
    c.frequency = particles == 10 ? 9.5 : 7.5;
    c.taps = 4;
    return c;
}

double sp_blackmore_overlap(const sp_tapped_spec *c) {
    return sp_tapped_mass(c, 1) * c->gravity / sp_tapped_stiffness(c);
}

/* ---- rows ------------------------------------------------------------------------------------------------------- */

static bool holds(const blackmore_row *row) {
    const double err = isfinite(row->err) ? row->err : 0;
    switch (row->relation) {
    case BLACKMORE_ABOVE: return row->ours - err > row->paper;
    case BLACKMORE_BELOW: return row->ours + err < row->paper;
    case BLACKMORE_EQUAL: break;
    }
    return fabs(row->ours - row->paper) <= row->precision + err;
}

/* Whether our value lies within its error of the limit of the claim. */
static bool is_near(const blackmore_row *row) {
    const double off = fabs(row->ours - row->paper), err = isfinite(row->err) ? row->err : 0;
    return row->relation == BLACKMORE_EQUAL
               ? off <= row->precision + err && off > row->precision && err > row->precision
               : off <= err;
}

void sp_blackmore_judge(blackmore_row *row) {
    if (isnan(row->ours))
        row->verdict = "missing";
    else if (isnan(row->paper))
        row->verdict = row->misprint ? "erratum" : "not given";
    else if (row->claim)
        row->verdict = is_near(row) ? "undecided" : holds(row) ? "holds" : "contradicted";
    else if (holds(row))
        row->verdict = "agrees";
    else
        row->verdict = row->misprint ? "erratum" : "deviates";
}

static sp_status make_room(tapped *p, sp_error *err) {
    if (p->rows < p->capacity)
        return SP_OK;
    const size_t capacity = p->capacity > 0 ? 2 * (size_t)p->capacity : 64;
    blackmore_row *larger = sp_alloc(capacity, sizeof *larger);
    if (!larger)
        return sp_fail_memory(err, capacity * sizeof *larger);
    if (p->rows > 0)
        memcpy(larger, p->row, (size_t)p->rows * sizeof *larger);
    sp_free(p->row);
    p->row = larger;
    p->capacity = (int64_t)capacity;
    return SP_OK;
}

sp_status sp_blackmore_add(tapped *p, blackmore_row row, sp_error *err, const char *quantity, ...) {
    sp_status status = make_room(p, err);
    if (status != SP_OK)
        return status;
    va_list args;
    va_start(args, quantity);
    vsnprintf(row.quantity, sizeof row.quantity, quantity, args);
    va_end(args);
    if (!row.unit)
        row.unit = "";
    sp_blackmore_judge(&row);
    p->row[p->rows++] = row;
    return SP_OK;
}

void sp_blackmore_say(tapped *p, int item, const char *format, ...) {
    char line[1200];
    va_list args;
    va_start(args, format);
    vsnprintf(line, sizeof line, format, args);
    va_end(args);
    sp_text_add(&p->section[item].text, "%s\n", line);
}

static sp_status add_comments(sp_table *t, sp_error *err) {
    static const char *const line[] = {
        "Blackmore et al., J. Mech. Mater. Struct. 6 (2011), beside our values; units cm, g, s",
        "paper: what is printed, or what follows from a printed equation or claim; nan: no number is given",
        "precision: how sharply it is printed, or a claim in words is meant; relation: what it says of ours",
        "err: bound of our error, or an estimate (see the note); 0: rounding alone, nan: none, as the note says",
        "verdict agrees: the relation holds within precision and err; deviates: it does not",
        "verdict erratum: the paper is wrong by its own premises, and ours is right; paper nan: no number is wrong",
        "verdict not given: the paper has no number; missing: there is none of ours",
        "claims in words: verdict holds, contradicted, or undecided where ours lies within its error of the limit"};
    sp_status status = SP_OK;
    for (size_t k = 0; k < sizeof line / sizeof *line && status == SP_OK; k++)
        status = sp_table_add_comment(t, err, "%s", line[k]);
    return status;
}

sp_status sp_blackmore_rows_table(int64_t n, const blackmore_row *rows, int item, sp_table *out, sp_error *err) {
    static const struct {
        const char *name;
        sp_cell_kind kind;
    } column[] = {{"item", SP_CELL_TEXT},        {"equation", SP_CELL_TEXT}, {"quantity", SP_CELL_TEXT},
                  {"unit", SP_CELL_TEXT},        {"relation", SP_CELL_TEXT}, {"paper", SP_CELL_NUMBER},
                  {"precision", SP_CELL_NUMBER}, {"ours", SP_CELL_NUMBER},   {"err", SP_CELL_NUMBER},
                  {"verdict", SP_CELL_TEXT},     {"note", SP_CELL_TEXT}};
    static const char *const relation[] = {"=", ">", "<"};
    sp_table t = sp_table_none();
    sp_status status = add_comments(&t, err);
    for (size_t k = 0; k < sizeof column / sizeof *column && status == SP_OK; k++)
        status = sp_table_add_column(&t, column[k].name, "", column[k].kind, err);
    for (int64_t k = 0; k < n && status == SP_OK; k++) {
        const blackmore_row *r = &rows[k];
        if (item < 0 || r->item == item)
            status = sp_table_add_row(&t, err, sp_blackmore_items[r->item].name, r->equation, r->quantity,
                                      *r->unit ? r->unit : "-", relation[r->relation], r->paper, r->precision, r->ours,
                                      r->err, r->verdict, *r->note ? r->note : "-");
    }
    if (status != SP_OK) {
        sp_table_free(&t);
        return status;
    }
    *out = t;
    return SP_OK;
}

/* ---- files ------------------------------------------------------------------------------------------------------ */

sp_status sp_blackmore_save(tapped *p, const char *name, sp_table *t, sp_error *err) {
    if (!p->opt->folder)
        return SP_OK;
    char path[SP_PATH_MAX];
    sp_status status = sp_table_add_comment(t, err, "sonopack %s, reproduce blackmore2011", SONOPACK_VERSION);
    char *text = status == SP_OK ? sp_table_text(t, SP_TSV) : NULL;
    if (status != SP_OK)
        return status;
    if (!text)
        return sp_fail_memory(err, (size_t)(t->rows * t->columns) * 24);
    snprintf(path, sizeof path, "%.3900s/%s.tsv", p->opt->folder, name);
    status = sp_text_save(path, text, strlen(text), err);
    sp_free(text);
    return status;
}

/* Adds figure NAME to the section and returns its path. */
static void add_figure(tapped *p, int item, const char *name, const char *caption, char path[SP_PATH_MAX]) {
    blackmore_section *s = &p->section[item];
    snprintf(path, SP_PATH_MAX, "%.3900s/%s.%s", p->opt->folder, name, p->opt->figures);
    if (s->figures == BLACKMORE_FIGURES)
        return;
    snprintf(s->file[s->figures], sizeof s->file[0], "%s.%s", name, p->opt->figures);
    snprintf(s->caption[s->figures], sizeof s->caption[0], "%s", caption);
    s->figures++;
}

sp_status sp_blackmore_draw(tapped *p, int item, const char *name, int tables, const sp_table *const *table,
                            const char *const *labels, const char *caption, sp_error *err) {
    if (!p->opt->folder)
        return SP_OK;
    char path[SP_PATH_MAX];
    sp_plot_table plot[4];
    for (int k = 0; k < tables && k < 4; k++)
        plot[k] = (sp_plot_table){.label = labels ? labels[k] : NULL, .table = table[k]};
    add_figure(p, item, name, caption, path);
    return sp_plot_column(tables, plot, NULL, path, err);
}

sp_status sp_blackmore_draw_sheet(tapped *p, int item, const char *name, const sp_sheet *sheet, const char *caption,
                                  sp_error *err) {
    if (!p->opt->folder)
        return SP_OK;
    char path[SP_PATH_MAX];
    add_figure(p, item, name, caption, path);
    return sp_plot_sheet(sheet, path, err);
}

/* ---- all of it -------------------------------------------------------------------------------------------------- */

static sp_status make_items(tapped *p, sp_error *err) {
    sp_status status = SP_OK;
    double all = 0;
    for (int item = 0; item < SP_PAPER_COLUMN_ITEMS; item++)
        all += sp_blackmore_wants(p, item) ? sp_blackmore_items[item].share : 0;
    for (int item = 0; item < SP_PAPER_COLUMN_ITEMS && status == SP_OK; item++) {
        if (!sp_blackmore_wants(p, item))
            continue;
        p->item_share = sp_blackmore_items[item].share / all;
        status = sp_blackmore_tell(p, 0, err);
        if (status == SP_OK)
            status = sp_blackmore_items[item].make(p, err);
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
    tapped p = {.opt = opt, .watch = watch, .user = user, .begun = sp_clock_wall()};
    if (opt->folder)
        status = sp_paper_page_unfinished(opt->folder, err);
    if (status == SP_OK)
        status = make_items(&p, err);
    sp_table t = sp_table_none();
    if (status == SP_OK)
        status = sp_blackmore_rows_table(p.rows, p.row, -1, &t, err);
    if (status == SP_OK && opt->folder)
        status = sp_blackmore_report(&p, err);
    for (int item = 0; item < SP_PAPER_COLUMN_ITEMS; item++)
        sp_text_free(&p.section[item].text);
    sp_free(p.row);
    if (status != SP_OK) {
        sp_table_free(&t);
        return status;
    }
    *out = t;
    return SP_OK;
}
