#ifndef SP_POOL_H
#define SP_POOL_H
/* A thread pool for work that is repeated thousands of times a second. */

#include <sonopack/status.h>
#include <stdint.h>

enum { SP_POOL_MOST = 256 }; /* parts */
typedef struct sp_pool sp_pool;
/* Does part `part` (from 0) of `parts`. The parts must be independent of each other. */
typedef void (*sp_pool_work)(void *data, int part, int parts);

/* Starts threads - 1 threads; the caller is the remaining one. For one thread *out is NULL, and sp_pool_run runs in the
 * caller alone. SP_ENOMEM. */
SP_SHARED sp_status sp_pool_make(int threads, sp_pool **out, sp_error *err);
/* Runs all parts and returns when they are done. The caller runs part 0. */
SP_SHARED void sp_pool_run(sp_pool *pool, sp_pool_work work, void *data);
SP_SHARED void sp_pool_free(sp_pool *pool);
/* Number of parts of each run; 1 for NULL. */
SP_SHARED int sp_pool_parts(const sp_pool *pool);

/* The things that a part has of n: [sp_pool_share(n, part, parts), sp_pool_share(n, part + 1, parts)). */
static inline int32_t sp_pool_share(int32_t n, int part, int parts) { return (int32_t)((int64_t)n * part / parts); }

#endif
