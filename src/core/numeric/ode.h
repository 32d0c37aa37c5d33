#ifndef SP_ODE_H
#define SP_ODE_H
/* Single explicit Runge-Kutta steps of y' = f(t, y). The caller chooses step lengths and stops at jumps of f. For
 * values between steps it takes a shorter step from the same start, which keeps the order. */

#include <sonopack/status.h>
#include <stdint.h>

typedef void sp_ode_slope(double t, const double *y, double *slope, void *user);

typedef struct sp_ode {
    int64_t n;
    sp_ode_slope *slope;
    void *user;
    double *scratch; /* stages and a point to evaluate them at, [8][n] */
} sp_ode;

SP_SHARED sp_status sp_ode_make(int64_t n, sp_ode_slope *slope, void *user, sp_ode *out, sp_error *err);
SP_SHARED void sp_ode_free(sp_ode *ode);

/* Classical step of order 4. `to` may be y. */
SP_SHARED void sp_ode_step4(sp_ode *ode, double t, double h, const double *y, double *to);
/* Step of order 5 with an error estimate of order 4, by Dormand and Prince (J. Comput. Appl. Math. 6, 1980). Returns
 * the largest |difference of both orders| over scale[i] + |y[i]|. `to` must not be y. */
SP_SHARED double sp_ode_step5(sp_ode *ode, double t, double h, const double *y, const double *scale, double *to);
/* Factor for the next step length, for an error in units of the tolerance. */
SP_SHARED double sp_ode_factor(double error);

#endif
