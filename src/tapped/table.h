#ifndef SP_TAPPED_TABLE_H
#define SP_TAPPED_TABLE_H
/* Comments of the tables of a column. */

#include <sonopack/tapped/tapped.h>

/* What diagrams go through, by its name in the scene. */
const char *sp_tapped_parameter_name(sp_tapped_parameter parameter);
/* What was asked for, as comments "key = value" with the names of the scene; those that are there already are left. */
sp_status sp_tapped_note_spec(const sp_tapped_spec *c, sp_table *t, sp_error *err);
/* What came of a run; and what must be known of it, as comments that begin with "warning: ". */
sp_status sp_tapped_note_report(const sp_tapped_spec *c, const sp_tapped_report *r, sp_table *t, sp_error *err);
/* What must be known of the model, likewise. */
sp_status sp_tapped_note_model(const sp_tapped_spec *c, sp_table *t, sp_error *err);

#endif
