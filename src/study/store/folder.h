#ifndef SP_STORE_FOLDER_H
#define SP_STORE_FOLDER_H
/* The files of a store, for what works on all of them. */

#include "base/file.h"
#include "store/claim.h"
#include "store/manifest.h"
#include "store/sample_h5.h"

#include <sonopack/study/store.h>

struct sp_store {
    char dir[SP_PATH_MAX];
    bool retry;      /* recorded failures are no reason to leave a sample */
    bool no_writing; /* nothing can be written; why: */
    sp_error why;
    sp_manifest *manifest;
    sp_claims claims;
};

typedef struct sp_name_list {
    int64_t count, capacity;
    char (*name)[SP_NAME_MAX]; /* sp_free */
} sp_name_list;

/* DIR/NAME.ENDING; the folder's length was checked when the store was opened. */
void sp_store_path(const sp_store *store, const char *name, const char *ending, char path[SP_PATH_MAX]);
bool sp_store_holds(const sp_store *store, const char *name, const char *ending);
/* Renames it to NAME.bad, or NAME.bad2 and so on where that is there. */
bool sp_store_put_aside(const sp_store *store, const char *name, const char *ending);
/* Reads NAME.h5: the packing too if packing is not NULL. SP_EFORMAT for a file that is damaged, or not that sample. */
sp_status sp_store_get(const sp_store *store, const char *name, sp_packing *packing, bool with_arrays, sp_record *out,
                       sp_error *err);
/* Names with a sample or a failure, sorted, each once. The list begins empty and is the caller's to free, also after an
 * error. */
sp_status sp_store_names(const sp_store *store, sp_name_list *list, sp_error *err);
/* The sample of a name: its results, or else its failure; from the manifest where it speaks of the file as it is. */
sp_status sp_store_sample(const sp_store *store, const char *name, sp_sample *out, sp_error *err);
/* The sample, if its file is one that the manifest speaks of, or else passes the checks of sp_store_verify, how good
 * its balance is excepted: that is what the scene asked for. Otherwise as sp_store_check_sample. */
sp_status sp_store_trusted(const sp_store *store, const char *name, sp_sample *out, sp_error *err);
/* Whether it is recorded that the sample failed. A damaged record says nothing. */
bool sp_store_has_failed(const sp_store *store, const char *name);
/* SP_EFORMAT if the file's bytes are not those that the manifest speaks of, though size and time are. */
sp_status sp_store_check_bytes(const sp_store *store, const char *name, sp_error *err);
/* SP_OK: sound, and entered into the manifest. SP_EFORMAT: damaged. SP_EFAILED: it can be read, and is not what it
 * should be. SP_EIO, SP_ENOMEM. */
sp_status sp_store_check_sample(const sp_store *store, const char *name, double tolerance, sp_error *err);
/* Enters the sample of that file into the manifest. */
void sp_store_enter(const sp_store *store, const sp_sample *sample);

#endif
