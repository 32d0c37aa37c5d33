#ifndef SP_PAPER_VERDICT_H
#define SP_PAPER_VERDICT_H
/* A value of the paper beside ours. */

#include <sonopack/table.h>
#include <stdint.h>

/* What one unit of sigma is. */
typedef enum paper_scatter {
    PAPER_SCATTER_PAPER = 0, /* the standard deviation that the paper gives */
    PAPER_SCATTER_OURS,      /* the paper gives none: that of our samples */
    PAPER_SCATTER_STATED,    /* a value without scatter: the precision of the wording, and our standard error */
    PAPER_SCATTER_BOUND      /* a lower bound: likewise, and 0 above it */
} paper_scatter;

typedef struct paper_row {
    int item;
    double p; /* NAN: of no single pressure */
    char quantity[48];
    double paper, paper_sd; /* paper_sd: standard deviation, or precision of the wording; NAN: none */
    paper_scatter scatter;
    double ours, ours_sd, err; /* mean, standard deviation, standard error; NAN where there is none */
    int64_t samples;           /* 0: not of samples */
    double sigma, combined;    /* filled in by paper_judge */
    const char *verdict;       /* likewise: "agrees", "deviates", or "missing" without a value or a scatter */
} paper_row;

enum { PAPER_SAMPLES = 30 }; /* of each pressure in the paper */

void paper_judge(paper_row *row);
/* Ours from n values: mean, standard deviation, standard error. Values that are not finite are left out. */
void paper_row_mean(paper_row *row, int64_t n, const double *values);

sp_status paper_rows_table(int64_t n, const paper_row *rows, sp_table *out, sp_error *err);

#endif
