#ifndef SP_FIELD_H
#define SP_FIELD_H
/* The table of a scene's fields, and values going in and out of an sp_scene through it. */

#include "base/key.h"

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
    SP_FIELD_REALS = SP_KEY_REALS, /* diameters, history, masses and radii, which the scene owns, or planes */
    SP_FIELD_LIST,                 /* unsigned bits: a list of words */
    SP_FIELD_SWEEP,                /* sp_scene.sweep */
    SP_FIELD_FILE,                 /* name of a file that is read in place of SP_FIELD_REALS, and forgotten */
    SP_FIELD_PATH                  /* name of a file that is kept: char [SP_FROM_MAX] */
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
    const char *meaning;
} sp_field;

/* A number as it was written: integers keep all their 64 bits. */
typedef struct sp_number {
    bool integral;
    int64_t integer;
    double real; /* also set for integers */
} sp_number;

enum { SP_FIELDS = 71 };
extern const sp_field sp_fields[SP_FIELDS];
enum { SP_GROUPS = 5 };
extern const char *const sp_groups[SP_GROUPS];
int sp_field_index(const sp_field *f);
const char *sp_field_name(const sp_field *f); /* without its group */
bool sp_field_in_group(const sp_field *f, const char *group);
/* Range and unit of numbers and lists, from the table of the spec that holds the value; NULL for other fields. */
SP_SHARED const sp_key *sp_field_limits(const sp_field *f);
/* The field of "group.name", NULL if there is none. */
SP_SHARED const sp_field *sp_field_find(const char *key);
/* The key most like this one, which is unknown; NULL if none comes near. group may be "". */
const sp_field *sp_field_nearest(const char *group, const char *name);

bool sp_field_is_number(const sp_field *f);
/* Of one value each: a number, a word or a boolean. */
bool sp_field_is_scalar(const sp_field *f);
/* Why a study may not sweep it; NULL: it may, as it makes another sample. */
const char *sp_field_not_swept(const sp_field *f);

/* What would be right, as "1e-10 .. 0.01 E*" or "piston, triangular or chain"; returns buf. */
SP_SHARED const char *sp_field_right(const sp_field *f, char *buf, size_t size);

/* SP_EINVAL "group.name = value: must be ..." for a number that is not finite, out of range, or broken where an integer
 * is wanted. */
sp_status sp_field_check(const sp_field *f, const sp_number *number, sp_error *err);
/* Checks and stores. */
sp_status sp_field_store(sp_scene *s, const sp_field *f, const sp_number *number, sp_error *err);
/* Value of a numeric field. */
sp_number sp_field_load(const sp_scene *s, const sp_field *f);

/* Frees the sweeps only. */
void sp_scene_free_sweeps(sp_scene *s);
void sp_sweep_free(sp_sweep *sweep);
/* Value k of a sweep of field f, checked, and nothing but that value. */
sp_status sp_sweep_store(sp_scene *s, const sp_field *f, const sp_sweep *sweep, int k, sp_error *err);
/* Makes these the scene's diameters; they are freed with it. NULL and 0: none. */
void sp_scene_take_diameters(sp_scene *s, double *diameters, int32_t count);
void sp_scene_take_history(sp_scene *s, double *history, int32_t count);
void sp_scene_take_masses(sp_scene *s, double *masses, int32_t count);
void sp_scene_take_radii(sp_scene *s, double *radii, int32_t count);
/* Whether a list is packing.history, signal.planes, column.mass or column.radius, and not packing.diameters. */
bool sp_field_is_history(const sp_field *f);
bool sp_field_is_planes(const sp_field *f);
bool sp_field_is_masses(const sp_field *f);
bool sp_field_is_radii(const sp_field *f);
bool sp_field_is_column(const sp_field *f); /* of the group column */

/* Number of single-letter changes, insertions, removals and swaps of neighbours that turn one word into the other;
 * letters above 63 are left out. */
SP_SHARED int sp_edit_distance(const char *a, const char *b);
/* Whether a distance is small enough to ask "did you mean" for a word. */
SP_SHARED bool sp_is_near(const char *word, int distance);
/* Of these words the one to ask "did you mean" for; NULL if none is near. */
const char *sp_nearest_word(const char *word, int count, const char *const *words);

#endif
