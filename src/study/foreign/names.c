/* Names of files that lie beside each other. */
#include "foreign/export.h"

#include <stdio.h>
#include <string.h>

const char *sp_export_base(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

const char *sp_export_ending(const char *path) {
    const char *name = sp_export_base(path), *dot = strrchr(name, '.');
    return dot && dot > name ? dot : name + strlen(name);
}

bool sp_export_beside(const char *path, const char *suffix, char name[SP_EXPORT_PATH_MAX]) {
    const int length = (int)(sp_export_ending(path) - path);
    return snprintf(name, SP_EXPORT_PATH_MAX, "%.*s%s", length, path, suffix) < SP_EXPORT_PATH_MAX;
}
