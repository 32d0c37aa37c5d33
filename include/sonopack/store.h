#ifndef SONOPACK_STORE_H
#define SONOPACK_STORE_H
/* Files: packings (HDF5 and text), tables (TSV, CSV, JSON), and stores of an ensemble. All writing goes to a temporary
 * file in the same folder, is synced, and renamed: no partial file ever has its final name. */

#include <sonopack/packing.h>
#include <sonopack/study.h>
#include <sonopack/table.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* HDF5 (H5MD groups, /connectivity, /sonopack). */
sp_status sp_packing_save(const sp_packing *p, const char *path, sp_error *err);
/* Any packing file, told by its content: HDF5 or the one-file text form. Checked (sp_packing_check). */
sp_status sp_packing_read(const char *path, sp_packing *out, sp_error *err);
/* The one-file text form ('packing_*.txt'). */
sp_status sp_packing_save_text(const sp_packing *p, const char *path, sp_error *err);
/* The two-table form. keys: "key=value" overrides of the comment lines (pressure, friction, poisson, width, height,
 * ...). */
sp_status sp_packing_read_tables(const char *grains, const char *contacts, int keys, char *const *key, sp_packing *out,
                                 sp_error *err);
sp_status sp_packing_save_tables(const sp_packing *p, const char *grains, const char *contacts, sp_error *err);

typedef enum sp_table_format { SP_TSV = 0, SP_CSV, SP_JSON } sp_table_format;
/* The table as text, numbers with the digits that read back exactly (15 to 17). Caller frees; NULL: no memory. */
char *sp_table_text(const sp_table *t, sp_table_format format);
/* Writes text to path atomically. */
sp_status sp_text_save(const char *path, const char *text, size_t size, sp_error *err);
/* A TSV file with '#' comments, one header row, then rows; or plain columns of numbers without a header (names c1, c2,
 * ...). Numbers where every cell of a column is one. */
sp_status sp_table_read(const char *path, sp_table *out, sp_error *err);

/* A store: a folder with one HDF5 file a sample. */
typedef struct sp_store sp_store;
sp_status sp_store_open(const char *dir, bool create, sp_store **out, sp_error *err);
void sp_store_close(sp_store *store);
/* A sink for sp_study_run; valid until the store is closed. */
sp_study_sink sp_store_sink(sp_store *store);
/* One finished sample by its name: packing, results and signal; each may be NULL, a signal that is not stored has n =
 * 0. SP_EIO if there is none. */
sp_status sp_store_read(sp_store *store, const char *name, sp_packing *packing, sp_sample *sample, sp_signal *signal,
                        sp_error *err);
/* All samples of the store, read without computing. Files that cannot be read are counted and named in *bad. */
sp_status sp_store_samples(sp_store *store, int64_t *n, sp_sample **samples, int64_t *bad, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
