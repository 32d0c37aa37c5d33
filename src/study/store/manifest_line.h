#ifndef SP_STORE_MANIFEST_LINE_H
#define SP_STORE_MANIFEST_LINE_H
/* One line of a manifest: a sample and its file, in cells between tabs. */

#include "base/text.h"

#include <sonopack/study/study.h>

/* Longest line that is read. */
enum { SP_MANIFEST_LINE_MAX = 16384 };

typedef struct sp_manifest_line {
    int64_t bytes, modified; /* of the file: size, and time of change [ns since 1970] */
    uint64_t content;        /* and sp_file_hash of it */
    sp_sample sample;        /* failed: the file is NAME.failed */
} sp_manifest_line;

/* The line above all others: names of the columns. It tells one form of the file from another. */
void sp_manifest_head(sp_text *out);
void sp_manifest_put(sp_text *out, const sp_manifest_line *line);
/* Whether the checksum at the end of a line (of that length, without its end of line) fits. */
bool sp_manifest_sound(const char *line, size_t length);
/* A sound line, which is cut into cells. False where it is none of this form. */
bool sp_manifest_get(char *line, sp_manifest_line *out);

#endif
