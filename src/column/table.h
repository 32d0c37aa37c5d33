#ifndef SP_COLUMN_TABLE_H
#define SP_COLUMN_TABLE_H
/* Comments of the tables of a column. */

#include <sonopack/column.h>

/* What diagrams go through, by its name in the scene. */
const char *sp_column_parameter_name(sp_column_parameter parameter);
/* What was asked for, as comments "key = value" with the names of the scene; those that are there already are left. */
sp_status sp_column_note_spec(const sp_column_spec *c, sp_table *t, sp_error *err);
/* What came of a run; and what must be known of it, as comments that begin with "warning: ". */
sp_status sp_column_note_report(const sp_column_spec *c, const sp_column_report *r, sp_table *t, sp_error *err);
/* What must be known of the model, likewise. */
sp_status sp_column_note_model(const sp_column_spec *c, sp_table *t, sp_error *err);

#endif
