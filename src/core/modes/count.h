#ifndef SP_COUNT_H
#define SP_COUNT_H
/* Bounds of the spectrum without modes: counts below a frequency, and discs around all eigenvalues. */

#include "linalg/discs.h"
#include "linalg/ldl.h"

typedef struct counter {
    sp_ldl *ldl;
    double top;   /* upper bound of the spectrum of A = M^-1/2 K M^-1/2 */
    double noise; /* upper bound of |A as assembled - A| */
} counter;

/* K becomes A = M^-1/2 K M^-1/2. */
void sp_scale_by_masses(const sp_network *net, sp_sparse *k);

/* Discs around the eigenvalues of A with all entries, as sp_discs_make has them. */
sp_status sp_network_discs(const sp_network *net, const double *source, const double *detector, bool vectors,
                           sp_discs *out, sp_error *err);

sp_status sp_counter_make(const sp_network *net, counter *out, sp_error *err);
void sp_counter_free(counter *c);
/* Bounds the number of modes with omega^2 <= limit: at least *least and at most *most, by the inertia just below and
 * just above the limit. */
sp_status sp_counter_below(const counter *c, double limit, int64_t *least, int64_t *most, sp_error *err);

/* SP_EREFUSED if prestress makes a motion grow by more than half within this time: its omega^2 is below -1/until^2,
 * and below 0 by more than rounding. One factorization with prestress, nothing without. */
sp_status sp_need_bounded(const sp_network *net, double until, sp_error *err);

#endif
