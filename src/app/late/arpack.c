/* The functions of ARPACK that the command uses, each loaded when it is first called. */
#include "late/late.h"

#include <arpack.h>

static late_library arpack = {LATE_ARPACK, NULL, PTHREAD_RECURSIVE_MUTEX_INITIALIZER_NP, NULL};

LATE_BLAS_FUNCTION(&arpack, void, dsaupd_c,
                   (a_int * a, const char *b, a_int c, const char *d, a_int e, double f, double *g, a_int h, double *i,
                    a_int j, a_int *k, a_int *l, double *m, double *n, a_int o, a_int *p),
                   (a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p))
LATE_BLAS_FUNCTION(&arpack, void, dseupd_c,
                   (a_int a, const char *b, const a_int *c, double *d, double *e, a_int f, double g, const char *h,
                    a_int i, const char *j, a_int k, double l, double *m, a_int n, double *o, a_int p, a_int *q,
                    a_int *r, double *s, double *t, a_int u, a_int *v),
                   (a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s, t, u, v))
