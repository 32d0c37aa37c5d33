/* Opens and closes HDF5 files. */
#include "store/h5.h"

#include "base/base.h"

#include "base/file.h"
#include <sonopack/study/store.h>

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static pthread_mutex_t library = PTHREAD_MUTEX_INITIALIZER;

/* ---- enter, leave, and reasons --------------------------------------------------------------------------------- */

/* SP_ENOMEM if HDF5 could not begin: with half of it sound files seem damaged. */
static sp_status enter(sp_h5 *h, const char *path, sp_error *err) {
    static bool broken;
    pthread_mutex_lock(&library);
    broken = broken || H5open() < 0;
    *h = (sp_h5){.file = H5I_INVALID_HID, .driver = H5I_INVALID_HID, .fd = -1, .path = path};
    H5Eget_auto2(H5E_DEFAULT, &h->handler, &h->handler_data);
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    return broken ? sp_fail(err, SP_ENOMEM, "%s: HDF5 cannot begin: no memory", path) : SP_OK;
}

void sp_h5_close(sp_h5 *h) {
    if (h->file >= 0)
        H5Fclose(h->file); /* closes what is still open in it; the data were flushed and checked before */
    if (h->driver >= 0)
        H5FDunregister(h->driver);
    if (h->fd >= 0)
        close(h->fd);
    H5Eclear2(H5E_DEFAULT);
    H5Eset_auto2(H5E_DEFAULT, h->handler, h->handler_data);
    h->file = h->driver = H5I_INVALID_HID;
    h->fd = -1;
    pthread_mutex_unlock(&library);
}

/* Finds the innermost reason on HDF5's error stack. */
static herr_t innermost(unsigned n, const H5E_error2_t *entry, void *out) {
    if (n == 0 && entry->desc)
        snprintf(out, 200, "%s", entry->desc);
    return 0;
}

/* Lists of properties are in memory, and of no file: HDF5 loses them when it finds none. */
static herr_t look_for_memory(unsigned n, const H5E_error2_t *entry, void *found) {
    (void)n;
    *(bool *)found = *(bool *)found || entry->maj_num == H5E_RESOURCE || entry->maj_num == H5E_PLIST;
    return 0;
}

bool sp_h5_short_of_memory(void) {
    bool found = false;
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, look_for_memory, &found);
    return found;
}

sp_status sp_h5_fail(const sp_h5 *h, sp_error *err, sp_status status, const char *format, ...) {
    char what[600], reason[200] = "";
    va_list args;
    va_start(args, format);
    vsnprintf(what, sizeof what, format, args);
    va_end(args);
    const int code = h->fd < 0 ? 0 : h->code == 0 && sp_h5_short_of_memory() ? ENOMEM : h->code;
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, innermost, reason);
    H5Eclear2(H5E_DEFAULT);
    if (code)
        return sp_fail(err, code == ENOMEM ? SP_ENOMEM : SP_EIO, "cannot read %s: %s", h->path, strerror(code));
    if (*reason)
        return sp_fail(err, status, "%s: %s (HDF5: %s)", h->path, what, reason);
    return sp_fail(err, status, "%s: %s", h->path, what);
}

size_t sp_h5_type_size(sp_h5_type type) {
    switch (type) {
    case SP_H5_F64:
    case SP_H5_I64:
    case SP_H5_U64: return 8;
    case SP_H5_I32: return 4;
    case SP_H5_U8: return 1;
    }
    return 0;
}

hid_t sp_h5_memory_type(sp_h5_type type) {
    switch (type) {
    case SP_H5_F64: return H5T_NATIVE_DOUBLE;
    case SP_H5_I32: return H5T_NATIVE_INT32;
    case SP_H5_I64: return H5T_NATIVE_INT64;
    case SP_H5_U64: return H5T_NATIVE_UINT64;
    case SP_H5_U8: return H5T_NATIVE_UINT8;
    }
    return H5I_INVALID_HID;
}

/* Access properties: the format of HDF5 1.8, whose object headers have checksums; no file locks, because files never
 * change. */
static hid_t file_access(bool create, bool memory) {
    hid_t fapl = H5Pcreate(H5P_FILE_ACCESS);
    if (fapl >= 0 && (H5Pset_fclose_degree(fapl, H5F_CLOSE_STRONG) < 0 || H5Pset_file_locking(fapl, false, true) < 0 ||
                      (create && H5Pset_libver_bounds(fapl, H5F_LIBVER_V18, H5F_LIBVER_V18) < 0) ||
                      (memory && H5Pset_fapl_core(fapl, (size_t)1 << 20, false) < 0))) {
        H5Pclose(fapl);
        fapl = H5I_INVALID_HID;
    }
    return fapl;
}

/* fapl: access properties, which are closed. */
static void create(sp_h5 *h, hid_t fapl) {
    hid_t fcpl = H5Pcreate(H5P_FILE_CREATE);
    if (fapl >= 0 && fcpl >= 0 && H5Pset_obj_track_times(fcpl, false) >= 0)
        h->file = H5Fcreate("sonopack", H5F_ACC_TRUNC, fcpl, fapl);
    H5Pclose(fcpl);
    H5Pclose(fapl);
}

sp_status sp_h5_create(sp_h5 *h, const char *path, sp_error *err) {
    sp_status status = enter(h, path, err);
    if (status != SP_OK)
        return status;
    create(h, file_access(true, true));
    return h->file >= 0 ? SP_OK : sp_h5_fail(h, err, SP_ENOMEM, "no memory: cannot make an HDF5 file there");
}

sp_status sp_h5_create_draft(sp_h5 *h, int fd, const char *path, sp_error *err) {
    sp_status status = enter(h, path, err);
    if (status != SP_OK)
        return status;
    hid_t fapl = file_access(true, false);
    h->driver = fapl >= 0 ? sp_h5_set_draft(fapl, fd, &h->code) : H5I_INVALID_HID;
    if (h->driver >= 0)
        create(h, fapl);
    else
        H5Pclose(fapl);
    return h->file >= 0 ? SP_OK : sp_h5_fail(h, err, SP_ENOMEM, "no memory: cannot make an HDF5 file there");
}

sp_status sp_h5_end_draft(sp_h5 *h, sp_error *err) {
    bool good = H5Fflush(h->file, H5F_SCOPE_GLOBAL) >= 0;
    good = H5Fclose(h->file) >= 0 && good;
    h->file = H5I_INVALID_HID;
    if (h->code)
        return sp_fail(err, SP_EIO, "cannot write %s: %s", h->path, strerror(h->code));
    return good ? SP_OK : sp_h5_fail(h, err, SP_EIO, "cannot be written");
}

void sp_hdf5_exit_silently(void) { H5dont_atexit(); }

/* A file that cannot be opened is not damaged. Reading a pipe or a device might never end. */
static sp_status open_file(const char *path, int *fd, sp_error *err) {
    struct stat info;
    if (stat(path, &info) != 0 || (S_ISREG(info.st_mode) && (*fd = open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC)) < 0))
        return sp_fail(err, SP_EIO, "cannot read %s: %s", path, strerror(errno));
    if (!S_ISREG(info.st_mode))
        return sp_fail(err, SP_EFORMAT, "%s: not a regular file, which an HDF5 file must be", path);
    return SP_OK;
}

sp_status sp_h5_open(sp_h5 *h, const char *path, sp_error *err) {
    sp_status status = enter(h, path, err);
    if (status == SP_OK)
        status = open_file(path, &h->fd, err);
    if (status != SP_OK)
        return status;
    hid_t fapl = file_access(false, false);
    hsize_t size = 0;
    h->driver = fapl >= 0 ? sp_h5_set_draft(fapl, h->fd, &h->code) : H5I_INVALID_HID;
    if (h->driver >= 0)
        h->file = H5Fopen(path, H5F_ACC_RDONLY, fapl);
    if (h->file < 0 || H5Fget_filesize(h->file, &size) < 0)
        status = sp_h5_fail(h, err, SP_EFORMAT, "not an intact HDF5 file");
    H5Pclose(fapl); /* not earlier, because it clears the reason */
    h->size = size;
    return status;
}
