#ifndef SP_SUPERNODES_H
#define SP_SUPERNODES_H
/* Ordering and symbolic factorization of a sparse symmetric matrix (CHOLMOD), for factors of any kind of number.
 * Columns of the factor with the same rows form a supernode, stored as one dense panel. */

#include <sonopack/network.h>
#include <sonopack/status.h>

typedef struct sp_supernodes {
    int64_t n, count;            /* rows; supernodes */
    int32_t *order;              /* [n] the row of A that is this row of the factor */
    int32_t *first;              /* [count + 1] first column of each supernode */
    int64_t *rows_at, *value_at; /* [count + 1] start of its rows in `rows`, and of its panel in the values */
    int32_t *rows;               /* its own columns, then the rows below them; both ascend */
    int32_t *owner;              /* [n] the supernode of a column */
    int64_t *place;              /* [entries of A] index of the entry in the values */
    int64_t *diagonal;           /* [n] index of the diagonal entry of a row of A in the values */
    int64_t largest_panel,
        largest_update; /* values of the largest panel, and of the largest update of one by another */
} sp_supernodes;

/* a: the lower triangle. net: the network that it is a matrix of, with rows for all its degrees of freedom, or NULL;
 * the order is that of the fewer operations among AMD's and, where there are many, that by the places of the grains. A
 * panel is stored by rows, [rows][width]. SP_ENOMEM; SP_EREFUSED if the factor is too large.
 */
sp_status sp_supernodes_make(const sp_sparse *a, const sp_network *net, sp_supernodes *out, sp_error *err);
void sp_supernodes_free(sp_supernodes *s);

static inline int32_t sp_supernode_width(const sp_supernodes *s, int64_t k) { return s->first[k + 1] - s->first[k]; }
static inline int32_t sp_supernode_rows(const sp_supernodes *s, int64_t k) {
    return (int32_t)(s->rows_at[k + 1] - s->rows_at[k]);
}

#endif
