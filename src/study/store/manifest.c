/* The cache of a store. */
#include "store/manifest.h"

#include "base/base.h"
#include "base/file.h"

#include <fcntl.h>
#include <sonopack/study/store.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { NAME = 32, LINE_MAX = 16384 };

/* Place of the last line of a sample. */
typedef struct slot {
    char name[NAME];
    int64_t at;     /* from the beginning of the file */
    int32_t length; /* without the end of line; 0: a free slot */
} slot;

struct sp_manifest {
    char path[SP_PATH_MAX];
    sp_text head;
    int fd; /* negative: there is no readable file */
    bool adding;
    int64_t read_to; /* lines up to here are in the table */
    int64_t samples; /* slots in use */
    int64_t slots;   /* a power of two */
    slot *slot;      /* hash table with open addressing */
};

/* ---- the table ------------------------------------------------------------------------------------------------- */

/* The slot of a name, or the free slot for it. Names are hashes themselves. */
static slot *find_slot(const sp_manifest *m, const char *name) {
    char half[17];
    snprintf(half, sizeof half, "%.16s", name);
    for (uint64_t k = strtoull(half, NULL, 16);; k++) {
        slot *s = &m->slot[k & (uint64_t)(m->slots - 1)];
        if (s->length == 0 || memcmp(s->name, name, NAME) == 0)
            return s;
    }
}

static bool grow(sp_manifest *m) {
    const int64_t count = m->slots;
    slot *old = m->slot, *fresh = sp_alloc((size_t)(count ? 2 * count : 1024), sizeof *fresh);
    if (!fresh)
        return false;
    m->slot = fresh;
    m->slots = count ? 2 * count : 1024;
    for (int64_t k = 0; k < count; k++)
        if (old[k].length > 0)
            *find_slot(m, old[k].name) = old[k];
    sp_free(old);
    return true;
}

/* Whether the line is in the table, or not one of a sample. */
static bool index_line(sp_manifest *m, const char *line, int64_t length, int64_t at) {
    if (length <= NAME || length >= LINE_MAX || line[NAME] != '\t')
        return true;
    if (4 * (m->samples + 1) > 3 * m->slots && !grow(m))
        return false;
    slot *s = find_slot(m, line);
    m->samples += s->length == 0;
    *s = (slot){.at = at, .length = (int32_t)length};
    memcpy(s->name, line, NAME);
    return true;
}

/* ---- the file -------------------------------------------------------------------------------------------------- */

static void forget(sp_manifest *m) {
    if (m->fd >= 0)
        close(m->fd);
    m->fd = -1;
    if (m->samples > 0)
        memset(m->slot, 0, (size_t)m->slots * sizeof *m->slot);
    m->read_to = m->samples = 0;
}

/* Reads whole lines that have been added. */
static void read_on(sp_manifest *m, int64_t size) {
    char *text = sp_alloc((size_t)(size - m->read_to) + 1, 1);
    const int64_t got = text ? sp_file_read_at(m->fd, text, (size_t)(size - m->read_to), m->read_to) : 0;
    const char *line = text, *stop;
    while (line && (stop = memchr(line, '\n', (size_t)(got > 0 ? text + got - line : 0)))) {
        if (!index_line(m, line, stop - line, m->read_to + (line - text)))
            break;
        line = stop + 1;
    }
    m->read_to += line ? line - text : 0;
    sp_free(text);
}

/* Opens the file. False if there is none of this format. */
static bool open_file(sp_manifest *m) {
    struct stat info;
    char *first = sp_alloc(m->head.size, 1);
    m->fd = open(m->path, (m->adding ? O_RDWR | O_APPEND : O_RDONLY) | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    const bool good = first && m->fd >= 0 && fstat(m->fd, &info) == 0 && S_ISREG(info.st_mode) &&
                      sp_file_read_at(m->fd, first, m->head.size, 0) == (int64_t)m->head.size &&
                      memcmp(first, m->head.data, m->head.size) == 0;
    sp_free(first);
    if (!good)
        forget(m);
    return good;
}

/* Reads new lines; or all lines, if another process has replaced or removed the file. */
static void refresh(sp_manifest *m) {
    struct stat mine, there;
    if (!(m->fd >= 0 && fstat(m->fd, &mine) == 0 && stat(m->path, &there) == 0 && mine.st_ino == there.st_ino &&
          mine.st_dev == there.st_dev && mine.st_size >= m->read_to)) {
        forget(m);
        if (!open_file(m) || fstat(m->fd, &mine) != 0)
            return;
    }
    if (mine.st_size > m->read_to)
        read_on(m, mine.st_size);
}

sp_status sp_manifest_open(const char *dir, sp_manifest **out, sp_error *err) {
    sp_manifest *m = sp_alloc(1, sizeof *m);
    if (!m)
        return sp_fail_memory(err, sizeof *m);
    m->fd = -1;
    snprintf(m->path, sizeof m->path, "%s/manifest.tsv", dir);
    sp_manifest_head(&m->head);
    if (m->head.failed || !grow(m)) {
        sp_manifest_close(m);
        return sp_fail_memory(err, sizeof *m);
    }
    refresh(m);
    *out = m;
    return SP_OK;
}

void sp_manifest_close(sp_manifest *m) {
    if (!m)
        return;
    forget(m);
    sp_text_free(&m->head);
    sp_free(m->slot);
    sp_free(m);
}

void sp_manifest_allow_adding(sp_manifest *m) {
    m->adding = true;
    forget(m);
    refresh(m);
}

/* ---- lines ----------------------------------------------------------------------------------------------------- */

static bool find(const sp_manifest *m, const char *name, bool failed, const struct stat *file, sp_sample *out) {
    char line[LINE_MAX];
    const slot *s = m->fd < 0 ? NULL : find_slot(m, name);
    if (!s || s->length == 0 || sp_file_read_at(m->fd, line, (size_t)s->length, s->at) != s->length)
        return false;
    line[s->length] = '\0';
    return sp_manifest_get(line, name, failed, file, out);
}

bool sp_manifest_find(sp_manifest *m, const char *name, bool failed, const struct stat *file, sp_sample *out) {
    if (strlen(name) != NAME)
        return false;
    if (find(m, name, failed, file, out))
        return true;
    refresh(m);
    return find(m, name, failed, file, out);
}

/* Creates the file if there is none, or one of another format. Anything but a regular file is left alone. */
static bool begin_file(sp_manifest *m) {
    struct stat info;
    if (lstat(m->path, &info) == 0 && !S_ISREG(info.st_mode))
        return false;
    if (sp_file_write(m->path, m->head.data, m->head.size, NULL) == SP_OK)
        refresh(m);
    return m->fd >= 0;
}

void sp_manifest_add(sp_manifest *m, const struct stat *file, const sp_sample *sample) {
    sp_text text = {0};
    char last = '\n';
    if (!m->adding)
        return;
    refresh(m);
    if (m->fd < 0 && !begin_file(m))
        return;
    if (m->read_to > 0 && sp_file_read_at(m->fd, &last, 1, lseek(m->fd, 0, SEEK_END) - 1) == 1 && last != '\n')
        sp_text_add(&text, "\n"); /* a line was cut off there */
    sp_manifest_put(&text, file, sample);
    if (!text.failed)
        (void)!write(m->fd, text.data, text.size);
    sp_text_free(&text);
}
