/* Loads shared libraries when they are first needed, and finds their functions. */
#include "late/late.h"

#include <dlfcn.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

static void *load(late_library *library) {
    bool first = false;
    pthread_mutex_lock(&library->lock);
    if (!library->handle) {
        library->handle = dlopen(library->file, RTLD_LAZY | RTLD_LOCAL);
        first = library->handle != NULL;
    }
    pthread_mutex_unlock(&library->lock);
    if (first && library->loaded)
        library->loaded();
    return library->handle;
}

void *late_find(late_library *library, const char *name) {
    void *handle = load(library), *found = handle ? dlsym(handle, name) : NULL;
    if (!found) {
        const char *reason = dlerror();
        fprintf(stderr, "sonopack: cannot load %s: %s\n", library->file, reason ? reason : "no reason given");
        exit(EXIT_FAILURE);
    }
    return found;
}
