#ifndef SP_RANDOM_H
#define SP_RANDOM_H
/* Counter-based random streams (Philox4x32-10; Salmon et al., SC 2011). Number k of stream s of a seed depends on
 * (seed, s, k) alone, so results do not depend on threads, order or interruptions. */

#include <sonopack/visibility.h>
#include <stdint.h>

typedef struct sp_random {
    uint64_t seed, stream, count; /* count: numbers drawn so far; may be set to jump */
} sp_random;

/* Stream numbers. They never change. */
enum {
    SP_STREAM_DIAMETERS = 1,
    SP_STREAM_GAS = 2,
    SP_STREAM_BOOTSTRAP = 3,
    SP_STREAM_TRACE = 4,
    SP_STREAM_PROBE = 5,
    SP_STREAM_POISSON = 6,
    SP_STREAM_LARGEST = 7,
    SP_STREAM_TYPES = 8,
    SP_STREAM_SPREAD = 20,
    SP_STREAM_MASSES = 21,
    SP_STREAM_TRIALS = 1 << 16
};

static inline sp_random sp_random_make(uint64_t seed, uint64_t stream) { return (sp_random){seed, stream, 0}; }
uint64_t sp_random_bits(sp_random *r);
SP_SHARED double sp_random_uniform(sp_random *r); /* uniform in [0, 1), 53 bits */
/* Normal, of mean 0 and standard deviation 1. Takes two uniform numbers and keeps none, so that a count tells all. */
SP_SHARED double sp_random_normal(sp_random *r);
/* Uniform in 0 .. n-1 without bias; n >= 1. */
SP_SHARED uint64_t sp_random_below(sp_random *r, uint64_t n);

#endif
