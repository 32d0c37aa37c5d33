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
    sp_error *err;        /* never NULL */
} sp_reader;

/* Fails with "group.name = value: must be ..." for a value of the wrong type or none of the words. */
sp_status sp_reader_wrong(const sp_reader *r, const sp_field *f, const config_setting_t *setting);
bool sp_reader_number(const config_setting_t *setting, sp_number *out);

/* packing.diameters, packing.history and signal.planes. */
sp_status sp_read_reals(sp_reader *r, const sp_field *f, const config_setting_t *setting);
/* packing.diameter_file: its name is kept, as the override that comes may name another one. */
sp_status sp_read_list_name(sp_reader *r, const sp_field *f, const config_setting_t *setting);
/* packing.file. */
sp_status sp_read_path(sp_reader *r, const sp_field *f, const config_setting_t *setting);
/* Reads the file that is named. */
sp_status sp_reader_load_list(sp_reader *r);

/* study.sweep. */
sp_status sp_read_sweeps(sp_reader *r, const sp_field *f, const config_setting_t *setting);
/* The finished scene as a whole; a reason begins with the key where one is to blame. */
sp_status sp_reader_check(sp_reader *r);

#endif
