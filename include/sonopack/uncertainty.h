#ifndef SONOPACK_UNCERTAINTY_H
#define SONOPACK_UNCERTAINTY_H
/* How far errors of a measured packing carry into the sound computed from it: first order, from exact derivatives, and
 * Monte Carlo, from packings drawn with these errors.
 *
 * The grains of a real packing are known from photoelastic pictures or tomography, with errors. Errors of different
 * grains, contacts and directions are taken as independent and normally distributed. The box and the load are exact. */

#include <sonopack/network.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Where stiffnesses come from. FORCES: the normal force of each contact was measured by itself (photoelastic discs),
 * and k_n follows from it by Hertz's law; positions give the directions of contacts only, radii the lever arms, masses
 * and curvatures. OVERLAPS: nothing but positions and radii was measured; they decide which grains touch, and the
 * overlap R_i + R_j - r_ij gives k_n. An overlap is a small difference of large numbers, so that errors that do little
 * to the first kind of packing may destroy the second. */
typedef enum sp_measured { SP_MEASURED_FORCES = 0, SP_MEASURED_OVERLAPS } sp_measured;

/* Standard errors. 0: known exactly. */
typedef struct sp_errors {
    sp_measured measured;
    double position;    /* of each coordinate of each grain [d] */
    double radius;      /* of each radius [d] */
    double force;       /* of each normal force, relative (lognormal); FORCES only */
    double stiffness;   /* of each contact's stiffness, relative (lognormal); k_n and k_t together */
    double calibration; /* of all stiffnesses together, relative (lognormal): E*, or the calibration of all forces */
    bool mean_one;      /* these three factors have the mean 1; false: the median 1, so the mean exp(sd^2/2) */
    double false_part;  /* probability that a contact carries no force, although it is listed */
    double missing; /* probability that a pair of grains within `gap`, or a grain and a wall, carries force, although
                       it is not listed; FORCES only */
    double gap;     /* distance of the surfaces up to which a pair may touch, by its positions [d]; 0.01 */
    double missing_force; /* a missed contact carries up to this part of the mean normal force, all forces below it
                             being equally likely; 0.2 */
} sp_errors;
SP_API sp_errors sp_errors_default(void);

/* The kinds of errors, as they share in the first-order variance. */
typedef enum sp_error_kind {
    SP_ERROR_POSITION = 0,
    SP_ERROR_RADIUS,
    SP_ERROR_FORCE,
    SP_ERROR_STIFFNESS,
    SP_ERROR_CALIBRATION,
    SP_ERROR_FALSE,
    SP_ERROR_MISSING,
    SP_ERROR_KINDS
} sp_error_kind;

typedef struct sp_uncertainty_options {
    sp_errors errors;
    sp_network_options network;
    sp_source source;
    double margin;    /* layers left out of the density of the speeds c_l and c_t [d]; 3 */
    int32_t modes;    /* number of lowest frequencies, 0 or more; 0 */
    bool moduli;      /* true */
    bool first_order; /* false: Monte Carlo alone; true */
    bool parts;       /* makes by_grain and by_contact; false */
    int32_t samples;  /* drawn packings; 0: first order alone, else at least 10; 200 */
    uint64_t seed;    /* 1; sample k depends on the seed and k alone */
    int32_t threads;  /* does not change the result; 1 */
} sp_uncertainty_options;
SP_API sp_uncertainty_options sp_uncertainty_options_default(void);

/* Whether first order and Monte Carlo agree. NO: the standard deviations differ by more than three standard errors and
 * by more than 5%, or the mean is shifted by more than three of its standard errors and by more than half a standard
 * deviation (beyond the first-order shift), or more than 1 sample in 100 has no value. Differences of 1e-9 of the value
 * (of moduli: of the largest) are rounding. */
typedef enum sp_linear { SP_LINEAR_UNKNOWN = 0, SP_LINEAR_YES, SP_LINEAR_NO } sp_linear;

/* One quantity. */
typedef struct sp_uncertain {
    char name[24]; /* t10, t_peak, peak, width, c (the height over t10), C11 .., c_l, c_t, omega_1 .. */
    char unit[40];
    double value;                 /* without errors */
    double first_order;           /* standard deviation to first order; NAN if there are no derivatives */
    double shift;                 /* of the mean to first order, from false contacts; NAN as above */
    double share[SP_ERROR_KINDS]; /* of each kind in the first-order variance, together 1; NAN as above */
    double sd, sd_error;          /* standard deviation of the samples; its standard error */
    double bias, bias_error;      /* mean of the samples minus value; its standard error */
    int32_t samples;              /* those that have a value */
    sp_linear linear;
} sp_uncertain;

typedef struct sp_uncertainty {
    int32_t n;
    sp_uncertain *quantity; /* [n] */
    int32_t samples;        /* sets of errors that were drawn */
    int32_t loose;          /* of these: no network, no front, or no moduli, because no springs connect the walls */
    int32_t candidates;     /* pairs that a missing contact may join */
    double overlap;         /* mean overlap of the carrying contacts without errors [d] */
    double contacts, contacts_error; /* mean number of carrying contacts of the samples over that without errors; its
                                        standard error */
    /* With `parts`, of the network without errors: what single grains (position, radius) and springs (force, stiffness,
     * false) have of the first-order variance; with the share of the calibration all are 1 together. NAN as share. */
    int32_t grains, springs;
    int32_t *grain;          /* [grains] index in the packing */
    int32_t *pair;           /* [springs][2] grains of the packing that a spring joins, or a grain and a wall */
    double *by_grain;        /* [n][grains] */
    double *by_contact;      /* [n][springs] */
    char why[SP_ERROR_TEXT]; /* reason of the first sample that has no value */
} sp_uncertainty;

SP_API sp_uncertainty sp_uncertainty_none(void);
SP_API void sp_uncertainty_free(sp_uncertainty *u);
/* Computes the errors of the sound of a packing. Quantities that begin at a wall are left out in periodic cells. NAN
 * without a cause of errors. SP_EINVAL for errors and options out of range, and for force or missing with OVERLAPS.
 * SP_EREFUSED if the packing itself has no front or no network. */
SP_API sp_status sp_uncertainty_make(const sp_packing *p, const sp_uncertainty_options *opt, sp_uncertainty *out,
                                     sp_error *err);

/* A packing drawn with errors, as sample number `sample` (from 0) of a seed; sample < 0: without errors. With FORCES
 * every contact has a stiffness of its own, and its grains need not overlap. Free it. */
SP_API sp_status sp_packing_perturb(const sp_packing *p, const sp_errors *errors, uint64_t seed, int64_t sample,
                                    sp_packing *out, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
