/* Judges our values against those of the paper. */
#include "paper/verdict.h"

#include <math.h>

static double known(double x) { return isfinite(x) ? x : 0; }

static double one_sigma(const paper_row *row) {
    switch (row->scatter) {
    case PAPER_SCATTER_PAPER: return row->paper_sd;
    case PAPER_SCATTER_OURS: return row->ours_sd;
    case PAPER_SCATTER_STATED:
    case PAPER_SCATTER_BOUND:
    case PAPER_SCATTER_CLAIM: break;
    }
    return hypot(row->paper_sd, known(row->err));
}

/* Standard error of the paper's value. */
static double paper_error(const paper_row *row) {
    switch (row->scatter) {
    case PAPER_SCATTER_PAPER: return row->paper_sd / sqrt(PAPER_SAMPLES);
    case PAPER_SCATTER_OURS: return row->ours_sd / sqrt(PAPER_SAMPLES);
    case PAPER_SCATTER_STATED:
    case PAPER_SCATTER_BOUND:
    case PAPER_SCATTER_CLAIM: break;
    }
    return row->paper_sd;
}

double sp_paper_rounding(const paper_row *row) { return row->digit / sqrt(12); }

bool sp_paper_is_claim(const paper_row *row) { return row->scatter == PAPER_SCATTER_CLAIM; }

static const double decided = 2; /* a claim is decided at this many standard errors from its limit */

static void judge_claim(paper_row *row) {
    double inside = row->ours - row->paper; /* distance of ours from the limit, positive if the claim holds */
    if (row->relation == PAPER_BELOW)
        inside = -inside;
    else if (row->relation == PAPER_EQUAL)
        inside = row->paper_sd - fabs(inside);
    row->sigma = row->combined = row->deviation_err = NAN;
    if (!isfinite(inside) || !isfinite(row->err))
        row->verdict = "missing";
    else if (fabs(inside) < decided * row->err)
        row->verdict = "undecided";
    else
        row->verdict = inside >= 0 ? "holds" : "contradicted";
}

void sp_paper_judge(paper_row *row) {
    if (sp_paper_is_claim(row)) {
        judge_claim(row);
        return;
    }
    double difference = row->ours - row->paper;
    if (row->scatter == PAPER_SCATTER_BOUND && difference > 0)
        difference = 0;
    row->sigma = difference / one_sigma(row);
    const double errors = hypot(paper_error(row), row->err);
    row->combined = isfinite(row->err) ? difference / errors : NAN;
    row->deviation_err = isfinite(row->err) ? difference / hypot(errors, sp_paper_rounding(row)) : NAN;
    if (!isfinite(row->sigma))
        row->verdict = "missing";
    else
        row->verdict = fabs(row->sigma) <= 1 ? "agrees" : "deviates";
}

void sp_paper_row_mean(paper_row *row, int64_t n, const double *values) {
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
