#ifndef SP_PAPER_VERDICT_H
#define SP_PAPER_VERDICT_H
/* One row: a value of the paper and ours. */

#include <sonopack/table.h>
#include <stdbool.h>
#include <stdint.h>

/* The unit of sigma. */
typedef enum paper_scatter {
    PAPER_SCATTER_PAPER = 0, /* standard deviation given in the paper */
    PAPER_SCATTER_OURS,      /* standard deviation of our samples; the paper gives none */
    PAPER_SCATTER_STATED,    /* value stated in words: precision of the wording and our standard error */
    PAPER_SCATTER_BOUND,     /* lower bound: likewise, but 0 above it */
    PAPER_SCATTER_CLAIM      /* claim in words as a relation to a number: it holds or not, without sigma */
} paper_scatter;

/* What a claim states about our value. */
typedef enum paper_relation { PAPER_EQUAL = 0, PAPER_ABOVE, PAPER_BELOW } paper_relation;

typedef struct paper_row {
    int item;
    double p; /* NAN: no single pressure */
    char quantity[64];
    double paper, paper_sd; /* paper_sd: standard deviation or precision of the wording; NAN: none */
    paper_scatter scatter;
    double ours, ours_sd, err; /* mean, standard deviation, standard error; NAN: none */
    int64_t samples;           /* 0: not an average over samples */
    double digit;              /* unit of the last digit printed in the paper; 0: not rounded */
    paper_relation relation;   /* for claims; PAPER_EQUAL: within paper_sd */
    const char *where;         /* place in the paper; NULL: that of the item */
    char note[200];            /* the claim in words, and how ours is computed; "" for none */
    double sigma, combined;    /* set by sp_paper_judge, like the following fields */
    double deviation_err;      /* like combined, with the rounding error of the paper */
    const char *verdict;       /* "agrees" or "deviates"; for claims "holds", "contradicted" or "undecided" (within two
                                  standard errors of the limit); "missing" without a value or a scatter */
} paper_row;

enum { PAPER_SAMPLES = 30 }; /* at each pressure in the paper */

void sp_paper_judge(paper_row *row);
/* Standard deviation of what the paper's rounding took away: uniform within half of the last digit. */
double sp_paper_rounding(const paper_row *row);
bool sp_paper_is_claim(const paper_row *row);
/* Sets mean, standard deviation and standard error from n values. Values that are not finite are left out. */
void sp_paper_row_mean(paper_row *row, int64_t n, const double *values);

sp_status sp_paper_rows_table(int64_t n, const paper_row *rows, sp_table *out, sp_error *err);

#endif
