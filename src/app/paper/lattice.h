#ifndef SP_PAPER_LATTICE_H
#define SP_PAPER_LATTICE_H
/* Speeds of triangular lattices of equal balls. */

#include "paper/paper.h"

/* Eqs. (18), eta = 0, and (19). */
double sp_paper_lattice_speed(double p, double eta);
/* By the difference between heights of about 8 and 24, as for packings; NAN where there is none. */
double sp_paper_lattice_small(const paper *p, bool friction, double pressure);
/* At 5e-7 the front arrives at H/c + a + b H^(1/3) (Eq. (16)): c from three heights. between: by the difference of the
 * two highest, about 80 and 160. */
double sp_paper_lattice_long(const paper *p, bool friction, double *between);

#endif
