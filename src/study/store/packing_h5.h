#ifndef SP_STORE_PACKING_H5_H
#define SP_STORE_PACKING_H5_H
/* A packing in an open HDF5 file, which may be a packing file or a sample of a store. */

#include "store/h5.h"

#include <sonopack/packing.h>

/* Format 2 has masses or stiffnesses that a reader of format 1 would not notice, format 3 another cell than a piston's,
 * or gravity. Everything else is written as 1. */
enum { SP_H5_FORMAT = 1, SP_H5_FORMAT_OWN_LAW = 2, SP_H5_FORMAT_CELL = 3 };

void sp_packing_put(sp_h5 *h, const sp_packing *p);
/* The format of the file's packing. SP_EIO if a newer version made it: it is not damaged. */
sp_status sp_packing_get_format(sp_h5 *h, int64_t *format);
/* Reads a packing, and checks it (sp_packing_check). */
sp_status sp_packing_get(sp_h5 *h, sp_packing *out);

/* Whether a file is HDF5, by its content. SP_EIO if it cannot be read. */
sp_status sp_is_hdf5(const char *path, bool *yes, sp_error *err);

#endif
