/* A driver of our own, for HDF5 files that are read, or written to the disk at once. It notes the first error: a file
 * that cannot be read at the moment is told from one that is damaged. Where the disk is full, HDF5's own driver makes
 * H5Fclose fail, and HDF5 1.10 then crashes at exit; this one lets HDF5 finish. */
#include "base/base.h"
#include "base/file.h"
#include "store/h5.h"

#include <errno.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

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

static const H5FD_class_t driver = {.name = "sonopack",
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

hid_t sp_h5_set_draft(hid_t fapl, int fd, int *code) {
    const target to = {fd, code};
    const hid_t id = H5FDregister(&driver);
    if (id < 0 || H5Pset_driver(fapl, id, &to) >= 0)
        return id;
    H5FDunregister(id);
    return H5I_INVALID_HID;
}
