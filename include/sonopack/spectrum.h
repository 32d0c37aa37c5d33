#ifndef SONOPACK_SPECTRUM_H
#define SONOPACK_SPECTRUM_H
/* Spectra of a network of springs: the density of states, transmission from wall to wall, and propagation of waves.
 * Frequencies are angular, in sqrt(E* / rho)/d. */

#include <sonopack/elastic.h>
#include <sonopack/modes.h>
#include <sonopack/network.h>
#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- density of states ------------------------------------------------------------------------------------------ */

typedef enum sp_dos_method {
    SP_DOS_AUTO = 0, /* exact for small networks, else kernel polynomials */
    SP_DOS_EXACT,    /* all frequencies by the dense solver */
    SP_DOS_KPM,      /* kernel polynomial method: matrix products and a stochastic trace */
    SP_DOS_COUNT /* an exact histogram by the inertia of K - omega^2 M at each edge of a bin, for any size that can be
                    factored; the smooth density by kernel polynomials */
} sp_dos_method;

typedef enum sp_dos_norm {
    SP_DOS_GRAIN =
        0,       /* modes per grain of the network: the integral over all omega is the degrees of freedom of a grain */
    SP_DOS_ONE,  /* the integral is 1 */
    SP_DOS_MODES /* the integral is the number of modes */
} sp_dos_norm;

typedef struct sp_dos_options {
    sp_dos_method method;
    sp_dos_norm norm;
    int32_t bins;      /* number of bins, of equal width; 100 */
    double until;      /* last frequency; 0: the upper bound of the spectrum */
    double resolution; /* standard deviation of the kernel at omega = 0; 0: the width of a bin */
    int32_t vectors;   /* random vectors of the trace, even; 0: 4 to 64, about 2e5 random numbers in all */
    uint64_t seed;     /* seed of the random vectors; 1 */
    int32_t threads;   /* number of threads, which does not change the result; 1 */
} sp_dos_options;
SP_API sp_dos_options sp_dos_options_default(void);

/* The density g(omega) with respect to omega, not omega^2. Rattlers are excluded. Zero modes would be a peak at omega =
 * 0. The methods exact and count report their number separately and leave them out of the histogram and the smooth
 * density. Kernel polynomials cannot distinguish zero modes from soft modes and smear them over the
 * kernel's width at 0. */
typedef struct sp_dos {
    int32_t bins;         /* of equal width */
    sp_dos_method method; /* method that was used */
    double *edge;         /* [bins + 1] edges of the bins [sqrt(E* / rho)/d] */
    double *density;      /* [bins] mean over the bin: a histogram */
    double *cumulative;   /* [bins] integral from 0 to the upper edge of the bin */
    double *smooth;       /* [bins] density at the middle of the bin, smoothed by Jackson's kernel */
    double *density_error, *cumulative_error, *smooth_error; /* [bins] kpm: standard error, from the scatter over the
                                                                random vectors. exact and count: upper bound */
    double resolution;  /* standard deviation of the kernel at omega = 0; at omega, sqrt(1 - (omega/Omega)^2) times this
                           [sqrt(E* / rho)/d] */
    double omega_max;   /* Omega, the upper bound of the spectrum [sqrt(E* / rho)/d] */
    sp_zero_modes zero; /* kpm: mechanisms and total are unknown, -1 */
    int64_t modes;      /* degrees of freedom of the network */
    int64_t moments;    /* of the kernel polynomial; 0 for other methods */
    int32_t vectors;    /* random vectors; 0 for the method exact */
} sp_dos;
SP_API sp_dos sp_dos_none(void);
/* SP_EINVAL for invalid options. SP_EREFUSED for an unstable network, and if the network is too large for the method
 * exact. */
SP_API sp_status sp_dos_make(const sp_network *net, const sp_dos_options *opt, sp_dos *out, sp_error *err);
SP_API void sp_dos_free(sp_dos *d);

/* ---- transmission ----------------------------------------------------------------------------------------------- */

typedef struct sp_transmission_options {
    sp_source source;
    sp_place from, to; /* source and detector; default: the whole walls, normal component */
    int32_t points;    /* frequencies: the middles of equal bins from 0 to until; 400 */
    double until;      /* last frequency; 0: the upper bound of the spectrum */
    double resolution; /* standard deviation of the kernel at omega = 0; 0: the width of a bin */
} sp_transmission_options;
SP_API sp_transmission_options sp_transmission_options_default(void);

/* Spectrum of the signal, F^(omega) = integral from 0 to infinity of F(t) exp(i omega t) dt. Each line is smoothed by
 * Jackson's kernel. The density g(omega) = sum a_n b_n delta(omega - omega_n), smoothed, gives F(t) = integral over
 * omega > 0 of g sin(omega t), with cos for a displacement source. It is 2/pi times the imaginary part of F^ (real part
 * for a displacement source). Computed from matrix products, without eigenvectors. */
typedef struct sp_transmission {
    int32_t n;         /* frequencies */
    double *omega;     /* [n] frequencies [sqrt(E* / rho)/d] */
    double *density;   /* [n] g, whose sine transform is the signal */
    double *re, *im;   /* [n] real part of F^; imaginary part */
    double *error;     /* [n] rounding error of re and im; smoothing is not counted as an error */
    double resolution; /* standard deviation of the kernel at omega = 0; at omega, sqrt(1 - (omega/Omega)^2) times this
                          [sqrt(E* / rho)/d] */
    double omega_max;  /* Omega, the upper bound of the spectrum [sqrt(E* / rho)/d] */
    int64_t moments;   /* of the expansion */
} sp_transmission;
SP_API sp_transmission sp_transmission_none(void);
SP_API sp_status sp_transmission_make(const sp_network *net, const sp_transmission_options *opt, sp_transmission *out,
                                      sp_error *err);
SP_API void sp_transmission_free(sp_transmission *t);

/* ---- dispersion ------------------------------------------------------------------------------------------------- */

typedef enum sp_polarization {
    SP_LONGITUDINAL = 0, /* displacements along k */
    SP_TRANSVERSE,       /* displacements across k: vertical for waves along x or y, along x for vertical waves; in a
                            tilted cell what of these directions is across k */
    SP_ROTATIONAL,       /* rotations (3D: about y, for waves along y about x) */
    SP_POLARIZATIONS
} sp_polarization;

typedef struct sp_dispersion_options {
    bool up;       /* along the up axis; false: along x. Where the network is periodic these are plane waves whose wave
                      vectors are n times 2 pi and the reciprocal lattice vector of that axis: k = 2 pi n/width where it is
                      not tilted. Between walls they are standing, sin(k (h + node)), k = n pi/(H + 2 node) */
    int32_t waves; /* wave numbers n = 1 .. waves; 8 */
    double node;   /* distance of the nodes behind the walls [d]; 0. Half a grain if the walls respond like grains */
    double resolution; /* standard deviation of the kernel at omega = 0; 0: Omega/200 */
    int32_t profile;   /* number of frequencies of S(k, omega); 0: none */
    bool along_y;      /* in 3D: along y. up is false then */
} sp_dispersion_options;
SP_API sp_dispersion_options sp_dispersion_options_default(void);

/* One wave vector and polarization. The spectral function is S(k, omega) = <q| delta(omega - sqrt A) |q> with the wave
 * q as a mass-weighted unit vector. */
typedef struct sp_dispersion_point {
    sp_polarization polarization; /* of the wave */
    int32_t n;                    /* wave number in units of the smallest */
    double k;                     /* wave number, the length of the wave vector [1/d] */
    double rms;                   /* sqrt(<omega^2>) = sqrt(q . A q), exact [sqrt(E* / rho)/d] */
    double
        spread;  /* standard deviation of omega^2 over 2 rms, sqrt(|A q|^2 - rms^4)/(2 rms), exact [sqrt(E* / rho)/d] */
    double peak; /* frequency of the maximum of the smoothed S cos(psi), sin(psi) = omega/Omega. The kernel has the same
                    width in psi at all frequencies, so heights of peaks show their strength [sqrt(E* / rho)/d] */
    double half_width; /* half the width of that peak at half its height; NAN if S does not fall so low [sqrt(E* /
                          rho)/d] */
    double resolution; /* standard deviation of the kernel at the peak [sqrt(E* / rho)/d] */
} sp_dispersion_point;

typedef struct sp_dispersion {
    int32_t n;                 /* waves */
    sp_dispersion_point *wave; /* [n] one for each polarization and wave number */
    int32_t profile;           /* number of frequencies: the middles of equal bins from 0 to omega_max */
    double *omega;             /* [profile] frequencies of s [sqrt(E* / rho)/d] */
    double *s;                 /* [n][profile] S(k, omega), smoothed; its integral is 1 */
    double omega_max;          /* Omega, the upper bound of the spectrum [sqrt(E* / rho)/d] */
    int64_t moments;           /* of the expansion */
} sp_dispersion;
SP_API sp_dispersion sp_dispersion_none(void);
/* All polarizations that the network has. SP_EREFUSED for a wave with all grains at its nodes. */
SP_API sp_status sp_dispersion_make(const sp_network *net, const sp_dispersion_options *opt, sp_dispersion *out,
                                    sp_error *err);
SP_API void sp_dispersion_free(sp_dispersion *d);

/* ---- participation ---------------------------------------------------------------------------------------------- */

/* Participation ratios (sp_modes) of the modes in a bin of frequencies. Zero modes are excluded. */
typedef struct sp_participation_bin {
    double low, high;      /* edge below, not included; edge above, included [sqrt(E* / rho)/d] */
    int64_t modes;         /* their number */
    double mean, sd;       /* mean of the ratios, NAN without modes; standard deviation, NAN for less than two */
    double least, largest; /* smallest ratio; largest ratio */
} sp_participation_bin;
/* modes: with vectors. bins: of equal width from 0 to until (0: the largest frequency). out [bins]. */
SP_API sp_status sp_participation(const sp_modes *modes, int32_t bins, double until, sp_participation_bin *out,
                                  sp_error *err);

/* ---- harmonic driving ------------------------------------------------------------------------------------------- */

typedef struct sp_harmonic_options {
    double damping;      /* fraction of critical damping of each contact, or the value of another kind; 0: none */
    sp_source source;    /* impulse or velocity; the momenta of the pulse are the amplitudes of the driving forces */
    sp_place from, to;   /* source and detector; default: the whole walls, normal component */
    int32_t n;           /* number of frequencies */
    const double *omega; /* [n] all > 0 */
    int32_t planes;      /* horizontal planes that divide the height into equal layers; 0: one per mean diameter */
    double range[2];     /* heights of the planes used in the fit; both 0: all planes at least 2 d from the walls */
    double tolerance;    /* allowed error of F relative to |F|, or to 1e-6 of the largest force at a plane if |F| is
                            smaller; at planes relative to that largest force. 1e-8 */
    bool keep;           /* frequencies that miss the tolerance are kept, with NAN in place of all results; false */
    sp_damping_kind damping_kind; /* ZETA; see sp_network_dashpots */
    double damping_ratio;         /* c_t/c_n of the other kinds; 1 */
} sp_harmonic_options;
SP_API sp_harmonic_options sp_harmonic_options_default(void);

/* An upward wave and its reflection, A exp(-(alpha + i k) y) + B exp((alpha + i k) y), fitted to the forces through the
 * planes. Errors are standard errors from the scatter. The upward wave is the one that decays as it travels, alpha > 0;
 * k is then negative if its phase runs downward. If alpha is within three errors of 0, the sign is chosen so that k >
 * 0. */
typedef struct sp_wave_fit {
    double k, k_err;         /* wave number, omega over the phase speed; its standard error [1/d] */
    double alpha, alpha_err; /* attenuation of the amplitude, one over the decay length; its standard error [1/d] */
    double misfit;           /* sum of squared deviations over the sum of squared forces */
} sp_wave_fit;

/* Quality factor Q = |k|/(2 alpha) of a wave that decays, and its standard error to first order. Both NAN unless alpha
 * is above three errors of its own; a NAN among the errors makes only *q_err NAN, and then alpha > 0 is enough. */
SP_API void sp_wave_quality(double k, double k_err, double alpha, double alpha_err, double *q, double *q_err);

/* Steady response to driving with exp(i omega t): (K - omega^2 M + i omega C) u = p. F is the force of springs and
 * dashpots on the detector. It is the Fourier integral of F(t) exp(-i omega t) over t > 0 of the damped signal. */
typedef struct sp_harmonic {
    int32_t n, planes;  /* frequencies; planes */
    double *omega;      /* [n] frequencies [sqrt(E* / rho)/d] */
    double *f;          /* [n][2] F at the detector: real and imaginary part */
    double *error;      /* [n] upper bound of |error of F| */
    double *height;     /* [planes] above the bottom [d] */
    double *flux;       /* [n][planes][2] force through each plane, in the detector's component */
    double *flux_error; /* [n][planes] upper bound of its error */
    sp_wave_fit *fit;   /* [n] fitted waves; NAN if fewer than 5 planes are in the range */
    int32_t refused;    /* with `keep': frequencies without results */
    char reason[256];   /* of the first of them; "" */
} sp_harmonic;
SP_API sp_harmonic sp_harmonic_none(void);
/* SP_EREFUSED if the tolerance is missed, for example too near to an eigenfrequency of an undamped network; not with
 * `keep', unless all are refused. */
SP_API sp_status sp_harmonic_make(const sp_network *net, const sp_harmonic_options *opt, sp_harmonic *out,
                                  sp_error *err);
SP_API void sp_harmonic_free(sp_harmonic *h);

/* ---- continuum ------------------------------------------------------------------------------------------------- */

/* A mode of a strip of homogeneous elastic material with the packing's moduli and density, between fixed walls and
 * periodic along x: u = (v(y) cos, -w(y) sin)(k1 x) and (v sin, w cos)(k1 x), k1 = 2 pi n1/L1. */
typedef struct sp_strip_mode {
    double omega; /* relative error about 1e-8 */
    int32_t n1;   /* wave number along x */
    int32_t n2;   /* number of half waves between the walls of the strongest sine component of v and w; k2 = n2 pi/L2 */
    bool fast;    /* omega+ is the nearer of the two plane waves; false: omega- */
    double omega_plane;  /* sqrt(lambda/Phi3*), lambda an eigenvalue of the acoustic tensor A(k1, k2) (Somfai et al.
                            2005, section IV E); exact only for n1 = 0 */
    double v[48], w[48]; /* coefficients of (L_k - L_(k+2))(2 y/L2 - 1)/sqrt(4 k + 6), with Legendre polynomials L */
} sp_strip_mode;
/* The `count` lowest modes with wave number n1 along x. out [count], ascending. box: L1, L2. SP_EINVAL unless 1 <=
 * count <= 24, and for invalid moduli. */
SP_API sp_status sp_strip_modes(const sp_moduli *m, double phi3s, const double box[2], int32_t n1, int32_t count,
                                sp_strip_mode *out, sp_error *err);

/* A mode of the packing and the strip mode with which it overlaps most. */
typedef struct sp_continuum_row {
    int64_t n;                           /* number in the whole spectrum, from 0; zero modes of rattlers come first */
    double omega;                        /* frequency of the packing's mode [sqrt(E* / rho)/d] */
    int32_t n1, n2;                      /* wave number of the strip's mode along x; half waves between the walls */
    bool fast;                           /* whether the faster of the two plane waves is nearer */
    double omega_plane, omega_continuum; /* frequency of that plane wave; of the strip's mode [sqrt(E* / rho)/d] */
    double overlap; /* squared projection, in the metric of the masses, on the two degenerate modes of the strip (one
                       for n1 = 0) */
} sp_continuum_row;
typedef struct sp_continuum {
    int32_t n;             /* modes of the packing */
    sp_continuum_row *row; /* [n] in ascending order of omega */
    sp_moduli moduli;      /* of the strip */
} sp_continuum;
SP_API sp_continuum sp_continuum_none(void);
/* Compares the `lowest` modes of a 2D packing, apart from its zero modes, with those of the strip. SP_EREFUSED in other
 * dimensions, for walls without friction, and without phi3s. */
SP_API sp_status sp_continuum_make(const sp_network *net, double phi3s, int32_t lowest, sp_modes_solver solver,
                                   sp_continuum *out, sp_error *err);
SP_API void sp_continuum_free(sp_continuum *c);

#ifdef __cplusplus
}
#endif
#endif
