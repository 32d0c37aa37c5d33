/* A thread pool for very short, repeated jobs. */
#include "base/pool.h"

#include "base/base.h"

#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdbool.h>

enum { SPINS = 40000, SPINS_A_YIELD = 256 };

typedef struct member {
    sp_pool *pool;
    int part;
    pthread_t thread;
} member;

struct sp_pool {
    int parts;
    sp_pool_work work;
    void *data;
    atomic_uint round;  /* incremented to start a round */
    atomic_int working; /* threads that have not finished the round */
    bool stop;
    pthread_mutex_t lock; /* for threads that have spun for too long */
    pthread_cond_t started, finished;
    member *members;
};

/* Spinning uses a processor, but waking a sleeping thread takes as long as a whole round. So a thread spins for one or
 * two milliseconds, and yields now and then. */
static void relax(int spin) {
    if (spin % SPINS_A_YIELD == SPINS_A_YIELD - 1) {
        sched_yield();
        return;
    }
#if defined(__x86_64__)
    __builtin_ia32_pause();
#endif
}

static void *member_main(void *argument) {
    member *self = argument;
    sp_pool *pool = self->pool;
    for (unsigned seen = 0;;) {
        for (int spin = 0; spin < SPINS && atomic_load(&pool->round) == seen; spin++)
            relax(spin);
        if (atomic_load(&pool->round) == seen) {
            pthread_mutex_lock(&pool->lock);
            while (atomic_load(&pool->round) == seen)
                pthread_cond_wait(&pool->started, &pool->lock);
            pthread_mutex_unlock(&pool->lock);
        }
        seen = atomic_load(&pool->round);
        if (pool->stop)
            return NULL;
        pool->work(pool->data, self->part, pool->parts);
        if (atomic_fetch_sub(&pool->working, 1) == 1) {
            pthread_mutex_lock(&pool->lock);
            pthread_cond_signal(&pool->finished);
            pthread_mutex_unlock(&pool->lock);
        }
    }
}

static void start_round(sp_pool *pool) {
    atomic_store(&pool->working, pool->parts - 1);
    pthread_mutex_lock(&pool->lock);
    atomic_fetch_add(&pool->round, 1);
    pthread_cond_broadcast(&pool->started);
    pthread_mutex_unlock(&pool->lock);
}

/* They block all signals, which are for the threads of whoever calls the library. */
static void start_members(sp_pool *pool, int threads) {
    sigset_t all, old;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &old);
    for (pool->parts = 1; pool->parts < threads; pool->parts++) {
        member *m = &pool->members[pool->parts];
        *m = (member){.pool = pool, .part = pool->parts};
        if (pthread_create(&m->thread, NULL, member_main, m) != 0)
            break; /* fewer threads do the same work */
    }
    pthread_sigmask(SIG_SETMASK, &old, NULL);
}

sp_status sp_pool_make(int threads, sp_pool **out, sp_error *err) {
    *out = NULL;
    threads = threads > SP_POOL_MOST ? SP_POOL_MOST : threads;
    if (threads <= 1)
        return SP_OK;
    sp_pool *pool = sp_alloc(1, sizeof *pool);
    member *members = sp_alloc((size_t)threads, sizeof *members);
    if (!pool || !members) {
        sp_free(pool);
        sp_free(members);
        return sp_fail_memory(err, (size_t)threads * sizeof *members);
    }
    pool->members = members;
    pthread_mutex_init(&pool->lock, NULL);
    pthread_cond_init(&pool->started, NULL);
    pthread_cond_init(&pool->finished, NULL);
    start_members(pool, threads);
    *out = pool;
    return SP_OK;
}

void sp_pool_run(sp_pool *pool, sp_pool_work work, void *data) {
    if (!pool) {
        work(data, 0, 1);
        return;
    }
    pool->work = work;
    pool->data = data;
    start_round(pool);
    work(data, 0, pool->parts);
    for (int spin = 0; spin < SPINS && atomic_load(&pool->working) > 0; spin++)
        relax(spin);
    if (atomic_load(&pool->working) > 0) {
        pthread_mutex_lock(&pool->lock);
        while (atomic_load(&pool->working) > 0)
            pthread_cond_wait(&pool->finished, &pool->lock);
        pthread_mutex_unlock(&pool->lock);
    }
}

int sp_pool_parts(const sp_pool *pool) { return pool ? pool->parts : 1; }

void sp_pool_free(sp_pool *pool) {
    if (!pool)
        return;
    pool->stop = true;
    start_round(pool);
    for (int part = 1; part < pool->parts; part++)
        pthread_join(pool->members[part].thread, NULL);
    pthread_cond_destroy(&pool->finished);
    pthread_cond_destroy(&pool->started);
    pthread_mutex_destroy(&pool->lock);
    sp_free(pool->members);
    sp_free(pool);
}
