#ifndef SP_SLICES_H
#define SP_SLICES_H
/* Eigenpairs of A = M^-1/2 K M^-1/2 between two shifts at which the inertia tells how many there are. */

#include "linalg/lanczos.h"
#include "modes/refine.h"

/* A shift and what its factor counts: the eigenvalues below sigma of a matrix within `error` of A. */
typedef struct slice_edge {
    double sigma, error;
    int64_t below;
} slice_edge;

typedef struct slicer {
    const sp_network *net;
    bool vectors;     /* whether they are kept */
    double tolerance; /* of the Lanczos residuals */
    int64_t n;
    double top;   /* upper bound of the spectrum of A */
    double noise; /* |A as assembled - A| is at most this */
    sp_ldl *ldl;
    int64_t room, found;
    sp_ritz *ritz;         /* [room] */
    double *vector;        /* [room][n] */
    sp_lanczos_pairs last; /* of the slice before */
    int64_t factors, solves;
} slicer;

sp_status sp_slicer_make(const sp_network *net, bool vectors, slicer *out, sp_error *err);
void sp_slicer_free(slicer *z);

/* An edge somewhere in low .. high, where the count is as good as can be had; SP_EREFUSED where none is. */
sp_status sp_slicer_edge(slicer *z, double low, double high, slice_edge *out, sp_error *err);
/* An edge below the whole spectrum, `depth` below 0 or more. SP_EREFUSED for an unstable network. */
sp_status sp_slicer_bottom(slicer *z, double depth, slice_edge *out, sp_error *err);
/* An edge above it, which costs nothing. */
slice_edge sp_slicer_top(const slicer *z);
/* omega^2 below which `count` modes are, roughly: Debye's law. */
double sp_slicer_guess(const slicer *z, double count);

/* All eigenvalues between two edges, into ritz and vector. certain: none of them is so near one of the two edges that
 * it may be on its other side. */
sp_status sp_slicer_between(slicer *z, slice_edge a, slice_edge b, bool *certain, sp_error *err);
/* The lowest `count`, or some more, with the edge above the last of them that proves that none is missing. */
sp_status sp_slicer_lowest(slicer *z, int64_t count, slice_edge *end, sp_error *err);

#endif
