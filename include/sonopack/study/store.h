#ifndef SONOPACK_STORE_H
#define SONOPACK_STORE_H
/* Files: packings (HDF5 and text), tables (TSV, CSV, JSON), and stores of an ensemble. All writing goes to a temporary
 * file in the same folder, is synced, and renamed: no partial file ever has its final name. */

#include <sonopack/packing.h>
#include <sonopack/study/study.h>
#include <sonopack/table.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* HDF5 (H5MD groups, /connectivity, /sonopack). */
SP_API sp_status sp_packing_save(const sp_packing *p, const char *path, sp_error *err);
/* Any packing file, told by its content: HDF5 or the one-file text form. Checked (sp_packing_check). */
SP_API sp_status sp_packing_read(const char *path, sp_packing *out, sp_error *err);
/* The one-file text form ('packing_*.txt'). */
SP_API sp_status sp_packing_save_text(const sp_packing *p, const char *path, sp_error *err);
/* The two-table form. keys: "key=value" overrides of the comment lines (pressure, friction, poisson, width, height,
 * ...). */
SP_API sp_status sp_packing_read_tables(const char *grains, const char *contacts, int keys, char *const *key,
                                        sp_packing *out, sp_error *err);
SP_API sp_status sp_packing_save_tables(const sp_packing *p, const char *grains, const char *contacts, sp_error *err);

/* A store: a folder with one HDF5 file a sample, and an index of them (manifest.tsv) that is never believed against the
 * files. Many processes may work on it. create: samples are to be saved; the folder is made if need be, and what
 * killed processes left half written is removed. Where nothing can be written it is opened all the same if it holds
 * samples, and refuses to make more. */
typedef struct sp_store sp_store;
SP_API sp_status sp_store_open(const char *dir, bool create, sp_store **out, sp_error *err);
SP_API void sp_store_close(sp_store *store);
/* A sink for sp_study_run; valid until the store is closed. */
SP_API sp_study_sink sp_store_sink(sp_store *store);
/* One finished sample by its name: packing, results, and the signal and frequencies; each may be NULL, what is not
 * stored of the last has n = 0 or modes = 0. SP_EIO if there is none. */
SP_API sp_status sp_store_read(sp_store *store, const char *name, sp_packing *packing, sp_sample *sample,
                               sp_sample_arrays *arrays, sp_error *err);
/* All samples of the store, read without computing. Files that cannot be read are counted and named in *bad. */
SP_API sp_status sp_store_samples(sp_store *store, int64_t *n, sp_sample **samples, int64_t *bad, sp_error *err);
/* Whether the sink of the store leaves samples that are recorded as failed to be tried again (at first: no). A success
 * removes the record. */
SP_API void sp_store_retry(sp_store *store, bool retry);

typedef enum sp_verdict {
    SP_SOUND = 0, /* all of it was read, and is what it should be; a readable record of a failure is sound too */
    SP_FAULTY,    /* its packing or its results are not what they should be, or it may not be read; left where it is */
    SP_DAMAGED    /* cannot be read, or is not the sample of its name */
} sp_verdict;

/* What the check of one file found. */
typedef struct sp_store_finding {
    const char *file; /* name within the folder */
    sp_verdict verdict;
    const char *reason;  /* of the verdict; of a sound record why the sample failed; else "" */
    bool record;         /* NAME.failed */
    bool aside;          /* damaged, and now NAME.bad, so that a study makes the sample anew */
    int64_t done, names; /* samples looked at, this one included, and samples in all */
} sp_store_finding;

typedef struct sp_store_check {
    int64_t names;                                              /* below 0: all samples of the store */
    const char (*name)[SP_NAME_MAX];                            /* those of them that are in the store are looked at */
    double tolerance;                                           /* of the audit (sp_audit_worst) */
    bool (*found)(const sp_store_finding *finding, void *user); /* false: stop */
    void *user;
} sp_store_check;

/* Reads every file of the samples: all of the packing, results, signal and scene; the name inside against the file's,
 * and against the hash of the scene inside where this version can read that; the structure of the packing
 * (sp_packing_check), its audit, and that results are finite which are made of finite numbers only. Nothing is computed
 * anew. Damaged files are renamed to NAME.bad where the folder can be written, and the index says all that was found.
 * SP_EINTERRUPTED when `found' said so. */
SP_API sp_status sp_store_verify(sp_store *store, const sp_store_check *check, sp_error *err);

/* Leaves out HDF5's clean-up at exit, which after a damaged file prints lines of its own to stderr. For programs whose
 * HDF5 files are all closed by then; to be called before anything else. */
SP_API void sp_hdf5_exit_silently(void);

#ifdef __cplusplus
}
#endif
#endif
