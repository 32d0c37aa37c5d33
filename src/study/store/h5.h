#ifndef SP_STORE_H5_H
#define SP_STORE_H5_H
/* HDF5 files: built in memory and then written as a whole, or read with every size and type checked.
 *
 * One lock serialises all calls of the process, from create or open to close, so keep that time short. Meanwhile HDF5
 * does not print errors; its reason becomes part of ours. */

#include <hdf5.h>
#include <sonopack/status.h>
#include <stdbool.h>
#include <stdint.h>

typedef struct sp_h5 {
    hid_t file;          /* H5I_INVALID_HID when closed */
    hid_t driver;        /* of a draft, or of a file that is read; else H5I_INVALID_HID */
    int fd;              /* of a file that is read; else -1 */
    const char *path;    /* for messages; belongs to the caller */
    uint64_t size;       /* of a file that is read [bytes] */
    int code;            /* errno of the first failure to read, or to write a draft; 0: none */
    H5E_auto2_t handler; /* of the calling program, restored by close */
    void *handler_data;
} sp_h5;

typedef enum sp_h5_type { SP_H5_F64, SP_H5_I32, SP_H5_I64, SP_H5_U64, SP_H5_U8 } sp_h5_type;
size_t sp_h5_type_size(sp_h5_type type);
hid_t sp_h5_memory_type(sp_h5_type type);

/* Path, unit and meaning, which every dataset has. */
typedef struct sp_h5_name {
    const char *path, *unit, *description;
} sp_h5_name;

enum { SP_H5_RANK = 3 };
typedef struct sp_h5_shape {
    int rank; /* 0: a single value */
    int64_t dim[SP_H5_RANK];
} sp_h5_shape;

/* ---- writing --------------------------------------------------------------------------------------------------- */

sp_status sp_h5_create(sp_h5 *h, const char *path, sp_error *err); /* in memory; path is for messages */
/* On the disk, for data that should not be in memory a second time. fd: an empty file, open to read and write. *h must
 * stay where it is until it is closed. */
sp_status sp_h5_create_draft(sp_h5 *h, int fd, const char *path, sp_error *err);
/* Ends a file of sp_h5_create_draft. SP_EIO if the disk did not take all of it; other functions do not notice.
 * sp_h5_close is needed all the same. */
sp_status sp_h5_end_draft(sp_h5 *h, sp_error *err);
/* Makes files of these access properties use an open file and our driver (h5_draft.c), which stores the errno of the
 * first failure in *code. Returns the driver, which must outlive the file: H5Fclose still uses what it has released.
 * H5I_INVALID_HID on failure. */
hid_t sp_h5_set_draft(hid_t fapl, int fd, int *code);
sp_status sp_h5_group(sp_h5 *h, const char *path, sp_error *err); /* its parents must exist */
/* An array of two axes with one row in a chunk, so that a row can be read alone. */
sp_status sp_h5_put_rows(sp_h5 *h, const sp_h5_name *name, sp_h5_type type, const sp_h5_shape *shape, const void *data,
                         sp_error *err);
sp_status sp_h5_put(sp_h5 *h, const sp_h5_name *name, sp_h5_type type, const sp_h5_shape *shape, const void *data,
                    sp_error *err);
sp_status sp_h5_put_text(sp_h5 *h, const sp_h5_name *name, const char *text, sp_error *err);
/* Attributes of an object: arrays of `count` texts or integers, or single values for count = 0. */
sp_status sp_h5_attribute_texts(sp_h5 *h, const char *object, const char *name, int count, const char *const *text,
                                sp_error *err);
sp_status sp_h5_attribute_ints(sp_h5 *h, const char *object, const char *name, int count, const int32_t *value,
                               sp_error *err);
/* A reference to another object, which H5MD's connectivity needs. */
sp_status sp_h5_attribute_reference(sp_h5 *h, const char *object, const char *name, const char *target, sp_error *err);
/* The file as bytes, for sp_file_write. Free them with sp_free. */
sp_status sp_h5_image(sp_h5 *h, void **data, size_t *size, sp_error *err);

/* ---- reading --------------------------------------------------------------------------------------------------- */

/* SP_EIO if the file cannot be opened, SP_EFORMAT if it is not an intact HDF5 file. *h must stay where it is until it
 * is closed. Whatever is read later fails with SP_EIO or SP_ENOMEM, and not with SP_EFORMAT, if that is due to the disk
 * or to the memory. */
sp_status sp_h5_open(sp_h5 *h, const char *path, sp_error *err);
/* Whether there is such an object. Also true where that could not be read: then reading the object fails. */
bool sp_h5_has(sp_h5 *h, const char *path);
/* The extents of a dataset, which must have this type and rank. SP_EFORMAT if its data are larger than the file can
 * hold. */
sp_status sp_h5_find(sp_h5 *h, const char *path, sp_h5_type type, int rank, sp_h5_shape *shape, sp_error *err);
/* Reads a dataset, whose extents must be as expected. data: NULL to check it only. */
sp_status sp_h5_get(sp_h5 *h, const char *path, sp_h5_type type, const sp_h5_shape *expected, void *data,
                    sp_error *err);
/* Checks how an open dataset of these extents is stored, element bytes each: in the file, with known filters, in chunks
 * that are neither too large nor too many, and no larger than what the file holds can be. */
sp_status sp_h5_check_layout(sp_h5 *h, hid_t set, const char *path, const sp_h5_shape *shape, size_t element,
                             sp_error *err);
/* Reads rows first .. first + count - 1 of an array of two axes with these extents. */
sp_status sp_h5_get_rows(sp_h5 *h, const char *path, sp_h5_type type, const sp_h5_shape *expected, int64_t first,
                         int64_t count, void *data, sp_error *err);
sp_status sp_h5_get_text(sp_h5 *h, const char *path, char **text, sp_error *err); /* free with sp_free */
sp_status sp_h5_attribute_int(sp_h5 *h, const char *object, const char *name, int64_t *value, sp_error *err);
/* SP_EFORMAT unless an attribute is this array of `count` texts. */
sp_status sp_h5_check_texts(sp_h5 *h, const char *object, const char *name, int count, const char *const *text,
                            sp_error *err);

/* To be called once after create or open, even if they failed. */
void sp_h5_close(sp_h5 *h);

/* Whether HDF5 has just failed for lack of memory. */
bool sp_h5_short_of_memory(void);
/* Fails with "PATH: what (HDF5: ...)". Of a file that is read, what the disk or the memory did comes first. */
sp_status sp_h5_fail(const sp_h5 *h, sp_error *err, sp_status status, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

#endif
