#ifndef SP_UNCERTAIN_H
#define SP_UNCERTAIN_H
/* What the two ways to the errors of a packing's sound share. */

#include "inference/perturb.h"
#include "inference/quantities.h"

/* First order: fills in first_order, shift and share of out->quantity; NAN where there are no derivatives. p: the
 * packing without errors (of overlaps: with contacts from its positions). */
sp_status sp_uncertain_first_order(const sp_quantities *q, const sp_drawing *d, const sp_packing *p,
                                   sp_uncertainty *out, sp_error *err);
/* Monte Carlo: fills in sd, bias, their errors and samples, and the counts of out. contacts: of p. */
sp_status sp_uncertain_sample(const sp_quantities *q, const sp_drawing *d, int32_t contacts, sp_uncertainty *out,
                              sp_error *err);

#endif
