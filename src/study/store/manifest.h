#ifndef SP_STORE_MANIFEST_H
#define SP_STORE_MANIFEST_H
/* A cache of the numbers in a store: manifest.tsv has a line for each sample, so that tables need not open every file.
 *
 * The files decide. A line counts only if its checksum is right and the sample's file has the size and the modification
 * time in the line; every other sample is read from its file, and gets a new line. The cache may therefore be deleted,
 * cut off or old. Lines are only appended, each by one write. The last line of a sample counts. */

#include "base/text.h"

#include <sonopack/study/study.h>
#include <sys/stat.h>

/* Appends the line of a sample: NAME.failed, or NAME.h5. */
void sp_manifest_put(sp_text *out, const struct stat *file, const sp_sample *sample);
/* Parses a line without its end, in place. False if it is not such a line of this sample and file, bit for bit as it
 * was written. */
bool sp_manifest_get(char *line, const char *name, bool failed, const struct stat *file, sp_sample *out);
/* Appends the lines with which the file begins. They name the columns, and identify the format. */
void sp_manifest_head(sp_text *out);

typedef struct sp_manifest sp_manifest;

/* Opens the cache of a folder. A file that is missing or wrong gives an empty one; only SP_ENOMEM is a failure. */
sp_status sp_manifest_open(const char *dir, sp_manifest **out, sp_error *err);
void sp_manifest_close(sp_manifest *m);
/* Allows adding lines. The file is created if there is none of this format. */
void sp_manifest_allow_adding(sp_manifest *m);
/* Finds the sample in this file; if it is not in memory, among the lines that others have added meanwhile. */
bool sp_manifest_find(sp_manifest *m, const char *name, bool failed, const struct stat *file, sp_sample *out);
/* Adds a line. Failures are ignored. */
void sp_manifest_add(sp_manifest *m, const struct stat *file, const sp_sample *sample);

#endif
