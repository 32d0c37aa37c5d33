/* Adds the columns of a table from a list. */
#include "ensemble/groups.h"

sp_status sp_columns_add(sp_table *t, int count, const sp_column *column, sp_error *err) {
    sp_status status = SP_OK;
    for (int k = 0; k < count && status == SP_OK; k++)
        status = sp_table_add_column(t, column[k].name, column[k].unit, column[k].kind, err);
    return status;
}
