#ifndef SP_DRIVEN_H
#define SP_DRIVEN_H
/* The driven network, H = M^-1/2 (K - omega^2 M + i omega C) M^-1/2: sparse solves with error bounds. */

#include "linalg/lu.h"

#include <sonopack/spectrum.h>

typedef struct driven {
    int64_t n;
    int64_t *p, *i;          /* all entries, by columns */
    double *a, *c;           /* [p[n]] K and C over sqrt(m m); c is NULL without damping */
    double *size_a, *size_c; /* [p[n]] magnitudes of the terms that form the entries */
    double *x;               /* [p[n]][2] H */
    double *root;            /* [n] sqrt(m) */
    sp_lu *lu;
    double omega, inverse; /* frequency of the factor; estimate of |H^-1| from below */
    double *memory;        /* of all arrays except p and i */
    double *v, *w;         /* [n][2] scratch */
} driven;

/* dashpots: NULL without damping. */
sp_status sp_driven_make(const sp_network *net, const sp_network *dashpots, driven *out, sp_error *err);
sp_status sp_driven_factor(driven *d, double omega, sp_error *err);
/* u = H^-1 right, [n][2] each. */
sp_status sp_driven_solve(driven *d, const double *right, double *u, sp_error *err);
/* f = detector . u (without conjugation) and an upper bound of its error; u = H^-1 source and y = H^-1 detector from
 * sp_driven_solve. */
void sp_driven_response(driven *d, const double *source, const double *u, const double *detector, const double *y,
                        double f[2], double *error);
void sp_driven_free(driven *d);

/* Fits the waves of sp_wave_fit. f [n][2] at heights y, ascending and equally spaced. */
void sp_driven_fit(int32_t n, const double *y, const double *f, sp_wave_fit *out);

#endif
