#ifndef SP_POOL_H
#define SP_POOL_H
/* A thread pool for work that is repeated thousands of times a second. */

#include <sonopack/status.h>

typedef struct sp_pool sp_pool;
/* Does part `part` (from 0) of `parts`. The parts must be independent of each other. */
typedef void (*sp_pool_work)(void *data, int part, int parts);

/* Starts threads - 1 threads; the caller is the remaining one. For one thread *out is NULL, and sp_pool_run runs in the
 * caller alone. SP_ENOMEM. */
SP_SHARED sp_status sp_pool_make(int threads, sp_pool **out, sp_error *err);
/* Runs all parts and returns when they are done. The caller runs part 0. */
SP_SHARED void sp_pool_run(sp_pool *pool, sp_pool_work work, void *data);
SP_SHARED void sp_pool_free(sp_pool *pool);

#endif
