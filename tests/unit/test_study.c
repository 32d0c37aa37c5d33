#include "base/base.h"
#include "ensemble/sample.h"
#include "test.h"

#include <pthread.h>
#include <sonopack/study/store.h>
#include <sonopack/study/study.h>
#include <stdatomic.h>
#include <unistd.h>

/* ---- scenes ------------------------------------------------------------------------------------------------------ */

static sp_scene parse(const char *text) {
    sp_scene scene;
    assert_ok(sp_scene_parse(text, "test", 0, NULL, &scene, &err));
    return scene;
}

/* Chains: made in no time, with an exact front. */
static const char chains[] = "packing = { kind = \"chain\"; grains = 20; friction = 0; seed = 5; };"
                             "study = { samples = 3; want = [\"ctof\"]; sweep = ("
                             "{ key = \"packing.pressure\"; values = [1e-6, 1e-4]; },"
                             "{ key = \"packing.grains\"; values = [10, 20, 30]; } ); };";

TEST(hash_of_known_texts) {
    char name[SP_NAME_MAX];
    sp_hash128("", 0, name); /* the published values of FNV-1a, 128 bits */
    assert_string_equal(name, "6c62272e07bb014262b821756295c58d");
    sp_hash128("a", 1, name);
    assert_string_equal(name, "d228cb696f1a8caf78912b704e4a8964");
    sp_hash128("foobar", 6, name);
    assert_string_equal(name, "343e1662793c64bf6f0d3597ba446f18");
}

TEST(every_combination_has_its_first_seed_first) {
    FREED(sp_scene) study = parse(chains);
    assert_int_equal(sp_study_count(&study), 18);
    const double p[] = {1e-6, 1e-4};
    const int grains[] = {10, 20, 30};
    char name[18][SP_NAME_MAX];
    for (int k = 0; k < 18; k++) {
        sp_scene one;
        assert_ok(sp_study_scene(&study, k, &one, &err));
        assert_int_equal(one.pack.seed, 5 + k / 6);
        assert_true(one.pack.pressure == p[k % 6 / 3]);
        assert_int_equal(one.pack.grains, grains[k % 3]);
        assert_int_equal(one.sweeps, 0);
        assert_int_equal(sp_study_count(&one), 1);
        sp_sample_name(&one, name[k]);
        assert_int_equal(strlen(name[k]), 32);
        for (int i = 0; i < k; i++)
            assert_string_not_equal(name[i], name[k]);
    }
    sp_scene one;
    assert_fails(sp_study_scene(&study, 18, &one, &err), SP_EINVAL, "18");
    assert_fails(sp_study_scene(&study, -1, &one, &err), SP_EINVAL, "-1");
}

TEST(a_name_says_what_decides_the_numbers_and_no_more) {
    static const char *const deciding[] = {
        "packing.grains=21",      "packing.pressure=2e-4",      "packing.seed=6",           "packing.poisson=0.1",
        "packing.tolerance=1e-9", "network.threshold=2e-4",     "network.prestress=true",   "network.sliding_free=true",
        "packing.damping=0.7",    "signal.source=displacement", "packing.time_step=0.0999", "packing.friction=0.1"};
    static const char *const silent[] = {"signal.until=100",  "signal.points=77",  "signal.tolerance=1e-9",
                                         "study.samples=100", "study.want=moduli", "packing.grains=20"};
    FREED(sp_scene) study = parse(chains);
    char own[SP_NAME_MAX], other[SP_NAME_MAX];
    sp_sample_name(&study, own);
    for (int silently = 0; silently < 2; silently++) {
        size_t count = silently ? sizeof silent / sizeof *silent : sizeof deciding / sizeof *deciding;
        for (size_t k = 0; k < count; k++) {
            char set[64];
            snprintf(set, sizeof set, "%s", silently ? silent[k] : deciding[k]);
            char *sets[] = {set};
            FREED(sp_scene) changed;
            assert_ok(sp_scene_parse(chains, "test", 1, sets, &changed, &err));
            sp_sample_name(&changed, other);
            if ((strcmp(own, other) == 0) != silently)
                fail_msg("%s: names %s and %s", set, own, other);
        }
    }
}

/* ---- a sink in memory -------------------------------------------------------------------------------------------- */

enum { ROOM = 64 };

typedef struct shelf {
    int n, saves, loads;
    sp_sample sample[ROOM];
    sp_packing packing[ROOM];
    int signal_points[ROOM];
    int fail_at; /* the save of that number fails, 0: none */
    atomic_int inside;
    atomic_int wrong; /* calls that should not have been: asserts must not fail on a worker's thread */
    bool broken;      /* load says that files are damaged */
} shelf;

static void enter(shelf *s) {
    s->wrong += atomic_fetch_add(&s->inside, 1) != 0; /* one call at a time */
    usleep(100);
}

static void leave(shelf *s) { atomic_fetch_sub(&s->inside, 1); }

static int find(const shelf *s, const char *name) {
    for (int k = 0; k < s->n; k++)
        if (strcmp(s->sample[k].name, name) == 0)
            return k;
    return -1;
}

static sp_stored shelf_has(void *user, const sp_scene *scene, const char *name) {
    shelf *s = user;
    enter(s);
    int k = find(s, name);
    sp_stored has = !s->broken && k >= 0 ? sp_sample_stored(scene, &s->sample[k]) : SP_STORED_NOT;
    leave(s);
    return has;
}

static sp_status copy_packing(const sp_packing *from, sp_packing *to) {
    sp_packing p = sp_packing_none();
    sp_status status = sp_packing_alloc(&p, from->dim, from->n, from->n_contacts, NULL);
    if (status != SP_OK)
        return status;
    double *x = p.x, *r = p.r;
    sp_contact *contacts = p.contacts;
    memcpy(x, from->x, (size_t)from->n * 3 * sizeof *x);
    memcpy(r, from->r, (size_t)from->n * sizeof *r);
    memcpy(contacts, from->contacts, (size_t)from->n_contacts * sizeof *contacts);
    p = *from;
    p.x = x;
    p.r = r;
    p.contacts = contacts;
    p.scene = NULL;
    *to = p;
    return SP_OK;
}

static sp_status shelf_load(void *user, const char *name, sp_packing *packing, sp_sample *sample, bool *found,
                            sp_error *err) {
    shelf *s = user;
    enter(s);
    sp_status status = SP_OK;
    int k = find(s, name);
    if (s->broken) {
        status = sp_fail(err, SP_EFORMAT, "damaged");
    } else if (k >= 0 && s->packing[k].n > 0) {
        s->loads++;
        *sample = s->sample[k];
        *found = true;
        status = copy_packing(&s->packing[k], packing);
    }
    leave(s);
    return status;
}

static sp_status shelf_save(void *user, const sp_scene *scene, const sp_sample *sample, const sp_packing *packing,
                            const sp_sample_arrays *arrays, sp_error *err) {
    shelf *s = user;
    enter(s);
    char name[SP_NAME_MAX];
    sp_sample_name(scene, name); /* empty where a test lets it have no memory */
    s->wrong += name[0] && strcmp(name, sample->name) != 0;
    s->wrong += sample->failed != (packing == NULL) || (sample->failed || sample->lacks) != (sample->reason[0] != '\0');
    s->wrong += packing && !packing->scene;
    sp_status status = SP_OK;
    int k = find(s, sample->name);
    if (k < 0)
        k = s->n++;
    if (k >= ROOM)
        return sp_fail(err, SP_EIO, "no room");
    sp_packing_free(&s->packing[k]);
    s->sample[k] = *sample;
    if (arrays && arrays->signal.n > 0) /* else what was there stays */
        s->signal_points[k] = arrays->signal.n;
    if (packing)
        status = copy_packing(packing, &s->packing[k]);
    if (++s->saves == s->fail_at)
        status = sp_fail(err, SP_EIO, "disk full");
    leave(s);
    return status;
}

static shelf *shelf_new(void) {
    shelf *s = calloc(1, sizeof *s);
    assert_non_null(s);
    return s;
}

static void shelf_free(shelf *s) {
    assert_int_equal(s->wrong, 0);
    for (int k = 0; k < s->n; k++)
        sp_packing_free(&s->packing[k]);
    free(s);
}

static sp_study_sink sink_of(shelf *s) {
    return (sp_study_sink){.user = s, .has = shelf_has, .load = shelf_load, .save = shelf_save};
}

static sp_study_progress run(const sp_scene *scene, shelf *s, int jobs, int shard, int shards) {
    sp_study_options o = {.jobs = jobs, .shard = shard, .shards = shards};
    sp_study_sink sink = sink_of(s);
    sp_study_progress done = {0};
    assert_ok(sp_study_run(scene, &o, &sink, NULL, NULL, &done, &err));
    assert_int_equal(done.done, done.total);
    assert_true(done.seconds >= 0);
    return done;
}

/* Cells and comments, bit for bit. */
static void assert_same_table(const sp_table *a, const sp_table *b) {
    char *left = sp_table_text(a, SP_TSV), *right = sp_table_text(b, SP_TSV);
    assert_non_null(left);
    assert_non_null(right);
    assert_string_equal(left, right);
    sp_free(left);
    sp_free(right);
}

static sp_table table_of(const char *name, const shelf *s) {
    sp_table t = sp_table_none();
    assert_ok(sp_study_table(name, s->n, s->sample, NULL, &t, &err));
    return t;
}

/* ---- running ----------------------------------------------------------------------------------------------------- */

TEST(threads_and_shards_change_nothing) {
    FREED(sp_scene) scene = parse(chains);
    shelf *one = shelf_new(), *many = shelf_new(), *parts = shelf_new();
    sp_study_progress done = run(&scene, one, 1, 1, 1);
    assert_int_equal(done.total, 18);
    assert_int_equal(done.computed, 18);
    assert_int_equal(done.failed, 0);
    run(&scene, many, 4, 1, 1);
    assert_int_equal(run(&scene, parts, 2, 4, 4).total, 4);
    assert_int_equal(run(&scene, parts, 2, 2, 4).total, 5);
    assert_int_equal(run(&scene, parts, 2, 1, 4).total, 5);
    assert_int_equal(run(&scene, parts, 2, 3, 4).total, 4);
    assert_int_equal(parts->saves, 18); /* no sample twice, none left out */
    assert_int_equal(parts->n, 18);
    static const char *const names[] = {"ctof", "ensemble"};
    for (int k = 0; k < 2; k++) {
        FREED(sp_table) a = table_of(names[k], one), b = table_of(names[k], many), c = table_of(names[k], parts);
        assert_same_table(&a, &b);
        assert_same_table(&a, &c);
    }
    /* first seeds first */
    for (int k = 0; k < 18; k++)
        assert_int_equal(one->sample[k].seed, 5 + k / 6);
    shelf_free(one);
    shelf_free(many);
    shelf_free(parts);
}

TEST(only_what_is_missing_is_made) {
    FREED(sp_scene) scene = parse(chains);
    shelf *s = shelf_new();
    scene.samples = 1;
    run(&scene, s, 1, 1, 1);
    for (int k = 0; k < s->n; k++) {
        assert_int_equal(s->sample[k].have, SP_WANT_CTOF); /* nothing that nobody wants */
        assert_int_equal(s->signal_points[k], 0);
    }
    scene.samples = 3;
    assert_int_equal(run(&scene, s, 2, 1, 1).computed, 12); /* 6 were there */
    assert_int_equal(run(&scene, s, 2, 1, 1).computed, 0);
    assert_int_equal(s->saves, 18);
    for (int k = 0; k < s->n; k++)
        s->packing[k].seconds = 12345; /* marks the packings that are there */
    scene.want |= SP_WANT_SIGNAL;
    scene.signal.points = 33;
    sp_study_progress done = run(&scene, s, 2, 1, 1);
    assert_int_equal(done.computed, 18);
    assert_int_equal(s->loads, 18);
    for (int k = 0; k < s->n; k++) {
        assert_int_equal(s->sample[k].have, SP_WANT_CTOF | SP_WANT_SIGNAL);
        assert_int_equal(s->signal_points[k], 33);
        assert_true(s->packing[k].seconds == 12345);
    }
    scene.want = SP_WANT_STATICS; /* the signal stays, and is not made again */
    run(&scene, s, 1, 1, 1);
    for (int k = 0; k < s->n; k++) {
        assert_int_equal(s->sample[k].have, SP_WANT_CTOF | SP_WANT_SIGNAL | SP_WANT_STATICS);
        assert_int_equal(s->signal_points[k], 33);
    }
    s->broken = true; /* damaged files are made again */
    assert_int_equal(run(&scene, s, 1, 1, 1).computed, 18);
    for (int k = 0; k < s->n; k++)
        assert_true(s->packing[k].seconds != 12345);
    shelf_free(s);
}

typedef struct guard {
    pthread_t caller;
    int calls;
    int64_t last;
    int64_t stop_at; /* says stop once so many samples are done */
} guard;

static bool watch(const sp_study_progress *now, void *user) {
    guard *g = user;
    assert_true(pthread_equal(g->caller, pthread_self()));
    assert_true(now->done >= g->last && now->done <= now->total && now->computed + now->failed <= 2 * now->done);
    g->last = now->done;
    g->calls++;
    return now->done < g->stop_at;
}

TEST(stopping_keeps_what_is_finished) {
    /* packings that take for ever: given up within moments, and not saved */
    sp_scene scene = parse("packing = { grains = 5000; width = 100; pressure = 1e-7; }; study = { samples = 4; };");
    shelf *s = shelf_new();
    sp_study_sink sink = sink_of(s);
    sp_study_options o = {.jobs = 2, .shard = 1, .shards = 1};
    sp_study_progress done = {0};
    guard g = {.caller = pthread_self(), .stop_at = 0};
    /* one of them would take an hour: if they went on the test would time out */
    assert_fails(sp_study_run(&scene, &o, &sink, watch, &g, &done, &err), SP_EINTERRUPTED, "0 4");
    assert_int_equal(s->saves, 0);
    assert_int_equal(done.total, 4);
    assert_int_equal(done.done, 0);
    assert_true(g.calls >= 1);
    sp_scene_free(&scene);
    scene = parse(chains); /* the watch sees the end */
    g = (guard){.caller = pthread_self(), .stop_at = INT64_MAX};
    assert_ok(sp_study_run(&scene, &o, &sink, watch, &g, NULL, &err));
    assert_int_equal(g.last, 18);
    sp_scene_free(&scene);
    shelf_free(s);
}

TEST(a_failed_packing_is_recorded) {
    FREED(sp_scene) scene = parse("packing = { grains = 30; width = 6; max_steps = 20; };"
                                  "study = { samples = 2; want = [\"ctof\", \"statics\"]; };");
    shelf *s = shelf_new();
    sp_study_progress done = run(&scene, s, 1, 1, 1);
    assert_int_equal(done.failed, 2);
    assert_int_equal(s->n, 2);
    for (int k = 0; k < 2; k++) {
        assert_true(s->sample[k].failed);
        assert_int_equal(s->sample[k].have, 0);
        assert_int_equal(s->sample[k].grains, 30);
        assert_true(isnan(s->sample[k].height));
    }
    done = run(&scene, s, 1, 1, 1); /* it would fail again */
    assert_int_equal(done.computed, 0);
    FREED(sp_table) t = table_of("ctof", s);
    assert_int_equal(t.rows, 1);
    assert_true(isnan(sp_table_number(&t, 0, 2)));
    assert_string_equal(sp_table_get_text(&t, "failed"), "2");
    shelf_free(s);
}

TEST(a_failed_part_leaves_the_others) {
    /* no contact carries ten times the load: no network, hence no front */
    FREED(sp_scene) scene = parse("packing = { kind = \"chain\"; grains = 20; friction = 0; };"
                                  "study = { want = [\"ctof\", \"statics\"]; };");
    scene.network.threshold = 10;
    shelf *s = shelf_new();
    assert_int_equal(run(&scene, s, 1, 1, 1).failed, 1);
    assert_false(s->sample[0].failed);
    assert_int_equal(s->sample[0].have, SP_WANT_STATICS);
    assert_true(s->packing[0].n == 20);
    assert_int_equal(s->sample[0].lacks, SP_WANT_CTOF);
    sp_study_progress done = run(&scene, s, 1, 1, 1);
    assert_int_equal(done.failed, 1);
    assert_int_equal(done.computed, 0); /* not tried again */
    assert_int_equal(s->saves, 1);
    scene.want = SP_WANT_STATICS;
    assert_int_equal(run(&scene, s, 1, 1, 1).computed, 0);
    shelf_free(s);
}

/* What could not be made of a signal says nothing of a signal with other keys. */
TEST(a_lacking_signal_is_one_of_its_keys) {
    FREED(sp_scene) scene = parse("packing = { kind = \"chain\"; grains = 20; friction = 0; };"
                                  "study = { want = [\"ctof\", \"signal\"]; };");
    scene.network.threshold = 10;
    shelf *s = shelf_new();
    assert_int_equal(run(&scene, s, 1, 1, 1).failed, 1);
    assert_int_equal(s->sample[0].lacks, SP_WANT_CTOF | SP_WANT_SIGNAL);
    assert_int_equal(run(&scene, s, 1, 1, 1).computed, 0);
    scene.signal.points = 17;
    assert_int_equal(run(&scene, s, 1, 1, 1).computed, 1);
    scene.want = SP_WANT_CTOF;
    assert_int_equal(run(&scene, s, 1, 1, 1).computed, 0);
    shelf_free(s);
}

/* ---- several processes ------------------------------------------------------------------------------------------- */

static int64_t every_third(void *user) {
    int64_t *next = user;
    *next += 3;
    return *next < 18 ? *next : -1;
}

TEST(numbers_given_from_outside) {
    FREED(sp_scene) scene = parse(chains);
    shelf *whole = shelf_new(), *s = shelf_new();
    run(&scene, whole, 2, 1, 1);
    double cost = 0;
    for (int64_t first = -3; first < 0; first++) {
        int64_t next = first;
        sp_study_options o = {.jobs = 2, .shard = 1, .shards = 1, .take = every_third, .take_user = &next};
        sp_study_sink sink = sink_of(s);
        sp_study_progress done = {0};
        assert_ok(sp_study_run(&scene, &o, &sink, NULL, NULL, &done, &err));
        assert_int_equal(done.total, 18);
        assert_int_equal(done.done, 6);
        assert_int_equal(done.computed, 6);
        cost += done.cost_computed;
        assert_true(fabs(done.cost_computed - done.cost_done) == 0 && done.cost > done.cost_done);
        if (first == -1)
            assert_true(fabs(cost - done.cost) < 1e-12 * cost);
    }
    FREED(sp_table) a = table_of("ensemble", whole), b = table_of("ensemble", s);
    assert_same_table(&a, &b);
    shelf_free(whole);
    shelf_free(s);
}

/* Another process that has the first two samples: one for a while, then it is done; the other until it is gone. */
typedef struct neighbour {
    shelf *own;
    const shelf *theirs;
    char name[2][SP_NAME_MAX];
    int asked[2], taken, released;
} neighbour;

static sp_stored neighbour_has(void *user, const sp_scene *scene, const char *name) {
    neighbour *n = user;
    return shelf_has(n->own, scene, name);
}

static sp_status neighbour_claim(void *user, const char *name, bool *taken, sp_error *out) {
    neighbour *n = user;
    (void)out;
    *taken = true;
    for (int k = 0; k < 2; k++)
        if (n->taken >= 2 && strcmp(name, n->name[k]) == 0)
            *taken = ++n->asked[k] > 3;
    for (int k = 0; k < 2 && n->taken < 2; k++)
        if (n->name[k][0] == '\0' && *taken) {
            memcpy(n->name[k], name, SP_NAME_MAX);
            n->taken++;
            *taken = false;
        }
    if (*taken && n->asked[0] > 3 && strcmp(name, n->name[0]) == 0) { /* it was made meanwhile */
        const int there = find((shelf *)n->own, name), k = find((shelf *)n->theirs, name);
        assert_true(there < 0 && k >= 0);
        n->own->sample[n->own->n] = n->theirs->sample[k];
        n->own->n++;
    }
    n->released -= *taken;
    return SP_OK;
}

static void neighbour_release(void *user, const char *name) {
    neighbour *n = user;
    (void)name;
    n->released++;
}

static sp_status neighbour_load(void *user, const char *name, sp_packing *packing, sp_sample *sample, bool *found,
                                sp_error *out) {
    return shelf_load(((neighbour *)user)->own, name, packing, sample, found, out);
}

static sp_status neighbour_save(void *user, const sp_scene *scene, const sp_sample *sample, const sp_packing *packing,
                                const sp_sample_arrays *arrays, sp_error *out) {
    return shelf_save(((neighbour *)user)->own, scene, sample, packing, arrays, out);
}

TEST(samples_of_a_neighbour_come_last) {
    FREED(sp_scene) scene = parse(chains);
    neighbour n = {.own = shelf_new(), .theirs = NULL};
    shelf *whole = shelf_new();
    run(&scene, whole, 1, 1, 1);
    n.theirs = whole;
    const sp_study_sink sink = {.user = &n,
                                .has = neighbour_has,
                                .claim = neighbour_claim,
                                .release = neighbour_release,
                                .load = neighbour_load,
                                .save = neighbour_save};
    sp_study_options o = {.jobs = 1, .shard = 1, .shards = 1};
    sp_study_progress done = {0};
    assert_ok(sp_study_run(&scene, &o, &sink, NULL, NULL, &done, &err));
    assert_int_equal(done.done, 18);
    assert_int_equal(done.computed, 17);
    assert_int_equal(n.released, 0);
    assert_true(n.asked[0] == 4 && n.asked[1] == 4);
    FREED(sp_table) a = table_of("ensemble", whole), b = table_of("ensemble", n.own);
    assert_same_table(&a, &b);
    shelf_free(n.own);
    shelf_free(whole);
}

TEST(a_sink_that_fails_ends_the_study) {
    FREED(sp_scene) scene = parse(chains);
    shelf *s = shelf_new();
    s->fail_at = 5;
    sp_study_sink sink = sink_of(s);
    sp_study_options o = {.jobs = 1, .shard = 1, .shards = 1};
    sp_study_progress done = {0};
    assert_fails(sp_study_run(&scene, &o, &sink, NULL, NULL, &done, &err), SP_EIO, "disk full");
    assert_int_equal(done.done, 4);
    assert_int_equal(s->saves, 5);
    shelf_free(s);
}

TEST(wrong_runs) {
    FREED(sp_scene) scene = parse(chains);
    shelf *s = shelf_new();
    sp_study_sink sink = sink_of(s), none = {0};
    const sp_study_options bad[] = {{.jobs = 0, .shard = 1, .shards = 1},
                                    {.jobs = -1, .shard = 1, .shards = 1},
                                    {.jobs = 1, .shard = 0, .shards = 1},
                                    {.jobs = 1, .shard = 3, .shards = 2},
                                    {.jobs = 1, .shard = 1, .shards = 0}};
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++)
        assert_fails(sp_study_run(&scene, &bad[k], &sink, NULL, NULL, NULL, &err), SP_EINVAL, k < 2 ? "jobs" : "shard");
    sp_study_options o = {.jobs = 1, .shard = 1, .shards = 1};
    assert_fails(sp_study_run(&scene, &o, &none, NULL, NULL, NULL, &err), SP_EINVAL, "save");
    scene.sweep[1].values[2] = -5; /* a combination that is none, found before any work */
    assert_fails(sp_study_run(&scene, &o, &sink, NULL, NULL, NULL, &err), SP_EINVAL, "grains");
    assert_int_equal(s->saves, 0);
    scene.samples = 0;
    assert_fails(sp_study_run(&scene, &o, &sink, NULL, NULL, NULL, &err), SP_EINVAL, "samples");
    scene.samples = 40; /* shards without work are done at once */
    scene.sweep[1].values[2] = 30;
    o = (sp_study_options){.jobs = 1, .shard = 1000, .shards = 1000};
    assert_ok(sp_study_run(&scene, &o, &sink, NULL, NULL, NULL, &err));
    assert_int_equal(s->saves, 0);
    shelf_free(s);
}

/* ---- one sample -------------------------------------------------------------------------------------------------- */

/* Every allocation that a sample needs may fail: a reason each time, nothing leaks, nothing is half there. */
TEST(a_sample_without_memory) {
    FREED(sp_scene) scene = parse(chains);
    sp_status status = SP_ENOMEM;
    int64_t failures = 0;
    for (int64_t k = 0; status != SP_OK; k++) {
        FREED(sp_packing) packing = sp_packing_none();
        sp_sample sample = {0};
        FREED(sp_sample_arrays) arrays = sp_sample_arrays_none();
        sp_error err = {0};
        sp_alloc_fail_after(k);
        status =
            sp_sample_make(&scene, SP_WANT_CTOF | SP_WANT_SIGNAL | SP_WANT_SPECTRUM, &packing, &sample, &arrays, &err);
        sp_alloc_fail_after(-1);
        if (status != SP_OK) {
            assert_int_equal(status, SP_ENOMEM);
            assert_false(sample.failed); /* it may go well another time */
            failures++;
        }
        assert_int_equal(arrays.modes > 0, !!(sample.have & SP_WANT_SPECTRUM));
        assert_true(k < 1000);
    }
    assert_true(failures > 10);
}

/* A lack of memory goes before a part that is refused: what is missing then is no property of the sample. */
TEST(a_refused_part_without_memory) {
    FREED(sp_scene) scene = parse(chains);
    scene.network.threshold = 10;
    int lacking = 0;
    for (int64_t k = 0; k < 60; k++) {
        FREED(sp_packing) packing = sp_packing_none();
        sp_sample sample = {0};
        sp_alloc_fail_after(k);
        sp_status status = sp_sample_make(&scene, SP_WANT_CTOF | SP_WANT_STATICS, &packing, &sample, NULL, NULL);
        sp_alloc_fail_after(-1);
        assert_true(status == SP_ENOMEM || status == SP_EREFUSED);
        assert_true(sample.failed == (status == SP_EREFUSED));
        if (status == SP_EREFUSED)
            assert_int_equal(sample.have, SP_WANT_STATICS);
        lacking += status == SP_ENOMEM;
    }
    assert_true(lacking > 5 && lacking < 60);
}

TEST(a_study_without_memory) {
    FREED(sp_scene) scene = parse(chains);
    scene.samples = 1;
    sp_status status = SP_ENOMEM;
    for (int64_t k = 0; status != SP_OK; k += 7) {
        shelf *s = shelf_new();
        sp_study_options o = {.jobs = 2, .shard = 1, .shards = 1};
        sp_study_sink sink = sink_of(s);
        sink.save = shelf_save;
        sp_error err = {0};
        sp_alloc_fail_after(k);
        status = sp_study_run(&scene, &o, &sink, NULL, NULL, NULL, &err);
        sp_alloc_fail_after(-1);
        if (status != SP_OK)
            assert_int_equal(status, SP_ENOMEM);
        shelf_free(s);
        assert_true(k < 5000);
    }
}

/* A chain's front is known: the Airy front (16) of [S] gives its arrival at the far wall within the grid's error of a
 * dense eigensolution; here, the marks on the default grid against those on a grid 50 times finer. */
TEST(marks_on_the_default_grid) {
    assert_relative(sp_front_spacing(1e-10) / sp_front_spacing(1e-4), 10.0, 1e-12); /* times go as p^(-1/6) */
    const double pressure[] = {1e-7, 1e-4};
    for (int k = 0; k < 2; k++)
        for (int grains = 5; grains <= 80; grains *= 4) {
            sp_pack_spec spec = sp_pack_spec_default();
            spec.kind = SP_PACK_CHAIN;
            spec.dim = 1;
            spec.friction = 0;
            spec.grains = grains;
            spec.pressure = pressure[k];
            FREED(sp_packing) p = sp_packing_none();
            FREED(sp_network) net = sp_network_none();
            sp_network_options options = sp_network_options_default();
            sp_front coarse, fine;
            assert_ok(sp_packing_make(&spec, NULL, NULL, &p, &err));
            assert_ok(sp_network_make(&p, &options, &net, &err));
            assert_ok(sp_network_front(&net, SP_SOURCE_IMPULSE, 0, &coarse, &err));
            sp_signal_options o = sp_signal_options_default();
            FREED(sp_signal) signal = sp_signal_none();
            o.method = SP_SIGNAL_CHEBYSHEV;
            o.source = SP_SOURCE_IMPULSE;
            o.until = 1.5 * coarse.t_zero;
            o.points = (int32_t)(50 * o.until / sp_front_spacing(pressure[k]));
            assert_ok(sp_signal_make(&net, &o, &signal, &err));
            sp_front_options rule = sp_front_options_default();
            assert_ok(sp_front_find(signal.n, signal.t, signal.f, &rule, &fine, &err));
            assert_relative(coarse.t10, fine.t10, 2e-4);
            assert_relative(coarse.t_peak, fine.t_peak, 2e-4);
            assert_relative(coarse.t_zero, fine.t_zero, 2e-4);
            assert_relative(coarse.amplitude, fine.amplitude, 1e-5);
        }
}

RUN_TESTS(NULL, NULL)
