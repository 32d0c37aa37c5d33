/* Access to a network, and its release. */
#include "base/base.h"

#include <sonopack/network.h>

sp_network_options sp_network_options_default(void) { return (sp_network_options){.threshold = 1e-4}; }

sp_network sp_network_none(void) { return (sp_network){0}; }

int64_t sp_network_dofs(const sp_network *net) { return (int64_t)net->n * net->dof; }

double sp_network_omega_bound(const sp_network *net) { return net->omega_bound; }

double sp_network_skew(const sp_network *net) { return net->skew; }

double sp_network_soft(const sp_network *net) { return net->soft; }

sp_status sp_network_need_symmetry(const sp_network *net, const char *what, sp_error *err) {
    if (!net->carried)
        return SP_OK;
    return sp_fail(
        err, SP_EREFUSED,
        "%s needs a symmetric stiffness: with prestress and friction it has an antisymmetric part (up to %.3g "
        "in omega^2, of %.3g); leave out the prestress, or take what does without: signals by chebyshev, "
        "moduli, the verdict of stability",
        what, net->skew, net->omega_bound * net->omega_bound);
}

void sp_network_free(sp_network *net) {
    sp_free(net->grain);
    sp_free(net->mass);
    sp_free(net->x);
    sp_free(net->r);
    sp_free(net->springs);
    sp_free(net->length);
    sp_free(net->carried);
    *net = sp_network_none();
}
