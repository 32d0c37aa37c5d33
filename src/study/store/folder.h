#ifndef SP_STORE_FOLDER_H
#define SP_STORE_FOLDER_H
/* The files of a store.
 *
 * From the bottom: files.c reads and writes single files, lookup.c finds results by way of the manifest, check.c checks
 * a sample; the sink of a study (sink.c), the check of a whole store (verify.c) and store.c use them. */

#include "base/file.h"
#include "store/claim.h"
#include "store/manifest.h"
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

/* ---- lookup.c --------------------------------------------------------------------------------------------------- */

/* Whether the manifest has an up-to-date line of the sample's file; if so *out is the sample. */
bool sp_store_recall(const sp_store *store, const char *name, bool failed, sp_sample *out);
/* The results of a sample, or else the record of its failure; read from the manifest where that is up to date. */
sp_status sp_store_sample(const sp_store *store, const char *name, sp_sample *out, sp_error *err);
/* Whether the sample is recorded as failed. A damaged record does not count. */
bool sp_store_has_failed(const sp_store *store, const char *name);
/* SP_EFORMAT if the manifest has the file's size and time, but another hash of its bytes. */
sp_status sp_store_check_bytes(const sp_store *store, const char *name, sp_error *err);
/* Adds the sample's file to the manifest. */
void sp_store_enter(const sp_store *store, const sp_sample *sample);
/* SP_EFAILED if the manifest has an up-to-date line of the sample with other numbers than its file. SP_ENOMEM. */
sp_status sp_store_check_line(const sp_store *store, const sp_sample *s, sp_error *err);

/* ---- possible.c, follows.c, recompute.c -------------------------------------------------------------------------- */

/* Whether a sample's numbers, and its arrays, are values that such results can have. SP_EFAILED with the dataset at
 * fault in err->key. */
sp_status sp_sample_possible(const sp_sample *s, sp_error *err);
sp_status sp_arrays_possible(const sp_sample *s, const sp_sample_arrays *a, sp_error *err);
/* Compares the keys of a sample with its scene. SP_EFAILED as above, SP_ENOMEM. */
sp_status sp_record_scene(const sp_record *r, const sp_scene *scene, const sp_packing *p, sp_error *err);
/* Compares results with what follows from packing, scene and other results at little cost. The same errors. */
sp_status sp_record_follows(const sp_record *r, const sp_scene *scene, const sp_packing *p, sp_error *err);
/* Compares all results with new ones from the packing. The same errors. May run in several threads. */
sp_status sp_record_recompute(const sp_record *r, const sp_scene *scene, const sp_packing *p, sp_error *err);

/* ---- check.c ---------------------------------------------------------------------------------------------------- */

/* Checks a sample, and reads it into *r (empty before) and *p. SP_OK: it is sound, and in the manifest now. SP_EFORMAT:
 * its file is damaged. SP_EFAILED: its file can be read, but its content is wrong. SP_EIO and SP_ENOMEM. The caller
 * frees both after any status. */
sp_status sp_store_examine(const sp_store *store, const char *name, double tolerance, sp_record *r, sp_packing *p,
                           sp_error *err);
/* Computes the results of a record again, if this version can read its scene (sp_record_recompute). */
sp_status sp_record_again(const sp_record *r, const sp_packing *p, sp_error *err);
/* A sample that is safe to use: either the manifest has an up-to-date line of it, or it passes sp_store_examine with an
 * infinite tolerance, which allows any imbalance of forces: the scene decides how good the balance is. */
sp_status sp_store_trusted(const sp_store *store, const char *name, sp_sample *out, sp_error *err);

#endif
