/* Prints motions of all grains. */
#include "cli/motion.h"

#include <inttypes.h>

void cli_motion_comments(const cli_file *file, const char *motion, cli_writer *w) {
    const sp_network_options *made = &file->scene->network;
    cli_comment(w, "motion = %s", motion);
    cli_comment(w, "packing = %016" PRIx64, sp_packing_hash(&file->packing));
    cli_value(w, "threshold", made->threshold);
    cli_comment(w, "prestress = %d", made->prestress);
    cli_comment(w, "sliding_free = %d", made->sliding_free);
}

void cli_motion_columns(const sp_network *net, const char *displacement, const char *rotation, cli_writer *w) {
    static const char *const displacements[] = {"ux", "uy", "uz"}, *const rotations[] = {"rx", "ry", "rz"};
    cli_columns(w, SP_COLUMN_INTEGER, "grain", "", NULL);
    cli_place_columns(w, net->dim);
    cli_columns(w, SP_COLUMN_NUMBER, "radius", "d", NULL);
    for (int a = 0; a < net->dim; a++)
        cli_columns(w, SP_COLUMN_NUMBER, displacements[a], displacement, NULL);
    for (int a = net->dim == 2 ? 2 : 0; a < 3 && net->dof > net->dim; a++) /* in 2D the only rotation is about z */
        cli_columns(w, SP_COLUMN_NUMBER, rotations[a], rotation, NULL);
}

void cli_motion_row(const sp_network *net, int32_t i, const double *u, cli_writer *w) {
    cli_put(w, net->grain[i]);
    for (int a = 0; a < net->dim; a++)
        cli_put(w, net->x[3 * (int64_t)i + a]);
    cli_put(w, net->r[i]);
    for (int a = 0; a < net->dof; a++)
        cli_put(w, u[a]);
    cli_end_row(w);
}
