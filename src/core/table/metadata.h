#ifndef SP_TABLE_METADATA_H
#define SP_TABLE_METADATA_H
/* Metadata of a table: the comment lines "key = value". */

#include <sonopack/table.h>

/* Adds a comment line without looking for metadata in it. */
sp_status sp_table_add_line(sp_table *t, const char *line, sp_error *err);

#endif
