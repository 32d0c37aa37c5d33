#ifndef SONOPACK_CODA_H
#define SONOPACK_CODA_H
/* Coda-wave interferometry: where a small change of stiffness happened, from the change of signals, most of all of
 * their late part (the coda), which has passed every place many times.
 *
 * The kernel of a grain is the exact derivative of the signal at all times by the logarithm of the stiffness of all its
 * contacts. A change in one place is sought as the grain whose kernel, times one amplitude, fits the change best. */

#include <sonopack/network.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sp_coda_options {
    sp_source source;
    int32_t sources, detectors; /* number of places; 0 or 1 with NULL: the whole wall, normal component */
    const sp_place *from, *to;
    int32_t times;
    const double *t; /* [times] ascending, >= 0: the window that is compared */
    int threads;     /* does not change the result; 0 counts as 1 */
} sp_coda_options;

/* Kernels of the grains of a network. */
typedef struct sp_coda {
    int32_t n, pairs, times; /* grains of the network; pairs of source and detector, detectors running fastest; times of
                                each signal */
    int32_t *grain;          /* [n] index in the packing */
    double *kernel;          /* [pairs][n][times] dF/d(ln k) */
    double *square;          /* [n] sum of squares of a grain's kernel over pairs and times */
} sp_coda;

SP_API sp_coda sp_coda_none(void);
SP_API void sp_coda_free(sp_coda *c);
/* SP_EREFUSED as sp_sensitivity_times; SP_EINVAL for times that do not ascend; SP_ENOMEM. */
SP_API sp_status sp_coda_make(const sp_network *net, const sp_coda_options *opt, sp_coda *out, sp_error *err);

/* One grain as the place of the change. */
typedef struct sp_coda_candidate {
    int32_t grain;        /* index in the packing */
    double change, error; /* relative change of the stiffness of its contacts that fits best, and its standard error, of
                           * noise alone: the kernel is of first order, and sp_coda_signal tells how far it holds */
    double misfit;        /* part of the squared change of the signals that it leaves unexplained */
    double probability;   /* of being the place, for white noise, if each grain is equally likely beforehand */
} sp_coda_candidate;

/* Fits a change [pairs][times] of the signals by each grain alone. out [n], the most probable first. noise: standard
 * deviation of each value of the change; 0, or where the best fit leaves more: what it leaves, with its correlation.
 * SP_EREFUSED for a change of 0, and where no kernel differs from 0; SP_EINVAL for numbers that are not finite. */
SP_API sp_status sp_coda_locate(const sp_coda *c, const double *change, double noise, sp_coda_candidate *out,
                                sp_error *err);

/* signal [pairs][times] of the network in which the stiffness of all contacts of a grain (index in the packing) is
 * multiplied by 1 + change; grain < 0: of the network as it is. SP_EINVAL for a grain that is not in the network, and
 * for a change of -1 or below. */
SP_API sp_status sp_coda_signal(const sp_network *net, const sp_coda_options *opt, int32_t grain, double change,
                                double *signal, sp_error *err);

/* Adds to the error of a candidate what its kernel, which is of first order, leaves out: how far the change that the
 * kernel finds in the signal of a packing with this very change is from it. Without noise this is the larger error.
 * before [pairs][times]: the signal of the network as it is, from sp_coda_signal; opt: that of c. */
SP_API sp_status sp_coda_first_order(const sp_network *net, const sp_coda_options *opt, const sp_coda *c,
                                     const double *before, sp_coda_candidate *found, sp_error *err);

/* Relative change of speed that stretches `before` to `before + change` [times], by least squares to first order, and
 * its standard error. NAN where `before` does not change with time. */
SP_API void sp_coda_stretch(int32_t times, const double *t, const double *before, const double *change, double *stretch,
                            double *error);

#ifdef __cplusplus
}
#endif
#endif
