#ifndef SONOPACK_SCALING_H
#define SONOPACK_SCALING_H
/* How the first front goes with distance: speeds, and the exponents of amplitude and width (Table III of Somfai et al.
 * 2005), with errors. From plain arrays, whatever the fronts come from (docs/physics.md, "Front statistics"). */

#include <sonopack/front.h>
#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Fronts at `rows` distances, that ascend in the mean. Marks that are NAN are missing, and left out of the means. */
typedef struct sp_scaling_input {
    int rows;
    const int64_t *samples;        /* [rows] */
    const double *const *distance; /* [rows][samples] */
    const sp_front *const *front;  /* [rows][samples] */
    /* The rows are of the same packings, sample k of every row of packing k: the bootstrap draws packings. Else the
     * rows are independent, and each is drawn by itself. */
    bool joint;
} sp_scaling_input;

/* A value and its standard error; NAN where there is none. */
typedef struct sp_estimate {
    double value, error;
} sp_estimate;

typedef struct sp_scaling_row {
    int64_t samples; /* that have a t10 */
    sp_estimate distance, t10, t_peak, t_zero;
    sp_estimate amplitude;     /* arithmetic mean */
    sp_estimate log_amplitude; /* mean of ln A */
    sp_estimate width;         /* t_zero - t10 */
    sp_estimate width_peak;    /* t_zero - t_peak */
    /* of the interval to the next row; NAN in the last row */
    double between;                            /* geometric mean of the two distances, where the exponents belong */
    sp_estimate speed, speed_peak, speed_zero; /* from <t10>, <t_peak>, <t_zero>; NAN where time does not grow */
    sp_estimate gamma;                         /* -d ln <A> / d ln L */
    sp_estimate alpha, alpha_peak;             /* d ln <W> / d ln L of both widths */
} sp_scaling_row;

/* A straight line through all rows that have the mean: of logarithms, prefactor x L^exponent, or of t10 over L. Weights
 * from the standard errors of the rows (of y - slope x, so that samples at unlike distances do not count as scatter);
 * equal weights where a row has no error. */
typedef struct sp_scaling_fit {
    sp_estimate value; /* gamma, alpha or a speed, and its bootstrap error */
    double fit_error;  /* what least squares say: from the rows' errors, or without these from the scatter */
    double prefactor;  /* of the power law; of the speed: t10 at L = 0 */
    double chi2;       /* NAN for equal weights; only a hint for joint rows, which are correlated */
    int64_t freedom;   /* rows - 2 */
} sp_scaling_fit;

typedef struct sp_scaling {
    int rows;
    sp_scaling_row *row;
    bool joint;
    sp_scaling_fit gamma, gamma_log; /* of <A>, and of exp <ln A> */
    sp_scaling_fit alpha, alpha_peak;
    sp_scaling_fit speed; /* of t10 */
} sp_scaling;

/* Means with sd/sqrt(n) as error, all else with bootstrap errors over samples or packings: NAN where a row has fewer
 * than two. SP_EINVAL for no rows, joint rows of unlike numbers, distances that are not positive or do not ascend. */
SP_API sp_status sp_scaling_make(const sp_scaling_input *in, sp_scaling *out, sp_error *err);
SP_API void sp_scaling_free(sp_scaling *s);

#ifdef __cplusplus
}
#endif
#endif
