#ifndef SP_ADJOINT_H
#define SP_ADJOINT_H
/* Derivatives of a functional of a signal: its pass run backwards, and what source and detector add. */

#include "sensitivity/forward.h"
#include "sensitivity/products.h"

typedef struct adjoint_plan {
    const forward *f;
    const sp_moment_weights *weights;
    bool whole, masses;
    int threads;
} adjoint_plan;

/* The forward pass must have sp_adjoint_terms moments. */
int64_t sp_adjoint_terms(const sp_moment_weights *w);
sp_status sp_adjoint_make(const adjoint_plan *plan, sp_products *out, sp_error *err);

#endif
