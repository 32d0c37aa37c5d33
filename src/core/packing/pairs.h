#ifndef SP_PAIRS_H
#define SP_PAIRS_H
/* The two neighbour lists of dynamics.h. */
#include "packing/dynamics.h"

void sp_pair_list_free(pair_list *p);
/* All pairs and wall neighbours by cells (outer list), tangential forces carried over. */
sp_status sp_pairs_rebuild(dynamics *d, double gap, sp_error *err);
/* The inner list out of the outer one. */
sp_status sp_pairs_refill(dynamics *d, double gap, sp_error *err);
/* The tangential force on i of a pair (2D: ft[0] along (-ny, nx)). */
typedef struct pair_force {
    int32_t i, j;
    double ft[3];
} pair_force;
/* Before the lists are made: what their pairs shall carry. Each pair at most once. */
sp_status sp_pairs_give(dynamics *d, const pair_force *force, int32_t count, sp_error *err);
/* Brings the inner list's tangential forces back to the outer list. */
void sp_pairs_return(dynamics *d);

#endif
