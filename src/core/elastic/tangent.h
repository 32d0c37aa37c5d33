#ifndef SP_TANGENT_H
#define SP_TANGENT_H
/* The tangent stiffness of a packing: derivatives of the forces on its grains. */

#include "packing/vibrate.h"

#include <sonopack/network.h>

/* Whether the contact is closed and at Coulomb's limit. */
bool sp_contact_slides(const vibration *m, const touching *t);
/* Component of a vibration's vectors (0 .. 5: translation, rotation) for degree of freedom d of a grain of the
 * network. */
int sp_tangent_component(const sp_network *net, int d);
/* Adds to out the forces of closed contacts due to the displacements `in`; both [dofs]. row: for each grain of the
 * packing its row in the network, from 1. */
void sp_tangent_apply(const vibration *m, const sp_network *net, const int32_t *row, const double *in, double *out);

#endif
