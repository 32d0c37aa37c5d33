#ifndef SONOPACK_MODES_H
#define SONOPACK_MODES_H
/* Eigenfrequencies and eigenmodes of K u = omega^2 M u. */

#include <sonopack/network.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sp_modes_options {
    bool vectors;     /* false: frequencies only */
    sp_source source; /* for a; b is the force on the top wall */
} sp_modes_options;
SP_API sp_modes_options sp_modes_options_default(void);

enum { SP_MODES_DENSE_MAX = 20000 }; /* degrees of freedom that the dense solver takes */

typedef enum sp_modes_method { SP_MODES_DENSE = 0, SP_MODES_SPARSE } sp_modes_method;

/* A set of modes: the whole spectrum, or a part of it without a hole. In ascending order; the zero modes of rattlers
 * (dof each) come first and have no vector here. u^(n) = M^(-1/2) e^(n) with e orthonormal. Signal: F(t) = sum a_n b_n
 * sin(omega_n t) (Eq. (3)), or cos for a displacement source. */
typedef struct sp_modes {
    int64_t n;             /* rows below: n_rattler, and those with vectors; all that there are, or a part */
    int64_t n_rattler;     /* zero modes that belong to rattlers: rows 0 .. n_rattler-1 */
    int64_t n_zero;        /* all modes with omega reported as 0, those included */
    int64_t dofs;          /* length of a vector: network n x dof */
    double *omega;         /* [n] sqrt(E* / rho)/d */
    double *error;         /* [n] bound of the error of omega */
    double *a, *b;         /* [n] source and detector amplitudes; NULL without vectors */
    double *participation; /* [n] (sum w)^2 / (N sum w^2), w = |e|^2 of each of the network's N grains, rattlers left
                              out (1/N for a mode of a rattler); NULL without vectors */
    double *vectors;       /* [n - n_rattler][dofs], e^(n) (mass weighted), the sign makes the largest part positive;
                              NULL without vectors */
    double residual;       /* largest |A e - omega^2 e| / omega_max^2 over modes; NAN without vectors */
    double orthogonality;  /* largest |e_m . e_n - delta|; NAN without vectors */
    int64_t first;         /* modes of the whole spectrum below row 0; 0 for a set that starts at omega = 0 */
    sp_modes_method method;
    double certified_from, certified_to; /* no mode with a frequency between these is missing: by the number of rows
                                            (dense), by the inertia of K - omega^2 M at both (sparse) */
    int64_t on_edge;                     /* rows of which the error bound does not tell whether they lie in the band */
    int64_t factors, solves;             /* sparse: factorisations, and right-hand sides solved for */
} sp_modes;

SP_API sp_modes sp_modes_none(void);
/* All modes with LAPACK (dense: memory 8 (n dof)^2 bytes twice; refuses above 20000 degrees of freedom). */
SP_API sp_status sp_modes_dense(const sp_network *net, const sp_modes_options *opt, sp_modes *out, sp_error *err);

/* Which modes. */
typedef struct sp_modes_range {
    int64_t lowest;  /* > 0: that many, counted from the lowest of the network, rattlers' zero modes in front beside
                        them;  0: the band below */
    double from, to; /* omega, limits included; 0 and infinity: all */
} sp_modes_range;
SP_API sp_modes_range sp_modes_range_all(void);
SP_API sp_modes_range sp_modes_range_lowest(int64_t count);
SP_API sp_modes_range sp_modes_range_band(double from, double to);

/* A part of the spectrum, or all of it, by block Lanczos on (K - sigma M)^-1 in slices, each counted by the inertia of
 * K - sigma M: memory 8 bytes for each element of the vectors that are kept, and for the factor. A mode within its own
 * error of a limit of the band is in the set, and counted in on_edge. SP_EINVAL for a range that is none; SP_EREFUSED
 * where no count can be vouched for, for an unstable network, and for more memory than there is. */
SP_API sp_status sp_modes_sparse(const sp_network *net, const sp_modes_options *opt, const sp_modes_range *range,
                                 sp_modes *out, sp_error *err);
/* Either solver, whichever is expected to be faster; the dense one's set is cut to the range. */
SP_API sp_status sp_modes_make(const sp_network *net, const sp_modes_options *opt, const sp_modes_range *range,
                               sp_modes *out, sp_error *err);
SP_API void sp_modes_free(sp_modes *m);

enum { SP_DAMPED_MODES_MAX = 2000 }; /* degrees of freedom */

/* Modes u e^(lambda t) of M u'' + C u' + K u = 0, the dashpots C those of sp_network_damping: one row for a pair lambda
 * = -decay +- i omega, or for a real lambda (omega = 0). Ascending by omega, then decay; without rattlers. Signal: F(t)
 * = sum e^(-decay t) (cosine cos(omega t) + sine sin(omega t)), the force of springs and dashpots on the top wall after
 * the whole bottom wall's source, as long as no two lambda coincide. */
typedef struct sp_damped_modes {
    int64_t n;
    double *omega, *decay; /* [n] sqrt(E* / rho)/d */
    double *cosine, *sine; /* [n] */
    double *error;         /* [n] of lambda, to first order in rounding (of the second where two lambda coincide) */
    double residual; /* largest |(lambda^2 M + lambda C + K) u| over (|lambda|^2 + |lambda| c + omega_max^2) |u|, in
                        the metric of the masses, c the largest eigenvalue of M^-1 C */
} sp_damped_modes;
SP_API sp_damped_modes sp_damped_modes_none(void);
/* Dense, of twice the size: a minute at 2000 degrees of freedom, beyond which SP_EREFUSED. zeta > 0. */
SP_API sp_status sp_damped_modes_make(const sp_network *net, double zeta, sp_source source, sp_damped_modes *out,
                                      sp_error *err);
SP_API void sp_damped_modes_free(sp_damped_modes *m);

enum { SP_STABILITY_MAX = 6000 }; /* degrees of freedom whose eigenvalues are all found where K is not symmetric */

typedef enum sp_modes_verdict {
    SP_MODES_STABLE = 0, /* no eigenvalue is negative or complex, those that count as zero left out */
    SP_MODES_UNSTABLE,   /* some certainly are, by more than forces at rest that do not balance explain */
    SP_MODES_UNDECIDED   /* neither can be shown */
} sp_modes_verdict;

/* The stability of M u'' = -K u, K with prestress or without. An eigenvalue omega^2 of M^-1 K that is negative lets a
 * motion diverge, a complex pair lets one grow in turns (flutter). Each comes with a disc that holds it for certain. */
typedef struct sp_stability {
    sp_modes_verdict verdict;
    bool dense;          /* all eigenvalues, in discs; false: counts by the inertia of the symmetric part alone */
    int64_t dofs;        /* of the network */
    int64_t negative;    /* eigenvalues below 0 for certain; -1: not known */
    int64_t flutter;     /* complex pairs, for certain; -1: not known */
    int64_t unbalanced;  /* of the two, those within `balance`: alone they leave the verdict undecided; -1: not known */
    int64_t zero;        /* within their own error of 0 (floppy motions), or spins of spheres with two contacts that are
                            at rest; -1: not known */
    double softest;      /* least real part of the others; NAN: not known [E* / (rho d^2)] */
    double growth;       /* rate of the fastest motion that certainly grows with these springs; 0 without
                            [sqrt(E* / rho)/d] */
    double growth_bound; /* none grows faster than that */
    double error;        /* largest radius of a disc, or error of a count [E* / (rho d^2)] */
    double balance;      /* what forces at rest that do not balance may do to an eigenvalue that would be 0 */
    double skew;         /* sp_network_skew */
} sp_stability;
/* p: the packing that the network was made of. Where K is symmetric for any size, by counts. Else up to
 * SP_STABILITY_MAX degrees of freedom by all eigenvalues (dense: minutes there, memory 32 n^2 bytes); beyond that
 * undecided, with the growth that the values x^T A x allow. SP_EREFUSED where nothing can be shown. */
SP_API sp_status sp_stability_make(const sp_packing *p, const sp_network *net, sp_stability *out, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
