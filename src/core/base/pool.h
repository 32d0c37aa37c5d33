#ifndef SP_POOL_H
#define SP_POOL_H
/* A few threads that share one piece of work again and again, many thousand times a second. */

#include <sonopack/status.h>

typedef struct sp_pool sp_pool;
/* Part `part` of `parts` of the work; parts must not depend on each other. */
typedef void (*sp_pool_work)(void *data, int part, int parts);

/* threads - 1 new threads beside the caller's. *out stays NULL for one thread: sp_pool_run then works alone. */
SP_SHARED sp_status sp_pool_make(int threads, sp_pool **out, sp_error *err);
/* Returns when all parts are done. The caller does part 0. */
SP_SHARED void sp_pool_run(sp_pool *pool, sp_pool_work work, void *data);
SP_SHARED void sp_pool_free(sp_pool *pool);

#endif
