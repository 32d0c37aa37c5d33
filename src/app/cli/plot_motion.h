#ifndef SP_CLI_PLOT_MOTION_H
#define SP_CLI_PLOT_MOTION_H
/* Figures of displacements: a mode, or the motion at a time after a pulse. */

#include "cli/motion.h"

typedef struct plot_motion {
    bool mode;      /* else a snapshot */
    int64_t number; /* of the mode among all; < 0: the first that is not a zero mode */
    double time;    /* of the snapshot; < 0: when the front has travelled about three quarters of the height */
    const char *packing;
    const char *given; /* file of modes, or table of displacements, drawn instead of computing them; or NULL */
    int frames;        /* of a movie; 0: one figure */
    double from, to;   /* times of the first and the last frame of a snapshot; < 0: from the pulse, until it is there */
    const char *table; /* write the displacements to this table too; or NULL */
} plot_motion;

sp_status plot_motion_file(const cli_common *common, const sp_scene *scene, const plot_motion *what, sp_error *err);

/* The same displacements without a figure. motion.packing, net and u point into this struct's own members. */
typedef struct plot_motion_found {
    sp_packing packing;
    sp_network net;
    double *u; /* [dofs of net] */
    cli_motion motion;
} plot_motion_found;
plot_motion_found plot_motion_none(void);
/* Free *out, even after a failure. */
sp_status plot_motion_find(const cli_common *common, const sp_scene *scene, const plot_motion *what,
                           plot_motion_found *out, sp_error *err);
void plot_motion_free(plot_motion_found *found);

#endif
