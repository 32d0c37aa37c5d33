#ifndef SONOPACK_CHAIN_H
#define SONOPACK_CHAIN_H
/* The chain of equal balls between two walls in closed form (Section V A and Appendix C of Somfai et al. 2005): N
 * masses m at distances l, N + 1 springs K, walls fixed. Units here: length l, time l/c = sqrt(m/K), force K l. */

#include <sonopack/front.h>
#include <sonopack/status.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum sp_chain_source {
    SP_CHAIN_VELOCITY = 0, /* (A): the first ball has velocity c */
    SP_CHAIN_DISPLACEMENT  /* (B): the first ball is displaced by l */
} sp_chain_source;

/* Frequency (C2) of mode n, 1 <= n <= grains, and its amplitude (C5) [l]. */
double sp_chain_omega(int64_t grains, int64_t n);
double sp_chain_amplitude(int64_t grains, int64_t n, sp_chain_source source);

/* Force of the last ball on its wall (C6), from the moments: those of a uniform chain are 0 and +-1, so that F is a sum
 * of a few Bessel functions of orders about 2 N. Absolute error below 1e-14 sqrt(t). t ascending, >= 0, up to
 * 3 (grains + 1). SP_EINVAL. */
sp_status sp_chain_signal(int64_t grains, sp_chain_source source, int64_t n, const double *t, double *f, sp_error *err);
/* The same by the sum over modes (C4): grains x n terms. */
sp_status sp_chain_modal(int64_t grains, sp_chain_source source, int64_t n, const double *t, double *f, sp_error *err);
/* The front of an infinitely long chain, Eq. (16) for A and its derivative for B, with the factors that make them the
 * limit of sp_chain_signal. */
sp_status sp_chain_airy(int64_t grains, sp_chain_source source, int64_t n, const double *t, double *f, sp_error *err);
/* The first front, found on a grid fine enough for 1e-9 of its marks; distance: grains. */
sp_status sp_chain_front(int64_t grains, sp_chain_source source, sp_front *out, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
