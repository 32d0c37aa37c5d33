#ifndef SONOPACK_PULSE_H
#define SONOPACK_PULSE_H
/* Signals of pulses of any shape s(t): F(t) = integral of s(t') G(t - t') dt', with the signal G of the short pulse
 * (sp_signal_make). */

#include <sonopack/signal.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum sp_pulse_kind {
    SP_PULSE_DELTA = 0, /* short pulse: F = G */
    SP_PULSE_GAUSS,     /* exp(-t^2/(2 width^2))/(width sqrt(2 pi)): integral 1, centred at t = 0 */
    SP_PULSE_RICKER,    /* (1 - 2 q^2) exp(-q^2), q = omega t/2: spectrum largest at omega, centred at t = 0 */
    SP_PULSE_SINE,      /* burst sin(omega t) (1 - cos(omega t/cycles))/2 for 0 < t < 2 pi cycles/omega */
    SP_PULSE_SQUARE,    /* 1/width for 0 < t < width: integral 1 */
    SP_PULSE_TABLE      /* linear interpolation between points (t, s); 0 outside */
} sp_pulse_kind;

typedef struct sp_pulse {
    sp_pulse_kind kind;
    double width, omega, cycles; /* parameters of the kind */
    int64_t n;
    const double *t, *s; /* table: [n], t must not descend; two points at the same time are a jump */
} sp_pulse;

/* SP_EINVAL for invalid parameters. */
SP_API sp_status sp_pulse_check(const sp_pulse *p, sp_error *err);
SP_API double sp_pulse_strength(const sp_pulse *p,
                                double t); /* s(t), for any kind except delta. At a jump: the later value */
/* The interval outside which s is below 1e-16 of its largest value; 0 and 0 for a delta. */
SP_API void sp_pulse_span(const sp_pulse *p, double *first, double *last);

/* The signals of opt with this pulse. The error includes that of the quadrature, which is estimated with a second grid
 * and a second rule. SP_EREFUSED if the error exceeds the tolerance: if the frequencies of the pulse lie above those of
 * the network, next to nothing remains of the signal. */
SP_API sp_status sp_signal_pulse(const sp_network *net, const sp_signal_options *opt, const sp_pulse *pulse,
                                 sp_signal *out, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
