#ifndef SONOPACK_AMPLITUDE_H
#define SONOPACK_AMPLITUDE_H
/* What becomes of the sound of a packing when it is loud: the nonlinear motion between fixed walls, with Hertz's law,
 * sliding, and contacts that open and close, beside the linear signal (docs/amplitude.md).
 *
 * Amplitudes are those of sp_signal_options: the largest initial displacement of a grain, or velocity over omega_max,
 * over the mean overlap of the carrying contacts. */

#include <sonopack/front.h>
#include <sonopack/network.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A result with its error, an estimate from steps of twice the length and from every second time. */
typedef struct sp_amplitude_value {
    double value, error;
} sp_amplitude_value;

typedef struct sp_amplitude_options {
    sp_source source;
    double until;     /* last time; 0: sp_signal_window */
    double tolerance; /* largest relative error of the arrival and of the balance of energy; 1e-3 */
} sp_amplitude_options;
SP_API sp_amplitude_options sp_amplitude_options_default(void);

/* The balance of energy at the end of the run [E* d^3]. Energies are beyond those at rest and beyond the work of the
 * forces at rest, which is none in a packing in equilibrium:
 *     kinetic + normal + tangential + slid - released = input. */
typedef struct sp_amplitude_energy {
    double input;   /* of the source */
    double kinetic; /* of translations and rotations */
    double normal;  /* of the normal springs (Hertz) */
    double
        tangential;  /* work of the tangential springs without sliding; Mindlin's springs have no energy of their own */
    double slid;     /* what sliding rubbed away */
    double released; /* what of it the forces at rest have done: sliding lets go of stresses of the packing */
    double defect;   /* largest | left side - right side | / input on the way: the error of the time steps */
} sp_amplitude_energy;

/* The front at the top wall after a pulse of one amplitude at the bottom wall. */
typedef struct sp_amplitude_pulse {
    double amplitude;
    double factor;              /* of the source: F is the change of the force on the top wall over it */
    double step;                /* time step of the finer run */
    sp_front front;             /* of F */
    sp_amplitude_value t10;     /* [d/sqrt(E* / rho)] */
    sp_amplitude_value speed;   /* t10 of the linear signal over t10: H/t10 over its linear limit */
    sp_amplitude_value peak;    /* largest F of the front over that of the linear signal */
    sp_amplitude_value width;   /* t_zero - t10 over that of the linear signal */
    double overpressure;        /* largest change of the force on the top wall over the force at rest */
    double until;               /* end of the run, behind the front: the time of the counts and of the energies */
    int32_t carrying;           /* contacts that carry a force at rest; of these */
    int32_t slid, opened, lost; /* slid; were open at some time; are open at the end */
    int32_t closed;             /* gaps that closed at some time */
    sp_amplitude_energy energy;
} sp_amplitude_pulse;

/* Computes the fronts of `count` amplitudes, and that of the linear signal (all contacts, with prestress, by
 * Chebyshev expansion), which is their limit.
 * SP_EINVAL for an amplitude that is not in 1e-9 .. 1e6: below, rounding errors of the motion exceed the tolerance.
 * SP_EREFUSED for a packing without level walls at bottom and top, without a front, or where the tolerance takes too
 * many steps; SP_EFAILED if a grain moves farther than the search for contacts allows. */
SP_API sp_status sp_amplitude_pulses(const sp_packing *p, const sp_amplitude_options *opt, int32_t count,
                                     const double *amplitude, sp_amplitude_pulse *out, sp_front *linear, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
