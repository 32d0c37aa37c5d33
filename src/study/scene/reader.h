#ifndef SP_READER_H
#define SP_READER_H
/* Reads a scene from the settings of libconfig. Arrays have become lists before (scene/source.h).
 *
 * From the bottom: values.c reads single values and lists, sweep.c ranges and sweeps; check.c checks the whole scene;
 * read.c calls all of them. */

#include "scene/field.h"

#include <libconfig.h>

enum { SP_FROM_OVERRIDE = -1 };

typedef struct sp_reader {
    sp_scene scene;
    const char *name;     /* of the file; NULL: none */
    int given[SP_FIELDS]; /* line where a key was given, SP_FROM_OVERRIDE, or 0 */
    unsigned line;        /* of the setting that is being read */
    bool overrides;       /* the file has been read, and now --set is */
    char list[4096];      /* packing.diameter_file; "": none */
    int directs;          /* keys that were given a list or a range in the place of a value */
    sp_sweep direct[SP_SWEEPS_MAX];
    sp_error *err; /* never NULL */
} sp_reader;

/* ---- single values ---------------------------------------------------------------------------------------------- */

/* Fails with "group.name = value: must be ...": the value has the wrong type, or is an unknown word. */
sp_status sp_reader_wrong(const sp_reader *r, const sp_field *f, const config_setting_t *setting);
/* False for a setting that is no number. */
bool sp_reader_number(const config_setting_t *setting, sp_number *out);
/* A number, or a string with a number and a unit, which becomes a number in the unit of the field. Fails with the key
 * for other settings. */
sp_status sp_reader_quantity(const sp_reader *r, const sp_field *f, const config_setting_t *setting, sp_number *out);
/* A number in the range of its field. */
sp_status sp_reader_checked_number(sp_reader *r, const sp_field *f, const config_setting_t *setting, sp_number *out);
/* A number for a sweep of its field, which must fit into a double. */
sp_status sp_reader_swept_number(sp_reader *r, const sp_field *f, const config_setting_t *setting, double *out);
/* NULL for a setting that is none of the field's words. */
const sp_word *sp_reader_word(const sp_field *f, const config_setting_t *setting);

/* ---- lists ------------------------------------------------------------------------------------------------------ */

/* A list of numbers, of any field of type SP_FIELD_REALS. */
sp_status sp_read_reals(sp_reader *r, const sp_field *f, const config_setting_t *setting);
/* The numbers of a list, checked; out has space for all of them. */
sp_status sp_reader_list(sp_reader *r, const sp_field *f, const config_setting_t *list, double *out);
/* SP_EINVAL for a list that is too long. */
sp_status sp_reader_length(const sp_reader *r, const sp_field *f, const config_setting_t *list);
/* packing.diameter_file. Only the name is kept, because an override may still name another file. */
sp_status sp_read_list_name(sp_reader *r, const sp_field *f, const config_setting_t *setting);
/* Reads the file of diameters that was named. */
sp_status sp_reader_load_list(sp_reader *r);
/* packing.file. */
sp_status sp_read_path(sp_reader *r, const sp_field *f, const config_setting_t *setting);

/* ---- sweeps ----------------------------------------------------------------------------------------------------- */

/* study.sweep. */
sp_status sp_read_sweeps(sp_reader *r, const sp_field *f, const config_setting_t *setting);
/* A list or a range in the place of a single value: a sweep of that key. Its first value is the scene's own. */
sp_status sp_read_direct(sp_reader *r, const sp_field *f, const config_setting_t *setting);
/* Removes such a sweep: a later setting gave the key a single value. */
void sp_drop_direct(sp_reader *r, const sp_field *f);
/* Appends these sweeps to the sweeps of study.sweep. *listed counts the latter. */
sp_status sp_join_sweeps(sp_reader *r, int *listed);

/* ---- checks ----------------------------------------------------------------------------------------------------- */

/* Checks the material, once it has been read: before all other groups, whose numbers may have SI units. */
sp_status sp_reader_check_material(sp_reader *r);
/* Checks the finished scene as a whole. */
sp_status sp_reader_check(sp_reader *r);
/* Checks the tapped column alone. */
sp_status sp_reader_check_tapped(sp_reader *r);

#endif
