#ifndef SP_STORE_FOLDER_H
#define SP_STORE_FOLDER_H
/* The files of a store.
 *
 * From the bottom: files.c reads and writes single files, store.c finds results by way of the manifest, recompute.c
 * makes results again; the sink of a study (sink.c) and the check of a whole store (verify.c) use them. */

#include "base/file.h"
#include "store/claim.h"
#include "store/records.h"
#include "store/sample_h5.h"

#include <sonopack/study/store.h>

struct sp_store {
    char dir[SP_PATH_MAX];
    bool retry;     /* samples that are recorded as failed are made again */
    bool read_only; /* the folder cannot be written to */
    sp_error why;   /* it cannot */
    sp_manifest *manifest;
    sp_claims claims;
};

/* ---- files.c ---------------------------------------------------------------------------------------------------- */

/* Whether a word may be the name of a sample: 32 hexadecimal digits. */
bool sp_store_is_name(const char *name);
/* DIR/NAME.ENDING. sp_store_open has checked that the path is short enough. */
void sp_store_path(const sp_store *store, const char *name, const char *ending, char path[SP_PATH_MAX]);
bool sp_store_holds(const sp_store *store, const char *name, const char *ending);
/* Renames a file to NAME.bad; to NAME.bad2, NAME.bad3, ... if that exists. False on failure. */
bool sp_store_put_aside(const sp_store *store, const char *name, const char *ending);
/* Renames what stands where a new file is to be written. SP_EIO if that fails. */
sp_status sp_store_make_way(const sp_store *store, const char *name, const char *ending, sp_error *err);
/* Reads NAME.h5, and its packing unless packing is NULL. SP_EFORMAT if the file is damaged or holds another sample. */
sp_status sp_store_get(const sp_store *store, const char *name, sp_packing *packing, bool with_arrays, sp_record *out,
                       sp_error *err);
/* Writes NAME.h5, NAME being the name in the record. */
sp_status sp_store_put(const sp_store *store, const sp_record *record, const sp_packing *packing, sp_error *err);

typedef struct sp_name_list {
    int64_t count;
    size_t capacity;
    char (*name)[SP_NAME_MAX]; /* sp_free */
} sp_name_list;
/* The names of all samples with a result or a failure, sorted, each once. The list must be empty at first. The caller
 * frees list->name, even after an error. */
sp_status sp_store_names(const sp_store *store, sp_name_list *list, sp_error *err);

/* ---- store.c --------------------------------------------------------------------------------------------------- */

/* The results of a finished sample, all of whose file can be read; from the manifest where that is up to date. */
sp_status sp_store_finished(const sp_store *store, const char *name, sp_sample *out, sp_error *err);
/* Whether the sample is recorded as failed. A damaged record does not count. */
bool sp_store_has_failed(const sp_store *store, const char *name);
/* The status of NAME.ENDING, 0 everywhere if there is none. */
bool sp_store_stat(const sp_store *store, const char *name, const char *ending, struct stat *info);
/* Adds the sample and its file to the manifest. info: from before the sample was read, because another process may
 * replace the file at any moment, and what stands in the manifest beside the new file's status is believed. */
void sp_store_enter(const sp_store *store, const struct stat *info, const sp_sample *sample);

/* ---- stated.c and recompute.c
 * ------------------------------------------------------------------------------------------------- */

/* Fails with the field at fault as the key of the error, its stored value, and what it must be. */
sp_status sp_at_odds(sp_error *err, const char *field, double stored, double expected);
/* Compares all that a file says of a sample with what its scene and its packing make of it; and checks the packing.
 * tolerance: of the audit. SP_EFAILED with the dataset at fault in err->key, SP_EINVAL for a scene that cannot be read,
 * SP_ENOMEM, SP_EIO. May run in several threads. */
sp_status sp_record_recompute(const char *path, const sp_record *r, const sp_packing *p, double tolerance,
                              sp_error *err);

#endif
