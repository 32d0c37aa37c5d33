#ifndef SONOPACK_SPECTRUM_H
#define SONOPACK_SPECTRUM_H
/* Spectra of the network of springs: what frequencies there are, which of them reach the other wall, and how waves
 * travel. Frequencies are angular, in sqrt(E* / rho)/d. */

#include <sonopack/elastic.h>
#include <sonopack/modes.h>
#include <sonopack/network.h>
#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- density of states ------------------------------------------------------------------------------------------ */

typedef enum sp_dos_method {
    SP_DOS_AUTO = 0, /* exact for small networks */
    SP_DOS_EXACT,    /* every frequency, by the dense solver */
    SP_DOS_KPM,      /* kernel polynomials and a stochastic trace: matrix products only */
    SP_DOS_COUNT /* a histogram by the inertia of K - omega^2 M at every edge, exact for any size that can be factored;
                    the smooth density by kernel polynomials */
} sp_dos_method;

typedef enum sp_dos_norm {
    SP_DOS_GRAIN = 0, /* modes for each carrying grain: the integral over all omega is the degrees of freedom a grain */
    SP_DOS_ONE,       /* the integral is 1 */
    SP_DOS_MODES      /* numbers of modes */
} sp_dos_norm;

typedef struct sp_dos_options {
    sp_dos_method method;
    sp_dos_norm norm;
    int32_t bins;      /* of equal width; 100 */
    double until;      /* last frequency; 0: the bound of the spectrum */
    double resolution; /* standard deviation of the kernel at omega = 0; 0: the width of a bin */
    int32_t vectors;   /* random vectors of the trace, even; 0: so many that 2e5 numbers are drawn, 4 to 64 */
    uint64_t seed;     /* of the random vectors; 1 */
    int32_t threads;   /* the same numbers for any; 1 */
} sp_dos_options;
SP_API sp_dos_options sp_dos_options_default(void);

/* g(omega), in omega and not in omega^2. Rattlers are left out. Zero modes are a peak at omega = 0: the methods exact
 * and count count them apart and has them neither in the bins nor in the smooth density; kernel polynomials cannot tell
 * them from soft modes (zero_modes = -1) and have them within the kernel's width of 0. */
typedef struct sp_dos {
    int32_t bins;
    sp_dos_method method;  /* the one that was used */
    double *edge;          /* [bins + 1] */
    double *density;       /* [bins] mean over the bin: a histogram */
    double *cumulative;    /* [bins] integral from 0 to the bin's upper edge */
    double *smooth;        /* [bins] at the bin's middle, smoothed by Jackson's kernel */
    double *density_error, /* [bins] kpm: one standard error, from the spread over the random vectors; exact, count: a
                              bound */
        *cumulative_error, *smooth_error;
    double resolution; /* standard deviation of the kernel at omega = 0; at others sqrt(1 - (omega/Omega)^2) times it */
    double omega_max;  /* Omega, the bound of the spectrum */
    int64_t zero_modes; /* of the network; -1 not known */
    int64_t modes;      /* degrees of freedom of the network */
    int64_t moments;
    int32_t vectors; /* 0: exact */
} sp_dos;
SP_API sp_dos sp_dos_none(void);
/* SP_EINVAL for options out of range; SP_EREFUSED for an unstable network, or an exact density of too large a one. */
SP_API sp_status sp_dos_make(const sp_network *net, const sp_dos_options *opt, sp_dos *out, sp_error *err);
SP_API void sp_dos_free(sp_dos *d);

/* ---- transmission ----------------------------------------------------------------------------------------------- */

typedef struct sp_transmission_options {
    sp_source source;
    sp_place from, to; /* the whole walls, normal */
    int32_t points;    /* frequencies, middles of equal bins from 0 to until; 400 */
    double until;      /* last frequency; 0: the bound of the spectrum */
    double resolution; /* standard deviation of the kernel at omega = 0; 0: the width of a bin */
} sp_transmission_options;
SP_API sp_transmission_options sp_transmission_options_default(void);

/* The signal's spectrum, F^(omega) = integral from 0 to infinity of F(t) exp(i omega t) dt, every line of it smoothed
 * by Jackson's kernel: from matrix products, without eigenvectors. Its density is g(omega) with F(t) = integral of g
 * sin (omega t) over omega > 0 (cos for a displacement source): sum of a_n b_n delta(omega - omega_n), smoothed; it is
 * 2/pi of the imaginary (real) part. */
typedef struct sp_transmission {
    int32_t n;
    double *omega;     /* [n] */
    double *density;   /* [n] */
    double *re, *im;   /* [n] F^ */
    double *error;     /* [n] rounding of re and im; the smoothing is part of what they are */
    double resolution; /* at omega = 0; at others sqrt(1 - (omega/Omega)^2) times it */
    double omega_max;  /* Omega */
    int64_t moments;
} sp_transmission;
SP_API sp_transmission sp_transmission_none(void);
SP_API sp_status sp_transmission_make(const sp_network *net, const sp_transmission_options *opt, sp_transmission *out,
                                      sp_error *err);
SP_API void sp_transmission_free(sp_transmission *t);

/* ---- dispersion ------------------------------------------------------------------------------------------------- */

typedef enum sp_polarization {
    SP_LONGITUDINAL = 0, /* along k */
    SP_TRANSVERSE,       /* across k: up for waves along x; along x for waves along up */
    SP_ROTATIONAL,       /* the grains' angles (3D: about y) */
    SP_POLARIZATIONS
} sp_polarization;

typedef struct sp_dispersion_options {
    bool up;       /* standing waves between the walls, sin(k (h + node)), k = n pi/(H + 2 node); false: plane waves
                      along x, k = 2 pi n/width */
    int32_t waves; /* n = 1 .. waves; 8 */
    double node;   /* how far behind the walls the nodes are [d]: 0; half a grain for walls that answer like grains */
    double resolution; /* standard deviation of the kernel at omega = 0; 0: Omega/200 */
    int32_t profile;   /* frequencies of S(k, omega); 0: none */
} sp_dispersion_options;
SP_API sp_dispersion_options sp_dispersion_options_default(void);

/* One wave vector and polarization: the spectral function S(k, omega) = <q| delta(omega - sqrt A) |q>, q the wave as a
 * mass-weighted unit vector. */
typedef struct sp_dispersion_point {
    sp_polarization polarization;
    int32_t n;
    double k;      /* wave number [1/d] */
    double rms;    /* sqrt(<omega^2>) = sqrt(q . A q), exact: the frequency of an eigenmode that q were */
    double spread; /* standard deviation of omega^2 over 2 rms: sqrt(|A q|^2 - rms^4)/(2 rms), exact */
    double peak;   /* where S cos(psi), smoothed, is largest, sin(psi) = omega/Omega: the kernel is equally wide in psi
                      everywhere, so that a line is as high as it is strong */
    double half_width; /* half the width of that peak at half its height; NAN where it never falls so low */
    double resolution; /* standard deviation of the kernel at the peak: what peak and half_width are blurred by */
} sp_dispersion_point;

typedef struct sp_dispersion {
    int32_t n;
    sp_dispersion_point *wave; /* [n] */
    int32_t profile;           /* frequencies, middles of equal bins from 0 to omega_max */
    double *omega;             /* [profile]; NULL for none */
    double *s;                 /* [n][profile] S(k, omega) smoothed; its integral is 1 */
    double omega_max;
    int64_t moments;
} sp_dispersion;
SP_API sp_dispersion sp_dispersion_none(void);
/* All polarizations that the network has. SP_EREFUSED for a wave that moves no grain. */
SP_API sp_status sp_dispersion_make(const sp_network *net, const sp_dispersion_options *opt, sp_dispersion *out,
                                    sp_error *err);
SP_API void sp_dispersion_free(sp_dispersion *d);

/* ---- participation ---------------------------------------------------------------------------------------------- */

/* Participation ratios (sp_modes) of the modes of a bin of frequencies; zero modes are left out. */
typedef struct sp_participation_bin {
    double low, high; /* low < omega <= high */
    int64_t modes;
    double mean, sd; /* NAN without modes, sd also with one */
    double least, largest;
} sp_participation_bin;
/* modes with vectors; bins of equal width from 0 to until (0: the largest frequency); out [bins]. */
SP_API sp_status sp_participation(const sp_modes *modes, int32_t bins, double until, sp_participation_bin *out,
                                  sp_error *err);

/* ---- harmonic driving ------------------------------------------------------------------------------------------- */

typedef struct sp_harmonic_options {
    double damping;      /* fraction of critical damping of every contact; 0: none */
    sp_source source;    /* impulse or velocity: momenta are forces here */
    sp_place from, to;   /* the whole walls, normal */
    int32_t n;           /* frequencies */
    const double *omega; /* [n] above 0 */
    int32_t planes;      /* horizontal planes that cut the height into equal layers; 0: one a mean diameter */
    double range[2];     /* heights of the planes that the wave is fitted to; both 0: all that are 2 diameters and more
                            from the walls */
    double tolerance;    /* of F over its magnitude, or over a millionth of the strongest force at the planes where F is
                            smaller still; at planes over that of the strongest: 1e-8 */
} sp_harmonic_options;
SP_API sp_harmonic_options sp_harmonic_options_default(void);

/* A wave up and its echo, A exp(-(alpha + i k) y) + B exp((alpha + i k) y), fitted to the forces through planes. One
 * standard error each, from the scatter. Of the two the wave up is the one that decays on its way, alpha > 0 (k may
 * then be negative: phases run down); k > 0 where alpha is within three errors of 0. */
typedef struct sp_wave_fit {
    double k, k_err;         /* wave number [1/d]; phase speed omega/k */
    double alpha, alpha_err; /* attenuation of the amplitude [1/d]; decay length 1/alpha */
    double misfit;           /* sum of squared deviations over that of the forces */
} sp_wave_fit;

/* The steady response to the source driven with exp(i omega t): (K - omega^2 M + i omega C) u = p, F the force of
 * springs and dashpots on the detector. F is the transform integral of F(t) exp(-i omega t) dt of the damped signal, t
 * > 0. */
typedef struct sp_harmonic {
    int32_t n, planes;
    double *omega;      /* [n] */
    double *f;          /* [n][2] F at the detector, real and imaginary part */
    double *error;      /* [n] bound of |error of F| */
    double *height;     /* [planes] */
    double *flux;       /* [n][planes][2] force through the planes, along the detector's component */
    double *flux_error; /* [n][planes] */
    sp_wave_fit *fit;   /* [n]; NAN where fewer than 5 planes are in range */
} sp_harmonic;
SP_API sp_harmonic sp_harmonic_none(void);
/* SP_EREFUSED where the tolerance is missed, as too near to a frequency of an undamped network. */
SP_API sp_status sp_harmonic_make(const sp_network *net, const sp_harmonic_options *opt, sp_harmonic *out,
                                  sp_error *err);
SP_API void sp_harmonic_free(sp_harmonic *h);

/* ---- continuum ----------------------------------------------------------------------------------------------------
 */

/* A mode of a strip of homogeneous elastic material with the packing's moduli and density, between fixed walls and
 * periodic along x: u = (v(y) cos, -w(y) sin)(k1 x) and (v sin, w cos)(k1 x), k1 = 2 pi n1/L1. */
typedef struct sp_strip_mode {
    double omega;        /* converged to 1e-8 of it */
    int32_t n1;          /* wave number along x */
    int32_t n2;          /* half waves between the walls of the strongest sine of v and w; the k2 = n2 pi/L2 of */
    bool fast;           /* omega+ of the two plane waves, the nearer one; false: omega- */
    double omega_plane;  /* sqrt(lambda/Phi3*), lambda of the acoustic tensor A(k1, k2) (Somfai et al. 2005, section
                            IV E): exact for n1 = 0 alone */
    double v[48], w[48]; /* coefficients of (L_k - L_(k+2))(2 y/L2 - 1)/sqrt(4 k + 6), L Legendre's polynomials */
} sp_strip_mode;
/* The lowest modes with wave number n1 along x; out [count], ascending. box: L1, L2. SP_EINVAL for count outside 1 ..
 * 24, or moduli that are none. */
SP_API sp_status sp_strip_modes(const sp_moduli *m, double phi3s, const double box[2], int32_t n1, int32_t count,
                                sp_strip_mode *out, sp_error *err);

/* A mode of the packing beside the mode of the strip that it overlaps with most. */
typedef struct sp_continuum_row {
    int64_t n;    /* number in the whole spectrum, from 0, zero modes of rattlers in front */
    double omega; /* of the packing */
    int32_t n1, n2;
    bool fast;
    double omega_plane, omega_continuum;
    double overlap; /* squared projection, in the metric of the masses, on the two modes of the strip (n1 = 0: one) */
} sp_continuum_row;
typedef struct sp_continuum {
    int32_t n;
    sp_continuum_row *row; /* [n] ascending by omega */
    sp_moduli moduli;
} sp_continuum;
SP_API sp_continuum sp_continuum_none(void);
/* The `lowest` modes of a 2D packing but for those of frequency 0. SP_EREFUSED for other dimensions, walls that do not
 * grip, and without phi3s. */
SP_API sp_status sp_continuum_make(const sp_network *net, double phi3s, int32_t lowest, sp_continuum *out,
                                   sp_error *err);
SP_API void sp_continuum_free(sp_continuum *c);

#ifdef __cplusplus
}
#endif
#endif
