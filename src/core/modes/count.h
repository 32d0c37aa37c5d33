#ifndef SP_COUNT_H
#define SP_COUNT_H
/* How many modes lie below a frequency, without finding one. */

#include "linalg/ldl.h"

typedef struct counter {
    sp_ldl *ldl;
    double top;   /* an upper bound of the spectrum of A = M^-1/2 K M^-1/2 */
    double noise; /* |A as assembled - A| is at most this */
} counter;

sp_status sp_counter_make(const sp_network *net, counter *out, sp_error *err);
void sp_counter_free(counter *c);
/* Modes with omega^2 <= limit are at least `least` and at most `most`; by inertia a little below and a little above. */
sp_status sp_counter_below(const counter *c, double limit, int64_t *least, int64_t *most, sp_error *err);

#endif
