#ifndef SP_STORE_RECORDS_H
#define SP_STORE_RECORDS_H
/* What a store keeps as text beside its samples: records of failures, and the cache of the samples' numbers. */

#include "base/text.h"

#include <sonopack/study/study.h>
#include <sys/stat.h>

/* NAME.failed is the record of a sample that could not be made, in 'key = value' lines. */
sp_status sp_failure_save(const char *path, const sp_sample *sample, sp_error *err);
sp_status sp_failure_read(const char *path, const char *name, sp_sample *out, sp_error *err);

/* manifest.tsv has a line for each sample, so that tables need not open every file.
 *
 * The files decide. A line counts only if its checksum is right and the sample's file has the size and the modification
 * time in the line; every other sample is read from its file, and gets a new line. The cache may therefore be deleted,
 * cut off or old. Lines are only appended, each by one write. The last line of a sample counts. */

/* Appends the line of a sample: NAME.failed, or NAME.h5. */
void sp_manifest_put(sp_text *out, const struct stat *file, const sp_sample *sample);
/* Parses a line without its end, in place. False if it is not such a line of this sample and file, bit for bit as it
 * was written. */
bool sp_manifest_get(char *line, const char *name, bool failed, const struct stat *file, sp_sample *out);

typedef struct sp_manifest sp_manifest;

/* Opens the cache of a folder. A file that is missing or wrong gives an empty one; only SP_ENOMEM is a failure. adding:
 * lines may be added, and the file is made if there is none of this format. */
sp_status sp_manifest_open(const char *dir, bool adding, sp_manifest **out, sp_error *err);
void sp_manifest_close(sp_manifest *m);
/* Takes notice of lines that others have added since it was opened. */
void sp_manifest_refresh(sp_manifest *m);
/* Finds the sample in this file. */
bool sp_manifest_find(const sp_manifest *m, const char *name, bool failed, const struct stat *file, sp_sample *out);
/* Adds a line. Failures are ignored. */
void sp_manifest_add(sp_manifest *m, const struct stat *file, const sp_sample *sample);

#endif
