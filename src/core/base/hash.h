#ifndef SP_HASH_H
#define SP_HASH_H
/* Hashes of bytes (FNV-1a of 64 bits; Fowler, Noll, Vo, Eastlake). They find accidental changes, not deliberate ones.
 */

#include <sonopack/export.h>
#include <stddef.h>
#include <stdint.h>

/* Value to start a hash with. */
#define SP_HASH64_BEGIN 0xcbf29ce484222325u

/* Continues `hash` with `size` bytes, one byte at a time. */
SP_SHARED uint64_t sp_hash64(uint64_t hash, const void *data, size_t size);

/* Continues `hash` eight bytes at a time, which is faster and gives another value than sp_hash64. The last word is
 * padded with zeros, so the value depends on how the data are divided into calls. */
uint64_t sp_hash64_words(uint64_t hash, const void *data, size_t size);

#endif
