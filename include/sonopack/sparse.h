#ifndef SONOPACK_SPARSE_H
#define SONOPACK_SPARSE_H
/* Sparse square matrices. */

#include <sonopack/visibility.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Compressed sparse columns with ascending rows. Holds either all entries or the lower triangle, diagonal first. */
typedef struct sp_sparse {
    int64_t n;
    int64_t *p; /* [n+1] start of each column; p[n] is the number of entries */
    int64_t *i; /* [p[n]] row indices */
    double *x;  /* [p[n]] values */
} sp_sparse;

SP_API void sp_sparse_free(sp_sparse *a);

#ifdef __cplusplus
}
#endif
#endif
