#ifndef SP_STORE_H5_H
#define SP_STORE_H5_H
/* HDF5 as this program uses it: files built in memory and written whole, and files read without trust.
 *
 * All calls of the process go through one lock, from create or open to close: keep that time short. The library's own
 * error printing is off in between, and its reason goes into ours. */

#include <hdf5.h>
#include <sonopack/status.h>
#include <stdbool.h>
#include <stdint.h>

typedef struct sp_h5 {
    hid_t file;          /* H5I_INVALID_HID when closed */
    const char *path;    /* for messages; belongs to the caller */
    uint64_t size;       /* of the file that is read [bytes] */
    H5E_auto2_t handler; /* of the program around us, put back by close */
    void *handler_data;
} sp_h5;

typedef enum sp_h5_type { SP_H5_F64, SP_H5_I32, SP_H5_I64, SP_H5_U64, SP_H5_U8 } sp_h5_type;
size_t sp_h5_type_size(sp_h5_type type);
hid_t sp_h5_memory_type(sp_h5_type type);

/* Name, unit and meaning of a dataset: what every one of them carries. */
typedef struct sp_h5_name {
    const char *path, *unit, *description;
} sp_h5_name;

enum { SP_H5_RANK = 3 };
typedef struct sp_h5_shape {
    int rank; /* 0: a single value */
    int64_t dim[SP_H5_RANK];
} sp_h5_shape;

/* ---- writing --------------------------------------------------------------------------------------------------- */

sp_status sp_h5_create(sp_h5 *h, const char *path, sp_error *err); /* in memory; path only names it */
sp_status sp_h5_group(sp_h5 *h, const char *path, sp_error *err);  /* its parents must be there */
sp_status sp_h5_put(sp_h5 *h, const sp_h5_name *name, sp_h5_type type, const sp_h5_shape *shape, const void *data,
                    sp_error *err);
sp_status sp_h5_put_text(sp_h5 *h, const sp_h5_name *name, const char *text, sp_error *err);
/* Attributes of an object: `count` texts or integers; count 0: a single one. */
sp_status sp_h5_attribute_texts(sp_h5 *h, const char *object, const char *name, int count, const char *const *text,
                                sp_error *err);
sp_status sp_h5_attribute_ints(sp_h5 *h, const char *object, const char *name, int count, const int32_t *value,
                               sp_error *err);
/* A reference to another object, as H5MD's connectivity wants it. */
sp_status sp_h5_attribute_reference(sp_h5 *h, const char *object, const char *name, const char *target, sp_error *err);
/* The whole file as bytes, for sp_file_write; free with sp_free. */
sp_status sp_h5_image(sp_h5 *h, void **data, size_t *size, sp_error *err);

/* ---- reading --------------------------------------------------------------------------------------------------- */

/* SP_EIO if there is no such file, SP_EFORMAT if it is no intact HDF5 file. */
sp_status sp_h5_open(sp_h5 *h, const char *path, sp_error *err);
bool sp_h5_has(sp_h5 *h, const char *path);
/* The extents of a dataset of this type and rank, whose data are small enough to be in this file. */
sp_status sp_h5_find(sp_h5 *h, const char *path, sp_h5_type type, int rank, sp_h5_shape *shape, sp_error *err);
/* Its data; the extents must be those expected. */
sp_status sp_h5_get(sp_h5 *h, const char *path, sp_h5_type type, const sp_h5_shape *expected, void *data,
                    sp_error *err);
sp_status sp_h5_get_text(sp_h5 *h, const char *path, char **text, sp_error *err); /* free with sp_free */
sp_status sp_h5_attribute_int(sp_h5 *h, const char *object, const char *name, int64_t *value, sp_error *err);
/* Whether an array of `count` texts is this one. */
sp_status sp_h5_check_texts(sp_h5 *h, const char *object, const char *name, int count, const char *const *text,
                            sp_error *err);

/* After create or open, whether it went well or not, once. */
void sp_h5_close(sp_h5 *h);

/* A reason with what HDF5 says about it: "PATH: what (HDF5: ...)". */
sp_status sp_h5_fail(const sp_h5 *h, sp_error *err, sp_status status, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

#endif
