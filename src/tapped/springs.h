#ifndef SP_TAPPED_SPRINGS_H
#define SP_TAPPED_SPRINGS_H
/* The lattice (19) as a system y' = v, v' = acceleration for explicit steps. sigma and chi are sharp as in (9) or
 * smooth as in (30). The state holds y [N], v [N], the work of the floor and the dissipated energy. */

#include "numeric/ode.h"
#include "tapped/integrate.h"

typedef struct sp_tapped_springs {
    int32_t n;
    double stiffness, e, gravity;
    double alpha_v, alpha_x; /* INFINITY: the sharp functions */
    double *mass, *distance; /* [n] */
    sp_tapped_phase phase;
    sp_ode ode;
} sp_tapped_springs;

sp_status sp_tapped_springs_make(const sp_tapped_spec *c, double alpha_v, double alpha_x, sp_tapped_springs *out,
                                 sp_error *err);
void sp_tapped_springs_free(sp_tapped_springs *s);
/* Initial state: at rest, or dropped. */
void sp_tapped_springs_start(const sp_tapped_spec *c, const sp_tapped_springs *s, double *state);
void sp_tapped_springs_positions(const sp_tapped_springs *s, const double *state, double *y, double *v);
double sp_tapped_springs_energy(const sp_tapped_springs *s, double floor, const double *state);
/* Upper bound of the angular frequencies: 2 sqrt(K (1 + e)/m) with the smallest mass [1/s]. */
double sp_tapped_springs_frequency(const sp_tapped_springs *s);

#endif
