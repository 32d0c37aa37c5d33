/* Opens and closes HDF5 files, and has the driver by which HDF5 reads and writes them. */
#include "store/h5.h"

#include "base/base.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <sonopack/study/store.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static pthread_mutex_t library = PTHREAD_MUTEX_INITIALIZER;

/* ---- enter, leave, and reasons --------------------------------------------------------------------------------- */

/* SP_ENOMEM if HDF5 could not begin: with half of it sound files seem damaged. */
static void enter(sp_h5 *h, const char *path, sp_error *err) {
    static bool broken;
    pthread_mutex_lock(&library);
    broken = broken || H5open() < 0;
    *h = (sp_h5){
        .file = H5I_INVALID_HID, .driver = H5I_INVALID_HID, .fd = -1, .draft = {.fd = -1}, .path = path, .err = err};
    H5Eget_auto2(H5E_DEFAULT, &h->handler, &h->handler_data);
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    if (broken)
        h->status = sp_fail(err, SP_ENOMEM, "%s: HDF5 cannot begin: no memory", path);
}

static void leave(sp_h5 *h) {
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

sp_status sp_h5_close(sp_h5 *h) {
    const bool writing = h->draft.fd >= 0;
    bool good = h->status != SP_OK || !writing || H5Fflush(h->file, H5F_SCOPE_GLOBAL) >= 0;
    good = (h->file < 0 || H5Fclose(h->file) >= 0) && good; /* closes what is still open in it */
    if (writing && h->status == SP_OK && h->code)
        h->status = sp_fail(h->err, SP_EIO, "cannot write %s: %s", h->path, strerror(h->code));
    if (writing && !good)
        sp_h5_fail(h, SP_EIO, "cannot be written");
    leave(h);
    if (writing && h->status == SP_OK)
        return h->status = sp_draft_commit(&h->draft, h->err);
    if (writing)
        sp_draft_drop(&h->draft);
    return h->status;
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

sp_status sp_h5_fail(sp_h5 *h, sp_status status, const char *format, ...) {
    char what[600], reason[200] = "";
    va_list args;
    if (h->status != SP_OK)
        return h->status;
    va_start(args, format);
    vsnprintf(what, sizeof what, format, args);
    va_end(args);
    const int code = h->fd < 0 ? 0 : h->code == 0 && sp_h5_short_of_memory() ? ENOMEM : h->code;
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, innermost, reason);
    H5Eclear2(H5E_DEFAULT);
    if (code)
        h->status = sp_fail(h->err, code == ENOMEM ? SP_ENOMEM : SP_EIO, "cannot read %s: %s", h->path, strerror(code));
    else if (*reason)
        h->status = sp_fail(h->err, status, "%s: %s (HDF5: %s)", h->path, what, reason);
    else
        h->status = sp_fail(h->err, status, "%s: %s", h->path, what);
    return h->status;
}

void *sp_h5_alloc(sp_h5 *h, int64_t count, size_t size) {
    void *memory = h->status == SP_OK ? sp_alloc((size_t)count, size) : NULL;
    if (!memory && h->status == SP_OK)
        h->status = sp_fail_memory(h->err, (size_t)count * size);
    return memory;
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

/* ---- the driver ------------------------------------------------------------------------------------------------ */

/* It notes the first error: a file that cannot be read at the moment is told from one that is damaged. Where the disk
 * is full, HDF5's own driver makes H5Fclose fail, and HDF5 1.10 then crashes at exit; this one lets HDF5 finish. */

/* What the driver is given: an open file, and where to note the first error. */
typedef struct target {
    int fd, *code;
} target;

typedef struct draft_file {
    H5FD_t common; /* HDF5's part comes first */
    target to;
    bool whole;        /* the file is only read */
    haddr_t end, used; /* of the space that HDF5 has laid out, and of what was written, or is there to be read */
} draft_file;

static const haddr_t farthest = ((haddr_t)1 << 62) - 1;

static H5FD_t *open_draft(const char *name, unsigned flags, hid_t fapl, haddr_t most) {
    const target *to = H5Pget_driver_info(fapl);
    draft_file *f = to ? sp_alloc(1, sizeof *f) : NULL;
    struct stat info = {0};
    (void)name, (void)most;
    if (to && (!f || fstat(to->fd, &info) != 0)) {
        *to->code = f ? errno : ENOMEM;
        sp_free(f);
        return NULL;
    }
    if (f)
        *f = (draft_file){.to = *to, .whole = !(flags & H5F_ACC_RDWR), .used = (haddr_t)info.st_size};
    return (H5FD_t *)f;
}

static herr_t close_draft(H5FD_t *file) {
    sp_free(file);
    return 0;
}

static herr_t features(const H5FD_t *file, unsigned long *flags) {
    (void)file;
    *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
             H5FD_FEAT_AGGREGATE_SMALLDATA;
    return 0;
}

static haddr_t get_end(const H5FD_t *file, H5FD_mem_t type) {
    (void)type;
    return ((const draft_file *)file)->end;
}

static herr_t set_end(H5FD_t *file, H5FD_mem_t type, haddr_t end) {
    (void)type;
    ((draft_file *)file)->end = end;
    return 0;
}

static haddr_t get_used(const H5FD_t *file, H5FD_mem_t type) {
    const draft_file *f = (const draft_file *)file;
    (void)type;
    return f->whole || f->used > f->end ? f->used : f->end;
}

/* Bytes that were never written are 0. A file that has become shorter since it was opened is not damaged by that. */
static herr_t read_draft(H5FD_t *file, H5FD_mem_t type, hid_t dxpl, haddr_t at, size_t size, void *buffer) {
    const draft_file *f = (const draft_file *)file;
    (void)type, (void)dxpl;
    const int64_t got = *f->to.code ? -1 : sp_file_read_at(f->to.fd, buffer, size, (int64_t)at);
    if (*f->to.code == 0 && (got < 0 || ((size_t)got < size && at + (haddr_t)got < f->used)))
        *f->to.code = got < 0 ? errno : EIO;
    if (*f->to.code)
        return -1;
    memset((char *)buffer + got, 0, size - (size_t)got);
    return 0;
}

static herr_t write_draft(H5FD_t *file, H5FD_mem_t type, hid_t dxpl, haddr_t at, size_t size, const void *buffer) {
    draft_file *f = (draft_file *)file;
    (void)type, (void)dxpl;
    for (const char *from = buffer; size > 0 && *f->to.code == 0;) {
        const ssize_t put = pwrite(f->to.fd, from, size < ((size_t)1 << 30) ? size : (size_t)1 << 30, (off_t)at);
        if (put < 0 && errno != EINTR)
            *f->to.code = errno;
        if (put < 0)
            continue;
        from += put;
        at += (haddr_t)put;
        size -= (size_t)put;
        f->used = at > f->used ? at : f->used;
    }
    return 0;
}

static herr_t truncate_draft(H5FD_t *file, hid_t dxpl, hbool_t closing) {
    draft_file *f = (draft_file *)file;
    (void)dxpl, (void)closing;
    if (*f->to.code == 0 && ftruncate(f->to.fd, (off_t)f->end) != 0)
        *f->to.code = errno;
    f->used = f->end;
    return 0;
}

static const H5FD_class_t driver = {
#ifdef H5FD_CLASS_VERSION /* since HDF5 1.14 */
    .version = H5FD_CLASS_VERSION,
    .value = H5_VFD_RESERVED,
#endif
    .name = "sonopack",
    .maxaddr = farthest,
    .fc_degree = H5F_CLOSE_STRONG,
    .fapl_size = sizeof(target),
    .open = open_draft,
    .close = close_draft,
    .query = features,
    .get_eoa = get_end,
    .set_eoa = set_end,
    .get_eof = get_used,
    .read = read_draft,
    .write = write_draft,
    .truncate = truncate_draft,
    .fl_map = H5FD_FLMAP_DICHOTOMY};

/* ---- opening --------------------------------------------------------------------------------------------------- */

/* Access properties: the format of HDF5 1.8, whose object headers have checksums; no file locks, because files never
 * change. The driver must outlive the file: H5Fclose still uses what it has released. */
static hid_t file_access(sp_h5 *h, int fd, bool create) {
    const target to = {fd, &h->code};
    hid_t fapl = H5Pcreate(H5P_FILE_ACCESS);
    if (fapl >= 0)
        h->driver = H5FDregister(&driver);
    if (fapl >= 0 && (h->driver < 0 || H5Pset_driver(fapl, h->driver, &to) < 0 ||
                      H5Pset_fclose_degree(fapl, H5F_CLOSE_STRONG) < 0 || H5Pset_file_locking(fapl, false, true) < 0 ||
                      (create && H5Pset_libver_bounds(fapl, H5F_LIBVER_V18, H5F_LIBVER_V18) < 0))) {
        H5Pclose(fapl);
        return H5I_INVALID_HID;
    }
    return fapl;
}

sp_status sp_h5_create(sp_h5 *h, const char *path, sp_error *err) {
    enter(h, path, err);
    if (h->status == SP_OK)
        h->status = sp_draft_begin(path, &h->draft, err);
    if (h->status != SP_OK)
        return h->status;
    hid_t fapl = file_access(h, h->draft.fd, true), fcpl = H5Pcreate(H5P_FILE_CREATE);
    if (fapl >= 0 && fcpl >= 0 && H5Pset_obj_track_times(fcpl, false) >= 0)
        h->file = H5Fcreate("sonopack", H5F_ACC_TRUNC, fcpl, fapl);
    if (h->file < 0)
        sp_h5_fail(h, SP_ENOMEM, "no memory: cannot make an HDF5 file there");
    H5Pclose(fcpl);
    H5Pclose(fapl);
    return h->status;
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
    enter(h, path, err);
    if (h->status == SP_OK)
        h->status = open_file(path, &h->fd, err);
    if (h->status != SP_OK)
        return h->status;
    hid_t fapl = file_access(h, h->fd, false);
    hsize_t size = 0;
    if (fapl >= 0)
        h->file = H5Fopen(path, H5F_ACC_RDONLY, fapl);
    if (h->file < 0 || H5Fget_filesize(h->file, &size) < 0)
        sp_h5_fail(h, SP_EFORMAT, "not an intact HDF5 file");
    H5Pclose(fapl); /* not earlier, because it clears the reason */
    h->size = size;
    return h->status;
}
