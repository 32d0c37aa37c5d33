#ifndef SP_SVD_H
#define SP_SVD_H
/* Null space of a matrix with up to six columns and any number of rows, which are added one by one. */

enum { SP_SVD_MAX = 6 };

/* The factor R of W = Q R: R^T R = W^T W, but small singular values are not squared. */
typedef struct sp_svd {
    int n; /* columns */
    double r[SP_SVD_MAX][SP_SVD_MAX];
} sp_svd;

/* Adds a row of W, which is overwritten. */
void sp_svd_add(sp_svd *t, double row[SP_SVD_MAX]);
/* Singular values of W and its right singular vectors v[k], in no order. */
void sp_svd_values(const sp_svd *t, double value[SP_SVD_MAX], double v[SP_SVD_MAX][SP_SVD_MAX]);
/* A lower bound of all singular values. It costs less. */
double sp_svd_least(const sp_svd *t);

#endif
