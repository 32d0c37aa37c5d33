#ifndef TEST_CARRIED_H
#define TEST_CARRIED_H
/* Packings with tangential forces at rest, and networks of them with prestress. */
#include "base/base.h"
#include "reference.h"

#include <sonopack/network.h>

/* A number in [-1, 1) */
static inline double carried_noise(void) { return 2.0 * rand() / RAND_MAX - 1; }

/* Gives each contact a tangential force on i of up to `share` of F_n. */
static inline void carry(sp_packing *p, double share, unsigned seed) {
    srand(seed);
    for (int k = 0; k < p->n_contacts; k++) {
        sp_contact *c = &p->contacts[k];
        double t[3] = {0}, off = 0;
        for (int a = 0; a < p->dim; a++) {
            t[a] = share * c->fn * carried_noise() / sqrt(p->dim);
            off += t[a] * c->n[a];
        }
        for (int a = 0; a < p->dim; a++)
            c->ft[a] = t[a] - off * c->n[a];
    }
}

static inline sp_packing carried_packing(int dim, int cells, double share, unsigned seed) {
    sp_packing p = scattered_packing(dim, cells, 0.5, seed);
    carry(&p, share, seed);
    return p;
}

static inline sp_network carried_network(const sp_packing *p) {
    sp_network_options o = sp_network_options_default();
    sp_network net = sp_network_none();
    o.prestress = true;
    o.threshold = 0;
    assert_ok(sp_network_make(p, &o, &net, &err));
    return net;
}

static inline double *carried_vector(int64_t n) {
    double *u = calloc((size_t)n, sizeof *u);
    for (int64_t k = 0; k < n; k++)
        u[k] = carried_noise();
    return u;
}

#endif
