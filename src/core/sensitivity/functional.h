#ifndef SP_FUNCTIONAL_H
#define SP_FUNCTIONAL_H
/* What gradients of signals and of fronts share. */

#include "sensitivity/forward.h"

sp_status sp_functional_check(const sp_network *net, const sp_sensitivity_options *opt, sp_error *err);
/* More moments than any functional of times up to `last` needs. */
int64_t sp_functional_terms(double omega, double last);
/* Value and gradient of one functional; extends the forward pass as needed. */
sp_status sp_functional_gradient(forward *f, const sp_sensitivity_options *opt, const sp_nodes *nodes, sp_gradient *out,
                                 sp_error *err);

#endif
