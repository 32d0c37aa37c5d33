#ifndef SONOPACK_COHERENT_H
#define SONOPACK_COHERENT_H
/* The coherent wave in a record section, which is a set of signals at planes one above the other, from a simulation or
 * a laboratory. Its phase speed and attenuation as functions of frequency explain how a front broadens, decays and
 * slows down on its way. */

#include <sonopack/network.h>
#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A record section. The record of each plane ends at `until`, before the echo from the far wall; `arrival` is the
 * approximate arrival of the front. */
typedef struct sp_coherent_section {
    int32_t planes;  /* one above the other */
    int32_t n;       /* times of each signal */
    double spacing;  /* times are 0, spacing, 2 spacing, ... [d/sqrt(E* / rho)] */
    double *y;       /* [planes] heights, ascending [d] */
    double *arrival; /* [planes] first time at which the wave is there [d/sqrt(E* / rho)] */
    double *until;   /* [planes] last time used, above the arrival [d/sqrt(E* / rho)] */
    double *f;       /* [planes][n] flux of momentum through each plane [E* d^2] */
    double highest;  /* no wave has a higher frequency: the largest of the network, within 1e-3; 0: unknown [sqrt(E* /
                        rho)/d] */
} sp_coherent_section;
SP_API sp_coherent_section sp_coherent_section_none(void);
SP_API void sp_coherent_section_free(sp_coherent_section *s);

typedef struct sp_coherent_section_options {
    sp_source source;
    double spacing; /* distance between planes [d]; 1 */
    double low;     /* height of the first plane [d]; 4, beyond the influence of the wall's springs */
    double part;    /* the last plane is at this fraction of the height; 0.6, above which the echo arrives soon */
    double damping; /* dashpots of the contacts, as in sp_signal_options; 0: none */
    sp_damping_kind damping_kind;
    double damping_ratio; /* 1 */
    bool shear; /* the transverse wave: the bottom wall moves along x, and planes record the momentum along x that
                   crosses them; false */
} sp_coherent_section_options;
SP_API sp_coherent_section_options sp_coherent_section_options_default(void);
/* The momentum flux through planes of a packing after a pulse at its bottom wall. The flux is the same for all planes
 * between two layers of grains. y is the height at which it is carried (sp_network_plane_height); planes with equal y
 * count once. The record of a plane ends when the echo of the front arrives: t10 at the top wall, plus the time from
 * the top back to the plane. SP_EREFUSED for a box with fewer than 8 planes, and if there is no front. */
SP_API sp_status sp_coherent_section_make(const sp_network *net, const sp_coherent_section_options *opt,
                                          sp_coherent_section *out, sp_error *err);

/* The wave A exp(i k y - alpha y) at one frequency. */
typedef struct sp_coherent_wave {
    double omega; /* frequency [sqrt(E* / rho)/d] */
    double k;     /* wave number [1/d] */
    double alpha; /* attenuation of the amplitude [1/d]; without dashpots it is due to scattering */
    double part;  /* fraction of the weighted squared spectra of the planes that the wave explains, 0 .. 1 */
    double k_shift, alpha_shift; /* change of k; change of alpha, if only half the time after the arrival of the wave is
                                    used [1/d] */
} sp_coherent_wave;
/* Least-squares fit of the wave to the Fourier integrals of all planes. Planes near the source have most weight,
 * because the coherent wave dominates there. The integrals end smoothly four periods after the front, since what
 * follows is mostly scattered. The whole record is used instead if it leaves less than half as much unexplained, as in
 * an ordered system whose slow waves arrive late. A plane is left out if its record ends within half a period of the
 * arrival of the wave. Planes at a distance D resolve wave numbers below pi/D. k, alpha and their shifts are NAN above
 * the highest frequency of the section, with fewer than 4 planes, if k or alpha is at the end of its range (alpha:
 * -1/range .. 1/D), and if alpha > k. SP_EINVAL unless omega is positive and below half the Nyquist frequency of the
 * times. */
SP_API sp_status sp_coherent_fit(const sp_coherent_section *s, double omega, sp_coherent_wave *out, sp_error *err);
/* Errors of k and alpha of one packing: what half of the time after the front changes, and what scattered waves do to a
 * fit to fluxes that are independent at planes a diameter apart. Below omega = 0.4 they agree with the standard
 * deviation over 12 packings within a factor of two (docs/transport.md). */
SP_API void sp_coherent_errors(const sp_coherent_section *s, const sp_coherent_wave *wave, double *k_err,
                               double *alpha_err);

/* The scattering mean free path of a wave. */
typedef struct sp_free_path {
    double path, path_err;     /* 1/(2 alpha) [d]; NAN unless alpha is above twice its error */
    double low;                /* lower bound of path, from alpha plus two errors [d] */
    double k_path, k_path_err; /* k path; NAN where path is */
} sp_free_path;
SP_API sp_free_path sp_free_path_of(double k, double k_err, double alpha, double alpha_err);
/* The lowest frequency at which the mean free path falls to half a wavelength, k path = pi, between two of the
 * ascending frequencies omega [n], and its error (Ioffe and Regel 1960). False: there is none. */
SP_API bool sp_ioffe_regel(int32_t n, const double *omega, const sp_free_path *path, double *out, double *error);

#ifdef __cplusplus
}
#endif
#endif
