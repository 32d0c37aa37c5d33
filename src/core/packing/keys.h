#ifndef SP_PACK_KEYS_H
#define SP_PACK_KEYS_H
#include "base/key.h"

/* All members of sp_pack_spec with their allowed ranges. Their order is that of the hash in a saved state. */
SP_SHARED extern const sp_key sp_pack_keys[];

#endif
