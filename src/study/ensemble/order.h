#ifndef SP_STUDY_ORDER_H
#define SP_STUDY_ORDER_H
/* The order in which the samples of a study are made. The first seed of every combination comes before any second seed;
 * samples with more work come first, so that no thread has much work left at the end. The memory grows with the number
 * of combinations, not of samples. */

#include <sonopack/study/study.h>

typedef struct sp_order {
    int64_t count, combinations; /* samples of the study; combinations of swept values */
    int64_t *longest;            /* [combinations], the most expensive first */
    double *cost;                /* [combinations] expected work, in an arbitrary unit */
    int64_t shard_count;         /* samples of the shard */
    double shard_cost;
} sp_order;

/* Checks every combination: SP_EINVAL if one is no valid scene. */
sp_status sp_order_make(const sp_scene *study, int shard, int shards, sp_order *out, sp_error *err);
void sp_order_free(sp_order *o);
/* Number of the sample at a place, 0 <= place < count; negative if it belongs to another shard. */
int64_t sp_order_sample(const sp_order *o, int64_t place, int shard, int shards);
double sp_order_cost(const sp_order *o, int64_t number);

#endif
