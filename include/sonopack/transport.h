#ifndef SONOPACK_TRANSPORT_H
#define SONOPACK_TRANSPORT_H
/* How the energy of sound moves through a packing: its density and its flux, and the diffusivity of waves that have
 * been scattered many times, as a function of frequency. docs/transport.md has the equations. Frequencies are angular,
 * in sqrt(E* / rho)/d; energies are in E* d^3 times the square of the amplitude. */

#include <sonopack/modes.h>
#include <sonopack/network.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- density and flux ------------------------------------------------------------------------------------------- */

/* Energy of a grain: its kinetic energy, half the potential energy of each spring that joins it to another grain, and
 * all of that of its springs to walls. */
typedef struct sp_energy {
    double along;      /* kinetic, translation along the up axis */
    double across;     /* kinetic, translation along the other axes */
    double rotation;   /* kinetic */
    double normal;     /* potential, of normal springs */
    double tangential; /* potential, of tangential springs and prestress */
} sp_energy;
SP_API double sp_energy_sum(const sp_energy *e);

/* Flux of energy: its rate of flow along the up axis, by the forces that do the work. */
typedef struct sp_flux {
    double normal;   /* normal forces */
    double sideways; /* tangential forces, on the translation of the grains */
    double rotation; /* their torques, on the rotation of the grains */
} sp_flux;
SP_API double sp_flux_sum(const sp_flux *j);

/* Energy of each grain, out [n of the network], for displacements u and velocities v [n][dof]. The sum over the grains
 * is the energy of the motion. SP_EREFUSED if K is not symmetric: there is no energy then. */
SP_API sp_status sp_transport_energy(const sp_network *net, const double *u, const double *v, sp_energy *out,
                                     sp_error *err);
/* Flux through horizontal planes, out [planes]: what the grains with centres below a plane pass to those above it. The
 * energy of the grains below the plane changes at exactly minus this rate. In a cell without walls the images of the
 * plane are crossed too, and the energy between two planes changes at the rate of the difference. SP_EREFUSED if K is
 * not symmetric. */
SP_API sp_status sp_transport_flux(const sp_network *net, const double *u, const double *v, int32_t planes,
                                   const double *height, sp_flux *out, sp_error *err);
/* The current along an axis 0 .. dim-1: the sum over the springs of the energy that they pass on, times the distance
 * of the centres along the axis. Without walls across the axis it is the rate at which the energy's first moment
 * changes. SP_EINVAL for an axis, SP_EREFUSED if K is not symmetric. */
SP_API sp_status sp_transport_current(const sp_network *net, const double *u, const double *v, int axis, double *out,
                                      sp_error *err);

/* Displacements u and velocities v [n][dof] after the time t, without error but for rounding (Chebyshev expansion).
 * *drift, or NULL: relative change of the energy, a measure of the rounding errors. SP_EINVAL for a time that is
 * negative or not finite, SP_EREFUSED if K is not symmetric, and for an unstable network. */
SP_API sp_status sp_transport_advance(const sp_network *net, double t, double *u, double *v, double *drift,
                                      sp_error *err);

/* The energy after an impulse at the bottom wall, filtered to a band as in sp_spread_options; its energy is then 1. */
typedef struct sp_burst_options {
    double omega; /* above 0 */
    double width; /* of the band, over omega; 0.1 */
    int32_t times;
    const double *t; /* [times] ascending, >= 0: after the middle of the burst */
    int32_t planes;
    const double *height; /* [planes] */
} sp_burst_options;
/* below [times][planes]: energy of the grains below each plane; flux [times][planes]. *drift, or NULL: largest relative
 * change of the whole energy, which bounds the rounding errors. SP_EINVAL for invalid options, SP_EREFUSED without a
 * bottom wall, if K is not symmetric, if no mode is near the frequency, and for an unstable network. */
SP_API sp_status sp_burst_make(const sp_network *net, const sp_burst_options *opt, double *below, sp_flux *flux,
                               double *drift, sp_error *err);

/* ---- diffusivity from the spreading of energy -------------------------------------------------------------------- */

/* A random motion of all grains is limited to a band about omega: the energy of its modes falls off like
 * exp(-(w - omega)^2/(2 (width omega)^2)). It has an energy density 1 +- cos(q x) along an axis x. The part f(t) that
 * is left of the wave decays like exp(-D q^2 t) once the energy diffuses. q = 2 pi waves/L along an axis with a period
 * L, pi waves/L between walls. */
typedef struct sp_spread_options {
    int axis;        /* 0 .. dim-1; -1: the up axis (default) */
    double width;    /* of the band, over omega; 0.1 */
    int32_t waves;   /* 1 */
    int32_t sources; /* number of random motions, 2 .. 1000; 6 */
    uint64_t seed;   /* of the random motions; 1 */
    double until;    /* last time; 0: 300 periods of omega, or less if the decay is seen to stop */
} sp_spread_options;
SP_API sp_spread_options sp_spread_options_default(void);

/* What longer waves may change d by, over d_half: the change may double with each wave that is twice as short. */
#define SP_SPREAD_HALVES 2
/* Diffusivity of energy from the spreading of random motions of a band of frequencies. */
typedef struct sp_spread {
    double omega, q; /* frequency of the band [sqrt(E* / rho)/d]; wave number of the pattern [1/d] */
    double d;        /* diffusivity from the decay of f from `high` to `low` [d sqrt(E* / rho)] */
    double d_err; /* standard error over the random motions (jackknife), and in quadrature d_shift and SP_SPREAD_HALVES
                      times d_half, what longer times and waves may change [d sqrt(E* / rho)] */
    double d_shift;  /* d of the later half of ln f, minus d of the earlier half: near 0 if the energy diffuses [d
                        sqrt(E* / rho)] */
    double d_half;   /* d of a wave of half the length, minus d: near 0 if the energy diffuses [d sqrt(E* / rho)] */
    double from, to; /* first; last time of the fit [d/sqrt(E* / rho)] */
    double low;      /* f at the end of the fit: 0.2, or more where `until` came first */
    double drift;    /* largest relative change of the energy: rounding errors */
} sp_spread;
/* Part of the wave at which the fit begins; before it the motion is ballistic. */
#define SP_SPREAD_HIGH 0.7
/* d and what belongs to it are NAN if f is above 0.5 at the last time, or if d_shift or d_half exceeds a third of d by
 * more than twice its error, or two thirds: the energy does not diffuse over this distance. SP_EINVAL for invalid
 * options or a frequency that is not positive, SP_EREFUSED if K is not symmetric, if no mode is near the frequency, and
 * for an unstable network. */
SP_API sp_status sp_spread_make(const sp_network *net, double omega, const sp_spread_options *opt, sp_spread *out,
                                sp_error *err);

/* ---- diffusivity from eigenmodes --------------------------------------------------------------------------------- */

/* D(omega) = sum_n g_n sum_m pi |C_nm|^2/(omega_n + omega_m)^2 delta(omega_n - omega_m) / sum_n g_n, the formula of
 * Kubo for harmonic motion (Allen and Feldman 1993). C = [A, x] is the operator of the current along an axis, A =
 * M^(-1/2) K M^(-1/2). g_n is a Gaussian of standard deviation width omega about omega, delta one of `smear` omega. */
typedef struct sp_kubo_options {
    int axis;     /* 0 .. dim-1; -1: the mean over all axes without walls (default) */
    double width; /* 0.1 */
    double smear; /* 0.1: larger than the distance of the modes, smaller than the rate of scattering */
} sp_kubo_options;
SP_API sp_kubo_options sp_kubo_options_default(void);

/* What D is off for a delta that is not narrow, over d_shift: 2 where the difference is as the width, 4/3 where it is
 * as its square. */
#define SP_KUBO_SHIFTS 2
/* Diffusivity of energy from the modes of a band of frequencies. */
typedef struct sp_kubo {
    double omega;   /* frequency of the band [sqrt(E* / rho)/d] */
    double d;       /* diffusivity [d sqrt(E* / rho)] */
    double d_err;   /* standard error over the modes of the band (jackknife with 8 groups), and in quadrature
                       SP_KUBO_SHIFTS times d_shift [d sqrt(E* / rho)] */
    double d_shift; /* its change if delta is half as wide: near 0 if the choice does not matter, near d for waves that
                       are not scattered, negative for localised ones */
    double speed;   /* at which energy moves before it is scattered: root of the mean squared current over the energy,
                       in all directions; the sum over m goes over modes within 0.3 omega. In a lattice it is the root
                       mean squared group velocity [sqrt(E* / rho)] */
    double speed_err; /* its standard error [sqrt(E* / rho)] */
    double modes;     /* number of modes in the band, sum_n g_n */
} sp_kubo;
/* All but omega and modes are NAN with fewer than 10 modes in the band or fewer than 3 in the width of delta; d and
 * d_shift also if |d_shift| exceeds a third of d. */
/* For frequencies omega [n], from all modes of the network with vectors. out [n]. SP_EINVAL for invalid options and if
 * vectors are missing, SP_EREFUSED for an axis with walls, between which no energy is carried on. */
SP_API sp_status sp_kubo_make(const sp_network *net, const sp_modes *modes, int32_t n, const double *omega,
                              const sp_kubo_options *opt, sp_kubo *out, sp_error *err);

/* ---- split of the energy ------------------------------------------------------------------------------------------
 */

typedef struct sp_split_options {
    double width;    /* of the band, over omega; 0.1 */
    int32_t sources; /* number of random motions, 2 .. 1000; 6 */
    uint64_t seed;   /* of the random motions; 1 */
    double from;     /* first time after the pulse; 0: 100 periods of omega. The last is twice that. */
} sp_split_options;
SP_API sp_split_options sp_split_options_default(void);

/* Parts of the energy, which add up to 1. */
typedef struct sp_split {
    double omega;             /* frequency of the band [sqrt(E* / rho)/d] */
    sp_energy rest, rest_err; /* of random motions of all grains in the band about omega: each mode has the same energy
                                 (that of modes falls off as in sp_spread_options); standard errors over the motions */
    sp_energy pulse, pulse_err; /* of the motion after an impulse at the bottom wall, filtered to the band, NAN without
                                   a bottom wall: means over the times; standard errors from 8 parts of them */
    double from, until;         /* first; last of the times after the pulse [d/sqrt(E* / rho)] */
} sp_split;
/* SP_EINVAL for invalid options or a frequency that is not positive, SP_EREFUSED if K is not symmetric, if no mode is
 * near the frequency, and for an unstable network. */
SP_API sp_status sp_split_make(const sp_network *net, double omega, const sp_split_options *opt, sp_split *out,
                               sp_error *err);

/* ---- localisation in a chain ------------------------------------------------------------------------------------- */

/* Growth of the solution of -omega^2 m_j u_j = k_j (u_(j+1) - u_j) - k_(j-1) (u_j - u_(j-1)) from a fixed end, u_0 = 0.
 * Waves in a chain with disorder decay as exp(-gamma j); the localisation length is 1/gamma masses. */
typedef struct sp_localisation {
    double omega;
    double gamma;     /* mean growth of ln(|motion|) for each mass */
    double gamma_err; /* its standard error, from 32 parts of the chain; at least 1/n */
    double log_end;   /* ln |u_(n+1)/u_1|: the response of one end to the other is k_0 .. k_(n-1)/(k_0 |u_(n+1)/u_1|) */
} sp_localisation;
/* Chain of n masses between two walls with n + 1 springs, the first and the last to the walls. SP_EINVAL for fewer than
 * 320 masses, values that are not positive, and a frequency that is not. */
SP_API sp_status sp_localisation_chain(int64_t n, const double *mass, const double *stiffness, double omega,
                                       sp_localisation *out, sp_error *err);
/* gamma of equal springs k and independent masses of this mean and variance for small omega (Matsuda and Ishii 1970):
 * omega^2 variance/(8 k mean). */
SP_API double sp_localisation_law(double omega, double mean, double variance, double k);
/* Masses of mean 1 and standard deviation `disorder`, uniform and independent, out [n]. SP_EINVAL unless disorder is in
 * 0 .. 0.577, where the masses are positive. */
SP_API sp_status sp_localisation_masses(int64_t n, double disorder, uint64_t seed, double *out, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
