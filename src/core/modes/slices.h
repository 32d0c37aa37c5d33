#ifndef SP_SLICES_H
#define SP_SLICES_H
/* Eigenpairs of A = M^-1/2 K M^-1/2 between two shifts, with their number from the inertia.
 *
 * Null motions are known beforehand and are neither searched nor counted: only the other eigenvalues, called modes
 * here. Each spin s, a vector of one grain, is moved out of the spectrum: A + LIFT top s s^T has the eigenvalue LIFT
 * top in place of 0, all others remain, and the matrix has no new entries. The search for vectors is orthogonal to
 * rigid motions, and counts are corrected for them. */

#include "linalg/lanczos.h"
#include "modes/refine.h"

#include <sonopack/modes.h>

/* A shift and its count: `below` modes below sigma of a matrix within `error` of A. */
typedef struct slice_edge {
    double sigma, error;
    int64_t below;
} slice_edge;

typedef struct slicer slicer;
/* Finds the modes between two edges, for which there is room, in pieces. SP_EREFUSED if those of a piece cannot be
 * counted. */
typedef sp_status sp_slicer_divide(slicer *z, slice_edge a, slice_edge b, sp_error *err);

struct slicer {
    const sp_network *net;
    bool vectors;             /* keep the eigenvectors */
    sp_modes_solver solver;   /* ARPACK, or block Lanczos */
    int threads;              /* that share pieces of the spectrum */
    sp_slicer_divide *divide; /* solves many modes in pieces; NULL: there are none */
    double tolerance;         /* of the Lanczos residuals */
    int64_t n;                /* length of a vector */
    int64_t modes;            /* eigenvalues that are not those of null motions */
    sp_null_motions null;
    bool null_rows; /* keep the null motions in front of the list */
    double top;     /* upper bound of the spectrum of A */
    double noise;   /* upper bound of |A as assembled - A| */
    sp_ldl *ldl;
    int64_t capacity, found;
    int64_t front;         /* null motions in the list, or 0 */
    sp_ritz *ritz;         /* [front + capacity] */
    double *vector;        /* [front + capacity][n] */
    sp_lanczos_pairs last; /* pairs of the last slice */
    int64_t factors, solves;
};

sp_status sp_slicer_make(const sp_network *net, bool vectors, slicer *out, sp_error *err);
void sp_slicer_free(slicer *z);

/* Finds the most reliable edge between low and high. SP_EREFUSED if there is none. */
sp_status sp_slicer_edge(slicer *z, double low, double high, slice_edge *out, sp_error *err);
/* An edge below the whole spectrum, at -depth or lower. SP_EREFUSED for an unstable network. */
sp_status sp_slicer_bottom(slicer *z, double depth, slice_edge *out, sp_error *err);
/* An edge as near above zero as the factor allows. */
sp_status sp_slicer_soft(slicer *z, slice_edge *out, sp_error *err);
/* An edge above the whole spectrum; needs no factorization. */
slice_edge sp_slicer_top(const slicer *z);
/* What is known of the eigenvalue of a null motion. */
sp_ritz sp_slicer_null(const slicer *z);
/* Estimate of the omega^2 below which `count` modes lie, by Debye's law. */
double sp_slicer_guess(const slicer *z, double count);

/* Finds all modes between two edges and stores them in ritz and vector. *certain: none is so near an edge that it
 * may lie on the other side. */
sp_status sp_slicer_between(slicer *z, slice_edge a, slice_edge b, bool *certain, sp_error *err);
/* Finds the `count` softest modes, zero or not, or some more. *end: an edge above the last one, which proves that none
 * is missing. */
sp_status sp_slicer_softest(slicer *z, int64_t count, slice_edge *end, sp_error *err);
/* Number of zero modes among the modes found, which are all up to some edge. */
sp_status sp_slicer_zeros(const slicer *z, int64_t *zeros, sp_error *err);
/* Finds all modes that are zero modes and the `count` lowest others, or some more. SP_EINVAL if there are fewer. *end:
 * an edge above the last one, which proves that none is missing. */
sp_status sp_slicer_lowest(slicer *z, int64_t count, slice_edge *end, sp_error *err);

enum { SP_SLICER_PIECE = 512 }; /* modes of a piece at most: some slices, which cost more than its edges and analysis */
/* A sp_slicer_divide: each piece has a slicer of its own, and z->threads threads share them. The pieces do not depend
 * on the number of threads, and neither does the result. */
sp_status sp_slicer_pieces(slicer *z, slice_edge a, slice_edge b, sp_error *err);

#endif
