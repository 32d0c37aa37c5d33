#ifndef SP_DISSECTION_H
#define SP_DISSECTION_H
/* Nested dissection of a network by the places of its grains, for the factor of a matrix over its degrees of freedom.
 *
 * A set of grains is split by a separator, the fewest grains without which no contact joins its two ends. The grains of
 * each end are eliminated first, the separator last. Along a direction the grains of the middle fifth are free to
 * belong to either end, or to the separator; a largest flow through grains that carry one unit each finds the separator
 * (the theorem of Menger). If the set goes round a period of the cell, its ends are two opposite slabs, and the flow
 * cuts it at both places at once. Of the directions of axes and diagonals that one is taken whose separator is the
 * smallest part of the smaller end. */

#include <sonopack/network.h>

/* part [n]: the number of the set of each grain, which are eliminated in rising order, from 0 on. Deterministic. A
 * matrix of a network has rows for all n x dof degrees of freedom. SP_ENOMEM. */
sp_status sp_dissect(const sp_network *net, int32_t *part, sp_error *err);

#endif
