#ifndef SP_RANDOM_H
#define SP_RANDOM_H
/* Counter-based random streams (Philox4x32-10; Salmon et al., SC 2011): number k of stream s of a seed is a function of
 * (seed, s, k) alone, so results do not depend on threads, order or interruption. */

#include <stdint.h>

typedef struct sp_random {
    uint64_t seed, stream, count; /* count: numbers drawn so far; setting it jumps */
} sp_random;

/* Streams in use: one name, one number, for ever. */
enum {
    SP_STREAM_DIAMETERS = 1,
    SP_STREAM_GAS = 2,
    SP_STREAM_BOOTSTRAP = 3,
    SP_STREAM_TRACE = 4,
    SP_STREAM_PROBE = 5,
    SP_STREAM_POISSON = 6,
    SP_STREAM_LARGEST = 7
};

static inline sp_random sp_random_make(uint64_t seed, uint64_t stream) { return (sp_random){seed, stream, 0}; }
uint64_t sp_random_bits(sp_random *r);
double sp_random_uniform(sp_random *r); /* [0, 1), 53 bits */
/* 0 .. n-1, n >= 1, without bias. */
uint64_t sp_random_below(sp_random *r, uint64_t n);

#endif
