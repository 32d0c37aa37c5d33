/* Random streams. */
#include "numeric/random.h"

#include <Random123/philox.h>
#include <math.h>

uint64_t sp_random_bits(sp_random *r) {
    philox4x32_ctr_t counter = {
        {(uint32_t)r->count, (uint32_t)(r->count >> 32), (uint32_t)r->stream, (uint32_t)(r->stream >> 32)}};
    philox4x32_key_t key = {{(uint32_t)r->seed, (uint32_t)(r->seed >> 32)}};
    philox4x32_ctr_t bits = philox4x32(counter, key);
    r->count++;
    return (uint64_t)bits.v[0] | (uint64_t)bits.v[1] << 32;
}

double sp_random_uniform(sp_random *r) { return (double)(sp_random_bits(r) >> 11) * 0x1p-53; }

/* 1 - u is never 0, u may be. */
double sp_random_normal(sp_random *r) {
    const double radius = sqrt(-2 * log1p(-sp_random_uniform(r)));
    return radius * cos(2 * M_PI * sp_random_uniform(r));
}

uint64_t sp_random_below(sp_random *r, uint64_t n) {
    uint64_t limit = UINT64_MAX - UINT64_MAX % n; /* a multiple of n: larger numbers would favour small results */
    uint64_t bits = sp_random_bits(r);
    while (bits >= limit)
        bits = sp_random_bits(r);
    return bits % n;
}
