#ifndef SONOPACK_CHAIN_H
#define SONOPACK_CHAIN_H
/* The chain of equal balls between two fixed walls in closed form (Somfai et al. 2005, Section V A and Appendix C): N
 * masses m at distances l, N + 1 springs K. Units: length l, time l/c = sqrt(m/K), force K l. */

#include <sonopack/front.h>
#include <sonopack/status.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum sp_chain_source {
    SP_CHAIN_VELOCITY = 0, /* source A: the first ball has velocity c */
    SP_CHAIN_DISPLACEMENT  /* source B: the first ball is displaced by l */
} sp_chain_source;

/* Frequency (C2) and amplitude (C5) [l] of mode n, 1 <= n <= grains. Relative errors: a few 1e-16. */
SP_API double sp_chain_omega(int64_t grains, int64_t n);
SP_API double sp_chain_amplitude(int64_t grains, int64_t n, sp_chain_source source);

/* Force of the last ball on its wall, Eq. (C6), at times t [n], ascending and >= 0; grains up to 1e9. No sum over modes
 * is needed: with Omega = 2, the exact end of the spectrum, the Chebyshev moments of the chain are 0, +-1 and +-2. F is
 * therefore a sum of a few Bessel functions of orders near 2 (N + 1), and of 6 (N + 1), ... for the echoes. Run time n
 * t and memory 8 t bytes, independent of N. Absolute error: sp_chain_signal_error. SP_EINVAL for invalid arguments. */
SP_API sp_status sp_chain_signal(int64_t grains, sp_chain_source source, int64_t n, const double *t, double *f,
                                 sp_error *err);
/* A chain whose wall springs differ from K. The triangular lattice (Section V B) maps to such a chain with K_wall/K =
 * 4/3^(5/6) = 1.60, over 1 + eta/3 with friction (the paper prints the reciprocal). Its front is that of the chain of
 * equal springs, shifted by 2 (1/wall - 1) in time and multiplied by 1/wall, up to terms that fall as N^(-2/3). */
typedef struct sp_chain {
    int64_t grains;
    sp_chain_source source;
    double wall; /* K_wall/K, 0 < wall < 2; from 2 on, modes of the walls lie above the spectrum */
} sp_chain;
SP_API sp_status sp_chain_walls_signal(const sp_chain *chain, int64_t n, const double *t, double *f, sp_error *err);
/* Upper bound of the error of F at time t: 1e-15 (1 + (t + t^2/(N + 1))^(1/4)) for equal springs, where it grows with
 * the number of echoes, and 1e-15 (1 + t) for others, where the rounding of K_wall/K shifts the frequencies. */
SP_API double sp_chain_signal_error(const sp_chain *chain, double t);
/* The front of an infinitely long chain: Eq. (16), multiplied by 2 to be the limit of sp_chain_signal for A, and its
 * derivative for B,
 *     F_A -> -8 t^(-2/3) Ai'(w),  F_B -> 16 t^(-1) Ai''(w) = 16 t^(-1) w Ai(w),  w = 2 (N - t)/t^(1/3).
 * (The paper prints -4 for the factor, up to a constant.) At equal w the relative difference falls as N^(-1/3), because
 * w measures distance from N. With N + 1, the distance between the walls, it would fall as N^(-2/3): sp_chain_signal at
 * t + 1 is that close to this function at t. */
SP_API sp_status sp_chain_airy(int64_t grains, sp_chain_source source, int64_t n, const double *t, double *f,
                               sp_error *err);

/* The first front of sp_chain_signal: the marks of sp_front_find in a window that ends before the second crest.
 * Relative error of times 1e-11; absolute error of height and width 1e-14 (1 + N^(2/3)). SP_EREFUSED for source B with
 * one ball, whose signal starts at its peak. (Crests grow behind the front: at the second crest to 3 times its height
 * for A and 10 times for B. From N = 12 on, the first peak of B is below 0.2 of the largest value of a long signal.) */
SP_API sp_status sp_chain_front(int64_t grains, sp_chain_source source, sp_front *out, sp_error *err);

/* Limits for an infinitely long chain: amplitude N^gamma -> height, (t_zero - t10)/N^(1/3) -> width, (t_zero -
 * t_peak)/N^(1/3) -> width_peak; gamma = 2/3 (A) or 1 (B), alpha = 1/3. */
typedef struct sp_chain_limit {
    double gamma, alpha, height, width, width_peak;
} sp_chain_limit;
SP_API sp_chain_limit sp_chain_limit_of(sp_chain_source source);

#ifdef __cplusplus
}
#endif
#endif
