#ifndef SP_MOMENTS_H
#define SP_MOMENTS_H
/* Spectral densities without eigenvectors, by the kernel polynomial method (Weisse, Wellein, Alvermann, Fehske, Rev.
 * Mod. Phys. 78, 275, 2006). A = M^-1/2 K M^-1/2; Omega is an upper bound of the frequencies; X = 1 - 2 A/Omega^2. An
 * eigenfrequency is omega = Omega sin(phi/2), with X = cos(phi), and
 *   <x| delta(phi - phi(A)) |y> = (1/pi) [mu_0 + 2 sum_k g_k mu_k cos(k phi)],   mu_k = <x| T_k(X) |y>.
 * Jackson's factors g_k give a positive kernel with the standard deviation pi/n in phi. */

#include <sonopack/network.h>

/* Moments of two vectors x, y. One pass over the springs gives two moments. Vectors are displacements, [dofs][2]
 * interleaved, with the masses in the scalar product. */
typedef struct moment_set {
    int64_t n;
    double omega;    /* Omega */
    double *xx, *yy; /* [n] <x|T_k|x>, <y|T_k|y> */
    double *xy;      /* [n] <x|T_k|y> */
    double reach;    /* |x| |y| */
} moment_set;

/* SP_EREFUSED if the vectors grow: the network is unstable, or Omega is too small. */
sp_status sp_moments_make(const sp_network *net, int64_t n, const double *pair, moment_set *out, sp_error *err);
void sp_moments_free(moment_set *m);

/* Number of moments for which the kernel has the standard deviation `width` at frequency 0. It is pi Omega/(2 n) there
 * and sqrt(1 - (omega/Omega)^2) times that at omega. */
int64_t sp_moments_for_width(double omega, double width);
double sp_moments_width(double omega, int64_t n);
/* Jackson's factors, g [n]. */
void sp_moments_jackson(int64_t n, double *g);

/* phi of a frequency; above Omega: that of Omega. */
double sp_moments_phase(double omega, double frequency);
/* Density in omega, (1/pi) [g_0 mu_0 + 2 sum g_k mu_k cos(k phi)] dphi/domega; 0 from Omega on. g NULL: mu holds the
 * products g_k mu_k. */
double sp_moments_density(double omega, int64_t n, const double *g, const double *mu, double frequency);
/* Its integral from 0 to the frequency. */
double sp_moments_integral(double omega, int64_t n, const double *g, const double *mu, double frequency);

#endif
