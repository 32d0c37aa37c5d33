#ifndef SONOPACK_DESIGN_H
#define SONOPACK_DESIGN_H
/* Design: which grains of a packing to make heavier, stiffer or larger, within limits, so that the front arrives later
 * or earlier, or that little passes in a band of frequencies. Gradients are exact (sonopack/sensitivity.h). */

#include <sonopack/network.h>

#ifdef __cplusplus
extern "C" {
#endif

/* DELAY, ADVANCE: t_10 of the front as large, as small as possible. BAND: the energy of the signal between two
 * frequencies, the integral of |F(omega)|^2, as small as possible. */
typedef enum sp_design_goal { SP_DESIGN_DELAY = 0, SP_DESIGN_ADVANCE, SP_DESIGN_BAND } sp_design_goal;

/* What a grain's factor multiplies. MASS: its mass and moment of inertia; masses do not enter the balance of forces, so
 * that the packing at rest stays as it is. MODULUS: the modulus E* of its material; k_n ~ E12^(2/3) F^(1/3) of its
 * contacts follows by Hertz's law at the forces that they have, which the packing made of such grains need not have.
 * RADIUS: its radius; each candidate is compressed again, from the best one so far, so that forces and contacts are
 * those of a packing at rest. */
typedef enum sp_design_variable { SP_DESIGN_MASS = 0, SP_DESIGN_MODULUS, SP_DESIGN_RADIUS } sp_design_variable;

typedef struct sp_design_options {
    sp_design_goal goal;
    sp_design_variable vary;
    double low, high; /* limits of the factors, low <= 1 <= high, neither 1 while the total is kept; 0.5, 2 */
    bool free;        /* the total need not be kept. false: the total mass of the grains that carry force, the sum of
                         moduli, or to first order the total volume stays what it was */
    double band_low, band_high; /* of BAND [sqrt(E* / rho)/d] */
    double until;               /* of BAND: length of the signal; 0: sp_signal_window [d/sqrt(E* / rho)] */
    sp_network_options network;
    sp_source source;
    int32_t iterations; /* at most; 50 */
    double tolerance;   /* end when an iteration gains less than this part of the objective's gain so far; 1e-3 */
    int32_t threads;    /* does not change the result; 1 */
} sp_design_options;
SP_API sp_design_options sp_design_options_default(void);

/* One point of the way. */
typedef struct sp_design_step {
    double value; /* t_10, or the energy in the band over that of the start */
    double error; /* upper bound of its error */
    double
        predicted; /* what the gradient of the step before, times the change of the factors, promised; NAN at first */
    int64_t bound; /* factors at a limit */
} sp_design_step;

typedef struct sp_design {
    int32_t n;                   /* grains of the packing */
    double *factor;              /* [n] of each grain's mass, modulus or radius; 1 for rattlers */
    int32_t steps;               /* rows of `step` */
    sp_design_step *step;        /* [steps], the first is the packing as it was */
    double linear_predicted;     /* value promised by the first gradient for the best factors within the limits */
    double linear, linear_error; /* value that these factors really have; upper bound of its error */
    double effective; /* number of grains that share the first gradient: (sum |g|)^2 / sum g^2 over deviations from the
                         multiplier of the total */
    sp_packing packing; /* the packing made of these grains: `signal` and all other commands take it */
} sp_design;

SP_API sp_design sp_design_none(void);
SP_API void sp_design_free(sp_design *d);
/* Climbs by projected gradients, once from the packing and once from the factors that the first gradient makes best,
 * and keeps the better end: a local optimum. SP_EINVAL for options out of range. SP_EREFUSED where the signal has no
 * front or its derivatives are refused; for BAND, where the band is above all frequencies or its energy is not above
 * the error; for RADIUS, where the packing cannot be compressed. */
SP_API sp_status sp_design_make(const sp_packing *p, const sp_design_options *opt, sp_design *out, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
