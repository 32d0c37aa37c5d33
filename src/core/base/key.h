#ifndef SP_KEY_H
#define SP_KEY_H
/* The scene keys whose values a spec struct holds. Each spec has one table of them, which says where a value stands and
 * which values are allowed. The check of the spec, the scene's own table of keys and the identity of a saved state all
 * walk this table, so that no range and no list of keys stands twice. */

#include <sonopack/status.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum sp_key_type {
    SP_KEY_REAL,  /* double */
    SP_KEY_INT,   /* int or int32_t */
    SP_KEY_INT64, /* int64_t or uint64_t */
    SP_KEY_BOOL,  /* bool */
    SP_KEY_WORD,  /* an enumeration */
    SP_KEY_REALS  /* const double *, a list */
} sp_key_type;

typedef struct sp_key {
    const char *name; /* as in a scene, "packing.width"; NULL ends a table */
    sp_key_type type;
    size_t offset; /* of the value in the spec */
    size_t count;  /* of a list: offset of the int32_t that says how many values it has */
    const char *unit;
    double low, high; /* smallest and largest value allowed; of a list, of each of its values */
    bool zero;        /* 0 is allowed even where it is outside of the range: it stands for a default */
} sp_key;

/* The value of a key in a spec as a number: 0 and 1 for a bool, the code of a word. Not for lists. */
double sp_key_value(const sp_key *key, const void *spec);
/* The same of a key that is neither real nor a list, with all its bits; negative numbers as in two's complement. */
uint64_t sp_key_integer(const sp_key *key, const void *spec);
/* Whether a value lies in the key's range. NAN does not. */
SP_SHARED bool sp_key_allows(const sp_key *key, double value);
/* The range in words, "1e-10 .. 0.01 E*" or "0.001 .. 2 critical, or 0"; returns buf. */
SP_SHARED const char *sp_key_range(const sp_key *key, char *buf, size_t size);
/* Checks every value of a spec, those of lists included: SP_EINVAL with the first key that is out of its range. */
SP_SHARED sp_status sp_keys_check(const sp_key *keys, const void *spec, sp_error *err);

#endif
