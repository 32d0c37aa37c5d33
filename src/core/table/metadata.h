#ifndef SP_TABLE_METADATA_H
#define SP_TABLE_METADATA_H
/* Metadata of a table: the comment lines "key = value". */

#include <sonopack/table.h>

/* Records the metadata in the table's last comment line, if there is any. */
sp_status sp_table_index_comment(sp_table *t, sp_error *err);

#endif
