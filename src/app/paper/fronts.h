#ifndef SP_PAPER_FRONTS_H
#define SP_PAPER_FRONTS_H
/* Fronts against distance, for boxes of several heights and for chains. */

#include "paper/paper.h"

/* A mean with its standard error. */
typedef struct paper_mean {
    double mean, sd, err;
} paper_mean;

/* Averages over boxes of one height, or chains of one length. */
typedef struct paper_distance {
    paper_ensemble ensemble;
    int32_t grains;
    int64_t n; /* samples with a front */
    double distance;
    paper_mean t10, t_peak, t_zero, amplitude, width; /* width = t_zero - t10 */
} paper_distance;

enum { PAPER_DISTANCES = 6 };
/* Averages over boxes of 100 to 2400 grains at p = 1e-4, and over the chains of an ensemble, sorted by distance.
 * Distances without fronts are left out. */
sp_status sp_paper_heights(const paper *p, int *n, paper_distance out[PAPER_DISTANCES], sp_error *err);
/* Range d[first .. end) of boxes for line fits: from L = 8, the lower height in the paper, up to L = 60 or to the end.
 * The paper does not state where its figures end. */
typedef struct paper_range {
    int first, end;
} paper_range;
paper_range sp_paper_fitted(int n, const paper_distance *d, bool all);
sp_status sp_paper_chains(const paper *p, paper_ensemble e, int *n, paper_distance out[PAPER_DISTANCES], sp_error *err);

/* Least-squares line through points of equal weight. err follows from the errors of the points (0 for points without).
 * NAN for fewer than two points. */
typedef struct paper_line {
    double slope, intercept, err;
} paper_line;
paper_line sp_paper_line_fit(int n, const double *x, const double *y, const double *y_err);
/* Line through ln mean against ln distance. */
paper_line sp_paper_power(int n, const paper_distance *d, const paper_mean *(*of)(const paper_distance *d));
const paper_mean *sp_paper_amplitude(const paper_distance *d);
const paper_mean *sp_paper_width(const paper_distance *d);

#endif
