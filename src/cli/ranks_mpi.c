/* Shares a study among the ranks of an MPI job.
 *
 * A thread of each process makes all MPI calls, and polls for messages instead of waiting for them. So a worker never
 * waits for a sample that another one computes, rank 0 answers while it computes samples itself, and ranks that wait
 * for the last sample sleep. This needs only MPI_THREAD_FUNNELED and plain messages; one-sided operations would need
 * the progress of the target process on many networks. */
#include "cli/ranks.h"

#include "base/base.h"

#include <math.h>
#include <mpi.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* From another rank to rank 0: asks for a sample, reports progress, has no more samples, or is about to exit. */
typedef enum request_kind { REQUEST_NUMBER = 1, REPORT_PROGRESS, REPORT_JOINED, REPORT_END } request_kind;
typedef struct request {
    request_kind kind;
    bool stop;
    sp_status status;
    uint64_t study; /* hash of what it computes */
    sp_study_progress progress;
    char reason[512];
} request;

/* From rank 0 to another rank. */
typedef enum answer_kind { ANSWER_NUMBER = 1, ANSWER_STOP, ANSWER_LEAVE } answer_kind;
typedef struct answer {
    answer_kind kind;
    int exit_status;
    int64_t number;
} answer;

/* What rank 0 knows of another rank. */
typedef struct other {
    bool waits; /* for the number of a sample */
    bool joined, ended;
    uint64_t study;
    sp_status status;
    sp_study_progress progress;
    char reason[512];
} other;

static struct {
    pthread_t thread;
    pthread_mutex_t lock;   /* of all members below */
    pthread_cond_t changed; /* signalled when a message has changed something */
    pthread_cond_t wake;    /* signalled when there is something to send */
    bool up, over;          /* MPI has started; the thread is to end */
    int rank, size;
    pid_t launcher;
    /* this rank */
    uint64_t study;               /* 0: not known yet */
    bool pending[REPORT_END + 1]; /* requests to be sent */
    bool waits, stop, leaves;
    int64_t number;
    int exit_status;
    sp_status status;
    sp_study_progress progress;
    char reason[512];
    /* rank 0 */
    bool stop_sent;
    int64_t next;
    other *other; /* [size] */
} ranks = {.lock = PTHREAD_MUTEX_INITIALIZER};

static const double busy_time = 2e-3; /* for so long after a message, the thread polls quickly [s] */

static void send_request(request_kind kind) {
    request q = {
        .kind = kind, .stop = ranks.stop, .status = ranks.status, .study = ranks.study, .progress = ranks.progress};
    snprintf(q.reason, sizeof q.reason, "%s", ranks.reason);
    MPI_Send(&q, (int)sizeof q, MPI_BYTE, 0, 0, MPI_COMM_WORLD);
}

static void send_answer(int rank, answer a) { MPI_Send(&a, (int)sizeof a, MPI_BYTE, rank, 0, MPI_COMM_WORLD); }

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

static void handle(int from, const request *q) {
    other *o = &ranks.other[from];
    o->study = q->study;
    o->progress = q->progress;
    o->waits = o->waits || q->kind == REQUEST_NUMBER;
    if (q->kind == REPORT_JOINED)
        o->joined = true;
    if (q->kind == REPORT_JOINED && o->status == SP_OK) { /* else it was stopped because it computes another study */
        o->status = q->status;
        memcpy(o->reason, q->reason, sizeof o->reason);
    }
    if (q->kind == REPORT_END)
        o->joined = o->ended = true;
    if (q->stop || o->status != SP_OK)
        ranks.stop = true;
}

/* Stops if a rank computes another study: it would take numbers whose samples nobody computes here. */
static void compare_study(int rank) {
    other *o = &ranks.other[rank];
    if (ranks.stop || o->study == ranks.study)
        return;
    o->status = SP_EINVAL;
    snprintf(o->reason, sizeof o->reason,
             "has another scene, store or --shard than rank 0: all ranks must be started with the same study");
    ranks.stop = true;
}

/* Rank 0: receives and answers requests, and tells the others when to stop and when to exit. */
static bool run_rank_zero(void) {
    request q;
    int from;
    bool came = false, ended = true;
    while (receive(&q, sizeof q, &from)) {
        handle(from, &q);
        came = true;
    }
    for (int k = 1; k < ranks.size; k++) {
        other *o = &ranks.other[k];
        ended = ended && o->ended;
        if (!o->waits || (!ranks.study && !ranks.stop))
            continue;
        compare_study(k);
        send_answer(k, (answer){.kind = ANSWER_NUMBER, .number = ranks.stop ? -1 : ranks.next++});
        o->waits = false;
    }
    if (ranks.stop && !ranks.stop_sent) {
        ranks.stop_sent = true;
        for (int k = 1; k < ranks.size; k++)
            if (!ranks.other[k].ended)
                send_answer(k, (answer){.kind = ANSWER_STOP});
    }
    if (ranks.leaves && ended) {
        for (int k = 1; k < ranks.size; k++)
            send_answer(k, (answer){.kind = ANSWER_LEAVE, .exit_status = ranks.exit_status});
        ranks.over = true;
    }
    return came;
}

/* Other ranks: send pending requests, and receive answers. */
static bool run_other_rank(void) {
    answer a;
    int from;
    bool came = false;
    for (request_kind kind = REQUEST_NUMBER; kind <= REPORT_END; kind++) {
        if (ranks.pending[kind])
            send_request(kind);
        ranks.pending[kind] = false;
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

/* The thread that makes all MPI calls. Rank 0 polls often, because others wait for it; the others receive nothing
 * unasked except a stop. */
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
        const bool came = ranks.rank == 0 ? run_rank_zero() : run_other_rank();
        if (came)
            last = sp_clock_wall();
        if (came || ranks.stop != stopped)
            pthread_cond_broadcast(&ranks.changed);
        stopped = ranks.stop;
        if (!ranks.over)
            wait_for(&ranks.wake, sp_clock_wall() - last < busy_time ? 50e-6 : idle);
    }
    pthread_cond_broadcast(&ranks.changed);
    pthread_mutex_unlock(&ranks.lock);
    MPI_Finalize();
    return NULL;
}

/* The number of the next sample, or -1. Workers call it one at a time. */
static int64_t take(void *nothing) {
    (void)nothing;
    pthread_mutex_lock(&ranks.lock);
    int64_t number = -1;
    if (ranks.rank > 0 && !ranks.stop) {
        ranks.waits = ranks.pending[REQUEST_NUMBER] = true;
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

/* For exits elsewhere, such as after a wrong option. */
static void leave(int status, void *nothing) {
    (void)nothing;
    cli_ranks_end(status);
}

sp_status cli_ranks_start(cli_ranks *out, sp_error *err) {
    *out = (cli_ranks){.size = 1, .mpi = true};
    if (!cli_launch_of_environment().mpi)
        return SP_OK;
    pthread_condattr_t attributes;
    pthread_condattr_init(&attributes);
    pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC);
    pthread_cond_init(&ranks.changed, &attributes);
    pthread_cond_init(&ranks.wake, &attributes);
    pthread_condattr_destroy(&attributes);
    ranks.launcher = getppid();
    sigset_t all, old; /* the calling thread handles signals */
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &old);
    const bool started = pthread_create(&ranks.thread, NULL, serve, NULL) == 0;
    pthread_sigmask(SIG_SETMASK, &old, NULL);
    if (!started)
        return sp_fail(err, SP_EFAILED, "no thread could be started for MPI");
    pthread_mutex_lock(&ranks.lock);
    while (!ranks.up)
        pthread_cond_wait(&ranks.changed, &ranks.lock);
    *out = (cli_ranks){.rank = ranks.rank, .size = ranks.size, .mpi = true, .take = ranks.size > 1 ? take : NULL};
    pthread_mutex_unlock(&ranks.lock);
    on_exit(leave, NULL);
    return SP_OK;
}

void cli_ranks_begin(const char *what) {
    pthread_mutex_lock(&ranks.lock);
    ranks.study = sp_hash64(SP_HASH64_BEGIN, what, strlen(what)) | 1; /* 0: not known yet */
    pthread_mutex_unlock(&ranks.lock);
}

/* The progress of all ranks, as of their last reports. On rank 0, with the lock held. */
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
        ranks.pending[REPORT_PROGRESS] = true;
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

/* The status of the whole study: the failure of this rank, else of another one, else an interruption. */
static sp_status overall(sp_status status, const sp_study_progress *all, sp_error *err) {
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
    ranks.pending[REPORT_JOINED] = true;
    pthread_cond_signal(&ranks.wake);
    while (ranks.rank == 0 && !all_joined()) {
        /* calls the watch as often as the run did, not after every message */
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
        status = overall(status, progress, err);
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
        fflush(stdout); /* a launcher may end all ranks as soon as one has failed */
    } else if (up) {
        ranks.pending[REPORT_END] = true;
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
