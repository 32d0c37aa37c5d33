/* Hashes of bytes. */
#include "base/hash.h"

#include <string.h>

#define FNV_PRIME 0x100000001b3u

uint64_t sp_hash64(uint64_t hash, const void *data, size_t size) {
    const unsigned char *byte = data;
    for (size_t k = 0; k < size; k++)
        hash = (hash ^ byte[k]) * FNV_PRIME;
    return hash;
}

uint64_t sp_hash64_words(uint64_t hash, const void *data, size_t size) {
    const unsigned char *byte = data;
    while (size > 0) {
        const size_t part = size < 8 ? size : 8;
        uint64_t word = 0;
        memcpy(&word, byte, part);
        hash = (hash ^ word) * FNV_PRIME;
        hash ^= hash >> 29; /* multiplication carries upwards only, so fold the high bits down */
        byte += part;
        size -= part;
    }
    return hash;
}
