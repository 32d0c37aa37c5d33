/* Products at springs in vectors of eight: four springs, two lanes. */
#include "base/clones.h"
#include "sensitivity/reverse_rows.h"

#ifdef MACHINES
#pragma GCC push_options
#pragma GCC target("arch=x86-64-v4,prefer-vector-width=512")

#include "network/wide_loads.h"

static ALWAYS_INLINE vec swap(vec x) { return __builtin_shufflevector(x, x, 1, 0, 3, 2, 5, 4, 7, 6); }

#include "sensitivity/multiply_quads.h"

void sp_multiply_wide(const multiply_job *job, const double *u) {
    if (job->whole)
        multiply_all(true, job, u);
    else
        multiply_all(false, job, u);
}

#pragma GCC pop_options
#else
void sp_multiply_wide(const multiply_job *job, const double *u) { (void)job, (void)u; }
#endif
