/* Loads shared libraries when they are first needed, and finds their functions. */
#include "late/late.h"

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>

/* The lock is recursive, since `loaded` looks up functions itself: other threads wait until it has returned. */
static void *load(late_library *library) {
    pthread_mutex_lock(&library->lock);
    if (!library->handle) {
        library->handle = dlopen(library->file, RTLD_LAZY | RTLD_LOCAL);
        if (library->handle && library->loaded)
            library->loaded();
    }
    void *handle = library->handle;
    pthread_mutex_unlock(&library->lock);
    return handle;
}

void *late_look(late_library *library, const char *name) {
    void *handle = load(library);
    return handle ? dlsym(handle, name) : NULL;
}

void *late_find(late_library *library, const char *name) {
    void *found = late_look(library, name);
    if (!found) {
        const char *reason = dlerror();
        fprintf(stderr, "sonopack: cannot load %s: %s\n", library->file, reason ? reason : "no reason given");
        exit(EXIT_FAILURE);
    }
    return found;
}
