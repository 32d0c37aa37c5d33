#ifndef SONOPACK_STUDY_MODES_FILE_H
#define SONOPACK_STUDY_MODES_FILE_H
/* Files of modes: frequencies, eigenvectors and what they belong to, as HDF5 (docs/file-format.md). One mode can be
 * read at a time, so that a file may be larger than memory. */

#include <sonopack/modes.h>
#include <sonopack/network.h>
#include <sonopack/packing.h>

#ifdef __cplusplus
extern "C" {
#endif

/* How the modes of a file were made. */
typedef struct sp_modes_made {
    sp_network_options network;
    sp_source source; /* of the amplitudes a */
} sp_modes_made;

/* Writes modes with their vectors. net: the network of p that they belong to. The file is written under a temporary
 * name in its folder, synced, and renamed; the vectors go from `m` to the disk without a second copy in memory.
 * SP_EINVAL for modes without vectors, or of another network. SP_EIO. */
SP_API sp_status sp_modes_save(const sp_modes *m, const sp_packing *p, const sp_network *net, const sp_modes_made *made,
                               const char *path, sp_error *err);

/* The same of modes that may grow; rattlers' rows are left out. */
SP_API sp_status sp_complex_modes_save(const sp_complex_modes *m, const sp_packing *p, const sp_network *net,
                                       const sp_modes_made *made, const char *path, sp_error *err);

/* Content of a file of modes but for the vectors. */
typedef struct sp_modes_file {
    sp_modes modes; /* vectors is NULL */
    sp_modes_made made;
    uint64_t packing; /* sp_packing_hash of the packing */
    int dim, dof;
    int32_t n;      /* grains of the network */
    int32_t *grain; /* [n] index in the packing, ascending */
    double *mass;   /* [modes.dofs] of each component of a vector: mass [rho d^3], or moment of inertia [rho d^5] */
} sp_modes_file;

SP_API sp_modes_file sp_modes_file_none(void);
SP_API void sp_modes_file_free(sp_modes_file *f);
/* Whether there is a file of modes at this path: HDF5 with the group /modes. Its content is not checked. */
SP_API bool sp_modes_file_looks(const char *path);
/* Reads a file of modes and checks it. p: the packing; SP_EFORMAT if the modes are of another one. SP_EIO if the file
 * cannot be opened. SP_EFORMAT with the first fault: not a file of modes, truncated, wrong sizes, numbers out of range.
 * The network of p with made.network has the same grains in the same order. */
SP_API sp_status sp_modes_file_read(const char *path, const sp_packing *p, sp_modes_file *out, sp_error *err);
/* Reads the vectors of modes.omega[row] .. [row + count - 1] to out, [count][modes.dofs]: mass weighted, e = M^1/2 u.
 * SP_EINVAL for rows that are not in the file, or are a rattler's. SP_EFORMAT if they are not unit vectors. */
SP_API sp_status sp_modes_file_vectors(const char *path, const sp_modes_file *f, int64_t row, int64_t count,
                                       double *out, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
