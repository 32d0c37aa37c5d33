#ifndef SP_PAPER_COUNTS_H
#define SP_PAPER_COUNTS_H
/* How many values of the paper agree with ours, by both measures, and where the differences have a system. */

#include "paper/verdict.h"

/* Values of an item, or of several. */
typedef struct paper_counts {
    int64_t values;                            /* that can be compared by one sample's scatter */
    int64_t agree;                             /* within one standard deviation of it */
    int64_t missing;                           /* no value of ours, or no scatter */
    int64_t judged, within1, beyond2, beyond3; /* by deviation_err */
    double chi2, chi2_bare; /* sums of squares of deviation_err, and of combined; NAN of stated numbers */
} paper_counts;

/* Which rows: means that the paper prints with its scatter or without, or numbers that it states in words. */
typedef enum paper_sort { PAPER_SORT_MEANS = 0, PAPER_SORT_STATED } paper_sort;

/* Of one item, or (item < 0) of all. Claims are never counted. */
paper_counts sp_paper_count(int64_t n, const paper_row *rows, int item, paper_sort sort);

typedef struct paper_claims {
    int64_t claims, hold, contradicted, undecided, missing;
} paper_claims;
paper_claims sp_paper_count_claims(int64_t n, const paper_row *rows);

/* One quantity at all its pressures. */
typedef struct paper_family {
    const paper_row *first;
    int64_t values;   /* that have a deviation_err */
    int side;         /* +1 or -1: all of ours are above, or below; 0: on both sides */
    double together;  /* sum of deviation_err over the root of their number: normal if each is */
    double least;     /* smallest |deviation_err| */
    double low, high; /* ours over the paper's, less one */
} paper_family;
/* The family that begins at rows[*at], and the row after it in *at. Families are rows in a row with one item and one
 * quantity, at pressures that differ. */
paper_family sp_paper_family_next(int64_t n, const paper_row *rows, int64_t *at);
/* Differences that chance does not explain: three values or more on one side and beyond three errors together, or on
 * both sides with none within two errors. */
bool sp_paper_is_systematic(const paper_family *f);

/* The counts, claims and families as comments of a table, one a line: "count: table1 values 40 ...". */
sp_status sp_paper_add_counts(int64_t n, const paper_row *rows, sp_table *t, sp_error *err);

#endif
