#ifndef SP_QUANTITY_H
#define SP_QUANTITY_H
/* What the numbers of a result are: symbol, unit and meaning, made from sonopack/quantities.inc. */

#include <sonopack/status.h>
#include <sonopack/table.h>

typedef struct sp_quantity {
    const char *symbol, *unit, *meaning; /* symbol = NULL ends a list */
    size_t offset;                       /* of the double in its struct */
} sp_quantity;
SP_SHARED extern const sp_quantity sp_statics_quantities[], sp_ring_statics_quantities[], sp_moduli_quantities[];

/* The next of the quantities whose symbols stand between blanks; *symbols moves behind it. NULL after the last. */
SP_SHARED const sp_quantity *sp_quantity_next(const sp_quantity *all, const char **symbols);
SP_SHARED double sp_quantity_value(const sp_quantity *q, const void *of);

/* Adds a row, one cell for each column; texts are copied. */
SP_SHARED sp_status sp_table_add_cells(sp_table *t, const sp_entry *cells, sp_error *err);

#endif
