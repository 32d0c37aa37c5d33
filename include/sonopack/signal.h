#ifndef SONOPACK_SIGNAL_H
#define SONOPACK_SIGNAL_H
/* The force on the top wall after a short pulse at the bottom wall (Eqs. (1) to (4) of Somfai et al. 2005). */

#include <sonopack/network.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum sp_signal_method {
    SP_SIGNAL_AUTO = 0,
    SP_SIGNAL_CHEBYSHEV,
    SP_SIGNAL_DENSE,
    SP_SIGNAL_VERLET,       /* time stepping, second order */
    SP_SIGNAL_LAX_WENDROFF, /* time stepping, fourth order */
    SP_SIGNAL_FABER,        /* expansion in matrix products that allows for damping */
    SP_SIGNAL_SPARSE,       /* the lowest modes, as many as the tolerance needs */
    SP_SIGNAL_DYNAMICS,     /* the packing's own nonlinear motion: sp_signal_dynamics */
} sp_signal_method;

typedef struct sp_signal_options {
    sp_signal_method method;
    sp_source source;
    double until;     /* last time; > 0 */
    int32_t points;   /* equally spaced times 0 .. until, >= 2 */
    double tolerance; /* error asked for, as a fraction of the largest |F| of each signal: 1e-10 */
    int32_t threads;  /* for networks large enough to gain by them; the same numbers for any: 1 */
    /* where; NULL: the whole wall, normal. All signals come from one pass. */
    int32_t sources, detectors; /* numbers of places; 0 or 1 with NULL */
    const sp_place *from, *to;
    double damping;   /* zeta, the dashpots' fraction of critical damping (sp_network_damping): M u'' + C u' + K u = 0,
                         and the force on a detector is that of springs and dashpots. 0: none */
    double amplitude; /* of dynamics: largest displacement of a grain at the start, or velocity over omega_max, over the
                         mean overlap of the carrying contacts; 0.001 */
    double step; /* of time stepping, made shorter so as to divide the spacing of the points; the error is then whatever
                    its bound says. 0: found from the tolerance */
    /* The signals end soon after their first fronts (Chebyshev only): they are followed in parts of 1/48 of `until`
       until sp_front_find, applied to what is known, gives every one of them a zero crossing and an amplitude above
       1e-6 of |a||b|/Omega, a and b source and detector with the mass. n is then smaller than `points`, all times and
       values are those of the longer signals. The rule's largest value is that of the part that was followed: a signal
       that goes on and becomes more than five times as large has another first peak by the rule than the part has. */
    bool front;
    int64_t modes; /* sparse: that many of the lowest modes of the network, and the error is then whatever its bound
                      says. 0: found from the tolerance, all of them if need be */
} sp_signal_options;
SP_API sp_signal_options sp_signal_options_default(void);

typedef struct sp_signal {
    int32_t n;
    int32_t sources, detectors;
    double *t;               /* [n] */
    double *f;               /* [sources][detectors][n] */
    double *errors;          /* [sources][detectors] bound of the error of f, in units of f */
    double error;            /* the largest of them */
    double omega_max;        /* bound of the spectrum that was used */
    int32_t products;        /* matrix products (0 for dense) */
    double step;             /* of time stepping; 0 for other methods */
    double amplitude;        /* of dynamics: what the first source was multiplied with; 0 for other methods */
    sp_signal_method method; /* the one that was used */
    int64_t modes;           /* sparse: that were summed; 0 for other methods */
} sp_signal;

SP_API const char *sp_signal_method_name(sp_signal_method method); /* "chebyshev"; NULL for none */

SP_API sp_signal sp_signal_none(void);
/* SP_EREFUSED if the error bound exceeds the tolerance. */
SP_API sp_status sp_signal_make(const sp_network *net, const sp_signal_options *opt, sp_signal *out, sp_error *err);
/* The same for every method, SP_SIGNAL_DYNAMICS among them, which needs the packing that the network was made of: the
 * motion from rest of all its grains and contacts, which open, close and slide, after the source times the amplitude; F
 * is the change of the force over that factor. Errors are estimates, from steps twice as long. SP_EFAILED if a grain
 * moves too far for the packing to be itself. */
SP_API sp_status sp_signal_dynamics(const sp_packing *p, const sp_network *net, const sp_signal_options *opt,
                                    sp_signal *out, sp_error *err);
SP_API void sp_signal_free(sp_signal *s);

/* What the displacements of all grains are wanted for. */
typedef struct sp_field_options {
    sp_source source;
    const sp_place *from; /* NULL: the whole bottom wall, normal */
    int32_t times;
    const double *t; /* [times] >= 0, in any order */
    int threads;     /* 0 and 1: none beside the caller's */
} sp_field_options;
/* The displacement field after the pulse, u [times][dofs of the network], Eq. (2) of Somfai et al. 2005, as the
 * Chebyshev expansion u(t) = (2/Omega) sum_k J_(2k+1)(Omega t) W_k M^-1 a of momenta a (displacements: 2 sum J_2k T_k
 * u_0): no modes, one pass for all times. errors [times], or NULL: bounds of the error of any entry of u(t).
 * SP_EREFUSED for an unstable network. */
SP_API sp_status sp_signal_field(const sp_network *net, const sp_field_options *spec, double *u, double *errors,
                                 sp_error *err);

/* The time in which the first front certainly has passed: [0, 8 H + 40] at p = 1e-4, scaled with p^(-1/6). */
SP_API double sp_signal_window(double height, double pressure);

#ifdef __cplusplus
}
#endif
#endif
