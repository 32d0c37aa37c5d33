#ifndef SP_PAPER_COUNTS_H
#define SP_PAPER_COUNTS_H
/* Counts of values that agree with the paper, and systematic differences. */

#include "paper/verdict.h"

/* Counts over the rows of one or all items. */
typedef struct paper_counts {
    int64_t values;                            /* values with a sigma */
    int64_t agree;                             /* within one sigma */
    int64_t missing;                           /* without a value of ours, or without scatter */
    int64_t judged, within1, beyond2, beyond3; /* counts of |deviation_err|: all, below 1, above 2, above 3 */
    double chi2, chi2_bare; /* sums of squares of deviation_err and of combined; NAN for stated numbers */
} paper_counts;

/* Kinds of rows: means that the paper prints in tables, or numbers that it states in words. */
typedef enum paper_sort { PAPER_SORT_MEANS = 0, PAPER_SORT_STATED } paper_sort;

/* Counts the rows of an item, or of all items if item < 0. Claims are not counted. */
paper_counts sp_paper_count(int64_t n, const paper_row *rows, int item, paper_sort sort);

typedef struct paper_claims {
    int64_t claims, hold, contradicted, undecided, missing;
} paper_claims;
paper_claims sp_paper_count_claims(int64_t n, const paper_row *rows);

/* One quantity at all its pressures. */
typedef struct paper_family {
    const paper_row *first;
    int64_t values;   /* values with a deviation_err */
    int side;         /* +1: all of ours are above, -1: all are below, 0: both */
    double together;  /* sum of deviation_err over the square root of their number; normally distributed if each is */
    double least;     /* smallest |deviation_err| */
    double low, high; /* range of ours/paper - 1 */
} paper_family;
/* Returns the family that begins at rows[*at] and advances *at to the row after it. A family is a run of rows with the
 * same item and quantity and different pressures. */
paper_family sp_paper_family_next(int64_t n, const paper_row *rows, int64_t *at);
/* Whether chance is unlikely to explain the differences: three or more values on one side that together exceed three
 * errors, or values on both sides that all exceed two errors. */
bool sp_paper_is_systematic(const paper_family *f);

/* Adds counts, claims and families to a table as comments, one per line: "count: table1 values 40 ...". */
sp_status sp_paper_add_counts(int64_t n, const paper_row *rows, sp_table *t, sp_error *err);

#endif
