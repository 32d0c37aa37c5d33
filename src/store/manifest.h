#ifndef SP_STORE_MANIFEST_H
#define SP_STORE_MANIFEST_H
/* The index of a store: manifest.tsv, a line a sample with all of its results, so that tables and the question of what
 * is missing need not open every file.
 *
 * It is never believed against the files: a line counts only while its own checksum fits and the sample's file has the
 * size and the time of change that the line has. So it may be torn, old, damaged, or gone: what it does not say is read
 * from the files, and said again. Lines are only ever added, each by one write; of a sample's lines the last counts. */

#include <sonopack/study.h>
#include <sys/stat.h>

typedef struct sp_manifest sp_manifest;

/* Of the store in the folder. Whatever is wrong with the file makes an empty index. SP_ENOMEM is the only failure. */
sp_status sp_manifest_open(const char *dir, sp_manifest **out, sp_error *err);
void sp_manifest_close(sp_manifest *m);
/* Lines may be added from now on; the file is made where there is none of this form. */
void sp_manifest_allow_adding(sp_manifest *m);

/* The sample, if a line speaks of its file as it is now. failed: the file is NAME.failed. */
bool sp_manifest_find(sp_manifest *m, const char *name, bool failed, const struct stat *file, sp_sample *out);
/* Says what its file holds, unless the index says that already. What cannot be written is no loss. */
void sp_manifest_add(sp_manifest *m, const struct stat *file, const sp_sample *sample);
/* Writes the file anew with one line for each sample of the list, where it has too many others. */
void sp_manifest_tidy(sp_manifest *m);

#endif
