#ifndef SP_MODULI_H
#define SP_MODULI_H
/* Moduli of a network that has been factored. */

#include "elastic/equilibrium.h"
#include "elastic/strain.h"

#include <sonopack/elastic.h>

sp_status sp_moduli_of(sp_equilibrium *e, double phi3s, sp_moduli *out, sp_error *err);
/* Sets the named components and the speeds, Eq. (8). */
void sp_moduli_from_stiffness(const sp_network *net, double phi3s, const sp_stiffness *s, sp_moduli *out);

#endif
