#ifndef SP_HASH_H
#define SP_HASH_H
/* Hashes that detect accidental changes of data (64-bit FNV-1a; Fowler, Noll, Vo, Eastlake). */

#include <sonopack/visibility.h>
#include <stddef.h>
#include <stdint.h>

/* initial value of a hash */
#define SP_HASH64_BEGIN 0xcbf29ce484222325u

/* Continues `hash` over `size` bytes. */
SP_SHARED uint64_t sp_hash64(uint64_t hash, const void *data, size_t size);

/* Continues `hash` eight bytes at a time. This is faster than sp_hash64 and gives another value. The last word is
 * padded with zeros, so the result depends on how the data are split over calls. */
uint64_t sp_hash64_words(uint64_t hash, const void *data, size_t size);

#endif
