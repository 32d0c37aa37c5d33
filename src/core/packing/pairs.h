#ifndef SP_PAIRS_H
#define SP_PAIRS_H
/* Memory of neighbour lists, and the outer list. */
#include "packing/grains.h"
#include "packing/mindlin.h"

/* Allocates a list for at least `capacity` pairs; `inner` adds the arrays of an inner list. SP_ENOMEM. */
sp_status sp_pair_list_alloc(pair_list *p, const dynamics *d, int32_t capacity, bool inner, sp_error *err);
void sp_pair_list_free(pair_list *p);
/* Rebuilds the outer list with all pairs closer than the gap, and keeps the tangential forces. SP_ENOMEM. */
sp_status sp_pairs_rebuild(dynamics *d, double gap, sp_error *err);

/* Tangential force on i of a pair (2D: ft[0] along (-ny, nx), and its history behind it). */
typedef struct pair_force {
    int32_t i, j;
    double ft[1 + MINDLIN_NUMBERS];
} pair_force;
/* Sets the tangential forces of a new dynamics, before its lists are first built. Each pair at most once, in either
 * order. SP_ENOMEM. */
sp_status sp_pairs_set_forces(dynamics *d, const pair_force *force, int32_t count, sp_error *err);
/* Copies the tangential forces of the inner list to the outer one; _part: a thread's part of them. */
void sp_pairs_store_forces(dynamics *d);
void sp_pairs_store_part(dynamics *d, int part, int parts);

#endif
