#ifndef SP_STORE_MANIFEST_H
#define SP_STORE_MANIFEST_H
/* The index of a store: manifest.tsv has a line for each sample with all of its results, so that tables need not open
 * every file.
 *
 * The files decide. A line counts only if its checksum is right and the sample's file has the size and the modification
 * time in the line. The index may therefore be truncated, old, damaged or missing: other samples are read from their
 * files, and get a new line. Lines are only appended, each by one write. The last line of a sample counts. */

#include "store/manifest_line.h"

#include <sys/stat.h>

typedef struct sp_manifest sp_manifest;

/* Opens the index of a folder. A file that is missing or wrong gives an empty index; only SP_ENOMEM is a failure. */
sp_status sp_manifest_open(const char *dir, sp_manifest **out, sp_error *err);
void sp_manifest_close(sp_manifest *m);
/* Allows adding lines. The file is created if there is none of this format. */
void sp_manifest_allow_adding(sp_manifest *m);

/* Modification time of a file [ns since 1970]. */
int64_t sp_manifest_time(const struct stat *file);
/* Finds the last line of a sample; failed: of the file NAME.failed. The line may describe an older file than `file`, as
 * *out tells. If the line in memory does, lines that other processes have added are read first. */
bool sp_manifest_find(sp_manifest *m, const char *name, bool failed, const struct stat *file, sp_manifest_line *out);
/* Adds a line, unless the sample has it already. Failures are ignored. */
void sp_manifest_add(sp_manifest *m, const sp_manifest_line *line);
/* Rewrites the file with one line for each sample, if it has many outdated lines. */
void sp_manifest_tidy(sp_manifest *m);

#endif
