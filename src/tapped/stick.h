#ifndef SP_TAPPED_STICK_H
#define SP_TAPPED_STICK_H
/* Which contacts of the lattice stick, and the states of all contacts. */

#include "tapped/lattice.h"

/* Decides which contacts stick, in the connected run of contacts with w = 0 and delta > 0 around contact `at`, and in
 * which direction the others start to move. cause: the contact whose force has left its band, or -1. */
void sp_lattice_stick(sp_lattice *l, int32_t at, int32_t cause);

/* Initial state: at rest, or dropped, before the first tap. */
void sp_lattice_start(sp_lattice *l);
/* Finds the states of all contacts from their overlaps and opening velocities. */
void sp_lattice_classify(sp_lattice *l);
/* Sets overlaps and opening velocities [n], and finds the states; reads them. */
void sp_lattice_set(sp_lattice *l, const double *overlap, const double *opening);
void sp_lattice_get(const sp_lattice *l, double *overlap, double *opening);

#endif
