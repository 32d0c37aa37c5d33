#ifndef SP_MODULI_H
#define SP_MODULI_H
/* Moduli of a network that has been factored. */

#include "elastic/equilibrium.h"
#include "elastic/strain.h"

#include <sonopack/elastic.h>

/* Doubles of scratch that sp_stiffness_of needs. */
size_t sp_stiffness_work(const sp_network *net);
/* sp_stiffness_make with a factor that is there. work + 4 n, with n = sp_network_dofs: the displacements [strains][n].
 */
sp_status sp_stiffness_of(sp_equilibrium *e, double *work, sp_stiffness *out, sp_error *err);
/* The same as a tensor with its isotropic part. */
void sp_elasticity_from(const sp_network *net, const sp_stiffness *s, sp_elasticity *out);
sp_status sp_moduli_of(sp_equilibrium *e, double phi3s, sp_moduli *out, sp_error *err);
/* Sets the named components and the speeds, Eq. (8). */
void sp_moduli_from_stiffness(const sp_network *net, double phi3s, const sp_stiffness *s, sp_moduli *out);

#endif
