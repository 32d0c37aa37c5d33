#ifndef SP_COLUMN_SPRINGS_H
#define SP_COLUMN_SPRINGS_H
/* The lattice (19) as y' = v, v' = Y for explicit steps, with sigma and chi sharp as in (9) or smooth as in (30). The
 * state: y [N], v [N], work of the floor, dissipated energy. */

#include "column/march.h"
#include "numeric/ode.h"

typedef struct sp_column_springs {
    int32_t n;
    double stiffness, e, gravity;
    double alpha_v, alpha_x; /* INFINITY: sharp */
    double *mass, *distance; /* [n] */
    sp_column_phase phase;
    sp_ode ode;
} sp_column_springs;

sp_status sp_column_springs_make(const sp_column_spec *c, double alpha_v, double alpha_x, sp_column_springs *out,
                                 sp_error *err);
void sp_column_springs_free(sp_column_springs *s);
/* At rest, or dropped. */
void sp_column_springs_start(const sp_column_spec *c, const sp_column_springs *s, double *state);
void sp_column_springs_particles(const sp_column_springs *s, const double *state, double *y, double *v);
double sp_column_springs_energy(const sp_column_springs *s, double floor, const double *state);
/* Highest angular frequency that contacts of K (1 + e) can have: 2 sqrt(K (1 + e)/m) of the lightest. */
double sp_column_springs_frequency(const sp_column_springs *s);

#endif
