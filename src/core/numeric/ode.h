#ifndef SP_ODE_H
#define SP_ODE_H
/* Single explicit Runge-Kutta steps of y' = f(t, y). Who drives them chooses lengths, stops at jumps of f, and looks
 * between steps by a shorter step from the same start, which costs no order. */

#include <sonopack/status.h>
#include <stdint.h>

typedef void sp_ode_slope(double t, const double *y, double *slope, void *user);

typedef struct sp_ode {
    int64_t n;
    sp_ode_slope *slope;
    void *user;
    double *room; /* stages and a point to evaluate them at, [8][n] */
} sp_ode;

SP_SHARED sp_status sp_ode_make(int64_t n, sp_ode_slope *slope, void *user, sp_ode *out, sp_error *err);
SP_SHARED void sp_ode_free(sp_ode *ode);

/* The classical scheme of order 4; to may be y. */
SP_SHARED void sp_ode_step4(sp_ode *ode, double t, double h, const double *y, double *to);
/* The pair of orders 5 and 4 of J. R. Dormand, P. J. Prince (J. Comput. Appl. Math. 6, 1980), going on with order 5.
 * Returns the largest |difference of the two| over scale[i] + |y[i]|; to may not be y. */
SP_SHARED double sp_ode_step5(sp_ode *ode, double t, double h, const double *y, const double *scale, double *to);
/* By which factor the length of a step of the pair should change when its error is error times the tolerance. */
SP_SHARED double sp_ode_factor(double error);

#endif
