#ifndef SP_CONTACTS_H
#define SP_CONTACTS_H

#include <sonopack/network.h>

/* The network with the forces at rest of its packing, which it does not have yet: k_p and carried forces. It shares all
 * but its springs with `net`, and is to be released before it. SP_ENOMEM. */
sp_status sp_network_prestress(const sp_packing *p, const sp_network *net, sp_network *out, sp_error *err);
void sp_network_release_prestress(sp_network *net);

#endif
