#ifndef SP_STUDY_ORDER_H
#define SP_STUDY_ORDER_H
/* The order in which the samples of a study are made: first seeds first; among equals the longest work first, so that
 * no thread is left with it at the end. Its memory goes with the combinations of swept values, not with the samples. */

#include <sonopack/study/study.h>

typedef struct sp_order {
    int64_t count, combinations; /* samples of the study; combinations of swept values */
    int64_t *longest;            /* [combinations] by falling cost */
    double *cost;                /* [combinations] expected, in units of its own */
    int64_t shard_count;         /* samples of the shard */
    double shard_cost;
} sp_order;

/* Every combination is checked: SP_EINVAL where one makes no scene. */
sp_status sp_order_make(const sp_scene *study, int shard, int shards, sp_order *out, sp_error *err);
void sp_order_free(sp_order *o);
/* Number of the sample at a place, 0 <= place < count; below 0 if it belongs to another shard. */
int64_t sp_order_sample(const sp_order *o, int64_t place, int shard, int shards);
double sp_order_cost(const sp_order *o, int64_t number);

#endif
