#ifndef SP_CLI_MOTION_H
#define SP_CLI_MOTION_H
/* The displacements of all grains in a mode, or at a time after a pulse: as a table, and read back. */

#include "cli/cli.h"

typedef struct cli_motion {
    const sp_packing *packing;
    const sp_network *net;
    sp_network_options made; /* of the network */
    bool mode;               /* else a snapshot */
    int64_t number;          /* of the mode among all */
    double omega, omega_error;
    double t;         /* of the snapshot */
    sp_source source; /* of its pulse */
    double error;     /* bound: of |e - exact|, e = M^(1/2) u, of a mode; of every component of a snapshot */
    const double *u;  /* [dofs of net] */
} cli_motion;

/* Fills a table: a row a grain of the network. */
sp_status cli_motion_table(const cli_motion *m, sp_table *t, sp_error *err);
/* Writes the table to path, in the format of its ending. */
sp_status cli_motion_write(const cli_common *common, const cli_motion *m, const char *path, sp_error *err);

/* Reads a table of motion of the packing p. m->mode says which kind it must be. Sets m->number, omega, t, ... but for
 * packing, net and u. SP_EFORMAT if it is of another packing or kind. */
sp_status cli_motion_head(const char *path, const sp_packing *p, const sp_table *t, cli_motion *m, sp_error *err);
/* Reads the displacements of a network with the same grains. */
sp_status cli_motion_field(const char *path, const sp_network *net, const sp_table *t, double *u, sp_error *err);

/* u = M^(-1/2) e for a vector e of a mode. */
void cli_motion_of_mode(const sp_network *net, const double *e, double *u);

#endif
