#ifndef SP_PACK_KEYS_H
#define SP_PACK_KEYS_H
#include "base/key.h"

/* Every member of sp_pack_spec, with the range of what the user may give. All of them belong to the identity of a saved
 * state, in this order. */
SP_SHARED extern const sp_key sp_pack_keys[];

#endif
