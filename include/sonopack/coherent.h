#ifndef SONOPACK_COHERENT_H
#define SONOPACK_COHERENT_H
/* The coherent wave in a record section: signals at planes one above the other, of a simulation or a laboratory. Its
 * phase speed and its attenuation against frequency say how a front broadens, decays and slows down on its way. */

#include <sonopack/network.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Signals at planes. `until` ends each of them before the echo of the far wall comes; `arrival` is about when the front
 * does. */
typedef struct sp_coherent_section {
    int32_t planes;
    int32_t n;
    double spacing;  /* of the times 0, spacing, 2 spacing, ... [d/sqrt(E* / rho)] */
    double *y;       /* [planes] heights, ascending [d] */
    double *arrival; /* [planes] */
    double *until;   /* [planes] last time that counts, above the arrival */
    double *f;       /* [planes][n] */
    double highest;  /* no wave has a higher frequency: the network's largest, up to 1e-3; 0: not known */
} sp_coherent_section;
SP_API sp_coherent_section sp_coherent_section_none(void);
SP_API void sp_coherent_section_free(sp_coherent_section *s);

typedef struct sp_coherent_section_options {
    sp_source source;
    double spacing; /* of the planes [d]; 1 */
    double low;     /* the first plane above the bottom wall [d]; 4: farther than the springs of the wall are felt */
    double part;    /* planes up to this part of the height; 0.6: above it the echo soon follows */
} sp_coherent_section_options;
SP_API sp_coherent_section_options sp_coherent_section_options_default(void);
/* The momentum flux through planes of a packing after a pulse at its bottom wall. The flux is the same for all planes
 * between two layers of grains: `y` is where it is carried (sp_network_plane_height), and a plane with the y of the one
 * below is left out. A plane's time ends when the echo of
 * the front comes down to it: t10 at the top wall, and as long again as from the plane to the top. SP_EREFUSED for a
 * box with fewer than 8 planes, or without a front. */
SP_API sp_status sp_coherent_section_make(const sp_network *net, const sp_coherent_section_options *opt,
                                          sp_coherent_section *out, sp_error *err);

/* A e^(i k y - alpha y) at one frequency. */
typedef struct sp_coherent_wave {
    double omega;
    double k;     /* wave number [1/d] */
    double alpha; /* attenuation of the amplitude [1/d], by scattering where nothing is damped */
    double part;  /* of the planes' squared spectra, weighted as they are, that the wave accounts for, 0 .. 1 */
    double k_shift,
        alpha_shift; /* by how much k and alpha change if only half the time after the wave's coming counts */
} sp_coherent_wave;
/* Least squares over the planes' Fourier integrals, by which the planes near the source, where the wave stands out of
 * what is scattered, count most. The integrals end, smoothly, four periods after the front: later comes what was
 * scattered. Where the whole record leaves less than half as much unexplained, as in an ordered system whose slow waves
 * come late, it is taken. Planes whose record ends within half a period of the wave's coming do not count. Planes D
 * apart tell wave numbers below pi/D. k, alpha and the shifts are NAN where the section does not tell them: above its
 * highest frequency, with fewer than 4 planes that count, with alpha at an end of its range, -1/range .. 1/D, k at the
 * end of its, or alpha above k, which is no wave. omega > 0, below the half of what the spacing of the times can carry.
 * SP_EINVAL. */
SP_API sp_status sp_coherent_fit(const sp_coherent_section *s, double omega, sp_coherent_wave *out, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
