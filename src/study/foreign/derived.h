#ifndef SP_FOREIGN_DERIVED_H
#define SP_FOREIGN_DERIVED_H
/* What files of other programs list beside positions and forces: sums over the contacts of a grain, stiffnesses, and
 * the ends of contacts. */

#include <sonopack/packing.h>

typedef struct sp_derived {
    int32_t *contacts; /* [n] force-carrying contacts of each grain, F_n > 1e-4 p d^2, none of a rattler */
    int32_t *rattler;  /* [n] 1 for rattlers */
    uint8_t *carrying; /* [n_contacts] */
    double *mass;      /* [n] */
    double *net;       /* [n][3] sum of all contact forces */
    double *stress;    /* [n][3][3] sum of (branch) x (force) over the grain's volume; positive in compression */
    double *pressure;  /* [n] trace of the stress over the dimension */
} sp_derived;

/* SP_ENOMEM. Free it, even after a failure. */
sp_status sp_derive(const sp_packing *p, sp_derived *out, sp_error *err);
void sp_derived_free(sp_derived *d);

/* Force on grain i of the contact. */
void sp_contact_force(const sp_contact *c, double force[3]);
/* Tangential stiffness, the contact's own or Mindlin's. */
double sp_contact_kt(const sp_packing *p, const sp_contact *c);
/* Where the contact's line ends: the centre of the image of j that touches i, or the point on the wall. Returns whether
 * the line crosses a periodic edge. */
bool sp_contact_end(const sp_packing *p, const sp_contact *c, double end[3]);

#endif
