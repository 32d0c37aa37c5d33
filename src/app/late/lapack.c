/* The functions of LAPACKE and BLAS that the command uses, each loaded when it is first called. */
#include "late/late.h"

#include <cblas.h>
#include <lapacke.h>

static late_library lapacke = {LATE_LAPACKE, NULL, PTHREAD_RECURSIVE_MUTEX_INITIALIZER_NP, NULL};
static late_library blas = {LATE_BLAS, NULL, PTHREAD_RECURSIVE_MUTEX_INITIALIZER_NP, NULL};

#define LAPACKE(type, name, parameters, arguments) LATE_BLAS_FUNCTION(&lapacke, type, name, parameters, arguments)
#define BLAS(type, name, parameters, arguments)    LATE_BLAS_FUNCTION(&blas, type, name, parameters, arguments)

LAPACKE(lapack_int, LAPACKE_dgeev_work,
        (int a, char b, char c, lapack_int d, double *e, lapack_int f, double *g, double *h, double *i, lapack_int j,
         double *k, lapack_int l, double *m, lapack_int n),
        (a, b, c, d, e, f, g, h, i, j, k, l, m, n))
LAPACKE(lapack_int, LAPACKE_dgetrf_work, (int a, lapack_int b, lapack_int c, double *d, lapack_int e, lapack_int *f),
        (a, b, c, d, e, f))
LAPACKE(lapack_int, LAPACKE_dgetri_work,
        (int a, lapack_int b, double *c, lapack_int d, const lapack_int *e, double *f, lapack_int g),
        (a, b, c, d, e, f, g))
LAPACKE(lapack_int, LAPACKE_dormtr_work,
        (int a, char b, char c, char d, lapack_int e, lapack_int f, const double *g, lapack_int h, const double *i,
         double *j, lapack_int k, double *l, lapack_int m),
        (a, b, c, d, e, f, g, h, i, j, k, l, m))
LAPACKE(lapack_int, LAPACKE_dstemr,
        (int a, char b, char c, lapack_int d, double *e, double *f, double g, double h, lapack_int i, lapack_int j,
         lapack_int *k, double *l, double *m, lapack_int n, lapack_int o, lapack_int *p, lapack_int *q),
        (a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q))
LAPACKE(lapack_int, LAPACKE_dsterf, (lapack_int a, double *b, double *c), (a, b, c))
LAPACKE(lapack_int, LAPACKE_dsyevd_2stage_work,
        (int a, char b, char c, lapack_int d, double *e, lapack_int f, double *g, double *h, lapack_int i,
         lapack_int *j, lapack_int k),
        (a, b, c, d, e, f, g, h, i, j, k))
LAPACKE(lapack_int, LAPACKE_dsyevd_work,
        (int a, char b, char c, lapack_int d, double *e, lapack_int f, double *g, double *h, lapack_int i,
         lapack_int *j, lapack_int k),
        (a, b, c, d, e, f, g, h, i, j, k))
LAPACKE(lapack_int, LAPACKE_dsytrd_work,
        (int a, char b, lapack_int c, double *d, lapack_int e, double *f, double *g, double *h, double *i,
         lapack_int j),
        (a, b, c, d, e, f, g, h, i, j))
BLAS(double, cblas_ddot, (blasint a, const double *b, blasint c, const double *d, blasint e), (a, b, c, d, e))
BLAS(void, cblas_dgemm,
     (enum CBLAS_ORDER a, enum CBLAS_TRANSPOSE b, enum CBLAS_TRANSPOSE c, blasint d, blasint e, blasint f, double g,
      const double *h, blasint i, const double *j, blasint k, double l, double *m, blasint n),
     (a, b, c, d, e, f, g, h, i, j, k, l, m, n))
BLAS(void, cblas_dgemv,
     (CBLAS_ORDER a, CBLAS_TRANSPOSE b, blasint c, blasint d, double e, const double *f, blasint g, const double *h,
      blasint i, double j, double *k, blasint l),
     (a, b, c, d, e, f, g, h, i, j, k, l))
BLAS(void, cblas_dscal, (blasint a, double b, double *c, blasint d), (a, b, c, d))
BLAS(void, cblas_dtrsm,
     (enum CBLAS_ORDER a, enum CBLAS_SIDE b, enum CBLAS_UPLO c, enum CBLAS_TRANSPOSE d, enum CBLAS_DIAG e, blasint f,
      blasint g, double h, const double *i, blasint j, double *k, blasint l),
     (a, b, c, d, e, f, g, h, i, j, k, l))
BLAS(void, cblas_zgemm,
     (CBLAS_ORDER a, CBLAS_TRANSPOSE b, CBLAS_TRANSPOSE c, blasint d, blasint e, blasint f, const void *g,
      const void *h, blasint i, const void *j, blasint k, const void *l, void *m, blasint n),
     (a, b, c, d, e, f, g, h, i, j, k, l, m, n))
BLAS(void, cblas_ztrsm,
     (CBLAS_ORDER a, CBLAS_SIDE b, CBLAS_UPLO c, CBLAS_TRANSPOSE d, CBLAS_DIAG e, blasint f, blasint g, const void *h,
      const void *i, blasint j, void *k, blasint l),
     (a, b, c, d, e, f, g, h, i, j, k, l))
