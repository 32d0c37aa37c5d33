/* Files in memory, parts of inputs, and what must hold of every error. */
#include "guided.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

void guided_must(bool good, const char *what, const char *file, int line) {
    if (good)
        return;
    fprintf(stderr, "%s:%d: must hold: %s\n", file, line, what);
    abort();
}

const char *guided_file(int k, const void *data, size_t size) {
    static char path[GUIDED_FILES][GUIDED_PATH];
    static int file[GUIDED_FILES];
    must(k >= 0 && k < GUIDED_FILES);
    if (file[k] == 0) {
        file[k] = memfd_create("guided", MFD_CLOEXEC);
        must(file[k] > 0);
        snprintf(path[k], GUIDED_PATH, "/proc/self/fd/%d", file[k]);
    }
    must(ftruncate(file[k], 0) == 0 && pwrite(file[k], data, size, 0) == (ssize_t)size);
    return path[k];
}

static char folder[64];

static void remove_folder(void) {
    DIR *d = opendir(folder);
    for (struct dirent *e; d && (e = readdir(d));)
        if (e->d_name[0] != '.' || strlen(e->d_name) > 2)
            unlinkat(dirfd(d), e->d_name, 0);
    if (d)
        closedir(d);
    rmdir(folder);
}

const char *guided_folder(void) {
    if (folder[0] == '\0') {
        snprintf(folder, sizeof folder, "%s/sonopack-guided-XXXXXX",
                 access("/dev/shm", W_OK) == 0 ? "/dev/shm" : "/tmp");
        must(mkdtemp(folder) != NULL && atexit(remove_folder) == 0);
    }
    return folder;
}

const char *guided_output(int k) {
    static char path[GUIDED_FILES][80];
    must(k >= 0 && k < GUIDED_FILES);
    snprintf(path[k], sizeof path[k], "%s/%d", guided_folder(), k);
    return path[k];
}

guided_parts guided_split(const uint8_t *data, size_t size, int most) {
    guided_parts p = {.count = 1, .memory = malloc(size + 1)};
    must(p.memory != NULL);
    if (size > 0)
        memcpy(p.memory, data, size);
    p.memory[size] = '\0';
    p.part[0] = p.memory;
    for (size_t k = 0; p.count < most && k + 5 < size; k++)
        if (memcmp(p.memory + k, "\n====\n", 6) == 0) {
            p.memory[k + 1] = '\0';
            p.size[p.count - 1] = (size_t)(p.memory + k + 1 - p.part[p.count - 1]);
            p.part[p.count++] = p.memory + k + 6;
            k += 5;
        }
    p.size[p.count - 1] = (size_t)(p.memory + size - p.part[p.count - 1]);
    return p;
}

void guided_free(guided_parts *p) { free(p->memory); }

int guided_words(char *text, char *word[GUIDED_WORDS]) {
    int count = 0;
    for (char *rest = text; count < GUIDED_WORDS && (word[count] = strtok_r(rest, " \n", &rest)) != NULL;)
        count++;
    return count;
}

sp_error guided_error(void) { return (sp_error){.status = SP_OK, .text = ""}; }

bool guided_good(sp_status status, const sp_error *err) {
    must(status <= SP_OK && status >= SP_EINTERRUPTED);
    if (status == SP_OK)
        return true;
    must(err->status == status);
    const size_t length = strnlen(err->text, sizeof err->text);
    must(length > 0 && length < sizeof err->text && strnlen(err->key, sizeof err->key) < sizeof err->key);
    must(memchr(err->text, '\n', length) == NULL);
    return false;
}
