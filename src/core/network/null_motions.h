#ifndef SP_NULL_MOTIONS_H
#define SP_NULL_MOTIONS_H
/* Motions that stretch no spring and are known without an eigenproblem: those of a single grain (with friction, the
 * spin of a sphere that is held at two points) and those of a part of the network that moves as a rigid body (a packing
 * that slides along walls without friction). Each is an exact null vector of K. */

#include <sonopack/network.h>

enum { SP_GRAIN_DOFS = 6 };

/* Mass-weighted vectors, orthonormal all together: M^1/2 times the motion. */
typedef struct sp_null_motions {
    int64_t spins;
    int32_t *grain;                /* [spins] the grain that moves, ascending */
    double (*spin)[SP_GRAIN_DOFS]; /* [spins] its components; those of all other grains are 0 */
    int64_t rigid;
    double *motion; /* [rigid][dofs] */
    double stretch; /* upper bound of |A^1/2 e| of all of them, A = M^-1/2 K M^-1/2: rounding */
} sp_null_motions;

/* SP_ENOMEM. */
sp_status sp_null_motions_make(const sp_network *net, sp_null_motions *out, sp_error *err);
void sp_null_motions_free(sp_null_motions *z);
/* Writes vector k as [dofs]: the spins, then the rigid motions. */
void sp_null_motions_vector(const sp_network *net, const sp_null_motions *z, int64_t k, double *e);
/* Subtracts from e [dofs] its part in the space of these motions; returns the norm of that part. */
double sp_null_motions_remove(const sp_network *net, const sp_null_motions *z, double *e);

#endif
