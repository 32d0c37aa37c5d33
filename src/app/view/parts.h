#ifndef SP_VIEW_PARTS_H
#define SP_VIEW_PARTS_H
/* The parts of a packing in the page. */

#include "view/json.h"
#include "view/view.h"

/* What the parts of one packing share. */
typedef struct view_part {
    const sp_packing *packing;
    const view_options *options;
    const view_report *report;
    const sp_network *net; /* NULL: there is none, for the reason below */
    const sp_error *reason;
} view_part;

/* Grains and contacts. */
sp_status view_add_grains(view_json *j, const sp_packing *p, double threshold, sp_error *err);
/* "grain": the grains of the network, to which the displacements belong. */
void view_add_network(view_json *j, const sp_network *net);
/* "modes" and "wave": an object with the result, or with the `reason` for which there is none; or null, if not
 * wanted. */
sp_status view_add_modes(view_json *j, const view_part *part, sp_error *err);
sp_status view_add_wave(view_json *j, const view_part *part, sp_error *err);

/* Writes the reason instead of a part, and reports it. With `needed` it is an error. */
sp_status view_leave_out(view_json *j, const char *key, const view_part *part, bool needed, const sp_error *reason,
                         sp_error *err);

#endif
