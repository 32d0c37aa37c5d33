#ifndef SP_PACKET_H
#define SP_PACKET_H
/* Motions that are filtered to a band of frequencies, and advanced in time, by Chebyshev polynomials of
 * X = 1 - 2A/Omega^2 = cos(theta), A = M^-1/2 K M^-1/2: a frequency is omega = Omega sin(theta/2). */

#include <sonopack/transport.h>

/* Workspace for motions of one network. A motion is [dofs][2]: displacements and velocities, interleaved. Their energy
 * without change bounds the rounding errors, and tells an unstable network. */
typedef struct packet_space {
    const sp_network *net;
    int64_t n; /* degrees of freedom */
    double omega;
    double *t, *step, *force, *sum; /* [n][2] T_k, T_k - T_(k-1), K T_k, result */
    sp_energy *energy;              /* [grains] of sp_packet_energies */
} packet_space;

/* SP_EREFUSED if K is not symmetric. */
sp_status sp_packet_space_make(const sp_network *net, packet_space *out, sp_error *err);
void sp_packet_space_free(packet_space *s);

/* Coefficients of T_k(X): of displacements in displacements and of velocities in velocities (same), of velocities in
 * displacements (lift), of displacements in velocities (push). lift and push may be NULL: 0. */
typedef struct packet_map {
    int64_t terms;
    double *same, *lift, *push;
} packet_map;
void sp_packet_map_free(packet_map *m);

/* The motion after a time t >= 0. */
sp_status sp_packet_map_time(double omega_max, double t, packet_map *out, sp_error *err);
/* Multiplies each mode by exp(-(w - omega)^2/(2 width^2)), and by its image at -omega. */
sp_status sp_packet_map_band(double omega_max, double omega, double width, packet_map *out, sp_error *err);

/* Replaces a motion by its map. */
void sp_packet_apply(packet_space *s, const packet_map *m, double *motion);

/* SP_EINVAL, which begins with `what`, unless omega is above 0 and width, over omega, in 0.001 .. 0.5. */
sp_status sp_packet_check_band(const char *what, double omega, double width, sp_error *err);
/* The map of such a band: the energy falls off like the square of the filter. */
sp_status sp_packet_band(const packet_space *s, double omega, double width, packet_map *out, sp_error *err);
/* Limits a motion to a band. *energy: what is left, or NULL. SP_EREFUSED if that is nothing. */
sp_status sp_packet_filter(packet_space *s, const packet_map *band, double omega, double *motion, double *energy,
                           sp_error *err);
/* The motion after an impulse at the bottom wall. */
sp_status sp_packet_impulse(packet_space *s, double *motion, sp_error *err);

/* Energy of a motion. */
double sp_packet_energy(packet_space *s, const double *motion);
/* Energies of its grains, s->energy. */
sp_status sp_packet_energies(packet_space *s, const double *motion, sp_error *err);
/* Displacements and velocities of a motion, [2][n] in scratch memory. */
double *sp_packet_parts(packet_space *s, const double *motion);
/* *drift becomes the larger of its value and |ratio - 1| of two energies. SP_EREFUSED if it is not small. */
sp_status sp_packet_check_drift(double ratio, double *drift, sp_error *err);

#endif
