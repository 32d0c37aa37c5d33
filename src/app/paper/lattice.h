#ifndef SP_PAPER_LATTICE_H
#define SP_PAPER_LATTICE_H
/* Speed of sound in triangular lattices of equal balls. */

#include "paper/paper.h"

/* Eq. (18) for eta = 0, Eq. (19) otherwise. */
double sp_paper_lattice_speed(double p, double eta);
/* Speed from the difference between heights of about 8 and 24, as for packings. NAN without these samples. */
double sp_paper_lattice_small(const paper *p, bool friction, double pressure);
/* Speed at p = 5e-7 from three heights, with the arrival time H/c + a + b H^(1/3) (Eq. (16)). between: speed from the
 * difference of the two highest, about 80 and 160. */
double sp_paper_lattice_long(const paper *p, bool friction, double *between);

#endif
