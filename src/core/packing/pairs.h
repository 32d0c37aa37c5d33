#ifndef SP_PAIRS_H
#define SP_PAIRS_H
/* The outer and inner neighbour list; see pair_list. */
#include "packing/dynamics.h"

void sp_pair_list_free(pair_list *p);
/* Rebuilds the outer list and keeps the tangential forces. SP_ENOMEM. */
sp_status sp_pairs_rebuild(dynamics *d, double gap, sp_error *err);
/* Selects the inner list from the outer one. SP_ENOMEM. */
sp_status sp_pairs_refill(dynamics *d, double gap, sp_error *err);
/* Tangential force on i of a pair (2D: ft[0] along (-ny, nx)). */
typedef struct pair_force {
    int32_t i, j;
    double ft[3];
} pair_force;
/* Sets the tangential forces of a new dynamics, before its lists are first built. Each pair at most once, in either
 * order. SP_ENOMEM. */
sp_status sp_pairs_give(dynamics *d, const pair_force *force, int32_t count, sp_error *err);
/* Copies the tangential forces of the inner list to the outer one. */
void sp_pairs_return(dynamics *d);

#endif
