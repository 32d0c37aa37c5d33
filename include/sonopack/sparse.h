#ifndef SONOPACK_SPARSE_H
#define SONOPACK_SPARSE_H
/* A sparse square matrix. */

#include <sonopack/export.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Compressed columns, rows ascending in each: all entries, or those of the lower triangle with the diagonal first. */
typedef struct sp_sparse {
    int64_t n;
    int64_t *p; /* [n+1] where each column begins; p[n] entries in all */
    int64_t *i; /* [p[n]] rows */
    double *x;  /* [p[n]] */
} sp_sparse;

SP_API void sp_sparse_free(sp_sparse *a);

#ifdef __cplusplus
}
#endif
#endif
