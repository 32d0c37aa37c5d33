#ifndef SP_ARPACK_H
#define SP_ARPACK_H
/* Eigenpairs of a sparse symmetric A near a shift: implicitly restarted Lanczos (ARPACK) on (A - sigma)^-1. */

#include "linalg/lanczos.h"

/* The search of sp_lanczos by ARPACK: one right-hand side after another. ARPACK keeps its state in static variables,
 * so one search runs at a time in a process; others wait. */
sp_status sp_arpack(sp_ldl *factor, int64_t n, const sp_lanczos_spec *spec, sp_lanczos_pairs *out, sp_error *err);

#endif
