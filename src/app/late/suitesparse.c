/* The functions of CHOLMOD and UMFPACK that the command uses, each loaded when it is first called. */
#include "late/late.h"

#include <cholmod.h>
#include <umfpack.h>

static late_library cholmod = {LATE_CHOLMOD, NULL, PTHREAD_RECURSIVE_MUTEX_INITIALIZER_NP, NULL};
static late_library umfpack = {LATE_UMFPACK, NULL, PTHREAD_RECURSIVE_MUTEX_INITIALIZER_NP, NULL};

#define CHOLMOD(type, name, parameters, arguments) LATE_FUNCTION(&cholmod, type, name, parameters, arguments)
#define UMFPACK(type, name, parameters, arguments) LATE_FUNCTION(&umfpack, type, name, parameters, arguments)

CHOLMOD(cholmod_sparse *, cholmod_allocate_sparse,
        (size_t a, size_t b, size_t c, int d, int e, int f, int g, cholmod_common *h), (a, b, c, d, e, f, g, h))
CHOLMOD(cholmod_factor *, cholmod_analyze, (cholmod_sparse * a, cholmod_common *b), (a, b))
CHOLMOD(int, cholmod_change_factor, (int a, int b, int c, int d, int e, cholmod_factor *f, cholmod_common *g),
        (a, b, c, d, e, f, g))
CHOLMOD(int, cholmod_factorize_p,
        (cholmod_sparse * a, double b[2], int *c, size_t d, cholmod_factor *e, cholmod_common *f), (a, b, c, d, e, f))
CHOLMOD(int, cholmod_finish, (cholmod_common * a), (a))
CHOLMOD(int, cholmod_free_factor, (cholmod_factor * *a, cholmod_common *b), (a, b))
CHOLMOD(int, cholmod_free_sparse, (cholmod_sparse * *a, cholmod_common *b), (a, b))
CHOLMOD(cholmod_dense *, cholmod_l_allocate_dense, (size_t a, size_t b, size_t c, int d, cholmod_common *e),
        (a, b, c, d, e))
CHOLMOD(cholmod_sparse *, cholmod_l_allocate_sparse,
        (size_t a, size_t b, size_t c, int d, int e, int f, int g, cholmod_common *h), (a, b, c, d, e, f, g, h))
CHOLMOD(cholmod_factor *, cholmod_l_analyze, (cholmod_sparse * a, cholmod_common *b), (a, b))
CHOLMOD(int, cholmod_l_factorize, (cholmod_sparse * a, cholmod_factor *b, cholmod_common *c), (a, b, c))
CHOLMOD(int, cholmod_l_finish, (cholmod_common * a), (a))
CHOLMOD(int, cholmod_l_free_dense, (cholmod_dense * *a, cholmod_common *b), (a, b))
CHOLMOD(int, cholmod_l_free_factor, (cholmod_factor * *a, cholmod_common *b), (a, b))
CHOLMOD(int, cholmod_l_free_sparse, (cholmod_sparse * *a, cholmod_common *b), (a, b))
CHOLMOD(cholmod_dense *, cholmod_l_solve, (int a, cholmod_factor *b, cholmod_dense *c, cholmod_common *d), (a, b, c, d))
CHOLMOD(int, cholmod_l_start, (cholmod_common * a), (a))
CHOLMOD(int, cholmod_start, (cholmod_common * a), (a))
UMFPACK(void, umfpack_zl_defaults, (double a[20]), (a))
UMFPACK(void, umfpack_zl_free_numeric, (void **a), (a))
UMFPACK(void, umfpack_zl_free_symbolic, (void **a), (a))
UMFPACK(SuiteSparse_long, umfpack_zl_numeric,
        (const SuiteSparse_long a[], const SuiteSparse_long b[], const double c[], const double d[], void *e, void **f,
         const double g[20], double h[90]),
        (a, b, c, d, e, f, g, h))
UMFPACK(SuiteSparse_long, umfpack_zl_solve,
        (SuiteSparse_long a, const SuiteSparse_long b[], const SuiteSparse_long c[], const double d[], const double e[],
         double f[], double g[], const double h[], const double i[], void *j, const double k[20], double l[90]),
        (a, b, c, d, e, f, g, h, i, j, k, l))
UMFPACK(SuiteSparse_long, umfpack_zl_symbolic,
        (SuiteSparse_long a, SuiteSparse_long b, const SuiteSparse_long c[], const SuiteSparse_long d[],
         const double e[], const double f[], void **g, const double h[20], double i[90]),
        (a, b, c, d, e, f, g, h, i))
