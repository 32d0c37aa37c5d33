#include "base/team.h"

#include "base/base.h"

#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdbool.h>

enum { TEAM_MAX = 256, SPINS = 40000, SPINS_A_YIELD = 256 };

typedef struct member {
    sp_team *team;
    int part;
    pthread_t thread;
} member;

struct sp_team {
    int parts;
    sp_team_work work;
    void *data;
    atomic_uint round;  /* a new number starts a round of work */
    atomic_int working; /* members that have not finished it */
    bool stop;
    pthread_mutex_t lock; /* for those that have waited too long to spin on */
    pthread_cond_t started, finished;
    member *members;
};

/* Waiting costs a processor; sleeping costs the time of a whole round of work to wake up. So one waits for a
 * millisecond or two, and lets others have the processor now and then. */
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
    sp_team *team = self->team;
    for (unsigned seen = 0;;) {
        for (int spin = 0; spin < SPINS && atomic_load(&team->round) == seen; spin++)
            relax(spin);
        if (atomic_load(&team->round) == seen) {
            pthread_mutex_lock(&team->lock);
            while (atomic_load(&team->round) == seen)
                pthread_cond_wait(&team->started, &team->lock);
            pthread_mutex_unlock(&team->lock);
        }
        seen = atomic_load(&team->round);
        if (team->stop)
            return NULL;
        team->work(team->data, self->part, team->parts);
        if (atomic_fetch_sub(&team->working, 1) == 1) {
            pthread_mutex_lock(&team->lock);
            pthread_cond_signal(&team->finished);
            pthread_mutex_unlock(&team->lock);
        }
    }
}

static void start_round(sp_team *team) {
    atomic_store(&team->working, team->parts - 1);
    pthread_mutex_lock(&team->lock);
    atomic_fetch_add(&team->round, 1);
    pthread_cond_broadcast(&team->started);
    pthread_mutex_unlock(&team->lock);
}

/* Signals are for the threads of whoever calls the library, not for these. */
static void start_members(sp_team *team, int threads) {
    sigset_t all, old;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &old);
    for (team->parts = 1; team->parts < threads; team->parts++) {
        member *m = &team->members[team->parts];
        *m = (member){.team = team, .part = team->parts};
        if (pthread_create(&m->thread, NULL, member_main, m) != 0)
            break; /* fewer hands do the same work */
    }
    pthread_sigmask(SIG_SETMASK, &old, NULL);
}

sp_status sp_team_make(int threads, sp_team **out, sp_error *err) {
    *out = NULL;
    threads = threads > TEAM_MAX ? TEAM_MAX : threads;
    if (threads <= 1)
        return SP_OK;
    sp_team *team = sp_alloc(1, sizeof *team);
    member *members = sp_alloc((size_t)threads, sizeof *members);
    if (!team || !members) {
        sp_free(team);
        sp_free(members);
        return sp_fail_memory(err, (size_t)threads * sizeof *members);
    }
    team->members = members;
    pthread_mutex_init(&team->lock, NULL);
    pthread_cond_init(&team->started, NULL);
    pthread_cond_init(&team->finished, NULL);
    start_members(team, threads);
    *out = team;
    return SP_OK;
}

void sp_team_run(sp_team *team, sp_team_work work, void *data) {
    if (!team) {
        work(data, 0, 1);
        return;
    }
    team->work = work;
    team->data = data;
    start_round(team);
    work(data, 0, team->parts);
    for (int spin = 0; spin < SPINS && atomic_load(&team->working) > 0; spin++)
        relax(spin);
    if (atomic_load(&team->working) > 0) {
        pthread_mutex_lock(&team->lock);
        while (atomic_load(&team->working) > 0)
            pthread_cond_wait(&team->finished, &team->lock);
        pthread_mutex_unlock(&team->lock);
    }
}

void sp_team_free(sp_team *team) {
    if (!team)
        return;
    team->stop = true;
    start_round(team);
    for (int part = 1; part < team->parts; part++)
        pthread_join(team->members[part].thread, NULL);
    pthread_cond_destroy(&team->finished);
    pthread_cond_destroy(&team->started);
    pthread_mutex_destroy(&team->lock);
    sp_free(team->members);
    sp_free(team);
}
