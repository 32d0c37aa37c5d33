#ifndef SP_KEY_H
#define SP_KEY_H
/* Tables of the scene keys that a spec struct holds: where each value is stored and which values are allowed. The check
 * of the spec, the scene's own table of keys and the hash of a saved state use the same table. */

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
    size_t count;  /* of a list: offset of its int32_t number of values */
    const char *unit;
    double low, high; /* allowed range of the value, or of each value of a list */
    bool zero;        /* 0 is allowed too and stands for a default */
} sp_key;

/* Returns the value of a key in a spec as a number: 0 or 1 for a bool, the code of a word. Not for lists. */
double sp_key_value(const sp_key *key, const void *spec);
/* The same with all bits, for keys that are neither real nor lists. Negative numbers are in two's complement. */
uint64_t sp_key_integer(const sp_key *key, const void *spec);
/* Whether a value is allowed. NAN is not. */
SP_SHARED bool sp_key_allows(const sp_key *key, double value);
/* Writes the range as text, such as "1e-10 .. 0.01 E*" or "0.001 .. 2 critical, or 0". Returns buf. */
SP_SHARED const char *sp_key_range(const sp_key *key, char *buf, size_t size);
/* Checks all values of a spec, including those of lists. SP_EINVAL with the first key that is out of range. */
SP_SHARED sp_status sp_keys_check(const sp_key *keys, const void *spec, sp_error *err);

#endif
