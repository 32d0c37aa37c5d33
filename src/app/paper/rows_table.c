/* Writes the rows as a table. */
#include "paper/reproduce.h"
#include "paper/verdict.h"

#include <stdio.h>
#include <string.h>

static const char *const scatter_names[] = {[PAPER_SCATTER_PAPER] = "paper",
                                            [PAPER_SCATTER_OURS] = "ours",
                                            [PAPER_SCATTER_STATED] = "stated",
                                            [PAPER_SCATTER_BOUND] = "bound",
                                            [PAPER_SCATTER_CLAIM] = "claim"};

static const char *relation_of(const paper_row *row) {
    static const char *const names[] = {[PAPER_EQUAL] = "=", [PAPER_ABOVE] = ">", [PAPER_BELOW] = "<"};
    return row->scatter == PAPER_SCATTER_BOUND ? ">" : names[row->relation];
}

/* Place in the paper, from the title of the item: "Table I" from "Table I. Statics", "Fig. 6" from "Fig. 6. Arrival
 * times". */
static const char *where_of(const paper_row *row, char text[24]) {
    const char *title = sp_paper_item_title(row->item);
    if (row->where || !title)
        return row->where ? row->where : "-";
    const size_t number = strncmp(title, "Fig. ", 5) == 0 ? 5 : 0;
    snprintf(text, 24, "%.*s", (int)(number + strcspn(title + number, ".")), title);
    return text;
}

static sp_status add_columns(sp_table *t, sp_error *err) {
    static const struct {
        const char *name, *unit;
        sp_column_kind kind;
    } column[] = {
        {"item", "", SP_COLUMN_TEXT},      {"p", "E*", SP_COLUMN_NUMBER},           {"quantity", "", SP_COLUMN_TEXT},
        {"paper", "", SP_COLUMN_NUMBER},   {"paper_sd", "", SP_COLUMN_NUMBER},      {"ours", "", SP_COLUMN_NUMBER},
        {"err", "", SP_COLUMN_NUMBER},     {"sigma", "", SP_COLUMN_NUMBER},         {"verdict", "", SP_COLUMN_TEXT},
        {"ours_sd", "", SP_COLUMN_NUMBER}, {"samples", "", SP_COLUMN_INTEGER},      {"combined", "", SP_COLUMN_NUMBER},
        {"scatter", "", SP_COLUMN_TEXT},   {"deviation_err", "", SP_COLUMN_NUMBER}, {"rounding", "", SP_COLUMN_NUMBER},
        {"relation", "", SP_COLUMN_TEXT},  {"where", "", SP_COLUMN_TEXT},           {"note", "", SP_COLUMN_TEXT}};
    sp_status status = SP_OK;
    for (size_t k = 0; k < sizeof column / sizeof *column && status == SP_OK; k++)
        status = sp_table_add_column(t, column[k].name, column[k].unit, column[k].kind, err);
    return status;
}

static sp_status add_comments(sp_table *t, sp_error *err) {
    static const char *const line[] = {
        "values of Somfai et al., Phys. Rev. E 72, 021301 (2005), beside ours; units: d, E*, sqrt(E* / rho)",
        "err: standard error of our mean; ours_sd: one standard deviation of our samples",
        "sigma = (ours - paper)/scatter, agrees within one; scatter paper: paper_sd, its standard deviation",
        "scatter ours: the paper gives none, ours_sd; stated: paper_sd, the precision of the words, and err in square",
        "scatter bound: the paper gives a lower bound, paper_sd is our precision; above it sigma is 0",
        "combined = (ours - paper) over both standard errors, that of the paper with 30 samples; nan for one sample",
        "deviation_err = the same with the rounding of print in square, uniform within half of the last digit",
        "scatter claim: a claim in words, relation: what it says of ours (= within paper_sd); it holds or is",
        "contradicted, or is undecided: ours lies within two standard errors of the limit",
        "verdict missing: there is no value of ours, or no scatter, as that of one sample"};
    sp_status status = SP_OK;
    for (size_t k = 0; k < sizeof line / sizeof *line && status == SP_OK; k++)
        status = sp_table_add_comment(t, err, "%s", line[k]);
    return status;
}

sp_status sp_paper_rows_table(int64_t n, const paper_row *rows, sp_table *out, sp_error *err) {
    sp_table t = sp_table_none();
    sp_status status = add_comments(&t, err);
    if (status == SP_OK)
        status = add_columns(&t, err);
    for (int64_t k = 0; k < n && status == SP_OK; k++) {
        const paper_row *r = &rows[k];
        char where[24];
        status = sp_table_add_row(&t, err, sp_paper_item_name(r->item), r->p, r->quantity, r->paper, r->paper_sd,
                                  r->ours, r->err, r->sigma, r->verdict, r->ours_sd, r->samples, r->combined,
                                  scatter_names[r->scatter], r->deviation_err, sp_paper_rounding(r), relation_of(r),
                                  where_of(r, where), *r->note ? r->note : "-");
    }
    if (status != SP_OK) {
        sp_table_free(&t);
        return status;
    }
    *out = t;
    return SP_OK;
}
