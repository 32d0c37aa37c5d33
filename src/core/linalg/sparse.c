/* Frees sparse matrices. */
#include <sonopack/sparse.h>

#include "base/base.h"

void sp_sparse_free(sp_sparse *a) {
    sp_free(a->p);
    sp_free(a->i);
    sp_free(a->x);
    *a = (sp_sparse){0};
}
