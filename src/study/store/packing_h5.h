#ifndef SP_STORE_PACKING_H5_H
#define SP_STORE_PACKING_H5_H
/* A packing inside an HDF5 file that is open: what packings and samples of a store share. */

#include "store/h5.h"

#include <sonopack/packing.h>

/* Raised when a reader of the last format would misread the new one. */
enum { SP_H5_FORMAT = 1 };

sp_status sp_packing_put(sp_h5 *h, const sp_packing *p, sp_error *err);
/* Checked. */
sp_status sp_packing_get(sp_h5 *h, sp_packing *out, sp_error *err);

/* Closes the file and writes it; or, with a status that is not SP_OK, only closes it. Returns that status. */
sp_status sp_h5_finish(sp_h5 *h, sp_status status, const char *path, sp_error *err);

/* Single numbers of a struct, by one table for writing and reading. */
typedef struct sp_h5_field {
    sp_h5_name name;
    sp_h5_type type;
    size_t offset;
} sp_h5_field;
sp_status sp_h5_put_fields(sp_h5 *h, int count, const sp_h5_field *field, const void *from, sp_error *err);
sp_status sp_h5_get_fields(sp_h5 *h, int count, const sp_h5_field *field, void *to, sp_error *err);

#endif
