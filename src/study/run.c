#include "base/base.h"
#include "study/sample.h"

#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static const double watch_interval = 0.25; /* seconds between two calls of the watch */

/* One sample to do. */
typedef struct task {
    int64_t number; /* in the study */
    int64_t round;  /* which seed of its combination */
    double cost;    /* expected, in arbitrary units */
} task;

typedef struct run {
    const sp_scene *study;
    const sp_study_sink *sink;
    const sp_study_options *options;
    int64_t tasks;
    task *task;
    atomic_int_fast64_t next; /* first task that nobody has taken */
    atomic_bool stop;
    pthread_mutex_t lock; /* of the sink and of all below */
    pthread_cond_t left;  /* a worker has ended */
    int working;
    sp_study_progress progress;
    double begun, cost_left, cost_computed;
    sp_status status; /* of the first error that stopped the run */
    sp_error error;
} run;

static bool go_on(const sp_pack_progress *progress, void *user) {
    (void)progress;
    run *r = user;
    return !atomic_load(&r->stop);
}

/* The run ends for a reason that is no sample's own. Under the lock. */
static void stop_run(run *r, sp_status status, const sp_error *reason) {
    if (r->status == SP_OK) {
        r->status = status;
        r->error = *reason;
    }
    atomic_store(&r->stop, true);
}

/* A sample is there: counted, under the lock. */
static void count_done(run *r, const task *t, bool computed, bool failed) {
    r->progress.done++;
    r->progress.computed += computed;
    r->progress.failed += failed;
    r->cost_left -= t->cost;
    if (computed)
        r->cost_computed += t->cost;
}

/* One sample on its way. */
typedef struct job {
    sp_scene scene;
    sp_packing packing;
    sp_sample sample;
    sp_signal signal;
    bool done;   /* the sink has all of it */
    bool stored; /* the sink has its packing, and of the parts: */
    unsigned parts;
} job;

/* What the sink has. A stored file that cannot be read is made again, and so are parts that the scene now describes
 * otherwise. */
static sp_status take_stored(run *r, job *j, sp_error *err) {
    const sp_study_sink *sink = r->sink;
    const unsigned want = sp_want_parts(j->scene.want), described = SP_WANT_SIGNAL | SP_WANT_PLANES;
    sp_status status = SP_OK;
    j->done = sink->has && sink->has(sink->user, j->sample.name, want);
    if (!sink->load || (j->done && !(want & described)))
        return SP_OK;
    status = sink->load(sink->user, j->sample.name, &j->packing, &j->sample, &j->stored, err);
    if (j->stored) {
        j->parts = sp_sample_parts(&j->scene, &j->sample);
        j->sample.have = j->parts;
        j->done = j->done && (want & ~j->parts) == 0;
    }
    return status == SP_EFORMAT ? SP_OK : status;
}

/* A sample whose packing failed is saved as failed. Where only a part of the results failed, the packing and the other
 * parts are saved: a study that does not want that part shall find them, one that does will try it again. */
static sp_status save(run *r, job *j, sp_error *err) {
    const bool made = j->packing.n > 0;
    sp_sample sample = j->sample;
    if (made && j->stored && sample.have == j->parts)
        return SP_OK; /* nothing new */
    if (made) {
        sample.failed = false;
        sample.reason[0] = '\0';
    }
    return r->sink->save(r->sink->user, &j->scene, &sample, made ? &j->packing : NULL,
                         j->signal.n > 0 ? &j->signal : NULL, err);
}

static void run_task(run *r, const task *t) {
    job j = {.packing = sp_packing_none(), .signal = sp_signal_none(), .sample.height = NAN};
    sp_error reason = {0};
    sp_status status = sp_study_scene(r->study, t->number, &j.scene, &reason);
    if (status == SP_OK) {
        sp_sample_name(&j.scene, j.sample.name);
        if (j.sample.name[0] == '\0')
            status = sp_fail_memory(&reason, 4096);
    }
    pthread_mutex_lock(&r->lock);
    if (status == SP_OK)
        status = take_stored(r, &j, &reason);
    if (status != SP_OK)
        stop_run(r, status, &reason);
    else if (j.done)
        count_done(r, t, false, false);
    pthread_mutex_unlock(&r->lock);
    if (status != SP_OK || j.done)
        goto out;

    const sp_study_options *o = r->options;
    const sp_pack_hooks hooks = {.watch = go_on, .user = r, .threads = o->jobs == 1 ? o->threads : 1, .from = o->from};
    status = sp_sample_make_with(&j.scene, j.scene.want, &hooks, &j.packing, &j.sample, &j.signal, &reason);

    pthread_mutex_lock(&r->lock);
    if (status == SP_OK || j.sample.failed)
        status = save(r, &j, &reason);
    if (status == SP_OK)
        count_done(r, t, true, j.sample.failed);
    else if (status != SP_EINTERRUPTED)
        stop_run(r, status, &reason);
    pthread_mutex_unlock(&r->lock);
out:
    sp_packing_free(&j.packing);
    sp_signal_free(&j.signal);
}

static void *work(void *user) {
    run *r = user;
    while (!atomic_load(&r->stop)) {
        int64_t k = (int64_t)atomic_fetch_add(&r->next, 1);
        if (k >= r->tasks)
            break;
        run_task(r, &r->task[k]);
    }
    pthread_mutex_lock(&r->lock);
    r->working--;
    pthread_cond_signal(&r->left);
    pthread_mutex_unlock(&r->lock);
    return NULL;
}

/* The numbers as they are now; under the lock. */
static sp_study_progress look(const run *r) {
    sp_study_progress now = r->progress;
    now.seconds = sp_clock_wall() - r->begun;
    now.seconds_left = NAN;
    if (r->cost_computed > 0)
        now.seconds_left = now.done < now.total ? now.seconds * r->cost_left / r->cost_computed : 0;
    return now;
}

/* Waits for the workers, calling the watch, which may ask to stop. */
static void wait_for_workers(run *r, sp_study_watch watch, void *user) {
    pthread_mutex_lock(&r->lock);
    while (r->working > 0) {
        struct timespec until;
        clock_gettime(CLOCK_MONOTONIC, &until);
        until.tv_nsec += (long)(1e9 * watch_interval);
        until.tv_sec += until.tv_nsec / 1000000000;
        until.tv_nsec %= 1000000000;
        pthread_cond_timedwait(&r->left, &r->lock, &until);
        if (!watch)
            continue;
        sp_study_progress now = look(r);
        pthread_mutex_unlock(&r->lock);
        if (!watch(&now, user))
            atomic_store(&r->stop, true);
        pthread_mutex_lock(&r->lock);
    }
    sp_study_progress last = look(r);
    pthread_mutex_unlock(&r->lock);
    if (watch)
        watch(&last, user);
}

/* Starts the workers, waits, and joins them. Signals are for the caller's threads, not for the workers. */
static sp_status run_workers(run *r, int jobs, sp_study_watch watch, void *user, sp_error *err) {
    pthread_t *thread = sp_alloc((size_t)jobs, sizeof *thread);
    if (!thread)
        return sp_fail_memory(err, (size_t)jobs * sizeof *thread);
    sigset_t all, old;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &old);
    int started = 0;
    pthread_mutex_lock(&r->lock);
    while (started < jobs && pthread_create(&thread[started], NULL, work, r) == 0)
        started++;
    r->working = started; /* known before any worker can count itself out: the lock is held */
    pthread_mutex_unlock(&r->lock);
    pthread_sigmask(SIG_SETMASK, &old, NULL);
    if (started > 0)
        wait_for_workers(r, watch, user);
    for (int k = 0; k < started; k++)
        pthread_join(thread[k], NULL);
    sp_free(thread);
    return started > 0 ? SP_OK : sp_fail(err, SP_EFAILED, "no thread could be started, of %d wanted", jobs);
}

/* First seeds first; among equals the longest work first, so that no thread is left with it at the end. */
static int by_round_and_cost(const void *a, const void *b) {
    const task *p = a, *q = b;
    if (p->round != q->round)
        return p->round < q->round ? -1 : 1;
    if (p->cost > q->cost || p->cost < q->cost)
        return p->cost > q->cost ? -1 : 1;
    return p->number < q->number ? -1 : p->number > q->number;
}

/* The samples of this shard, in the order in which they are taken. Every combination is checked before any work. */
static sp_status list_tasks(run *r, const sp_study_options *opt, sp_error *err) {
    int64_t count = sp_study_count(r->study), rounds = r->study->samples, combinations = count / rounds;
    size_t most = (size_t)(count / opt->shards + 1);
    r->task = sp_alloc(most, sizeof *r->task);
    double *cost = sp_alloc((size_t)combinations, sizeof *cost);
    sp_status status = SP_OK;
    if (!r->task || !cost) {
        status = sp_fail_memory(err, most * sizeof *r->task + (size_t)combinations * sizeof *cost);
        goto out;
    }
    for (int64_t c = 0; c < combinations && status == SP_OK; c++) {
        sp_scene scene;
        status = sp_study_scene(r->study, c, &scene, err);
        /* measured: N^1.6, and p^-0.2 between 1e-4 and 1e-7 */
        if (status == SP_OK)
            cost[c] = pow((double)scene.pack.grains, 1.6) * pow(scene.pack.pressure, -0.2);
    }
    if (status != SP_OK)
        goto out;
    for (int64_t k = opt->shard - 1; k < count; k += opt->shards) {
        r->task[r->tasks++] = (task){.number = k, .round = k / combinations, .cost = cost[k % combinations]};
        r->cost_left += cost[k % combinations];
    }
    qsort(r->task, (size_t)r->tasks, sizeof *r->task, by_round_and_cost);
    r->progress.total = r->tasks;
out:
    sp_free(cost);
    return status;
}

static sp_status check(const sp_scene *scene, const sp_study_options *opt, const sp_study_sink *sink, sp_error *err) {
    if (opt->jobs < 1 || opt->jobs > 4096)
        return sp_fail(err, SP_EINVAL, "jobs = %d: 1 to 4096 threads", opt->jobs);
    if (opt->shards < 1 || opt->shard < 1 || opt->shard > opt->shards)
        return sp_fail(err, SP_EINVAL, "shard %d/%d: I/N with 1 <= I <= N", opt->shard, opt->shards);
    if (!sink || !sink->save)
        return sp_fail(err, SP_EINVAL, "study: nowhere to save samples");
    if (scene->samples < 1)
        return sp_fail(err, SP_EINVAL, "study.samples = %d: at least 1", scene->samples);
    if (sp_study_count(scene) < 1)
        return sp_fail(err, SP_EINVAL, "study.sweep: a sweep without values, or more than 2^63 samples");
    return SP_OK;
}

sp_status sp_study_run(const sp_scene *scene, const sp_study_options *opt, const sp_study_sink *sink,
                       sp_study_watch watch, void *user, sp_study_progress *out, sp_error *err) {
    sp_status status = check(scene, opt, sink, err);
    if (status != SP_OK)
        return status;
    run r = {.study = scene, .sink = sink, .options = opt, .begun = sp_clock_wall()};
    pthread_condattr_t attributes;
    pthread_condattr_init(&attributes);
    pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC);
    pthread_mutex_init(&r.lock, NULL);
    pthread_cond_init(&r.left, &attributes);
    pthread_condattr_destroy(&attributes);
    status = list_tasks(&r, opt, err);
    if (status == SP_OK && r.tasks > 0)
        status = run_workers(&r, opt->jobs < r.tasks ? opt->jobs : (int)r.tasks, watch, user, err);
    if (status == SP_OK && r.status != SP_OK) {
        status = r.status;
        if (err)
            *err = r.error;
    } else if (status == SP_OK && r.progress.done < r.progress.total) {
        status = sp_fail(err, SP_EINTERRUPTED, "stopped with %lld of %lld samples done", (long long)r.progress.done,
                         (long long)r.progress.total);
    }
    if (out)
        *out = look(&r);
    pthread_cond_destroy(&r.left);
    pthread_mutex_destroy(&r.lock);
    sp_free(r.task);
    return status;
}
