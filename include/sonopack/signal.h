#ifndef SONOPACK_SIGNAL_H
#define SONOPACK_SIGNAL_H
/* The signal: the force on the top wall after a short pulse at the bottom wall (Eqs. (1) to (4) of Somfai et al. 2005).
 */

#include <sonopack/modes.h>
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
    SP_SIGNAL_FABER,        /* Faber expansion: matrix products, with or without damping */
    SP_SIGNAL_SPARSE,       /* sum over the lowest modes, as many as the tolerance needs */
    SP_SIGNAL_DYNAMICS,     /* nonlinear motion of the packing: sp_signal_compute */
} sp_signal_method;

typedef struct sp_signal_options {
    sp_signal_method method;
    sp_source source;
    double until;     /* last time, > 0 */
    int32_t points;   /* number of equally spaced times from 0 to until, >= 2 */
    double tolerance; /* allowed error, as a fraction of the largest |F| of each signal; 1e-10 */
    int32_t threads;  /* number of threads, used for large networks; does not change the result; 1 */
    /* Places of sources and detectors. NULL: the whole wall, normal component. All signals are computed in one pass. */
    int32_t sources, detectors; /* number of places; 0 or 1 with NULL */
    const sp_place *from, *to;
    double damping;   /* zeta, the fraction of critical damping of a contact, or the value of another damping_kind
                         (sp_network_dashpots). The motion is M u'' + C u' + K u = 0, and dashpots contribute to the force
                         on a detector. 0: none */
    double amplitude; /* dynamics: largest initial displacement of a grain, or velocity over omega_max, over the mean
                         overlap of the carrying contacts; 0.001 */
    double step; /* time stepping: upper limit of the time step, shortened so that it divides the spacing of the points;
                    the error bound may then exceed the tolerance. 0: chosen from the tolerance */
    /* End the signals soon after their first fronts (Chebyshev only). The signals are computed in parts of until/48.
     * They end when sp_front_find gives each of them a zero crossing and an amplitude above 1e-6 |a||b|/Omega, where a
     * and b are the source and the detector in the metric of the masses. n is then smaller than `points`; the times and
     * values are those of the longer signals. The largest value that sp_front_find uses is that of the shortened
     * signal. It may find another front in the whole signal if that becomes more than five times as large. */
    bool front;
    int64_t modes; /* sparse: number of lowest modes to sum; the error bound may then exceed the tolerance. 0: chosen
                      from the tolerance */
    sp_modes_solver solver;       /* sparse: of these modes */
    sp_damping_kind damping_kind; /* ZETA */
    double damping_ratio;         /* c_t/c_n of the other kinds; 1 */
} sp_signal_options;
SP_API sp_signal_options sp_signal_options_default(void);
SP_API sp_damping sp_signal_damping(const sp_signal_options *opt); /* the law of its dashpots */

typedef struct sp_signal {
    int32_t n;                  /* times */
    int32_t sources, detectors; /* places of sources; of detectors */
    double *t;                  /* [n] times [d/sqrt(E* / rho)] */
    double *f;                  /* [sources][detectors][n] force on the detector minus its value at rest [E* d^2] */
    double *errors;             /* [sources][detectors] upper bounds of the error of f, absolute [E* d^2] */
    double error;               /* the largest of them [E* d^2] */
    double omega_max;           /* upper bound of the spectrum that was used [sqrt(E* / rho)/d] */
    int32_t products;           /* matrix products (0 for dense) */
    double step;                /* time step; 0 for other methods [d/sqrt(E* / rho)] */
    double amplitude;           /* dynamics: factor of the first source; 0 for other methods */
    sp_signal_method method;    /* method that was used */
    int64_t modes;              /* sparse: number of modes in the sum; 0 for other methods */
} sp_signal;

SP_API const char *sp_signal_method_name(sp_signal_method method); /* such as "chebyshev"; NULL for an unknown method */

SP_API sp_signal sp_signal_none(void);
/* Computes the signals of a network by any method except SP_SIGNAL_DYNAMICS. SP_EINVAL for invalid options. SP_EREFUSED
 * if the error bound exceeds the tolerance. */
SP_API sp_status sp_signal_make(const sp_network *net, const sp_signal_options *opt, sp_signal *out, sp_error *err);
/* The same for every method. SP_SIGNAL_DYNAMICS needs the packing p from which the network was made (NULL for the other
 * methods). It follows the motion of all grains from rest, with contacts that open, close and slide, after the source
 * times the amplitude; F is the change of the force over that factor. Its errors are estimates from steps of twice the
 * length. SP_EFAILED if a grain moves farther than the search for contacts allows. */
SP_API sp_status sp_signal_compute(const sp_packing *p, const sp_network *net, const sp_signal_options *opt,
                                   sp_signal *out, sp_error *err);
SP_API void sp_signal_free(sp_signal *s);

/* Options of sp_signal_field. */
typedef struct sp_field_options {
    sp_source source;
    const sp_place *from; /* NULL: the whole bottom wall, normal component */
    int32_t times;
    const double *t; /* [times] all >= 0, in any order */
    int threads;     /* number of threads; 0 counts as 1 */
} sp_field_options;
/* The displacement field after the pulse, Eq. (2) of Somfai et al. 2005: u [times][dofs of the network]. Computed
 * without eigenvectors, by the Chebyshev expansion u(t) = (2/Omega) sum_k J_(2k+1)(Omega t) W_k M^-1 a of momenta a, or
 * u(t) = 2 sum_k J_2k(Omega t) T_k u_0 of displacements u_0 (half the term k = 0). One pass serves all times. errors
 * [times], or NULL: upper bounds of the error of each component of u(t). SP_EREFUSED for an unstable network. */
SP_API sp_status sp_signal_field(const sp_network *net, const sp_field_options *spec, double *u, double *errors,
                                 sp_error *err);

/* A time after the passage of the first front: 8 H + 40 at p = 1e-4, scaled with p^(-1/6). */
SP_API double sp_signal_window(double height, double pressure);

#ifdef __cplusplus
}
#endif
#endif
