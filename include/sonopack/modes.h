#ifndef SONOPACK_MODES_H
#define SONOPACK_MODES_H
/* Frequencies and eigenmodes of a network of springs: K u = omega^2 M u. Frequencies are angular, in sqrt(E* / rho)/d.
 */

#include <sonopack/network.h>

#ifdef __cplusplus
extern "C" {
#endif

/* All of them give the same modes within their errors, and the same certificate. */
typedef enum sp_modes_solver {
    SP_SOLVER_AUTO = 0, /* the one that is expected to be the fastest */
    SP_SOLVER_LANCZOS,  /* block Lanczos on (K - sigma M)^-1, eight right-hand sides at a time */
    SP_SOLVER_ARPACK,   /* ARPACK on (K - sigma M)^-1; one search at a time in a process */
    SP_SOLVER_DENSE     /* LAPACK */
} sp_modes_solver;

typedef struct sp_modes_options {
    bool vectors;     /* compute eigenvectors too; false: frequencies only */
    sp_source source; /* source of the amplitudes a; b is always the force on the top wall */
    sp_modes_solver solver;
    int32_t threads; /* number of threads for large networks; does not change the result; 0 counts
                        as 1 */
} sp_modes_options;
SP_API sp_modes_options sp_modes_options_default(void);

/* Zero modes: motions without a restoring force. A mode counts as one if its frequency is below `below`, a fixed
 * fraction of the upper bound of all frequencies (1e-8, or 1e-7 with prestress): motions that stretch no spring stay
 * far below it in spite of rounding, and no mode of springs between grains is so soft. The numbers are exact: whatever
 * cannot be proved to lie on one side is refused. They belong to the packing, not to the modes that are asked for. */
typedef struct sp_zero_modes {
    int64_t rattlers;   /* dof for each rattler */
    int64_t spins;      /* motions of a single grain that stretch none of its springs: with friction, the spin of a
                           sphere about the line through its two contacts, or that of a grain without tangential
                           springs */
    int64_t rigid;      /* motions of grains that hang together, as a rigid body: a packing that slides along walls
                           without friction. Those that are sums of spins are not counted again. */
    int64_t mechanisms; /* all others: several grains that move against each other */
    int64_t total;      /* the sum of these four; -1, like mechanisms, if they were not counted */
    double below;       /* frequencies below this one count as zero [sqrt(E* / rho)/d] */
} sp_zero_modes;
/* Counts the zero modes, with one factorization of K unless there are mechanisms or very soft modes. SP_EREFUSED if K
 * is not symmetric, for an unstable network, and if it cannot be decided whether a mode is a zero mode. */
SP_API sp_status sp_zero_modes_count(const sp_network *net, sp_zero_modes *out, sp_error *err);

enum { SP_MODES_DENSE_MAX = 20000 }; /* largest problem for the dense solver, in degrees of freedom */

/* The whole spectrum or a contiguous part of it, in ascending order. If zero modes are among the rows, those of
 * rattlers come first; no eigenvectors are stored for them. The mode shapes are u^(n) = M^(-1/2) e^(n) with orthonormal
 * e^(n). The signal is F(t) = sum a_n b_n sin(omega_n t), Eq. (3) of Somfai et al. 2005, with cos in place of sin for a
 * displacement source.
 */
typedef struct sp_modes {
    int64_t n;          /* number of rows, n_rattler included */
    int64_t n_rattler;  /* rows 0 .. n_rattler-1 are the zero modes of rattlers */
    int64_t n_zero;     /* rows with omega = 0, n_rattler included */
    sp_zero_modes zero; /* zero modes of the whole spectrum, in the rows or not */
    int64_t dofs;       /* length of an eigenvector: grains of the network times dof */
    double *omega;      /* [n] frequencies, ascending [sqrt(E* / rho)/d] */
    double *error;      /* [n] upper bound of the error of omega [sqrt(E* / rho)/d] */
    double *a, *b; /* [n] amplitudes at the source, NAN if no spring leads to the bottom wall; at the detector, NAN if
                      no spring leads to the top wall. NULL without vectors */
    double *participation; /* [n] participation ratio (sum w)^2/(N sum w^2), w = |e|^2 of a grain, over the N grains of
                              the network (rattlers excluded; 1/N for a rattler's mode); NULL without vectors. It
                              has no error bound: that of a vector is about `residual` over the relative distance to
                              the next omega^2, and modes of one frequency have no definite vectors */
    double *vectors;      /* [n - n_rattler][dofs] e^(n), mass weighted; the largest component is positive. NULL without
                             vectors */
    double residual;      /* largest |A e - omega^2 e|/omega_max^2, A = M^(-1/2) K M^(-1/2); NAN without vectors */
    double orthogonality; /* largest |e_m . e_n - delta_mn|; NAN without vectors */
    int64_t first;        /* number of modes of the whole spectrum below row 0, zero modes included */
    sp_modes_solver solver; /* the one that was used */
    double certified_from,
        certified_to; /* first; last of the frequencies between which no mode is missing: all modes were found (dense),
                         or the inertia of K - omega^2 M at both ends gives their number (sparse) [sqrt(E* / rho)/d] */
    int64_t on_edge;  /* modes within their own error of an end of the band; these are included */
    int64_t factors, solves; /* sparse: factorizations, and right-hand sides solved */
} sp_modes;

SP_API sp_modes sp_modes_none(void);
/* All modes, with LAPACK. Memory: 24 (n dof)^2 bytes, half of it without vectors; SP_ENOMEM where the machine has less.
 * SP_EREFUSED above SP_MODES_DENSE_MAX degrees of freedom, for an unstable network, and if it cannot be decided whether
 * a mode is a zero mode. */
SP_API sp_status sp_modes_dense(const sp_network *net, const sp_modes_options *opt, sp_modes *out, sp_error *err);

/* Which modes to compute. */
typedef struct sp_modes_range {
    int64_t lowest;  /* > 0: this many of the lowest modes that are no zero modes; 0: the band from .. to */
    double from, to; /* limits of omega, included; 0 and infinity: the whole spectrum. A band from 0 has all zero modes,
                        any other band none. */
    bool zero;       /* with lowest: all zero modes too, in front of the others */
} sp_modes_range;
SP_API sp_modes_range sp_modes_range_all(void);
SP_API sp_modes_range sp_modes_range_lowest(int64_t count);
SP_API sp_modes_range sp_modes_range_band(double from, double to);

/* The modes in a range, by Lanczos iteration on (K - sigma M)^-1 with the solver of the options. The range is divided
 * into slices; the inertia of K - sigma M at their edges gives the number of modes in each. Memory: the eigenvectors
 * and one sparse factor. SP_EINVAL for an invalid range, also for more modes
 * than there are besides zero modes, and for the dense solver. SP_EREFUSED if the number of modes
 * cannot be certified, if the network is unstable, or if memory does not suffice. */
SP_API sp_status sp_modes_sparse(const sp_network *net, const sp_modes_options *opt, const sp_modes_range *range,
                                 sp_modes *out, sp_error *err);
/* The same with any solver. All frequencies of a large network (above 5000 degrees of freedom, 8000 in three
 * dimensions) without vectors come from the sparse solver, which shares them among threads; if it refuses, from LAPACK.
 */
SP_API sp_status sp_modes_make(const sp_network *net, const sp_modes_options *opt, const sp_modes_range *range,
                               sp_modes *out, sp_error *err);
SP_API void sp_modes_free(sp_modes *m);
/* Upper bound of |e - f| for the vector e of a row and the exact unit eigenvector f with the sign of e: sqrt(2) times
 * the residual over the distance of omega^2 to the next eigenvalue (Davis, Kahan). sqrt(2) where nothing is known:
 * modes that nearly coincide, such as several zero modes, span a space in which any vector is as good. row: n_rattler
 * .. n - 1. */
SP_API double sp_modes_vector_error(const sp_modes *m, const sp_network *net, int64_t row);

enum { SP_DAMPED_MODES_MAX = 2000 }; /* largest problem, in degrees of freedom */

/* Modes u exp(lambda t) of M u'' + C u' + K u = 0, with the dashpots C of sp_network_dashpots. One row for each pair
 * lambda = -decay +- i omega and for each real lambda (omega = 0), in ascending order of omega, then decay. Rattlers
 * are excluded. If no two lambda coincide, the signal is F(t) = sum exp(-decay t) (cosine cos(omega t) + sine sin(omega
 * t)): the force of springs and dashpots on the top wall after a pulse at the whole bottom wall. */
typedef struct sp_damped_modes {
    int64_t n;             /* rows: pairs of complex lambda, and real ones */
    double *omega, *decay; /* [n] imaginary part of lambda; minus its real part [sqrt(E* / rho)/d] */
    double *cosine, *sine; /* [n] amplitudes of the signal */
    double *error; /* [n] error of lambda: first order in rounding, or second order where two lambda coincide [sqrt(E* /
                      rho)/d] */
    double residual; /* largest |(lambda^2 M + lambda C + K) u|/((|lambda|^2 + |lambda| c + omega_max^2) |u|) in the
                        metric of the masses; c: the largest eigenvalue of M^-1 C */
} sp_damped_modes;
SP_API sp_damped_modes sp_damped_modes_none(void);
/* All damped modes, with LAPACK on the first-order form of twice the size: about a minute at SP_DAMPED_MODES_MAX
 * degrees of freedom. zeta > 0: fraction of critical damping of a contact. SP_EREFUSED above that size. */
SP_API sp_status sp_damped_modes_make(const sp_network *net, double zeta, sp_source source, sp_damped_modes *out,
                                      sp_error *err);
/* The same with dashpots of any kind. */
SP_API sp_status sp_damped_modes_with(const sp_network *net, const sp_damping *law, sp_source source,
                                      sp_damped_modes *out, sp_error *err);
/* Quality factor Q = |lambda|/(2 decay) of a mode, 2 pi times its energy over the loss in a period for weak damping,
 * and a bound of its error. Both NAN for an overdamped mode; INFINITY if the decay is not above its error. */
SP_API void sp_damped_modes_quality(const sp_damped_modes *m, int64_t k, double *q, double *q_error);
SP_API void sp_damped_modes_free(sp_damped_modes *m);

enum { SP_STABILITY_MAX = 6000 }; /* largest nonsymmetric problem, in degrees of freedom */

/* Modes of a network with prestress and friction, M u'' + J u = 0 with a J that is not symmetric. An eigenvalue omega^2
 * > 0 has one row. A complex pair has two, of motions that grow and decay as exp(growth t) while they oscillate; an
 * eigenvalue below 0 has two without oscillation. Rows of rattlers come first; all others are in ascending order of
 * omega, then growth. The signal is F(t) = sum exp(growth t) (cosine cos(omega t) + sine sin(omega t)). */
typedef struct sp_complex_modes {
    int64_t n, rattlers, pairs; /* rows; those of rattlers; complex pairs of eigenvalues */
    int64_t dofs;               /* length of an eigenvector */
    double *omega, *growth;     /* [n] [sqrt(E* / rho)/d] */
    double *error;              /* [n] bound of |growth + i omega - exact| [sqrt(E* / rho)/d] */
    double *cosine, *sine;      /* [n] amplitudes, without a bound; NAN without contacts at a wall [E* d^2] */
    double *right, *right_im;   /* [n - rattlers][dofs] real and imaginary parts of e with A e = z e, A = M^(-1/2) J
                                   M^(-1/2), z = -(growth + i omega)^2: the motion is M^(-1/2) e exp((growth + i omega)
                                   t). |e| = 1, and its largest component is positive. NULL without vectors */
    double *left, *left_im; /* [n - rattlers][dofs] f with A^T f = z f and f . e = 1 (not conjugate), 0 with the e of
                               other z; |f| is the condition number of z. NULL without vectors */
    double residual; /* largest |A e - z e| and |A^T f - z f|/|f| over the square of the bound of all frequencies: e and
                        f are exact for matrices that differ from A by so much; NAN without vectors */
    double orthogonality; /* largest |f_m . e_n - delta_mn|; NAN without vectors */
    int64_t zero, first;  /* of a part: zero motions, which have no rows; all motions below row 0 */
    int64_t on_edge;      /* of a band: motions within their own error of an end; these are included */
    bool sparse;          /* of a part: not from LAPACK */
    double complete;      /* no motion with omega below it is missing, but zero motions [sqrt(E* / rho)/d] */
} sp_complex_modes;
SP_API sp_complex_modes sp_complex_modes_none(void);
/* All of them, with LAPACK: minutes and 32 n^2 bytes at SP_STABILITY_MAX degrees of freedom, 64 with vectors. The
 * errors are those of discs that contain the eigenvalues (Gershgorin). Serves a symmetric J, too.
 *
 * Or a part: the `lowest` motions in the order of omega, then growth, and all that share the last omega, as a pair
 * does; or those of a band. Both without rattlers and zero motions: the spins of spheres with two contacts and whole
 * translations, which are the eigenvalues nearest to 0, and those that are 0 within their errors. For networks of any
 * size, if few are wanted, or lie below the end of the band: two-sided Davidson iteration with a factor of the
 * symmetric part. Discs contain the eigenvalues, and none with a lower omega is missing: the inertia of the symmetric
 * part bounds those that were not found.
 *
 * SP_EINVAL for ARPACK, and for an invalid range, also with `zero`. SP_EREFUSED above the size of LAPACK's, if the
 * vectors are nearly dependent, if it cannot be proved that none is missing, and without convergence. */
SP_API sp_status sp_complex_modes_make(const sp_network *net, const sp_modes_options *opt, const sp_modes_range *range,
                                       sp_complex_modes *out, sp_error *err);
SP_API void sp_complex_modes_free(sp_complex_modes *m);

typedef enum sp_modes_verdict {
    SP_MODES_STABLE = 0, /* no eigenvalue is negative or complex, apart from those that count as zero */
    SP_MODES_UNSTABLE,   /* some eigenvalues are, and imbalance of the forces at rest does not explain them */
    SP_MODES_UNDECIDED   /* neither can be proved */
} sp_modes_verdict;

/* Stability of M u'' = -K u, with or without prestress. Let omega^2 be an eigenvalue of M^-1 K. If it is negative, a
 * motion diverges; a complex pair gives oscillations that grow (flutter). */
typedef struct sp_stability {
    sp_modes_verdict verdict; /* stable, unstable, or undecided */
    bool dense;   /* all eigenvalues were computed, each with a disc that contains it; false: only counts by the inertia
                     of the symmetric part */
    int64_t dofs; /* degrees of freedom of the network */
    int64_t negative;   /* eigenvalues proved to be below 0; -1: unknown */
    int64_t flutter;    /* complex pairs proved to be complex; -1: unknown */
    int64_t unbalanced; /* eigenvalues among these two kinds that lie within `balance`; alone they leave the verdict
                           undecided. -1: unknown */
    int64_t zero;   /* eigenvalues that count as zero: floppy motions within their own error of 0, and spins of spheres
                       with two contacts; -1: unknown */
    double softest; /* smallest real part of all other eigenvalues; NAN: unknown [E* / (rho d^2)] */
    double growth;  /* lower bound of the fastest growth rate; 0 if no growth is proved [sqrt(E* / rho)/d] */
    double growth_bound; /* upper bound of all growth rates */
    double error;        /* largest radius of a disc, or error of a count [E* / (rho d^2)] */
    double balance;      /* how far the imbalance of the forces at rest can shift a zero eigenvalue [E* / (rho d^2)] */
    double skew;         /* result of sp_network_skew */
} sp_stability;
/* Decides whether a network is stable. p: the packing from which the network was made. A symmetric K of any size is
 * treated by counts. A nonsymmetric K up to SP_STABILITY_MAX degrees of freedom is treated by all its eigenvalues
 * (dense: minutes, 32 n^2 bytes). A larger one stays undecided; growth_bound then comes from the field of values of A.
 * SP_EREFUSED if nothing can be proved. */
SP_API sp_status sp_stability_make(const sp_packing *p, const sp_network *net, sp_stability *out, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
