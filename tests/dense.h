#ifndef TEST_DENSE_H
#define TEST_DENSE_H
#include "test.h"

#include <sonopack/network.h>

/* All entries of K, by columns. */
static inline double *dense_of(const sp_network *net) {
    const int64_t n = sp_network_dofs(net);
    FREED(sp_sparse) k = {0};
    double *a = calloc((size_t)(n * n), sizeof *a);
    assert_ok(sp_network_assemble_whole(net, &k, &err));
    for (int64_t c = 0; c < n; c++)
        for (int64_t q = k.p[c]; q < k.p[c + 1]; q++)
            a[c * n + k.i[q]] = k.x[q];
    return a;
}

#endif
