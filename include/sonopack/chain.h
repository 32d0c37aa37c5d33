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

/* Frequency (C2) of mode n, 1 <= n <= grains, and its amplitude (C5) [l]; relative errors of a few 1e-16. */
SP_API double sp_chain_omega(int64_t grains, int64_t n);
SP_API double sp_chain_amplitude(int64_t grains, int64_t n, sp_chain_source source);

/* Force of the last ball on its wall (C6) without a sum over modes. With Omega = 2, the exact end of the spectrum, the
 * moments of the chain are 0, +-1 and +-2, so that F is a sum of a few Bessel functions of orders about 2 (N + 1), and
 * of 6 (N + 1), ... once the echoes arrive. Time n t, memory 8 t bytes, whatever N. Absolute error below 1e-15 (1 +
 * t^(1/4)). t ascending, >= 0; grains up to 1e9. SP_EINVAL. */
SP_API sp_status sp_chain_signal(int64_t grains, sp_chain_source source, int64_t n, const double *t, double *f,
                                 sp_error *err);
/* The same with wall springs other than K: the mapping of the triangular lattice (Section V B) has 4/3^(5/6) = 1.60,
 * over 1 + eta/3 with friction (the paper prints the reciprocal). Such a front is that of an equal chain, shifted by 2
 * (1/wall
 * - 1) in time and 1/wall as high, but for what falls as N^(-2/3). */
typedef struct sp_chain {
    int64_t grains;
    sp_chain_source source;
    double wall; /* K_wall/K, above 0 and below 2, where modes of the walls leave the spectrum */
} sp_chain;
SP_API sp_status sp_chain_walls_signal(const sp_chain *chain, int64_t n, const double *t, double *f, sp_error *err);
/* The same by the sum over modes (C4): grains x n terms. Absolute error below 1e-15 (1 + t). */
SP_API sp_status sp_chain_modal(int64_t grains, sp_chain_source source, int64_t n, const double *t, double *f,
                                sp_error *err);

/* The front of an infinitely long chain: Eq. (16), times 2 to be the limit of sp_chain_signal for A,
 *     F_A -> -8 t^(-2/3) Ai'(w),  F_B -> 16 t^(-1) Ai''(w) = 16 t^(-1) w Ai(w),  w = 2 (N - t)/t^(1/3),
 * and for B its derivative (the paper prints -4 for the factor, up to a constant). At equal w the difference over the
 * height falls as N^(-1/3), because w counts the way from N: with N + 1, the way from wall to wall, it would fall as
 * N^(-2/3); that is, sp_chain_signal at t + 1 is that near to this at t. */
SP_API sp_status sp_chain_airy(int64_t grains, sp_chain_source source, int64_t n, const double *t, double *f,
                               sp_error *err);

/* The first front of sp_chain_signal: the marks of sp_front_find in a window that ends before the second crest. Times
 * right to 1e-11 of themselves, height and width to 1e-14 (1 + N^(2/3)). (Crests grow behind the front, for A to 3
 * times its height at the second one, for B to 10 times: for B the first peak is below 0.2 of the largest value of a
 * long trace from N = 12 on.) SP_EREFUSED for B with one ball, whose trace begins at its peak. */
SP_API sp_status sp_chain_front(int64_t grains, sp_chain_source source, sp_front *out, sp_error *err);

/* Of the front of an infinitely long chain: amplitude N^gamma -> height, (t_zero - t10)/N^(1/3) -> width, (t_zero -
 * t_peak)/N^(1/3) -> width_peak; gamma = 2/3 (A) or 1 (B), alpha = 1/3. */
typedef struct sp_chain_limit {
    double gamma, alpha, height, width, width_peak;
} sp_chain_limit;
SP_API sp_chain_limit sp_chain_limit_of(sp_chain_source source);

#ifdef __cplusplus
}
#endif
#endif
