#ifndef SONOPACK_PULSE_H
#define SONOPACK_PULSE_H
/* Signals of any pulse: the source acts with the strength s(t) instead of all at once, and
 * F(t) = integral of s(t') G(t - t') dt' with the signal G of the short pulse (sp_signal_make). */

#include <sonopack/signal.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum sp_pulse_kind {
    SP_PULSE_DELTA = 0, /* F = G */
    SP_PULSE_GAUSS,     /* exp(-t^2/(2 width^2))/(width sqrt(2 pi)): integral 1, middle at t = 0 */
    SP_PULSE_RICKER,    /* (1 - 2 q^2) exp(-q^2), q = omega t/2: its spectrum is largest at omega; middle at t = 0 */
    SP_PULSE_SINE,      /* sin(omega t) (1 - cos(omega t/cycles))/2 for 0 < t < 2 pi cycles/omega: a burst */
    SP_PULSE_SQUARE,    /* 1/width for 0 < t < width: integral 1 */
    SP_PULSE_TABLE      /* straight lines between points (t, s); 0 before the first and after the last */
} sp_pulse_kind;

typedef struct sp_pulse {
    sp_pulse_kind kind;
    double width, omega, cycles; /* as the kind needs them */
    int64_t n;
    const double *t, *s; /* table: [n], t not descending; two points at one time are a jump */
} sp_pulse;

/* SP_EINVAL for numbers that make no pulse. */
SP_API sp_status sp_pulse_check(const sp_pulse *p, sp_error *err);
SP_API double sp_pulse_strength(const sp_pulse *p, double t); /* s(t); not of a delta. At a jump the later value */
/* Where it is not negligible: below 1e-16 of its largest value outside. 0 and 0 for a delta. */
SP_API void sp_pulse_span(const sp_pulse *p, double *first, double *last);

/* The signals of opt with this pulse. Their errors include that of the quadrature, from two grids and two rules.
 * SP_EREFUSED where the error exceeds the tolerance: a pulse whose frequencies the network cannot follow leaves next to
 * nothing. */
SP_API sp_status sp_signal_pulse(const sp_network *net, const sp_signal_options *opt, const sp_pulse *pulse,
                                 sp_signal *out, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
