#ifndef SP_FOREIGN_EXPORT_H
#define SP_FOREIGN_EXPORT_H
/* The forms that packings are written in. A form fills texts, one for each of its files. */

#include "base/text.h"
#include "foreign/derived.h"
#include "foreign/units.h"

#include <sonopack/study/export_file.h>

/* What a form writes. */
typedef struct sp_export_data {
    const sp_packing *packing; /* in the units to be written */
    const sp_derived *derived;
    const sp_export_units *units;
    const sp_grain_vectors *vectors; /* NULL: none */
    const char *path;                /* of the first file */
} sp_export_data;

/* Without memory, text->failed is set; SP_EREFUSED where the form cannot hold the packing. */
typedef sp_status (*sp_export_writer)(const sp_export_data *e, sp_text text[SP_EXPORT_FILES_MAX], sp_error *err);
sp_status sp_export_vtp(const sp_export_data *e, sp_text text[SP_EXPORT_FILES_MAX], sp_error *err);
sp_status sp_export_lammps_data(const sp_export_data *e, sp_text text[SP_EXPORT_FILES_MAX], sp_error *err);
sp_status sp_export_lammps_dump(const sp_export_data *e, sp_text text[SP_EXPORT_FILES_MAX], sp_error *err);
sp_status sp_export_xyz(const sp_export_data *e, sp_text text[SP_EXPORT_FILES_MAX], sp_error *err);
sp_status sp_export_csv(const sp_export_data *e, sp_text text[SP_EXPORT_FILES_MAX], sp_error *err);
sp_status sp_export_mat(const sp_export_data *e, sp_text text[SP_EXPORT_FILES_MAX], sp_error *err);

/* The grains and the contacts as tables, for CSV and MAT. */
sp_status sp_export_grains_table(const sp_export_data *e, sp_table *t, sp_error *err);
sp_status sp_export_contacts_table(const sp_export_data *e, sp_table *t, sp_error *err);

/* The last part of a path, without folders. */
const char *sp_export_base(const char *path);
/* The ending of a path, ".vtp"; "" if there is none. */
const char *sp_export_ending(const char *path);
/* NAME + suffix for NAME.ending. False if it is too long. */
bool sp_export_beside(const char *path, const char *suffix, char name[SP_EXPORT_PATH_MAX]);

#endif
