/* Finds columns of numbers in tables. */
#include "figure/columns.h"

#include "base/base.h"

sp_status sp_column_find(const sp_table *t, const char *name, const char *what, int *out, sp_error *err) {
    *out = sp_table_find_column(t, name);
    if (*out < 0)
        return sp_fail(err, SP_EINVAL, "the table has no column %s; %s", name, what);
    if (t->column[*out].kind == SP_COLUMN_TEXT)
        return sp_fail(err, SP_EINVAL, "column %s holds text: must be numbers", name);
    return SP_OK;
}
