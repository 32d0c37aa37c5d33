#ifndef SP_TRIANGLE_H
#define SP_TRIANGLE_H
/* Null space of a matrix with up to six columns and any number of rows, which are added one by one. */

enum { SP_TRIANGLE_MAX = 6 };

/* The factor R of W = Q R: R^T R = W^T W, but small singular values are not squared. */
typedef struct sp_triangle {
    int n; /* columns */
    double r[SP_TRIANGLE_MAX][SP_TRIANGLE_MAX];
} sp_triangle;

/* Adds a row of W, which is overwritten. */
void sp_triangle_add(sp_triangle *t, double row[SP_TRIANGLE_MAX]);
/* Singular values of W and its right singular vectors v[k], in no order. */
void sp_triangle_values(const sp_triangle *t, double value[SP_TRIANGLE_MAX],
                        double v[SP_TRIANGLE_MAX][SP_TRIANGLE_MAX]);
/* A lower bound of all singular values. It costs less. */
double sp_triangle_least(const sp_triangle *t);

#endif
