#ifndef SP_STORE_MANIFEST_H
#define SP_STORE_MANIFEST_H
/* The index of a store: manifest.tsv, a line a sample with all of its results, so that tables and the question of what
 * is missing need not open every file.
 *
 * It is never believed against the files: a line counts only while its own checksum fits and the sample's file has the
 * size and the time of change that the line has. So it may be torn, old, damaged, or gone: what it does not say is read
 * from the files, and said again. Lines are only ever added, each by one write; of a sample's lines the last counts. */

#include "store/manifest_line.h"

#include <sys/stat.h>

typedef struct sp_manifest sp_manifest;

/* Of the store in the folder. Whatever is wrong with the file makes an empty index. SP_ENOMEM is the only failure. */
sp_status sp_manifest_open(const char *dir, sp_manifest **out, sp_error *err);
void sp_manifest_close(sp_manifest *m);
/* Lines may be added from now on; the file is made where there is none of this form. */
void sp_manifest_allow_adding(sp_manifest *m);

/* Time of change as lines have it. */
int64_t sp_manifest_time(const struct stat *file);
/* The last line of a sample, which may be of a file that is no more: *out says of which. One that has been added by
 * another process is seen, once the last one known is not of this file. failed: the file is NAME.failed. */
bool sp_manifest_find(sp_manifest *m, const char *name, bool failed, const struct stat *file, sp_manifest_line *out);
/* Adds a line, unless it is there. What cannot be written is no loss. */
void sp_manifest_add(sp_manifest *m, const sp_manifest_line *line);
/* Writes the file anew with one line for each sample of the list, where it has too many others. */
void sp_manifest_tidy(sp_manifest *m);

#endif
