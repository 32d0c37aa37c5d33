#ifndef EDITS_H
#define EDITS_H
/* Edits of HDF5 files in memory, so that all checksums are right whatever is changed. */

#include <stddef.h>
#include <stdint.h>

enum { EDITED_OBJECTS = 256, EDITED_PATH = 80 };

typedef struct edited_file {
    uint8_t *image;
    size_t size;
    int objects; /* groups and datasets */
    char path[EDITED_OBJECTS][EDITED_PATH];
} edited_file;

edited_file edited_read(const char *path);
/* The file after a list of edits, eight bytes each. The caller frees it. */
uint8_t *edited_apply(const edited_file *of, const uint8_t *edit, size_t size, size_t *bytes);

#endif
