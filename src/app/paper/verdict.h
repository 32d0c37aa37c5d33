#ifndef SP_PAPER_VERDICT_H
#define SP_PAPER_VERDICT_H
/* A value of the paper beside ours. */

#include <sonopack/table.h>
#include <stdbool.h>
#include <stdint.h>

/* What one unit of sigma is. */
typedef enum paper_scatter {
    PAPER_SCATTER_PAPER = 0, /* the standard deviation that the paper gives */
    PAPER_SCATTER_OURS,      /* the paper gives none: that of our samples */
    PAPER_SCATTER_STATED,    /* a value without scatter: the precision of the wording, and our standard error */
    PAPER_SCATTER_BOUND,     /* a lower bound: likewise, and 0 above it */
    PAPER_SCATTER_CLAIM      /* a claim in words as a relation to a number: it holds or not, no sigma */
} paper_scatter;

/* What a claim says of ours. */
typedef enum paper_relation { PAPER_EQUAL = 0, PAPER_ABOVE, PAPER_BELOW } paper_relation;

typedef struct paper_row {
    int item;
    double p; /* NAN: of no single pressure */
    char quantity[64];
    double paper, paper_sd; /* paper_sd: standard deviation, or precision of the wording; NAN: none */
    paper_scatter scatter;
    double ours, ours_sd, err; /* mean, standard deviation, standard error; NAN where there is none */
    int64_t samples;           /* 0: not of samples */
    double digit;              /* one unit of the last digit that the paper prints; 0: it is not rounded */
    paper_relation relation;   /* of claims; equal: within paper_sd */
    const char *where;         /* in the paper; NULL: where the item is */
    char note[200];            /* the claim in words, how ours is found; "" none */
    double sigma, combined;    /* filled in by sp_paper_judge, as what follows */
    double deviation_err;      /* as combined, with the rounding of print */
    const char *verdict; /* "agrees", "deviates"; of claims "holds", "contradicted", "undecided" (ours lies within two
                            standard errors of the limit); "missing" without a value or a scatter */
} paper_row;

enum { PAPER_SAMPLES = 30 }; /* of each pressure in the paper */

void sp_paper_judge(paper_row *row);
/* Standard deviation of what the paper's rounding took away: uniform within half of the last digit. */
double sp_paper_rounding(const paper_row *row);
bool sp_paper_is_claim(const paper_row *row);
/* Ours from n values: mean, standard deviation, standard error. Values that are not finite are left out. */
void sp_paper_row_mean(paper_row *row, int64_t n, const double *values);

sp_status sp_paper_rows_table(int64_t n, const paper_row *rows, sp_table *out, sp_error *err);

#endif
