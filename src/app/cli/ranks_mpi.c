/* Ranks of an MPI job. All of MPI happens in one thread of each process, which asks for what has come instead of
 * waiting in MPI for it: so workers never wait for a sample that is being made, rank 0 answers wherever it is in its
 * own work, and ranks that wait for the last one sleep. MPI's weakest level of threads does, and messages that each
 * transport has; windows with atomic operations need the one that owns them to help on many networks. */
#include "cli/ranks.h"

#include "base/base.h"
#include "base/hash.h"

#include <math.h>
#include <mpi.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* To rank 0. */
typedef enum ask { ASK_NUMBER = 1, ASK_NOTHING, ASK_JOIN, ASK_END } ask;
typedef struct question {
    ask kind;
    bool stop;
    sp_status status;
    uint64_t study; /* hash of what it makes */
    sp_study_progress progress;
    char reason[512];
} question;

/* From rank 0. */
typedef enum answer_kind { ANSWER_NUMBER = 1, ANSWER_STOP, ANSWER_LEAVE } answer_kind;
typedef struct answer {
    answer_kind kind;
    int exit_status;
    int64_t number;
} answer;

/* Another rank, as rank 0 knows it. */
typedef struct other {
    bool waits; /* for a number */
    bool joined, ended;
    uint64_t study;
    sp_status status;
    sp_study_progress progress;
    char reason[512];
} other;

static struct {
    pthread_t thread;
    pthread_mutex_t lock;   /* of all below */
    pthread_cond_t changed; /* for those who wait for the others */
    pthread_cond_t wake;    /* there is something to be sent */
    bool up, over;          /* MPI has begun; nothing is to be sent any more */
    int rank, size;
    pid_t launcher;
    /* this rank */
    uint64_t study; /* 0: not known yet */
    bool tell[ASK_END + 1];
    bool waits, stop, leaves;
    int64_t number;
    int exit_status;
    sp_status status;
    sp_study_progress progress;
    char reason[512];
    /* rank 0 */
    bool stop_told;
    int64_t next;
    other *other; /* [size] */
} ranks = {.lock = PTHREAD_MUTEX_INITIALIZER};

static const double settle = 2e-3; /* seconds of quick looks after something has come */

static void ask_zero(ask kind) {
    question q = {
        .kind = kind, .stop = ranks.stop, .status = ranks.status, .study = ranks.study, .progress = ranks.progress};
    snprintf(q.reason, sizeof q.reason, "%s", ranks.reason);
    MPI_Send(&q, (int)sizeof q, MPI_BYTE, 0, 0, MPI_COMM_WORLD);
}

static void answer_to(int rank, answer a) { MPI_Send(&a, (int)sizeof a, MPI_BYTE, rank, 0, MPI_COMM_WORLD); }

/* One message, if there is one. */
static bool receive(void *message, size_t size, int *from) {
    MPI_Status status;
    int there = 0;
    MPI_Iprobe(MPI_ANY_SOURCE, 0, MPI_COMM_WORLD, &there, &status);
    if (there) {
        *from = status.MPI_SOURCE;
        MPI_Recv(message, (int)size, MPI_BYTE, *from, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    }
    return there;
}

/* Rank 0 hears another one. */
static void hear(int from, const question *q) {
    other *o = &ranks.other[from];
    o->study = q->study;
    o->progress = q->progress;
    o->waits = o->waits || q->kind == ASK_NUMBER;
    if (q->kind == ASK_JOIN)
        o->joined = true;
    if (q->kind == ASK_JOIN && o->status == SP_OK) { /* else it has been stopped for making something else */
        o->status = q->status;
        memcpy(o->reason, q->reason, sizeof o->reason);
    }
    if (q->kind == ASK_END)
        o->joined = o->ended = true;
    if (q->stop || o->status != SP_OK)
        ranks.stop = true;
}

/* A rank that makes something else would take numbers that nobody makes. */
static void compare(int rank) {
    other *o = &ranks.other[rank];
    if (ranks.stop || o->study == ranks.study)
        return;
    o->status = SP_EINVAL;
    snprintf(o->reason, sizeof o->reason,
             "was started with another scene, store or --shard than rank 0: all ranks must make the same study");
    ranks.stop = true;
}

/* Rank 0: hears all, answers, and says when to stop and to leave. */
static bool lead(void) {
    question q;
    int from;
    bool came = false, ended = true;
    while (receive(&q, sizeof q, &from)) {
        hear(from, &q);
        came = true;
    }
    for (int k = 1; k < ranks.size; k++) {
        other *o = &ranks.other[k];
        ended = ended && o->ended;
        if (!o->waits || (!ranks.study && !ranks.stop))
            continue;
        compare(k);
        answer_to(k, (answer){.kind = ANSWER_NUMBER, .number = ranks.stop ? -1 : ranks.next++});
        o->waits = false;
    }
    if (ranks.stop && !ranks.stop_told) {
        ranks.stop_told = true;
        for (int k = 1; k < ranks.size; k++)
            if (!ranks.other[k].ended)
                answer_to(k, (answer){.kind = ANSWER_STOP});
    }
    if (ranks.leaves && ended) {
        for (int k = 1; k < ranks.size; k++)
            answer_to(k, (answer){.kind = ANSWER_LEAVE, .exit_status = ranks.exit_status});
        ranks.over = true;
    }
    return came;
}

/* Other ranks: say what there is to say, and hear rank 0. */
static bool follow(void) {
    answer a;
    int from;
    bool came = false;
    for (ask kind = ASK_NUMBER; kind <= ASK_END; kind++) {
        if (ranks.tell[kind])
            ask_zero(kind);
        ranks.tell[kind] = false;
    }
    while (receive(&a, sizeof a, &from)) {
        came = true;
        if (a.kind == ANSWER_NUMBER)
            ranks.number = a.number;
        else if (a.kind == ANSWER_STOP)
            ranks.stop = true;
        else
            ranks.over = true;
        if (a.kind == ANSWER_LEAVE)
            ranks.exit_status = a.exit_status;
        ranks.waits = ranks.waits && a.kind != ANSWER_NUMBER;
    }
    return came || ranks.waits;
}

static void wait_for(pthread_cond_t *condition, double seconds) {
    struct timespec until;
    clock_gettime(CLOCK_MONOTONIC, &until);
    const double nanoseconds = (double)until.tv_nsec + 1e9 * seconds;
    until.tv_sec += (time_t)(nanoseconds / 1e9);
    until.tv_nsec = (long)fmod(nanoseconds, 1e9);
    pthread_cond_timedwait(condition, &ranks.lock, &until);
}

/* The thread of MPI. Rank 0 looks often, since others wait for it; these hear nothing unasked but to stop. */
static void *serve(void *nothing) {
    int level;
    (void)nothing;
    MPI_Init_thread(NULL, NULL, MPI_THREAD_FUNNELED, &level);
    pthread_mutex_lock(&ranks.lock);
    MPI_Comm_rank(MPI_COMM_WORLD, &ranks.rank);
    MPI_Comm_size(MPI_COMM_WORLD, &ranks.size);
    ranks.other = sp_alloc((size_t)ranks.size, sizeof *ranks.other);
    if (!ranks.other || level < MPI_THREAD_FUNNELED)
        MPI_Abort(MPI_COMM_WORLD, CLI_FAILED);
    ranks.up = true;
    pthread_cond_broadcast(&ranks.changed);
    const double idle = ranks.rank == 0 ? 1e-3 : 20e-3;
    double last = sp_clock_wall();
    bool stopped = false;
    while (!ranks.over) {
        if (getppid() != ranks.launcher)
            ranks.stop = true;
        const bool came = ranks.rank == 0 ? lead() : follow();
        if (came)
            last = sp_clock_wall();
        if (came || ranks.stop != stopped)
            pthread_cond_broadcast(&ranks.changed);
        stopped = ranks.stop;
        if (!ranks.over)
            wait_for(&ranks.wake, sp_clock_wall() - last < settle ? 50e-6 : idle);
    }
    pthread_cond_broadcast(&ranks.changed);
    pthread_mutex_unlock(&ranks.lock);
    MPI_Finalize();
    return NULL;
}

/* Workers call it one at a time. */
static int64_t take(void *nothing) {
    (void)nothing;
    pthread_mutex_lock(&ranks.lock);
    int64_t number = -1;
    if (ranks.rank > 0 && !ranks.stop) {
        ranks.waits = ranks.tell[ASK_NUMBER] = true;
        pthread_cond_signal(&ranks.wake);
        while (ranks.waits && !ranks.stop)
            pthread_cond_wait(&ranks.changed, &ranks.lock);
        number = ranks.number;
    } else if (!ranks.stop) {
        number = ranks.next++;
    }
    if (ranks.stop)
        number = -1;
    pthread_mutex_unlock(&ranks.lock);
    return number;
}

/* For ends of the process elsewhere, as after a wrong option. */
static void leave(int status, void *nothing) {
    (void)nothing;
    cli_ranks_end(status);
}

sp_status cli_ranks_start(cli_ranks *out, sp_error *err) {
    *out = (cli_ranks){.rank = 0, .size = 1};
    if (!cli_launch_look().mpi)
        return SP_OK;
    pthread_condattr_t attributes;
    pthread_condattr_init(&attributes);
    pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC);
    pthread_cond_init(&ranks.changed, &attributes);
    pthread_cond_init(&ranks.wake, &attributes);
    pthread_condattr_destroy(&attributes);
    ranks.launcher = getppid();
    sigset_t all, old; /* signals are for the caller's thread */
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &old);
    const bool started = pthread_create(&ranks.thread, NULL, serve, NULL) == 0;
    pthread_sigmask(SIG_SETMASK, &old, NULL);
    if (!started)
        return sp_fail(err, SP_EFAILED, "no thread could be started for MPI");
    pthread_mutex_lock(&ranks.lock);
    while (!ranks.up)
        pthread_cond_wait(&ranks.changed, &ranks.lock);
    *out = (cli_ranks){.rank = ranks.rank, .size = ranks.size, .take = ranks.size > 1 ? take : NULL};
    pthread_mutex_unlock(&ranks.lock);
    on_exit(leave, NULL);
    return SP_OK;
}

sp_status cli_ranks_check(const cli_ranks *group, int shards, sp_error *err) {
    const cli_launch launch = cli_launch_look();
    if (launch.processes <= 1 || group->size > 1 || shards > 1)
        return SP_OK;
    return sp_fail(
        err, SP_EINVAL,
        "%d processes were started (%s) that MPI does not join, and each would print all tables: must be started "
        "by mpirun, or srun --mpi=pmix, or each process told its --shard I/%d",
        launch.processes, launch.variable, launch.processes);
}

void cli_ranks_begin(const char *what) {
    pthread_mutex_lock(&ranks.lock);
    ranks.study = sp_hash64(SP_HASH64_BEGIN, what, strlen(what)) | 1; /* 0: not known yet */
    pthread_mutex_unlock(&ranks.lock);
}

/* Of all ranks together, from what they said last; on rank 0, under the lock. */
static sp_study_progress sum(void) {
    sp_study_progress all = ranks.progress;
    for (int k = 1; k < ranks.size; k++) {
        const sp_study_progress *p = &ranks.other[k].progress;
        all.done += p->done;
        all.computed += p->computed;
        all.failed += p->failed;
        all.cost_done += p->cost_done;
        all.cost_computed += p->cost_computed;
    }
    all.seconds_left = all.cost_computed > 0 ? all.seconds * (all.cost - all.cost_done) / all.cost_computed : NAN;
    return all;
}

bool cli_ranks_share(sp_study_progress *progress, bool stopped) {
    pthread_mutex_lock(&ranks.lock);
    ranks.progress = *progress;
    ranks.stop = ranks.stop || stopped;
    if (ranks.rank == 0)
        *progress = sum();
    else
        ranks.tell[ASK_NOTHING] = true;
    if (ranks.up)
        pthread_cond_signal(&ranks.wake);
    const bool go_on = !ranks.stop;
    pthread_mutex_unlock(&ranks.lock);
    return go_on;
}

static bool all_joined(void) {
    bool all = true;
    for (int k = 1; k < ranks.size; k++)
        all = all && ranks.other[k].joined;
    return all;
}

/* What became of the study: this rank's failure before another's, a failure before an interruption. */
static sp_status judge(sp_status status, const sp_study_progress *all, sp_error *err) {
    bool stopped = all->done < all->total;
    for (int k = 1; k < ranks.size && (status == SP_OK || status == SP_EINTERRUPTED); k++) {
        const other *o = &ranks.other[k];
        if (o->status != SP_OK && o->status != SP_EINTERRUPTED)
            return sp_fail(err, o->status, "rank %d: %s", k, o->reason);
        stopped = stopped || o->status == SP_EINTERRUPTED;
    }
    return status == SP_OK && stopped ? sp_fail(err, SP_EINTERRUPTED, "stopped") : status;
}

sp_status cli_ranks_join(sp_status status, sp_study_watch watch, void *user, sp_study_progress *progress,
                         sp_error *err) {
    if (!ranks.up)
        return status;
    const double begun = sp_clock_wall(), before = progress->seconds;
    pthread_mutex_lock(&ranks.lock);
    ranks.status = status;
    ranks.progress = *progress;
    ranks.stop = ranks.stop || status != SP_OK;
    if (status != SP_OK)
        snprintf(ranks.reason, sizeof ranks.reason, "%.511s", err->text);
    ranks.tell[ASK_JOIN] = true;
    pthread_cond_signal(&ranks.wake);
    while (ranks.rank == 0 && !all_joined()) {
        /* as often as the run itself called the watch, not whenever something comes */
        for (double left = 0.25, end = sp_clock_wall() + left; left > 0 && !all_joined(); left = end - sp_clock_wall())
            wait_for(&ranks.changed, left);
        sp_study_progress now = *progress;
        now.seconds = before + sp_clock_wall() - begun;
        pthread_mutex_unlock(&ranks.lock);
        const bool go_on = !watch || watch(&now, user);
        pthread_mutex_lock(&ranks.lock);
        ranks.stop = ranks.stop || !go_on;
    }
    if (ranks.rank == 0) {
        ranks.progress = *progress;
        ranks.progress.seconds = before + sp_clock_wall() - begun;
        *progress = sum();
        status = judge(status, progress, err);
    }
    pthread_mutex_unlock(&ranks.lock);
    return status;
}

int cli_ranks_end(int exit_status) {
    pthread_mutex_lock(&ranks.lock);
    const bool up = ranks.up;
    if (up && ranks.rank == 0) {
        ranks.stop = ranks.stop || !all_joined();
        ranks.exit_status = exit_status;
        ranks.leaves = true;
        fflush(stdout); /* a launcher may end the others, and this one, as soon as one rank has failed */
    } else if (up) {
        ranks.tell[ASK_END] = true;
    }
    if (up)
        pthread_cond_signal(&ranks.wake);
    while (up && !ranks.over)
        pthread_cond_wait(&ranks.changed, &ranks.lock);
    if (up)
        exit_status = ranks.exit_status;
    ranks.up = false;
    pthread_mutex_unlock(&ranks.lock);
    if (up) {
        pthread_join(ranks.thread, NULL);
        sp_free(ranks.other);
    }
    return exit_status;
}
