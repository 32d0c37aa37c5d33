#ifndef SP_READER_H
#define SP_READER_H
/* A scene that is being read from libconfig's settings; arrays have become lists (scene/source.h). */

#include "scene/field.h"

#include <libconfig.h>

enum { SP_FROM_OVERRIDE = -1 };

typedef struct sp_reader {
    sp_scene scene;
    const char *name;     /* of the file; NULL: none */
    int given[SP_FIELDS]; /* line where a field was set, SP_FROM_OVERRIDE, or 0 */
    unsigned line;        /* of the setting under way */
    bool overrides;       /* the file has been read, --set is */
    char list[4096];      /* file of diameters that is to be read; "": none */
    int directs; /* keys that were given lists or ranges; their sweeps follow those of study.sweep in the end */
    sp_sweep direct[SP_SWEEPS_MAX];
    sp_error *err; /* never NULL */
} sp_reader;

/* Fails with "group.name = value: must be ..." for a value of the wrong type or none of the words. */
sp_status sp_reader_wrong(const sp_reader *r, const sp_field *f, const config_setting_t *setting);
bool sp_reader_number(const config_setting_t *setting, sp_number *out);
/* NULL: none of the field's words. */
const sp_word *sp_reader_word(const sp_field *f, const config_setting_t *setting);

/* packing.diameters, packing.history, signal.planes, column.mass and column.radius. */
sp_status sp_read_reals(sp_reader *r, const sp_field *f, const config_setting_t *setting);
/* The numbers of such a list but signal.planes, checked; out has room for its length. */
sp_status sp_reader_list(sp_reader *r, const sp_field *f, const config_setting_t *list, double *out);
/* SP_EINVAL for a list that is longer than such a list may be. */
sp_status sp_reader_length(const sp_reader *r, const sp_field *f, const config_setting_t *list);
/* packing.diameter_file: its name is kept, as the override that comes may name another one. */
sp_status sp_read_list_name(sp_reader *r, const sp_field *f, const config_setting_t *setting);
/* packing.file. */
sp_status sp_read_path(sp_reader *r, const sp_field *f, const config_setting_t *setting);
/* Reads the file that is named. */
sp_status sp_reader_load_list(sp_reader *r);

/* study.sweep. */
sp_status sp_read_sweeps(sp_reader *r, const sp_field *f, const config_setting_t *setting);
/* A list or a range that a scalar key was given: sweeps it, its first value is the scene's own. */
sp_status sp_read_direct(sp_reader *r, const sp_field *f, const config_setting_t *setting);
/* One value takes the place of such a sweep. */
void sp_drop_direct(sp_reader *r, const sp_field *f);
/* The sweeps of such keys go to the end of the scene's. Those in front of *listed are of study.sweep. */
sp_status sp_join_sweeps(sp_reader *r, int *listed);
/* { from = 1e-7; to = 1e-4; count = 4; spacing = "log"; } as the values of a sweep; a member named key is passed over.
 */
sp_status sp_read_range(sp_reader *r, const sp_field *f, const config_setting_t *range, sp_sweep *sweep);
/* A number for a sweep of f, checked. */
sp_status sp_read_sweep_number(sp_reader *r, const sp_field *f, const config_setting_t *setting, double *out);
/* The finished scene as a whole; a reason begins with the key where one is to blame. */
sp_status sp_reader_check(sp_reader *r);
/* Of its column alone. */
sp_status sp_reader_check_column(sp_reader *r);

#endif
