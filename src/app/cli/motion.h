#ifndef SP_CLI_MOTION_H
#define SP_CLI_MOTION_H
/* The displacements of all grains in a mode, as a table. */

#include "cli/cli.h"

typedef struct cli_motion {
    const sp_packing *packing;
    const sp_network *net;
    sp_network_options made; /* of the network */
    int64_t number;          /* of the mode among all */
    double omega, omega_error;
    double error;    /* bound of |e - exact|, e = M^(1/2) u */
    const double *u; /* [dofs of net] */
} cli_motion;

/* Writes a table to path, in the format of its ending: a row a grain of the network. */
sp_status cli_motion_write(const cli_common *common, const cli_motion *m, const char *path, sp_error *err);

/* u = M^(-1/2) e for a vector e of a mode. */
void cli_motion_of_mode(const sp_network *net, const double *e, double *u);

#endif
