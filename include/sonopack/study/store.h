#ifndef SONOPACK_STORE_H
#define SONOPACK_STORE_H
/* Files of packings (HDF5 and text), and stores that hold the samples of a study. Every file is written under a
 * temporary name in its folder, synced, and renamed, so that no file with its final name is ever incomplete. */

#include <sonopack/packing.h>
#include <sonopack/study/study.h>
#include <sonopack/table.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Writes HDF5: the groups of H5MD, /connectivity and /sonopack (docs/file-format.md). */
SP_API sp_status sp_packing_save(const sp_packing *p, const char *path, sp_error *err);
/* Reads a packing from HDF5 or from the text form in one file, whichever the file contains, and checks it
 * (sp_packing_check). */
SP_API sp_status sp_packing_read(const char *path, sp_packing *out, sp_error *err);
/* Compares what the file of a packing says beside grains and contacts with these: its scene, the residual, and the
 * masses, rattlers and steps of an HDF5 file. audit: of the packing. SP_EFAILED with the field at fault in err->key,
 * its value and what it must be; SP_EIO, SP_EFORMAT and SP_ENOMEM. */
SP_API sp_status sp_packing_check_stated(const char *path, const sp_packing *p, const sp_audit *audit, sp_error *err);
/* Writes the text form in one file ('packing_*.txt'). */
SP_API sp_status sp_packing_save_text(const sp_packing *p, const char *path, sp_error *err);

/* A folder with one HDF5 file for each sample, and a cache of their numbers (manifest.tsv), which may be deleted: the
 * files decide. Several processes may use a store at once. */
typedef struct sp_store sp_store;
/* With create, samples are to be saved: makes the folder if there is none, and removes what killed processes left half
 * written. A folder that cannot be written to is opened nevertheless if it holds samples; saving more then fails. */
SP_API sp_status sp_store_open(const char *dir, bool create, sp_store **out, sp_error *err);
SP_API void sp_store_close(sp_store *store);
/* The sink for sp_study_run. Valid until the store is closed. */
SP_API sp_study_sink sp_store_sink(sp_store *store);
/* Reads a finished sample by its name. packing, sample and arrays may each be NULL. An array that is not stored has n =
 * 0 or modes = 0. SP_EIO if there is no such sample. */
SP_API sp_status sp_store_read(sp_store *store, const char *name, sp_packing *packing, sp_sample *sample,
                               sp_sample_arrays *arrays, sp_error *err);
/* Reads all samples. *bad counts files that are damaged, or gone by now; *err then has the reason of the first. SP_EIO
 * if a file of the store cannot be read although it is there: its sample would be missing. */
SP_API sp_status sp_store_samples(sp_store *store, int64_t *n, sp_sample **samples, int64_t *bad, sp_error *err);
/* Whether the sink makes samples again that are recorded as failed (by default not). A success removes the record. */
SP_API void sp_store_retry(sp_store *store, bool retry);

typedef enum sp_verdict {
    SP_SOUND = 0, /* the file was read, and all of it is right; also said of a readable record of a failure */
    SP_FAULTY,    /* the file cannot be opened, or its packing or results are wrong; it stays where it is */
    SP_DAMAGED    /* the file cannot be parsed, or holds another sample */
} sp_verdict;

/* What the check of one file found. */
typedef struct sp_store_finding {
    const char *file; /* name within the folder */
    sp_verdict verdict;
    const char *reason;  /* of the verdict; of a sound record, why the sample failed; else "" */
    const char *field;   /* the dataset or key at fault; "" if the reason is about more than one */
    bool record;         /* the file is NAME.failed */
    bool aside;          /* the file was renamed to NAME.bad, so that a study makes the sample again */
    int64_t done, names; /* samples checked so far, with this one, and samples in all */
} sp_store_finding;

typedef struct sp_store_check {
    int64_t names;                   /* how many names; negative: check all samples of the store */
    const char (*name)[SP_NAME_MAX]; /* samples to check; names that are not in the store are ignored */
    double tolerance;                /* of the audit (sp_audit_worst) */
    int jobs;                        /* samples that are computed at a time, each by one thread; >= 1 */
    bool (*found)(const sp_store_finding *finding, void *user); /* called after each file; false stops the check */
    void *user;
} sp_store_check;

/* Checks the files of samples. Reads packing, results, signal and scene, and compares the name inside with the file's
 * name. Checks the packing: its structure (sp_packing_check), its audit, and what is stated of it
 * (sp_packing_check_stated). Computes the sample's keys, its name among them, and all of its results again from scene
 * and packing, which takes as long as the study without its packings. Renames damaged files to NAME.bad, and updates
 * the cache, if the folder can be written to. Faulty files stay. SP_EINTERRUPTED if found returned false. */
SP_API sp_status sp_store_verify(sp_store *store, const sp_store_check *check, sp_error *err);

/* Disables HDF5's clean-up at exit, which prints to stderr after a damaged file. For programs that have closed all HDF5
 * files by then. Call it before any other function of this header. */
SP_API void sp_hdf5_exit_silently(void);

#ifdef __cplusplus
}
#endif
#endif
