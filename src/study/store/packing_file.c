/* Reads a packing from HDF5 or from text. */
#include "base/base.h"
#include "base/file.h"
#include "store/packing_h5.h"
#include "store/packing_text.h"

#include <errno.h>
#include <fcntl.h>
#include <sonopack/study/store.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* HDF5's signature is at the start, or after a user block of 512, 1024, 2048, ... bytes. Returns an error number. */
static int find_signature(int fd, int64_t size, bool *found) {
    char head[8] = "";
    for (int64_t at = 0; at + 8 <= size && !*found; at = at ? 2 * at : 512) {
        if (sp_file_read_at(fd, head, sizeof head, at) < 0)
            return errno;
        *found = memcmp(head, "\x89HDF\r\n\x1a\n", 8) == 0;
    }
    return 0;
}

sp_status sp_is_hdf5(const char *path, bool *yes, sp_error *err) {
    struct stat info;
    int fd = -1, code = stat(path, &info) != 0 ? errno : S_ISDIR(info.st_mode) ? EISDIR : 0;
    *yes = false;
    if (code == 0 && S_ISREG(info.st_mode)) { /* a pipe can be read only once, and is taken for text */
        fd = open(path, O_RDONLY | O_CLOEXEC);
        code = fd < 0 ? errno : find_signature(fd, info.st_size, yes);
    }
    if (fd >= 0)
        close(fd);
    return code ? sp_fail(err, SP_EIO, "cannot read %s: %s%s", path, strerror(code),
                          code == EISDIR ? ", must be a file: the samples of a store are its *.h5" : "")
                : SP_OK;
}

static sp_status read_hdf5(const char *path, sp_packing *out, sp_error *err) {
    sp_h5 h;
    if (sp_h5_open(&h, path, err) == SP_OK)
        sp_packing_get(&h, out);
    return sp_h5_close(&h);
}

static sp_status fail_source(const char *path, const char *text, sp_error *err) {
    const sp_packing_source *s = sp_packing_text_source(text);
    if (s)
        return sp_fail(err, SP_EFORMAT, "%s: is %s, must be a packing: `sonopack %s %s %sP.h5' makes one of it", path,
                       s->what, s->command, path, s->output);
    return sp_fail(err, SP_EFORMAT,
                   "%s: neither an HDF5 packing nor its text form, whose header is 'N 600 Lx 24 Ly ...': `sonopack "
                   "convert %s P.h5' reads other programs' files, and --from FORM those that it does not recognise",
                   path, path);
}

static sp_status read_text(const char *path, sp_packing *out, sp_error *err) {
    char *text = NULL;
    size_t size = 0;
    sp_packing p = sp_packing_none();
    sp_status status = sp_file_read_text(path, &text, &size, err);
    if (status == SP_OK && !sp_packing_text_looks(text))
        status = fail_source(path, text, err);
    if (status == SP_OK)
        status = sp_packing_text_parse(path, text, size, &p, err);
    sp_free(text);
    if (status == SP_OK) {
        status = sp_packing_check(&p, err);
        if (status != SP_OK)
            sp_fail_prefix(err, "%s", path);
    }
    if (status == SP_OK)
        *out = p;
    else
        sp_packing_free(&p);
    return status;
}

sp_status sp_packing_file_looks(const char *path, bool *yes, sp_error *err) {
    struct stat info;
    char head[8192];
    *yes = false;
    if (stat(path, &info) == 0 && !S_ISREG(info.st_mode))
        return SP_OK;
    FILE *file = fopen(path, "rb");
    if (!file)
        return sp_fail(err, SP_EIO, "cannot open %s: %s", path, strerror(errno));
    const size_t size = fread(head, 1, sizeof head - 1, file);
    fclose(file);
    head[size] = '\0';
    *yes = strlen(head) < size || sp_packing_text_looks(head) || sp_packing_text_source(head);
    return SP_OK;
}

sp_status sp_packing_read(const char *path, sp_packing *out, sp_error *err) {
    bool hdf5;
    sp_status status = sp_is_hdf5(path, &hdf5, err);
    if (status != SP_OK)
        return status;
    return hdf5 ? read_hdf5(path, out, err) : read_text(path, out, err);
}
