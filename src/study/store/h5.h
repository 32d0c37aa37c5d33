#ifndef SP_STORE_H5_H
#define SP_STORE_H5_H
/* HDF5 files: written to a draft that is renamed when it is whole, or read with every size and type checked.
 *
 * The first failure of a file is kept in it: then every function returns at once, and sp_h5_close gives the failure. So
 * a caller looks at the status only before it uses what was read.
 *
 * One lock serialises all calls of the process, from create or open to close, so keep that time short. Meanwhile HDF5
 * does not print errors; its reason becomes part of ours. */

#include "base/file.h"

#include <hdf5.h>
#include <sonopack/status.h>
#include <stdbool.h>
#include <stdint.h>

typedef struct sp_h5 {
    sp_status status;    /* of the first failure */
    sp_error *err;       /* its reason; may be NULL */
    hid_t file, driver;  /* H5I_INVALID_HID when closed */
    sp_draft draft;      /* of a file that is written; its fd is -1 of one that is read */
    int fd;              /* of a file that is read; else -1 */
    const char *path;    /* for messages; belongs to the caller */
    uint64_t size;       /* of a file that is read [bytes] */
    int code;            /* errno of the first failure of the disk, or ENOMEM; 0: none */
    H5E_auto2_t handler; /* of the calling program, restored by close */
    void *handler_data;
} sp_h5;

typedef enum sp_h5_type { SP_H5_F64, SP_H5_I32, SP_H5_I64, SP_H5_U64, SP_H5_U8 } sp_h5_type;

/* Path, unit and meaning, which every dataset has. */
typedef struct sp_h5_name {
    const char *path, *unit, *description;
} sp_h5_name;

enum { SP_H5_RANK = 3 };
typedef struct sp_h5_shape {
    int rank; /* 0: a single value */
    int64_t dim[SP_H5_RANK];
} sp_h5_shape;

/* A number in a struct, and its dataset. */
typedef struct sp_h5_field {
    sp_h5_name name;
    sp_h5_type type;
    size_t offset;
} sp_h5_field;

/* ---- writing --------------------------------------------------------------------------------------------------- */

/* *h must stay where it is until it is closed. SP_EIO if the file cannot be written. */
sp_status sp_h5_create(sp_h5 *h, const char *path, sp_error *err);
void sp_h5_group(sp_h5 *h, const char *path); /* its parents must exist */
void sp_h5_put(sp_h5 *h, const sp_h5_name *name, sp_h5_type type, const sp_h5_shape *shape, const void *data);
/* An array of two axes with one row in a chunk, so that a row can be read alone. */
void sp_h5_put_rows(sp_h5 *h, const sp_h5_name *name, sp_h5_type type, const sp_h5_shape *shape, const void *data);
void sp_h5_put_text(sp_h5 *h, const sp_h5_name *name, const char *text);
void sp_h5_put_fields(sp_h5 *h, int count, const sp_h5_field *field, const void *from);
/* Attributes of an object: arrays of `count` texts or integers, or single values for count = 0. */
void sp_h5_attribute_texts(sp_h5 *h, const char *object, const char *name, int count, const char *const *text);
void sp_h5_attribute_ints(sp_h5 *h, const char *object, const char *name, int count, const int32_t *value);
/* A reference to another object, which H5MD's connectivity needs. */
void sp_h5_attribute_reference(sp_h5 *h, const char *object, const char *name, const char *target);

/* ---- reading --------------------------------------------------------------------------------------------------- */

/* SP_EIO if the file cannot be opened, SP_EFORMAT if it is not an intact HDF5 file. *h must stay where it is until it
 * is closed. Whatever is read later fails with SP_EIO or SP_ENOMEM, and not with SP_EFORMAT, if that is due to the disk
 * or to the memory. */
sp_status sp_h5_open(sp_h5 *h, const char *path, sp_error *err);
/* Whether there is such an object. If that could not be read, the file has failed. */
bool sp_h5_has(sp_h5 *h, const char *path);
/* The extents of a dataset, which must have this type and rank. SP_EFORMAT if its data are larger than the file can
 * hold. */
sp_status sp_h5_find(sp_h5 *h, const char *path, sp_h5_type type, int rank, sp_h5_shape *shape);
/* Reads a dataset, whose extents must be as expected. data: NULL to check it only. */
sp_status sp_h5_get(sp_h5 *h, const char *path, sp_h5_type type, const sp_h5_shape *expected, void *data);
/* Reads rows first .. first + count - 1 of an array of two axes with these extents. */
sp_status sp_h5_get_rows(sp_h5 *h, const char *path, sp_h5_type type, const sp_h5_shape *expected, int64_t first,
                         int64_t count, void *data);
sp_status sp_h5_get_text(sp_h5 *h, const char *path, char **text); /* free with sp_free */
/* Reads a text that must be one of the words, which NULL ends; its index. */
sp_status sp_h5_get_word(sp_h5 *h, const char *path, const char *const *words, int *out);
sp_status sp_h5_get_fields(sp_h5 *h, int count, const sp_h5_field *field, void *to);
sp_status sp_h5_attribute_int(sp_h5 *h, const char *object, const char *name, int64_t *value);
/* SP_EFORMAT unless an attribute is this array of `count` texts. */
sp_status sp_h5_check_texts(sp_h5 *h, const char *object, const char *name, int count, const char *const *text);

/* ---- both ------------------------------------------------------------------------------------------------------- */

/* To be called once after create or open, even if they failed. Returns the first failure. A file that was written
 * without one is synced and renamed, outside of the lock. */
sp_status sp_h5_close(sp_h5 *h);

/* Memory for an array, zeroed; NULL makes the file fail. Free it with sp_free. */
void *sp_h5_alloc(sp_h5 *h, int64_t count, size_t size);
size_t sp_h5_type_size(sp_h5_type type);
hid_t sp_h5_memory_type(sp_h5_type type);
/* Whether HDF5 has just failed for lack of memory. */
bool sp_h5_short_of_memory(void);
/* Makes the file fail with "PATH: what (HDF5: ...)", unless it has failed before. What the disk or the memory did comes
 * first. Returns the status of the file. */
sp_status sp_h5_fail(sp_h5 *h, sp_status status, const char *format, ...) __attribute__((format(printf, 3, 4)));

#endif
