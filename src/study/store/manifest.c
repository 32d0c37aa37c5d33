/* The index of a store. */
#include "store/manifest.h"

#include "base/base.h"
#include "base/file.h"

#include <errno.h>
#include <fcntl.h>
#include <sonopack/study/store.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const int64_t tidy_from = 1 << 18; /* fewer outdated bytes are not worth rewriting the file */

/* Place of the last line of a sample. */
typedef struct slot {
    uint64_t key[2]; /* the name as a number of 128 bits */
    int64_t at;      /* from the beginning of the file */
    int32_t length;  /* without the end of line; 0: a free slot */
} slot;

struct sp_manifest {
    char path[SP_PATH_MAX];
    int fd; /* negative: there is no readable file */
    bool adding;
    bool torn;       /* the last line may be incomplete */
    int64_t read_to; /* lines up to here are in the table */
    int64_t samples; /* slots in use */
    int64_t slots;   /* a power of two */
    slot *slot;      /* hash table with open addressing */
    char head[SP_MANIFEST_LINE_MAX];
};

/* ---- the table ------------------------------------------------------------------------------------------------- */

static bool name_key(const char *name, uint64_t key[2]) {
    char half[17];
    char *end;
    if (strlen(name) != 32 || strspn(name, "0123456789abcdef") != 32)
        return false;
    for (int k = 0; k < 2; k++) {
        snprintf(half, sizeof half, "%.16s", name + 16 * k);
        key[k] = strtoull(half, &end, 16);
    }
    return true;
}

/* The slot of a key, or the free slot for it. */
static slot *find_slot(const sp_manifest *m, const uint64_t key[2]) {
    uint64_t k = key[1];
    for (;; k++) {
        slot *s = &m->slot[k & (uint64_t)(m->slots - 1)];
        if (s->length == 0 || (s->key[0] == key[0] && s->key[1] == key[1]))
            return s;
    }
}

static sp_status grow(sp_manifest *m, sp_error *err) {
    const int64_t slots = m->slots ? 2 * m->slots : 1024;
    slot *fresh = sp_alloc((size_t)slots, sizeof *fresh), *old = m->slot;
    const int64_t count = m->slots;
    if (!fresh)
        return sp_fail_memory(err, (size_t)slots * sizeof *fresh);
    m->slot = fresh;
    m->slots = slots;
    for (int64_t k = 0; k < count; k++)
        if (old[k].length > 0)
            *find_slot(m, old[k].key) = old[k];
    sp_free(old);
    return SP_OK;
}

/* Stores the place of a line. A line with a wrong checksum is ignored. */
static sp_status index_line(sp_manifest *m, const char *line, size_t length, int64_t at, sp_error *err) {
    uint64_t key[2];
    char name[33];
    if (length < 33 || length >= SP_MANIFEST_LINE_MAX || line[32] != '\t' || !sp_manifest_sound(line, length))
        return SP_OK;
    memcpy(name, line, 32);
    name[32] = '\0';
    if (!name_key(name, key))
        return SP_OK;
    if (4 * (m->samples + 1) > 3 * m->slots) {
        sp_status status = grow(m, err);
        if (status != SP_OK)
            return status;
    }
    slot *s = find_slot(m, key);
    m->samples += s->length == 0;
    *s = (slot){.key = {key[0], key[1]}, .at = at, .length = (int32_t)length};
    return SP_OK;
}

/* ---- the file -------------------------------------------------------------------------------------------------- */

static void forget(sp_manifest *m) {
    if (m->fd >= 0)
        close(m->fd);
    m->fd = -1;
    if (m->samples > 0)
        memset(m->slot, 0, (size_t)m->slots * sizeof *m->slot);
    m->read_to = m->samples = 0;
    m->torn = false;
}

/* Reads lines that have been added. An incomplete line is left for the next time. */
static sp_status read_on(sp_manifest *m, sp_error *err) {
    enum { CHUNK = 4 * SP_MANIFEST_LINE_MAX };
    char buffer[CHUNK];
    sp_status status = SP_OK;
    bool skip = false; /* the rest of a line that is too long */
    while (status == SP_OK) {
        const ssize_t got = pread(m->fd, buffer, CHUNK, m->read_to);
        if (got <= 0)
            break;
        const char *line = buffer, *end = buffer + got, *stop;
        while (status == SP_OK && (stop = memchr(line, '\n', (size_t)(end - line)))) {
            if (!skip)
                status = index_line(m, line, (size_t)(stop - line), m->read_to + (line - buffer), err);
            skip = false;
            line = stop + 1;
        }
        m->torn = line == buffer && got < CHUNK; /* there is only an incomplete line */
        if (m->torn)
            break;
        skip = skip || line == buffer;
        m->read_to += line == buffer ? got : line - buffer;
    }
    return status;
}

/* Opens the file. False if there is none of this format. */
static bool open_file(sp_manifest *m) {
    char first[SP_MANIFEST_LINE_MAX];
    const size_t length = strlen(m->head);
    struct stat info;
    m->fd = open(m->path, (m->adding ? O_RDWR | O_APPEND : O_RDONLY) | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    if (m->fd < 0)
        return false;
    if (fstat(m->fd, &info) == 0 && S_ISREG(info.st_mode) && pread(m->fd, first, length, 0) == (ssize_t)length &&
        memcmp(first, m->head, length) == 0)
        return true;
    close(m->fd);
    m->fd = -1;
    return false;
}

/* Reads new lines; or all lines, if another process has replaced or removed the file. */
static sp_status refresh(sp_manifest *m, sp_error *err) {
    struct stat mine, there;
    const bool same = m->fd >= 0 && fstat(m->fd, &mine) == 0 && stat(m->path, &there) == 0 &&
                      mine.st_ino == there.st_ino && mine.st_dev == there.st_dev && there.st_size >= m->read_to;
    if (!same) {
        forget(m);
        if (!open_file(m))
            return SP_OK;
    } else if (there.st_size == m->read_to) {
        return SP_OK;
    }
    return read_on(m, err);
}

sp_status sp_manifest_open(const char *dir, sp_manifest **out, sp_error *err) {
    sp_text head = {0};
    sp_text_add(&head, "# index of the samples in this folder; may be taken away, and is made anew from their files\n");
    sp_manifest_head(&head);
    sp_manifest *m = sp_alloc(1, sizeof *m);
    sp_status status = SP_OK;
    if (!m || head.failed || head.size >= sizeof m->head) {
        sp_free(m);
        sp_text_free(&head);
        return sp_fail_memory(err, sizeof *m);
    }
    m->fd = -1;
    snprintf(m->head, sizeof m->head, "%s", head.data);
    snprintf(m->path, sizeof m->path, "%s/manifest.tsv", dir);
    sp_text_free(&head);
    status = grow(m, err);
    if (status == SP_OK && open_file(m))
        status = read_on(m, err);
    if (status != SP_OK) {
        sp_manifest_close(m);
        return status;
    }
    *out = m;
    return SP_OK;
}

void sp_manifest_close(sp_manifest *m) {
    if (!m)
        return;
    forget(m);
    sp_free(m->slot);
    sp_free(m);
}

void sp_manifest_allow_adding(sp_manifest *m) {
    m->adding = true;
    forget(m);
    refresh(m, NULL);
}

/* ---- lines ----------------------------------------------------------------------------------------------------- */

int64_t sp_manifest_time(const struct stat *file) {
    return (int64_t)file->st_mtim.tv_sec * 1000000000 + file->st_mtim.tv_nsec;
}

static bool get_line(const sp_manifest *m, const slot *s, sp_manifest_line *out) {
    char line[SP_MANIFEST_LINE_MAX];
    if (pread(m->fd, line, (size_t)s->length, s->at) != s->length || !sp_manifest_sound(line, (size_t)s->length))
        return false;
    line[s->length] = '\0';
    return sp_manifest_get(line, out);
}

static bool find(const sp_manifest *m, const char *name, bool failed, sp_manifest_line *out) {
    uint64_t key[2];
    if (m->fd < 0 || !name_key(name, key))
        return false;
    const slot *s = find_slot(m, key);
    return s->length > 0 && get_line(m, s, out) && strcmp(out->sample.name, name) == 0 && out->sample.failed == failed;
}

bool sp_manifest_find(sp_manifest *m, const char *name, bool failed, const struct stat *file, sp_manifest_line *out) {
    const bool known = find(m, name, failed, out);
    if (known && out->bytes == file->st_size && out->modified == sp_manifest_time(file))
        return true;
    return refresh(m, NULL) == SP_OK ? find(m, name, failed, out) : known;
}

/* Creates the file if there is none, or one of another format. Anything but a regular file is left alone. */
static void begin_file(sp_manifest *m) {
    struct stat info;
    if (lstat(m->path, &info) == 0 && !S_ISREG(info.st_mode))
        return;
    if (sp_text_save(m->path, m->head, strlen(m->head), NULL) == SP_OK)
        refresh(m, NULL);
}

/* Whether the last line of the sample is this text, end of line included. */
static bool has_line(const sp_manifest *m, const char *name, const sp_text *text) {
    char line[SP_MANIFEST_LINE_MAX];
    uint64_t key[2];
    if (!name_key(name, key))
        return true; /* no name of a sample has a line */
    const slot *s = find_slot(m, key);
    return (size_t)s->length + 1 == text->size && pread(m->fd, line, (size_t)s->length, s->at) == s->length &&
           memcmp(line, text->data, (size_t)s->length) == 0;
}

void sp_manifest_add(sp_manifest *m, const sp_manifest_line *line) {
    if (!m->adding || refresh(m, NULL) != SP_OK)
        return;
    if (m->fd < 0)
        begin_file(m);
    if (m->fd < 0)
        return;
    sp_text text = {0};
    sp_manifest_put(&text, line);
    if (!text.failed && !has_line(m, line->sample.name, &text)) {
        if (m->torn && write(m->fd, "\n", 1) != 1)
            text.size = 0;
        m->torn = write(m->fd, text.data, text.size) != (ssize_t)text.size;
    }
    sp_text_free(&text);
}

void sp_manifest_tidy(sp_manifest *m) {
    int64_t bytes = (int64_t)strlen(m->head);
    if (!m->adding || refresh(m, NULL) != SP_OK || m->fd < 0)
        return;
    for (int64_t k = 0; k < m->slots; k++)
        bytes += m->slot[k].length;
    if (m->read_to < 2 * bytes + tidy_from)
        return;
    sp_text text = {0};
    sp_text_add(&text, "%s", m->head);
    for (int64_t k = 0; k < m->slots; k++) {
        char line[SP_MANIFEST_LINE_MAX];
        const slot *s = &m->slot[k];
        if (s->length > 0 && pread(m->fd, line, (size_t)s->length, s->at) == s->length) {
            sp_text_bytes(&text, line, (size_t)s->length);
            sp_text_bytes(&text, "\n", 1);
        }
    }
    if (!text.failed)
        sp_text_save(m->path, text.data, text.size, NULL);
    sp_text_free(&text);
    refresh(m, NULL);
}
