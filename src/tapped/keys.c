/* The table of the keys of the tapped column. */
#include "tapped/keys.h"

#include <sonopack/tapped/tapped.h>

#define KEY(name, type, member, value, unit, low, high, zero, words, meaning)                                          \
    {"column." name, SP_KEY_##type, offsetof(sp_tapped_spec, member), 0, unit, low, high, zero},
#define LIST(name, member, value, count, values, unit, low, high, meaning)                                             \
    {"column." name, SP_KEY_REALS, offsetof(sp_tapped_spec, member), offsetof(sp_tapped_spec, count), unit, low,       \
     high,           false},

const sp_key sp_tapped_keys[] = {
#include "tapped/keys.inc"
    {NULL, SP_KEY_REAL, 0, 0, "", 0, 0, false}};
