#ifndef SP_STORE_MANIFEST_LINE_H
#define SP_STORE_MANIFEST_LINE_H
/* One line of the manifest: a sample and its file, in cells separated by tabs. */

#include "base/text.h"

#include <sonopack/study/study.h>

/* Longest line that is read. */
enum { SP_MANIFEST_LINE_MAX = 16384 };

typedef struct sp_manifest_line {
    int64_t bytes, modified; /* of the file: size, and modification time [ns since 1970] */
    uint64_t content;        /* sp_file_hash of the file */
    sp_sample sample;        /* failed: the file is NAME.failed */
} sp_manifest_line;

/* Appends the header line with the names of the columns, which identifies the format. */
void sp_manifest_head(sp_text *out);
void sp_manifest_put(sp_text *out, const sp_manifest_line *line);
/* Whether the checksum at the end of a line is right. length excludes the end of line. */
bool sp_manifest_sound(const char *line, size_t length);
/* Parses a line with a right checksum, in place. False if it is not of this format. */
bool sp_manifest_get(char *line, sp_manifest_line *out);

#endif
