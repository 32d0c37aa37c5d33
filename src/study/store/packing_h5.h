#ifndef SP_STORE_PACKING_H5_H
#define SP_STORE_PACKING_H5_H
/* A packing in an open HDF5 file, which may be a packing file or a sample of a store. */

#include "store/h5.h"

#include <sonopack/packing.h>

/* Format 2 has masses or stiffnesses that a reader of format 1 would not notice, format 3 another cell than a piston's,
 * or gravity. Everything else is written as 1. */
enum { SP_H5_FORMAT = 1, SP_H5_FORMAT_OWN_LAW = 2, SP_H5_FORMAT_CELL = 3 };

sp_status sp_packing_put(sp_h5 *h, const sp_packing *p, sp_error *err);
/* The format of the file's packing. SP_EIO if a newer version made it: it is not damaged. */
sp_status sp_packing_get_format(sp_h5 *h, int64_t *format, sp_error *err);
/* Reads a packing, and checks it (sp_packing_check). */
sp_status sp_packing_get(sp_h5 *h, sp_packing *out, sp_error *err);

/* Whether the file needs the kind of the cell and gravity (cell_h5.c). */
bool sp_packing_needs_cell(const sp_packing *p);
/* H5MD's word for each axis, "periodic" or "none". */
void sp_cell_boundary(const sp_packing *p, const char *boundary[3]);
/* The edges, the kind of the cell and gravity. */
sp_status sp_cell_put(sp_h5 *h, const sp_packing *p, sp_error *err);
/* The same and the boundary. p: allocated, with a piston. */
sp_status sp_cell_get(sp_h5 *h, int64_t format, sp_packing *p, sp_error *err);

/* Closes the file, and writes it to path if status is SP_OK. Returns status, or the error of writing. */
sp_status sp_h5_finish(sp_h5 *h, sp_status status, const char *path, sp_error *err);

/* A number in a struct, and its dataset. */
typedef struct sp_h5_field {
    sp_h5_name name;
    sp_h5_type type;
    size_t offset;
} sp_h5_field;
sp_status sp_h5_put_fields(sp_h5 *h, int count, const sp_h5_field *field, const void *from, sp_error *err);
sp_status sp_h5_get_fields(sp_h5 *h, int count, const sp_h5_field *field, void *to, sp_error *err);

#endif
