/* The table of the keys of a packing. */
#include "packing/keys.h"

#include <sonopack/packing.h>

#define KEY(name, type, member, value, unit, low, high, zero, words, meaning)                                          \
    {"packing." name, SP_KEY_##type, offsetof(sp_pack_spec, member), 0, unit, low, high, zero},
#define LIST(name, member, value, count, values, unit, low, high, meaning)                                             \
    {"packing." name,                                                                                                  \
     SP_KEY_REALS,                                                                                                     \
     offsetof(sp_pack_spec, member),                                                                                   \
     offsetof(sp_pack_spec, count),                                                                                    \
     unit,                                                                                                             \
     low,                                                                                                              \
     high,                                                                                                             \
     false},
#define SCENE_KEY(...)

const sp_key sp_pack_keys[] = {
#include "packing/keys.inc"
    {NULL, SP_KEY_REAL, 0, 0, "", 0, 0, false}};
