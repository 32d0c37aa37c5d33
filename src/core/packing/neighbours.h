#ifndef SP_NEIGHBOURS_H
#define SP_NEIGHBOURS_H
/* Keeps the neighbour lists up to date. */
#include "packing/grains.h"

/* Rebuilds the lists if grains may have moved too far. SP_ENOMEM. */
sp_status sp_neighbours_refresh(dynamics *d, sp_error *err);
/* Smallest period for which a pair cannot touch through both sides of the box; only one of these contacts would be
 * listed. */
double sp_neighbours_narrowest(const dynamics *d);

#endif
