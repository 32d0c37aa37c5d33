#include "paper/verdict.h"

#include <math.h>
#include <sonopack/paper.h>
#include <stddef.h>

static double known(double x) { return isfinite(x) ? x : 0; }

static double one_sigma(const paper_row *row) {
    switch (row->scatter) {
    case PAPER_SCATTER_PAPER: return row->paper_sd;
    case PAPER_SCATTER_OURS: return row->ours_sd;
    case PAPER_SCATTER_STATED:
    case PAPER_SCATTER_BOUND: break;
    }
    return hypot(row->paper_sd, known(row->err));
}

/* Of the paper's value. */
static double paper_error(const paper_row *row) {
    switch (row->scatter) {
    case PAPER_SCATTER_PAPER: return row->paper_sd / sqrt(PAPER_SAMPLES);
    case PAPER_SCATTER_OURS: return row->ours_sd / sqrt(PAPER_SAMPLES);
    case PAPER_SCATTER_STATED:
    case PAPER_SCATTER_BOUND: break;
    }
    return row->paper_sd;
}

void paper_judge(paper_row *row) {
    double difference = row->ours - row->paper;
    if (row->scatter == PAPER_SCATTER_BOUND && difference > 0)
        difference = 0;
    row->sigma = difference / one_sigma(row);
    row->combined = isfinite(row->err) ? difference / hypot(paper_error(row), row->err) : NAN;
    if (!isfinite(row->sigma))
        row->verdict = "missing";
    else
        row->verdict = fabs(row->sigma) <= 1 ? "agrees" : "deviates";
}

void paper_row_mean(paper_row *row, int64_t n, const double *values) {
    double sum = 0, squares = 0;
    int64_t count = 0;
    for (int64_t k = 0; k < n; k++)
        if (isfinite(values[k])) {
            sum += values[k];
            count++;
        }
    row->samples = count;
    row->ours = count > 0 ? sum / (double)count : NAN;
    for (int64_t k = 0; k < n; k++)
        if (isfinite(values[k]))
            squares += (values[k] - row->ours) * (values[k] - row->ours);
    row->ours_sd = count > 1 ? sqrt(squares / (double)(count - 1)) : NAN;
    row->err = count > 1 ? row->ours_sd / sqrt((double)count) : NAN;
}

static const char *const scatter_names[] = {[PAPER_SCATTER_PAPER] = "paper",
                                            [PAPER_SCATTER_OURS] = "ours",
                                            [PAPER_SCATTER_STATED] = "stated",
                                            [PAPER_SCATTER_BOUND] = "bound"};

static sp_status add_columns(sp_table *t, sp_error *err) {
    static const struct {
        const char *name, *unit;
        sp_cell_kind kind;
    } column[] = {{"item", "", SP_CELL_TEXT},      {"p", "E*", SP_CELL_NUMBER},      {"quantity", "", SP_CELL_TEXT},
                  {"paper", "", SP_CELL_NUMBER},   {"paper_sd", "", SP_CELL_NUMBER}, {"ours", "", SP_CELL_NUMBER},
                  {"err", "", SP_CELL_NUMBER},     {"sigma", "", SP_CELL_NUMBER},    {"verdict", "", SP_CELL_TEXT},
                  {"ours_sd", "", SP_CELL_NUMBER}, {"samples", "", SP_CELL_INTEGER}, {"combined", "", SP_CELL_NUMBER},
                  {"scatter", "", SP_CELL_TEXT}};
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
        "verdict missing: there is no value of ours, or no scatter, as that of one sample"};
    sp_status status = SP_OK;
    for (size_t k = 0; k < sizeof line / sizeof *line && status == SP_OK; k++)
        status = sp_table_add_comment(t, err, "%s", line[k]);
    return status;
}

sp_status paper_rows_table(int64_t n, const paper_row *rows, sp_table *out, sp_error *err) {
    sp_table t = sp_table_none();
    sp_status status = add_comments(&t, err);
    if (status == SP_OK)
        status = add_columns(&t, err);
    for (int64_t k = 0; k < n && status == SP_OK; k++) {
        const paper_row *r = &rows[k];
        status = sp_table_add_row(&t, err, sp_paper_item_name(r->item), r->p, r->quantity, r->paper, r->paper_sd,
                                  r->ours, r->err, r->sigma, r->verdict, r->ours_sd, r->samples, r->combined,
                                  scatter_names[r->scatter]);
    }
    if (status != SP_OK) {
        sp_table_free(&t);
        return status;
    }
    *out = t;
    return SP_OK;
}
