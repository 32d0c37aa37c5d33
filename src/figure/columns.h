#ifndef SP_COLUMNS_H
#define SP_COLUMNS_H
/* Columns of the tables that figures are drawn from. */

#include <sonopack/table.h>

/* A column of numbers by its name; SP_EINVAL if there is none, with `what' the table should be, or if it holds text. */
sp_status sp_column_find(const sp_table *t, const char *name, const char *what, int *out, sp_error *err);

#endif
