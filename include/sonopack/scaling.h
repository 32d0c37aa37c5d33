#ifndef SONOPACK_SCALING_H
#define SONOPACK_SCALING_H
/* The first front as a function of distance: speeds, and the exponents of amplitude and width (Table III of Somfai et
 * al. 2005), with errors. Input: plain arrays of fronts of any origin (docs/physics.md, "Front statistics"). */

#include <sonopack/front.h>
#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Fronts at `rows` distances; mean distances ascend. NAN marks a missing value, which is left out of the means. */
typedef struct sp_scaling_input {
    int rows;
    const int64_t *samples;        /* [rows] */
    const double *const *distance; /* [rows][samples] */
    const sp_front *const *front;  /* [rows][samples] */
    /* true: sample k of all rows is from the same packing, and the bootstrap resamples packings. false: the rows are
     * independent, and each is resampled on its own. */
    bool joint;
} sp_scaling_input;

/* A value and its standard error; NAN if unknown. */
typedef struct sp_estimate {
    double value, error;
} sp_estimate;

typedef struct sp_scaling_row {
    int64_t samples; /* samples with a t10 */
    sp_estimate distance, t10, t_peak, t_zero;
    sp_estimate amplitude;     /* arithmetic mean */
    sp_estimate log_amplitude; /* mean of ln A */
    sp_estimate width;         /* t_zero - t10 */
    sp_estimate width_peak;    /* t_zero - t_peak */
    /* for the interval to the next row; NAN in the last row */
    double between;                            /* geometric mean of the two distances */
    sp_estimate speed, speed_peak, speed_zero; /* from <t10>, <t_peak>, <t_zero>; NAN if the time does not increase */
    sp_estimate gamma;                         /* -d ln <A>/d ln L */
    sp_estimate alpha, alpha_peak;             /* d ln <W>/d ln L of both widths */
} sp_scaling_row;

/* A straight line through all rows for which the mean exists: of logarithms, prefactor x L^exponent, or of t10 against
 * L. Weights come from the standard errors of y - slope x in each row, so that unequal distances of samples do not
 * count as scatter. All weights are equal if a row has no error. */
typedef struct sp_scaling_fit {
    sp_estimate value; /* gamma, alpha or a speed, with its bootstrap error */
    double fit_error;  /* least-squares error: from the errors of the rows, or from the scatter if these are unknown */
    double prefactor;  /* of the power law; for the speed: t10 at L = 0 */
    double chi2;       /* NAN for equal weights; only a rough guide for joint rows, which are correlated */
    int64_t freedom;   /* degrees of freedom: rows - 2 */
} sp_scaling_fit;

typedef struct sp_scaling {
    int rows;
    sp_scaling_row *row;
    bool joint;
    sp_scaling_fit gamma, gamma_log; /* of <A>, and of exp <ln A> */
    sp_scaling_fit alpha, alpha_peak;
    sp_scaling_fit speed; /* from t10 */
} sp_scaling;

/* Errors of means are sd/sqrt(n). All other errors come from the bootstrap over samples or packings and are NAN if a
 * row has fewer than two. SP_EINVAL without rows, for joint rows with different numbers of samples, and unless
 * distances are positive and their means ascend. */
SP_API sp_status sp_scaling_make(const sp_scaling_input *in, sp_scaling *out, sp_error *err);
SP_API void sp_scaling_free(sp_scaling *s);

#ifdef __cplusplus
}
#endif
#endif
