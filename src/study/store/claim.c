/* Locks that reserve the samples of a store for one process. */
#include "store/claim.h"

#include "base/base.h"
#include "base/file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* The byte of the lock file that stands for a sample; small enough for off_t. */
static uint64_t byte_of(const char *name) {
    char half[17];
    snprintf(half, sizeof half, "%.16s", name);
    return strtoull(half, NULL, 16) >> 2;
}

static void open_file(sp_claims *c, const char *dir) {
    char path[SP_PATH_MAX];
    if (c->none || c->fd >= 0)
        return;
    if ((size_t)snprintf(path, sizeof path, "%s/.sonopack-lock", dir) < sizeof path)
        c->fd = open(path, O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0666);
    c->none = c->fd < 0;
}

static int64_t place_of(const sp_claims *c, uint64_t byte) {
    for (int64_t k = 0; k < c->held; k++)
        if (c->byte[k] == byte)
            return k;
    return -1;
}

static bool remember(sp_claims *c, uint64_t byte) {
    uint64_t *grown = sp_grow(c->byte, (size_t)c->held + 1, &c->capacity, sizeof *grown);
    if (!grown)
        return false;
    c->byte = grown;
    c->byte[c->held++] = byte;
    return true;
}

static int set_lock(const sp_claims *c, uint64_t byte, short type, bool wait) {
    struct flock lock = {.l_type = type, .l_whence = SEEK_SET, .l_start = (off_t)byte, .l_len = 1};
    int result;
    do
        result = fcntl(c->fd, wait ? F_OFD_SETLKW : F_OFD_SETLK, &lock);
    while (result != 0 && errno == EINTR);
    return result == 0 ? 0 : errno;
}

sp_claimed sp_claim_take(sp_claims *c, const char *dir, const char *name, bool wait) {
    const uint64_t byte = byte_of(name);
    open_file(c, dir);
    if (c->none)
        return SP_CLAIM_FREE;
    if (place_of(c, byte) >= 0) /* by another thread */
        return SP_CLAIM_OTHERS;
    const int code = set_lock(c, byte, F_WRLCK, wait);
    if (code == EAGAIN || code == EACCES)
        return SP_CLAIM_OTHERS;
    if (code != 0 || !remember(c, byte))
        return SP_CLAIM_FREE;
    return SP_CLAIM_MINE;
}

void sp_claim_release(sp_claims *c, const char *name) {
    const uint64_t byte = byte_of(name);
    const int64_t k = place_of(c, byte);
    if (k < 0)
        return;
    c->byte[k] = c->byte[--c->held];
    set_lock(c, byte, F_UNLCK, false);
}

bool sp_claim_holds(const sp_claims *c, const char *name) { return place_of(c, byte_of(name)) >= 0; }

void sp_claims_close(sp_claims *c) {
    if (c->fd >= 0)
        close(c->fd);
    sp_free(c->byte);
    *c = (sp_claims){.fd = -1};
}
