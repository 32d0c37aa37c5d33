#ifndef SP_FIELD_H
#define SP_FIELD_H
/* The table of a scene's keys, and values going in and out of an sp_scene through it. */

#include "base/key.h"
#include "base/text.h"

#include <sonopack/study/scene.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum sp_field_type {
    SP_FIELD_REAL = SP_KEY_REAL,
    SP_FIELD_INT = SP_KEY_INT,
    SP_FIELD_INT64 = SP_KEY_INT64, /* a scene has no numbers above INT64_MAX */
    SP_FIELD_BOOL = SP_KEY_BOOL,
    SP_FIELD_WORD = SP_KEY_WORD,
    SP_FIELD_REALS = SP_KEY_REALS, /* a list of numbers */
    SP_FIELD_LIST,                 /* unsigned bits, given as a list of words */
    SP_FIELD_SWEEP,                /* study.sweep */
    SP_FIELD_FILE,                 /* name of a file that is read at once; its numbers go into packing.diameters */
    SP_FIELD_PATH                  /* name of a file, kept as char [SP_FROM_MAX] */
} sp_field_type;

typedef struct sp_word {
    const char *word; /* NULL ends a list of words */
    unsigned value;
} sp_word;

typedef struct sp_field {
    const char *key; /* "group.name" */
    sp_field_type type;
    size_t offset;        /* of the value in sp_scene */
    const sp_word *words; /* of SP_FIELD_WORD and SP_FIELD_LIST */
    sp_key limits;        /* range and unit of a number or a list */
    const char *meaning;
} sp_field;

/* A number as the user wrote it. An integer keeps all of its 64 bits. */
typedef struct sp_number {
    bool integral;
    int64_t integer;
    double real; /* also set for integers */
} sp_number;

enum { SP_FIELDS = 96, SP_GROUPS = 6 };
extern const sp_field sp_fields[SP_FIELDS];
extern const char *const sp_groups[SP_GROUPS];
int sp_field_index(const sp_field *f);
const char *sp_field_name(const sp_field *f); /* the key without its group */
/* A group may be in a group, such as packing.law. */
bool sp_field_in_group(const sp_field *f, const char *group);
const sp_field *sp_field_first(const char *group); /* of a group; NULL: there is no such group */
/* The field of a key "group.name"; NULL for an unknown key. */
SP_SHARED const sp_field *sp_field_find(const char *key);
/* The field whose key is most like an unknown one; NULL if none is similar. group may be "". */
const sp_field *sp_field_nearest(const char *group, const char *name);
/* Range and unit of a number or a list; NULL for other fields. */
SP_SHARED const sp_key *sp_field_limits(const sp_field *f);

bool sp_field_is_number(const sp_field *f);
/* Whether the field has a single value: a number, a word or a boolean. */
bool sp_field_is_scalar(const sp_field *f);
bool sp_field_is_tapped(const sp_field *f); /* a key of the tapped column */
bool sp_field_is_material(const sp_field *f);
bool sp_field_is_planes(const sp_field *f); /* signal.planes, the one list that sp_scene holds in itself */
/* Why a study may not sweep the key; NULL if it may. */
const char *sp_field_not_swept(const sp_field *f);

/* What is allowed, as "1e-10 .. 0.01 E*" or "piston, triangular or chain"; returns buf. */
SP_SHARED const char *sp_field_right(const sp_field *f, char *buf, size_t size);
/* SP_EINVAL "group.name = value: must be ..." for a number out of range, and for a fraction where the value is an
 * integer. */
sp_status sp_field_check(const sp_field *f, const sp_number *number, sp_error *err);
/* Checks a number and stores it. */
sp_status sp_field_store(sp_scene *s, const sp_field *f, const sp_number *number, sp_error *err);
/* The value of a numeric field. */
sp_number sp_field_load(const sp_scene *s, const sp_field *f);

/* Adds the value of a field in the syntax of a scene. */
void sp_field_put(sp_text *t, const sp_scene *s, const sp_field *f);
/* The finished text; NULL without memory. */
char *sp_field_text_end(sp_text *t);

/* ---- lists ------------------------------------------------------------------------------------------------------ */

/* The most values that a list may have. */
int sp_field_list_max(const sp_field *f);
/* The values of a list, and how many there are. */
const double *sp_field_list(const sp_scene *s, const sp_field *f, int32_t *count);
/* Lets the spec in the scene point to these values, which stay the caller's. Not for signal.planes. */
void sp_field_set_list(sp_scene *s, const sp_field *f, const double *values, int32_t count);
/* The same, and the scene owns the values: they are freed with it. NULL and 0 for an empty list. */
void sp_scene_own_list(sp_scene *s, const sp_field *f, double *values, int32_t count);

/* ---- sweeps ----------------------------------------------------------------------------------------------------- */

void sp_sweep_free(sp_sweep *sweep);
/* Frees all sweeps of a scene, and nothing else. */
void sp_scene_free_sweeps(sp_scene *s);
/* Checks value k of a sweep of field f, and stores it. Other values of the scene stay as they are. */
sp_status sp_sweep_store(sp_scene *s, const sp_field *f, const sp_sweep *sweep, int k, sp_error *err);

/* ---- suggestions ------------------------------------------------------------------------------------------------ */

/* How many letters must be changed, inserted, removed, or swapped with their neighbour, to turn one word into the
 * other. Only the first 63 letters count. */
SP_SHARED int sp_edit_distance(const char *a, const char *b);
/* Whether a word at this distance is worth a "did you mean". */
SP_SHARED bool sp_is_near(const char *word, int distance);
/* The one of these words that is nearest; NULL if none is near. */
const char *sp_nearest_word(const char *word, int count, const char *const *words);

#endif
