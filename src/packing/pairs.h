#ifndef SP_PAIRS_H
#define SP_PAIRS_H
/* The two neighbour lists of dynamics.h. */
#include "packing/dynamics.h"

void pair_list_free(pair_list *p);
/* All pairs and wall neighbours by cells (outer list), tangential forces carried over. */
sp_status pairs_rebuild(dynamics *d, double gap, sp_error *err);
/* The inner list out of the outer one. */
sp_status pairs_refill(dynamics *d, double gap, sp_error *err);
/* Brings the inner list's tangential forces back to the outer list. */
void pairs_return(dynamics *d);

#endif
