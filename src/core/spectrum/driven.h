#ifndef SP_DRIVEN_H
#define SP_DRIVEN_H
/* The driven network, H = M^-1/2 (K - omega^2 M + i omega C) M^-1/2: sparse solves with error bounds. */

#include "linalg/complex_ldl.h"

#include <sonopack/spectrum.h>

typedef struct driven {
    int64_t n;
    int64_t *p, *i;          /* all entries, by columns */
    double *a, *c;           /* [p[n]] K and C over sqrt(m m); c is NULL without damping */
    double *size_a, *size_c; /* [p[n]] magnitudes of the terms that form the entries */
    double *x;               /* [p[n]][2] H */
    double *lower;           /* [entries of the lower triangle][2] of H */
    int64_t *in_lower;       /* index in x of an entry of the lower triangle */
    int64_t entries;         /* of the lower triangle */
    double *root;            /* [n] sqrt(m) */
    sp_complex_ldl *ldl;
    double omega, size, inverse; /* frequency of the factor; upper bound of |H|; estimate of |H^-1| from below */
    double *memory;              /* of all arrays of doubles */
    double *v, *w;               /* [SP_DRIVEN_MOST][n][2] scratch */
} driven;

enum { SP_DRIVEN_MOST = 32 }; /* right-hand sides at once */

/* A solution of sp_driven_solve: [n][2], [n][2], [n]. */
typedef struct driven_solution {
    const double *b, *u, *rest;
} driven_solution;

/* dashpots: NULL without damping. */
sp_status sp_driven_make(const sp_network *net, const sp_network *dashpots, driven *out, sp_error *err);
sp_status sp_driven_factor(driven *d, double omega, sp_error *err);
/* u = H^-1 b for `count` right-hand sides, [count][n][2] each, at most SP_DRIVEN_MOST. rest [count][n]: upper bound of
 * the magnitudes of b - H u. */
sp_status sp_driven_solve(driven *d, int count, const double *b, double *u, double *rest, sp_error *err);
/* f = detector . u (without conjugation) and an upper bound of its error, from the solutions of both with their rests.
 */
void sp_driven_response(const driven *d, const driven_solution *source, const driven_solution *detector, double f[2],
                        double *error);
void sp_driven_free(driven *d);

#endif
