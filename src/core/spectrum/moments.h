#ifndef SP_MOMENTS_H
#define SP_MOMENTS_H
/* Spectral densities without eigenvectors (kernel polynomial method; Weisse, Wellein, Alvermann, Fehske, Rev. Mod.
 * Phys. 78, 275, 2006). With A = M^-1/2 K M^-1/2, Omega no smaller than the largest frequency and X = 1 - 2 A/Omega^2,
 * an eigenfrequency is omega = Omega sin(phi/2), X = cos(phi), and <x| delta(phi - phi(A)) |y> = (1/pi) [mu_0 + 2 sum_k
 * g_k mu_k cos(k phi)],   mu_k = <x| T_k(X) |y>, with Jackson's factors g_k: a positive kernel with the standard
 * deviation pi/n in phi. */

#include <sonopack/network.h>

/* Moments of two vectors x, y from one pass over the springs for every two moments. Vectors are displacements (the
 * scalar product has the masses), [dofs][2] interleaved. */
typedef struct moment_set {
    int64_t n;
    double omega;    /* Omega */
    double *xx, *yy; /* [n] <x|T_k|x>, <y|T_k|y> */
    double *xy;      /* [n] <x|T_k|y> */
    double reach;    /* |x| |y| */
} moment_set;

/* SP_EREFUSED where the vectors grow: an unstable network, or Omega too small. */
sp_status sp_moments_make(const sp_network *net, int64_t n, const double *pair, moment_set *out, sp_error *err);
void sp_moments_free(moment_set *m);

/* How many moments give the kernel the standard deviation `width` at frequency 0, where it is largest: there it is pi
 * Omega/(2 n), and sqrt(1 - (omega/Omega)^2) times that elsewhere. */
int64_t sp_moments_for_width(double omega, double width);
double sp_moments_width(double omega, int64_t n);
/* g [n]: Jackson's factors. */
void sp_moments_jackson(int64_t n, double *g);

/* phi of a frequency; above Omega that of Omega. */
double sp_moments_phase(double omega, double frequency);
/* (1/pi) [g_0 mu_0 + 2 sum g_k mu_k cos(k phi)] dphi/domega: density in omega. g may be NULL (mu holds the products).
 */
double sp_moments_density(double omega, int64_t n, const double *g, const double *mu, double frequency);
/* Its integral from 0 to the frequency. */
double sp_moments_integral(double omega, int64_t n, const double *g, const double *mu, double frequency);

#endif
