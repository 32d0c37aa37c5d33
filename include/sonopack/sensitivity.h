#ifndef SONOPACK_SENSITIVITY_H
#define SONOPACK_SENSITIVITY_H
/* Sensitivities: exact derivatives of signals, first fronts, frequencies and moduli with respect to the stiffness of
 * each contact, the mass, radius and position of each grain, and the pressure. K is symmetric, so that the fields of
 * source and detector give the derivatives for all contacts at once (docs/sensitivity.md).
 *
 * Everything here needs a symmetric K: SP_EREFUSED for a network with tangential forces at rest under prestress, and
 * for damping. */

#include <sonopack/elastic.h>
#include <sonopack/front.h>
#include <sonopack/modes.h>
#include <sonopack/pulse.h>
#include <sonopack/signal.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What a quantity Q is differentiated by. Combine them with |.
 *
 * KN, KT: stiffness of one spring; everything else is held. The source and the detector belong to the network: the
 * momentum of a bottom grain is k_n of its wall contact, and changes with it. Without tangential springs the
 * derivative with respect to k_t is left out.
 * MASS: mass of one grain, its moment of inertia in proportion.
 * RADIUS, POSITION: radius of one grain at fixed centres, coordinates of one centre at fixed radii; walls and the cell
 * are held. The contact law then gives overlaps, k_n, k_t = eta k_n, and under prestress the force and k_p. No contact
 * is made or lost. The mass of a sphere of unit density follows its radius; masses of their own are held, with moments
 * of inertia in proportion to the square of the radius. Contacts with a stiffness of their own keep it, and under
 * prestress change their force by it.
 * PRESSURE: the pressure of the packing. The load on the walls (on the cell, where it is periodic) is changed, the
 * grains follow by the linear response of the springs, tangential springs and forces at rest included (whether or not
 * the network has the latter), and the change of their positions and of the height (of the cell) changes the network as
 * POSITION does. No contact slides, is made or lost.
 */
typedef enum sp_parameter {
    SP_BY_KN = 1,
    SP_BY_KT = 2,
    SP_BY_MASS = 4,
    SP_BY_RADIUS = 8,
    SP_BY_POSITION = 16,
    SP_BY_PRESSURE = 32
} sp_parameter;

/* Derivatives of one quantity with respect to one kind of parameter. */
typedef struct sp_partials {
    int64_t n;     /* 0: not computed */
    double *d;     /* [n] derivatives */
    double *error; /* [n] upper bounds of their errors */
} sp_partials;

/* Derivatives of a quantity Q. Springs are those of the network (sp_spring.contact is the contact of the packing),
 * grains too (sp_network.grain). */
typedef struct sp_gradient {
    double value, error;  /* Q, and an upper bound of its error */
    sp_partials kn, kt;   /* [springs] */
    sp_partials mass;     /* [grains] */
    sp_partials radius;   /* [grains] */
    sp_partials position; /* [grains][3], 0 on unused axes */
    sp_partials pressure; /* [1] */
    /* Check by Euler's theorem. If all springs (k_n, k_t, k_p) are multiplied by s, Q changes in a way that is known
     * from Q alone, such as t_10 -> t_10/sqrt(s). `homogeneity` is the sum of k dQ/dk over all springs minus the
     * derivative of that law; it is 0 but for rounding errors. `homogeneity_size`: the sum of their absolute values.
     * Only for gradients with KN and, where there are tangential springs, KT; NAN otherwise. */
    double homogeneity, homogeneity_size;
} sp_gradient;

SP_API sp_gradient sp_gradient_none(void);
SP_API void sp_gradient_free(sp_gradient *g);

/* ---- signals ------------------------------------------------------------------------------------------------------
 */

typedef struct sp_sensitivity_options {
    unsigned parameters; /* of sp_parameter, combined with |; KN | KT */
    sp_source source;
    const sp_place *from, *to; /* NULL: the whole bottom wall, the whole top wall; normal component */
    const sp_pulse *pulse;     /* NULL: the short pulse */
    double until;   /* of a front: last time of its search; 0: sp_signal_window, for the height of the packing */
    int32_t points; /* of a front: points of the signal in which it is sought, before it is refined on the continuous
                       signal; 2000 */
    sp_front_options front;
    int threads;               /* number of threads; 0 counts as 1 */
    const sp_packing *packing; /* the packing from which the network was made. Needed for RADIUS, POSITION and PRESSURE;
                                  NULL: unknown */
} sp_sensitivity_options;
SP_API sp_sensitivity_options sp_sensitivity_options_default(void);

/* A linear functional of the signal, J = sum of weight x the derivative of F of this order at time t. */
typedef struct sp_functional {
    int64_t n;
    const double *t;      /* [n] >= 0 */
    const double *weight; /* [n] */
    const int *order;     /* [n] 0: F, 1: dF/dt, 2: d2F/dt2; NULL: all 0. Pulses allow the same */
} sp_functional;

/* Values and gradients of `count` functionals of the signal of this network: out [count]. The expansion runs forward
 * once for all of them, and back once for each. Errors: remainder of the series and estimates of rounding, as those of
 * signals. SP_EINVAL, SP_EREFUSED for an unstable network and for a source or detector that meets no spring along it,
 * whose signal is 0, SP_ENOMEM. */
SP_API sp_status sp_sensitivity_signal(const sp_network *net, const sp_sensitivity_options *opt, int32_t count,
                                       const sp_functional *functional, sp_gradient *out, sp_error *err);

/* Quantities of the first front. Combine them with |. They are those of sp_front_find in the limit of dense points: the
 * peak is a maximum of F(t), t_10 the first time at `rise` times the peak, and so on. */
typedef enum sp_front_quantity {
    SP_FRONT_T10 = 1,
    SP_FRONT_T_PEAK = 2,
    SP_FRONT_PEAK = 4,
    SP_FRONT_T_ZERO = 8,
    SP_FRONT_WIDTH = 16
} sp_front_quantity;

typedef struct sp_front_gradient {
    sp_front found;   /* the front on the continuous signal */
    sp_front sampled; /* the front as sp_front_find gives it from the points */
    double t10_error, t_peak_error, peak_error, t_zero_error, width_error; /* upper bounds for `found` */
    sp_gradient t10, t_peak, peak, t_zero, width; /* those asked for; the others are sp_gradient_none */
} sp_front_gradient;

/* The front and gradients of its quantities. SP_EREFUSED as sp_front_find, and where a derivative does not exist within
 * the errors of the signal: a flat peak, or a signal that only touches the level. T_ZERO and WIDTH are refused without
 * a zero crossing. */
SP_API sp_status sp_sensitivity_front(const sp_network *net, const sp_sensitivity_options *opt, unsigned quantities,
                                      sp_front_gradient *out, sp_error *err);
SP_API void sp_front_gradient_free(sp_front_gradient *g);

/* dF(t)/dk_n and dF(t)/dk_t of chosen springs at all given times: one expansion of the source and one of the detector
 * serve all springs. kn, kt: [springs][times], either may be NULL; error: [springs][2] upper bounds for all times of
 * a spring, of kn and of kt, or NULL. spring: [springs] indices in the network; NULL: all. Delta pulses only. */
SP_API sp_status sp_sensitivity_times(const sp_network *net, const sp_sensitivity_options *opt, int32_t springs,
                                      const int32_t *spring, int32_t times, const double *t, double *kn, double *kt,
                                      double *error, sp_error *err);

/* ---- frequencies --------------------------------------------------------------------------------------------------
 */

/* Gradient of Q = the mean of omega^2 over rows first .. first + count - 1 of modes with vectors. For one row: the
 * derivative of its omega^2. Modes of one frequency have derivatives only as a group; so do modes so close that their
 * vectors are not known. SP_EREFUSED if a mode outside the group is too close for that: take it into the group. error:
 * first order in the errors of the vectors, which are those of the space of the group. */
SP_API sp_status sp_sensitivity_modes(const sp_network *net, const sp_modes *modes, int64_t first, int64_t count,
                                      unsigned parameters, const sp_packing *packing, sp_gradient *out, sp_error *err);

/* ---- moduli -------------------------------------------------------------------------------------------------------
 */

/* Moduli and speeds of sp_moduli. The speeds are NAN there without a density. */
typedef enum sp_modulus {
    SP_MODULUS_C11 = 0,
    SP_MODULUS_C12,
    SP_MODULUS_C22,
    SP_MODULUS_C33,
    SP_MODULUS_C13,
    SP_MODULUS_C23,
    SP_MODULUS_C44,
    SP_MODULUS_C55,
    SP_MODULUS_C66,
    SP_MODULUS_CL,
    SP_MODULUS_CT
} sp_modulus;
enum { SP_MODULUS_COUNT = 11 };

/* Gradients of `count` moduli or speeds: out [count]. One solve for each strain serves all contacts. density: as phi3s
 * of sp_moduli_make, for speeds; it is held, also where masses and radii change, so that its own change is left to the
 * caller: d c/c = -d density/(2 density). SP_EINVAL for a modulus that does not exist in this dimension; otherwise
 * refuses as sp_moduli_make. */
SP_API sp_status sp_sensitivity_moduli(const sp_network *net, double density, int32_t count, const sp_modulus *of,
                                       unsigned parameters, const sp_packing *packing, sp_gradient *out, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
