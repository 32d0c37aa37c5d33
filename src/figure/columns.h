#ifndef SP_COLUMNS_H
#define SP_COLUMNS_H
/* Columns of the tables that figures are drawn from. */

#include <sonopack/table.h>

/* Finds a column of numbers by name. SP_EINVAL if the table lacks it or if it holds text. `what` describes the expected
 * table in the message. */
sp_status sp_column_find(const sp_table *t, const char *name, const char *what, int *out, sp_error *err);

#endif
