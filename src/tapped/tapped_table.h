#ifndef SP_TAPPED_TABLE_H
#define SP_TAPPED_TABLE_H
/* Columns and comments of the tables of a column. */

#include <sonopack/tapped/tapped.h>

/* Adds columns letter<first> .. letter<N>. */
sp_status sp_tapped_add_particles(const sp_tapped_spec *c, const char *letter, int32_t first, const char *unit,
                                  sp_table *t, sp_error *err);
/* Name of the varied parameter of a diagram, as in the scene. */
const char *sp_tapped_parameter_name(sp_tapped_parameter parameter);
/* Adds the parameters as comments "key = value" with the names of the scene. Keys that are there already are kept. */
sp_status sp_tapped_comment_spec(const sp_tapped_spec *c, sp_table *t, sp_error *err);
/* Adds the results of a run as comments, and warnings as comments that begin with "warning: ". */
sp_status sp_tapped_comment_report(const sp_tapped_spec *c, const sp_tapped_report *r, sp_table *t, sp_error *err);
/* Adds the warnings about the model. */
sp_status sp_tapped_comment_model(const sp_tapped_spec *c, sp_table *t, sp_error *err);

#endif
