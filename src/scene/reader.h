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
    sp_error *err;        /* never NULL */
} sp_reader;

/* Fails with "group.name = value: must be ..." for a value of the wrong type or none of the words. */
sp_status sp_reader_wrong(const sp_reader *r, const sp_field *f, const config_setting_t *setting);
bool sp_reader_number(const config_setting_t *setting, sp_number *out);

/* study.sweep. */
sp_status sp_read_sweeps(sp_reader *r, const sp_field *f, const config_setting_t *setting);
/* The finished scene as a whole; a reason begins with the key where one is to blame. */
sp_status sp_reader_check(sp_reader *r);

#endif
