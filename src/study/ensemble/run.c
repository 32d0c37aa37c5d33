/* Runs a study: several threads, and several processes on one store, make its samples. */
#include "base/base.h"
#include "ensemble/sample.h"

#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <sonopack/study/forecast.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static const double watch_interval = 0.25;         /* seconds between calls of the watch */
static const long another_look = 50 * 1000 * 1000; /* nanoseconds between checks of samples that others have reserved */

/* ---- the order of the samples ----------------------------------------------------------------------------------- */

/* The first seed of every combination comes before any second seed; samples with more work come first, so that no
 * thread has much work left at the end. The memory grows with the number of combinations, not of samples. */
typedef struct order {
    int64_t count, combinations; /* samples of the study; combinations of swept values */
    int64_t *longest;            /* [combinations], the most expensive first */
    double *cost;                /* [combinations] expected work, in an arbitrary unit */
    int64_t shard_count;         /* samples of the shard */
    double shard_cost;
} order;

static void order_free(order *o) {
    sp_free(o->longest);
    sp_free(o->cost);
    *o = (order){0};
}

/* Number of the sample at a place, 0 <= place < count; negative if it belongs to another shard. */
static int64_t order_sample(const order *o, int64_t place, int shard, int shards) {
    const int64_t round = place / o->combinations;
    const int64_t number = round * o->combinations + o->longest[place % o->combinations];
    return number % shards == shard - 1 ? number : -1;
}

static double order_cost(const order *o, int64_t number) { return o->cost[number % o->combinations]; }

typedef struct ranked {
    int64_t combination;
    double cost;
} ranked;

static int by_falling_cost(const void *a, const void *b) {
    const ranked *p = a, *q = b;
    if (p->cost > q->cost || p->cost < q->cost)
        return p->cost > q->cost ? -1 : 1;
    return p->combination < q->combination ? -1 : p->combination > q->combination;
}

/* CPU seconds of a sample on the machine of the laws: only ratios matter here. */
static double expected_cost(const sp_scene *scene) {
    const sp_machine machine = sp_machine_reference();
    return sp_sample_expect(scene, &machine);
}

static sp_status rank_combinations(const sp_scene *study, order *o, sp_error *err) {
    ranked *all = sp_alloc((size_t)o->combinations, sizeof *all);
    if (!all)
        return sp_fail_memory(err, (size_t)o->combinations * sizeof *all);
    sp_status status = SP_OK;
    for (int64_t c = 0; c < o->combinations && status == SP_OK; c++) {
        sp_scene scene;
        status = sp_study_scene(study, c, &scene, err);
        if (status == SP_OK)
            all[c] = (ranked){c, o->cost[c] = expected_cost(&scene)};
    }
    if (status == SP_OK)
        qsort(all, (size_t)o->combinations, sizeof *all, by_falling_cost);
    for (int64_t c = 0; c < o->combinations; c++)
        o->longest[c] = all[c].combination;
    sp_free(all);
    return status;
}

/* Checks every combination: SP_EINVAL if one is no valid scene. */
static sp_status order_make(const sp_scene *study, int shard, int shards, order *out, sp_error *err) {
    order o = {.count = sp_study_count(study)};
    o.combinations = o.count / study->samples;
    o.longest = sp_alloc((size_t)o.combinations, sizeof *o.longest);
    o.cost = sp_alloc((size_t)o.combinations, sizeof *o.cost);
    sp_status status = SP_OK;
    if (!o.longest || !o.cost)
        status = sp_fail_memory(err, (size_t)o.combinations * (sizeof *o.longest + sizeof *o.cost));
    if (status == SP_OK)
        status = rank_combinations(study, &o, err);
    if (status != SP_OK) {
        order_free(&o);
        return status;
    }
    for (int64_t k = shard - 1; k < o.count; k += shards) {
        o.shard_count++;
        o.shard_cost += order_cost(&o, k);
    }
    *out = o;
    return SP_OK;
}

/* ---- workers ---------------------------------------------------------------------------------------------------- */

typedef struct run {
    const sp_scene *study;
    const sp_study_sink *sink;
    const sp_study_options *options;
    order samples;
    int64_t next; /* first place in the order that is not taken */
    int64_t postponed;
    size_t capacity;   /* of later */
    int64_t rechecked; /* postponed samples that are being checked now */
    int64_t *later;    /* [postponed] samples that another process has reserved */
    atomic_bool stop;
    pthread_mutex_t lock;  /* guards the sink and the other members */
    pthread_mutex_t takes; /* guards options->take */
    pthread_cond_t left;   /* a worker has ended */
    int working;
    sp_study_progress progress;
    double begun;
    sp_status status; /* of the first error that stopped the run */
    sp_error error;
} run;

/* Stops the run for a reason that is not one of a sample. The caller holds the lock. */
static void stop_run(run *r, sp_status status, const sp_error *reason) {
    if (r->status == SP_OK) {
        r->status = status;
        r->error = *reason;
    }
    atomic_store(&r->stop, true);
}

/* Counts a finished sample. The caller holds the lock. */
static void count_done(run *r, int64_t number, bool computed, bool failed) {
    const double cost = order_cost(&r->samples, number);
    r->progress.done++;
    r->progress.computed += computed;
    r->progress.failed += failed;
    r->progress.cost_done += cost;
    if (computed)
        r->progress.cost_computed += cost;
}

/* A sample that is being made. */
typedef struct job {
    int64_t number; /* in the study */
    sp_scene scene;
    sp_packing packing;
    sp_sample sample;
    sp_sample_arrays arrays;
    bool make; /* it is to be made by this thread, and is not yet */
    bool claimed;
    bool stored;    /* the sink has its packing */
    unsigned parts; /* that the sink has */
} job;

/* Samples that are made by one thread: one, or all that differ in packing.stages alone, for the packings of the others
 * lie on the way of the last one. */
typedef struct group {
    run *r;
    int64_t first, stride; /* number of the first sample; from one to the next */
    int count, last;       /* last: the one with the most stages */
    job *job;
} group;

/* The group of a sample. Where other processes make a part of the samples, each is alone. */
static group group_of(run *r, int64_t number) {
    const sp_scene *study = r->study;
    group g = {.r = r, .first = number, .stride = 1, .count = 1};
    for (int s = study->sweeps - 1; s >= 0 && r->options->shards == 1; s--) {
        const sp_sweep *sweep = &study->sweep[s];
        if (strcmp(sweep->key, "packing.stages") == 0) {
            g.count = sweep->count;
            g.first -= number % r->samples.combinations / g.stride % g.count * g.stride;
            for (int k = 1; k < g.count; k++) /* 0 stands for all */
                if (sweep->values[g.last] > 0 && !(sweep->values[k] > 0 && sweep->values[k] < sweep->values[g.last]))
                    g.last = k;
            break;
        }
        g.stride *= sweep->count;
    }
    return g;
}

static bool go_on(const sp_pack_progress *progress, void *user) {
    (void)progress;
    const group *g = user;
    return !atomic_load(&g->r->stop);
}

static sp_stored look(const run *r, const job *j) {
    const sp_study_sink *sink = r->sink;
    return sink->has ? sink->has(sink->user, &j->scene, j->sample.name) : SP_STORED_NOT;
}

/* Postpones a sample to the end. By then the other process has made it, or has ended. */
static sp_status postpone(run *r, int64_t number, sp_error *err) {
    int64_t *later = sp_grow(r->later, (size_t)r->postponed + 1, &r->capacity, sizeof *later);
    if (!later)
        return sp_fail_memory(err, (size_t)r->postponed * sizeof *later);
    r->later = later;
    r->later[r->postponed++] = number;
    return SP_OK;
}

/* Asks the sink for the sample. *make: this thread has to make it. The second look finds what another process made
 * before this one got the claim. A file that cannot be read is made again, and so are parts that the scene now
 * describes differently. */
static sp_status take_stored(run *r, job *j, bool *make, bool *postponed, sp_error *err) {
    const sp_study_sink *sink = r->sink;
    sp_status status = SP_OK;
    sp_stored stored = look(r, j);
    if (stored == SP_STORED_NOT && sink->claim) {
        status = sink->claim(sink->user, j->sample.name, &j->claimed, err);
        *postponed = status == SP_OK && !j->claimed;
        if (*postponed)
            return postpone(r, j->number, err);
        if (status == SP_OK)
            stored = look(r, j);
    }
    if (status == SP_OK && stored != SP_STORED_NOT)
        count_done(r, j->number, false, stored == SP_STORED_FAILED);
    *make = status == SP_OK && stored == SP_STORED_NOT;
    if (!*make || !sink->load)
        return status;
    status = sink->load(sink->user, j->sample.name, &j->packing, &j->sample, &j->stored, err);
    if (j->stored) {
        j->parts = sp_sample_parts(&j->scene, &j->sample);
        j->sample.have = j->parts;
    }
    return status == SP_EFORMAT ? SP_OK : status;
}

/* Saves a sample. If its packing failed, it is saved as failed. If only a part of the results failed, the packing and
 * the other parts are saved with the reason, for studies that do not want that part. */
static sp_status save(run *r, job *j, sp_error *err) {
    const bool made = j->packing.n > 0;
    sp_sample sample = j->sample;
    sample.lacks = 0;
    if (made && sample.failed) {
        sample.failed = false;
        sample.lacks = sp_want_parts(j->scene.want) & ~sample.have;
        sample.lacks_signal = sp_signal_keys(&j->scene);
    } else if (made) {
        sample.reason[0] = '\0';
    }
    if (made && j->stored && sample.have == j->parts && sample.lacks == 0)
        return SP_OK; /* nothing new */
    return r->sink->save(r->sink->user, &j->scene, &sample, made ? &j->packing : NULL, &j->arrays, err);
}

/* Takes a sample up: whether it is stored, or another process makes it. */
static void take(run *r, job *j, bool *postponed) {
    sp_error reason = {0};
    sp_status status = sp_study_sample(r->study, j->number, &j->scene, j->sample.name, &reason);
    pthread_mutex_lock(&r->lock);
    if (status == SP_OK)
        status = take_stored(r, j, &j->make, postponed, &reason);
    if (status != SP_OK)
        stop_run(r, status, &reason);
    pthread_mutex_unlock(&r->lock);
    j->make = j->make && status == SP_OK;
}

/* Saves and counts a sample that was made, or failed. */
static void finish(run *r, job *j, sp_status status, sp_error *reason) {
    pthread_mutex_lock(&r->lock);
    if (status == SP_OK || j->sample.failed)
        status = save(r, j, reason);
    if (status == SP_OK)
        count_done(r, j->number, true, j->sample.failed);
    else if (status != SP_EINTERRUPTED)
        stop_run(r, status, reason);
    pthread_mutex_unlock(&r->lock);
    j->make = false;
}

static void make(group *g, job *j, sp_status (*stage)(const sp_packing *, int32_t, void *, sp_error *)) {
    const sp_study_options *o = g->r->options;
    const sp_pack_hooks hooks = {
        .watch = go_on, .user = g, .threads = o->jobs == 1 ? o->threads : 1, .from = o->from, .stage = stage};
    sp_error reason = {0};
    const sp_status status =
        sp_sample_make_with(&j->scene, j->scene.want, &hooks, &j->packing, &j->sample, &j->arrays, &reason);
    finish(g->r, j, status, &reason);
}

/* Makes the samples whose packing this is. It stays the caller's. */
static sp_status make_on_the_way(const sp_packing *packing, int32_t index, void *user, sp_error *err) {
    group *g = user;
    (void)err;
    for (job *j = g->job; j < g->job + g->count; j++) {
        if (!j->make || sp_pack_stages(&j->scene.pack) != index + 1)
            continue;
        j->packing = *packing;
        j->packing.scene = NULL;
        make(g, j, NULL);
        sp_free(j->packing.scene);
        j->packing = sp_packing_none();
    }
    return SP_OK;
}

/* The unmade sample with the most stages. */
static job *longest(const group *g) {
    job *most = NULL;
    for (job *j = g->job; j < g->job + g->count; j++)
        if (j->make && (!most || sp_pack_stages(&j->scene.pack) > sp_pack_stages(&most->scene.pack)))
            most = j;
    return most;
}

/* Makes what is not stored of the group. What comes after a failure on the way fails for the same reason. */
static void make_group(group *g) {
    job *j;
    for (j = g->job; j < g->job + g->count; j++)
        if (j->make && j->packing.n > 0)
            make(g, j, NULL);
    while (!atomic_load(&g->r->stop) && (j = longest(g))) {
        make(g, j, g->count > 1 ? make_on_the_way : NULL);
        for (job *late = g->job; j->sample.failed && j->packing.n == 0 && late < g->job + g->count; late++)
            if (late->make) {
                sp_error reason = {0};
                sp_sample_describe(&late->scene, &late->sample, NULL);
                late->sample.failed = true;
                memcpy(late->sample.reason, j->sample.reason, sizeof j->sample.reason);
                finish(g->r, late, SP_OK, &reason);
            }
    }
}

/* Makes the samples of a group. False if another process has reserved one; it is then postponed, perhaps again. */
static bool run_group(group *g) {
    run *r = g->r;
    bool postponed = false;
    g->job = sp_alloc((size_t)g->count, sizeof *g->job);
    if (!g->job) {
        sp_error reason = {0};
        pthread_mutex_lock(&r->lock);
        stop_run(r, sp_fail_memory(&reason, (size_t)g->count * sizeof *g->job), &reason);
        pthread_mutex_unlock(&r->lock);
        return true;
    }
    for (int k = 0; k < g->count; k++) {
        g->job[k] = (job){.number = g->first + k * g->stride,
                          .packing = sp_packing_none(),
                          .arrays = sp_sample_arrays_none(),
                          .sample.height = NAN};
        take(r, &g->job[k], &postponed);
    }
    make_group(g);
    pthread_mutex_lock(&r->lock);
    for (int k = 0; k < g->count; k++)
        if (g->job[k].claimed)
            r->sink->release(r->sink->user, g->job[k].sample.name);
    pthread_mutex_unlock(&r->lock);
    for (int k = 0; k < g->count; k++) {
        sp_packing_free(&g->job[k].packing);
        sp_sample_arrays_free(&g->job[k].arrays);
    }
    sp_free(g->job);
    return !postponed;
}

/* Number of the next sample, negative when all are taken. The order is that of this process, or shared by all. */
static int64_t take_next(run *r) {
    const sp_study_options *o = r->options;
    int64_t number = -1;
    pthread_mutex_lock(o->take ? &r->takes : &r->lock);
    do {
        const int64_t place = o->take ? o->take(o->take_user) : r->next++;
        if (place < 0 || place >= r->samples.count)
            break;
        number = order_sample(&r->samples, place, o->shard, o->shards);
    } while (number < 0);
    pthread_mutex_unlock(o->take ? &r->takes : &r->lock);
    return number;
}

/* The postponed sample that has waited longest; negative if there is none. */
static int64_t take_postponed(run *r) {
    int64_t number = -1;
    pthread_mutex_lock(&r->lock);
    if (r->postponed > 0) {
        number = r->later[0];
        memmove(r->later, r->later + 1, (size_t)--r->postponed * sizeof *r->later);
        r->rechecked++;
    }
    pthread_mutex_unlock(&r->lock);
    return number;
}

static void *work(void *user) {
    run *r = user;
    int64_t number;
    while (!atomic_load(&r->stop) && (number = take_next(r)) >= 0) {
        group g = group_of(r, number);
        if (number == g.first + g.last * g.stride)
            run_group(&g);
    }
    while (!atomic_load(&r->stop) && (number = take_postponed(r)) >= 0) {
        const struct timespec wait = {.tv_nsec = another_look};
        group alone = {.r = r, .first = number, .stride = 1, .count = 1};
        if (!run_group(&alone)) /* the next one is probably not free yet either */
            nanosleep(&wait, NULL);
        pthread_mutex_lock(&r->lock);
        r->rechecked--;
        pthread_mutex_unlock(&r->lock);
    }
    pthread_mutex_lock(&r->lock);
    r->working--;
    pthread_cond_signal(&r->left);
    pthread_mutex_unlock(&r->lock);
    return NULL;
}

/* The progress at this moment. The caller holds the lock. */
static sp_study_progress now(const run *r) {
    sp_study_progress p = r->progress;
    p.elsewhere = r->postponed + r->rechecked;
    p.seconds = sp_clock_wall() - r->begun;
    p.seconds_left = NAN;
    if (p.cost_computed > 0 &&
        (p.done + p.elsewhere < p.total || p.elsewhere == 0)) /* else it depends on other processes */
        p.seconds_left = p.done < p.total ? p.seconds * (p.cost - p.cost_done) / p.cost_computed : 0;
    return p;
}

/* Waits for the workers, and calls the watch, which may stop them. */
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
        sp_study_progress p = now(r);
        pthread_mutex_unlock(&r->lock);
        if (!watch(&p, user))
            atomic_store(&r->stop, true);
        pthread_mutex_lock(&r->lock);
    }
    sp_study_progress last = now(r);
    pthread_mutex_unlock(&r->lock);
    if (watch)
        watch(&last, user);
}

/* Starts the workers, waits for them, and joins them. They block all signals, which are for the threads of the caller.
 */
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
    r->working = started; /* set before any worker can decrement it, because the lock is held */
    pthread_mutex_unlock(&r->lock);
    pthread_sigmask(SIG_SETMASK, &old, NULL);
    if (started > 0)
        wait_for_workers(r, watch, user);
    for (int k = 0; k < started; k++)
        pthread_join(thread[k], NULL);
    sp_free(thread);
    return started > 0 ? SP_OK : sp_fail(err, SP_EFAILED, "no thread could be started, of %d wanted", jobs);
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

static void make_locks(run *r) {
    pthread_condattr_t attributes;
    pthread_condattr_init(&attributes);
    pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC);
    pthread_mutex_init(&r->lock, NULL);
    pthread_mutex_init(&r->takes, NULL);
    pthread_cond_init(&r->left, &attributes);
    pthread_condattr_destroy(&attributes);
}

sp_status sp_study_run(const sp_scene *scene, const sp_study_options *opt, const sp_study_sink *sink,
                       sp_study_watch watch, void *user, sp_study_progress *out, sp_error *err) {
    sp_status status = check(scene, opt, sink, err);
    if (status != SP_OK)
        return status;
    run r = {.study = scene, .sink = sink, .options = opt, .begun = sp_clock_wall()};
    make_locks(&r);
    status = order_make(scene, opt->shard, opt->shards, &r.samples, err);
    if (status == SP_OK) {
        r.progress.total = r.samples.shard_count;
        r.progress.cost = r.samples.shard_cost;
        if (r.progress.total > 0)
            status =
                run_workers(&r, opt->jobs < r.progress.total ? opt->jobs : (int)r.progress.total, watch, user, err);
    }
    if (status == SP_OK && r.status != SP_OK) {
        status = r.status;
        if (err)
            *err = r.error;
    } else if (status == SP_OK && atomic_load(&r.stop) && r.progress.done < r.progress.total) {
        status = sp_fail(err, SP_EINTERRUPTED, "stopped with %lld of %lld samples done", (long long)r.progress.done,
                         (long long)r.progress.total);
    }
    if (out)
        *out = now(&r);
    pthread_cond_destroy(&r.left);
    pthread_mutex_destroy(&r.takes);
    pthread_mutex_destroy(&r.lock);
    order_free(&r.samples);
    sp_free(r.later);
    return status;
}
