#ifndef SP_CLI_MODES_H
#define SP_CLI_MODES_H
/* What the files of sonopack modes share. */

#include "cli/cli.h"

/* The table of --damping ZETA. */
sp_status modes_damped(const sp_packing *p, const sp_network *net, double zeta, sp_source source, sp_table *t,
                       sp_error *err);
/* The table of --stability. */
sp_status modes_stability(const sp_packing *p, const sp_network *net, sp_table *t, sp_error *err);

#define MODES_FREQUENCY "sqrt(E* / rho)/d"

#endif
