/* The functions of CHOLMOD that the command uses, each loaded when it is first called. */
#include "late/late.h"

#include <cholmod.h>

static late_library cholmod = {LATE_CHOLMOD, NULL, PTHREAD_RECURSIVE_MUTEX_INITIALIZER_NP, NULL};

#define CHOLMOD(type, name, parameters, arguments) LATE_FUNCTION(&cholmod, type, name, parameters, arguments)

CHOLMOD(cholmod_sparse *, cholmod_l_allocate_sparse,
        (size_t a, size_t b, size_t c, int d, int e, int f, int g, cholmod_common *h), (a, b, c, d, e, f, g, h))
CHOLMOD(cholmod_factor *, cholmod_l_analyze, (cholmod_sparse * a, cholmod_common *b), (a, b))
CHOLMOD(int, cholmod_l_finish, (cholmod_common * a), (a))
CHOLMOD(int, cholmod_l_free_factor, (cholmod_factor * *a, cholmod_common *b), (a, b))
CHOLMOD(int, cholmod_l_free_sparse, (cholmod_sparse * *a, cholmod_common *b), (a, b))
CHOLMOD(int, cholmod_l_start, (cholmod_common * a), (a))
