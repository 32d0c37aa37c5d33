#ifndef SP_MODULI_H
#define SP_MODULI_H
/* Moduli of a network that is factored already. */

#include "elastic/equilibrium.h"

#include <sonopack/elastic.h>

sp_status sp_moduli_of(sp_equilibrium *e, double phi3s, sp_moduli *out, sp_error *err);
/* The components by name, and the speeds (8). */
void sp_moduli_put(const sp_network *net, double phi3s, const sp_stiffness *s, sp_moduli *out);

#endif
