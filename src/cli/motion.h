#ifndef SP_CLI_MOTION_H
#define SP_CLI_MOTION_H
/* Tables of motions of all grains, which `sonopack plot mode' draws. */

#include "cli/files.h"

/* Comments: the kind of the motion, and the network that it belongs to. */
void cli_motion_comments(const cli_file *file, const char *motion, cli_writer *w);
/* Columns grain, x, y (z), radius, the displacements ux .. and the rotations rx .. in these units. */
void cli_motion_columns(const sp_network *net, const char *displacement, const char *rotation, cli_writer *w);
/* The row of grain i of the network. u: its [dof] displacements and rotations. */
void cli_motion_row(const sp_network *net, int32_t i, const double *u, cli_writer *w);

#endif
