#ifndef SP_TAPPED_KEYS_H
#define SP_TAPPED_KEYS_H
#include "base/key.h"

/* Every member of sp_tapped_spec that a scene may give, with its range. */
SP_SHARED extern const sp_key sp_tapped_keys[];

#endif
