#ifndef SP_MINDLIN_H
#define SP_MINDLIN_H
/* The tangential law of two spheres that slide on a ring around their contact (Mindlin and Deresiewicz, J. Appl. Mech.
 * 20, 327, 1953), in two dimensions. At a constant normal force F, with q = F_t/(mu F) and the stiffness k of full
 * stick,
 *
 *   dF_t/ds = k (1 - q)^(1/3)                on first loading,
 *   dF_t/ds = k (1 - |q - q'|/2)^(1/3)       after a reversal of the slip at q'.
 *
 * A loop closes when q comes back to where it began, and the branch before it goes on; the first unloading ends at -q'.
 * When F changes, F_t stays, as it does without history, and the forces at the reversals change in proportion to F
 * (Walton and Braun, J. Rheol. 30, 949, 1986). The terms in dF of the full theory, which has other paths for every
 * ratio of dF to dF_t, are left out. */

#include <stdint.h>

enum { MINDLIN_TURNS = 6, MINDLIN_NUMBERS = 1 + MINDLIN_TURNS };

/* The numbers of a contact that has just closed are 0. past[0]: sense of the last slip, +-(1 + number of reversals that
 * count), 0 for none. past[stride], past[2 stride] ...: q at these reversals. Of more than MINDLIN_TURNS loops inside
 * one another the innermost is forgotten. */

/* Tangential force after the slip, exact for a constant normal force however long the slip is. limit: mu F. */
double sp_mindlin_slip(double *past, int64_t stride, double force, double limit, double stiffness, double slip);

#endif
