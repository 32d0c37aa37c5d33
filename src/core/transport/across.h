#ifndef SP_ACROSS_H
#define SP_ACROSS_H
/* Products of stretches of a spring, from which energies and fluxes are made. */

#include "network/spring.h"

static inline shape sp_shape_of(const sp_network *net) {
    return (shape){net->dim, net->dof - net->dim, 1, net->prestress, false, false};
}

/* Sums of products of the components across the normal, weighted with k_t and with the prestress. */
static inline double sp_across(const shape *s, const sp_spring *c, const stretch *a, const stretch *b) {
    double turning = 0, plain = 0;
    for (int k = 0; k < 3; k++) {
        turning += a->tangential[k][0] * b->tangential[k][0];
        plain += a->transverse[k][0] * b->transverse[k][0];
    }
    return (s->rotations ? c->kt * turning : 0) + (s->prestress ? c->kp * plain : 0);
}

#endif
