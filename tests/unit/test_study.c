#include "base/base.h"
#include "study/sample.h"
#include "test.h"

#include <pthread.h>
#include <sonopack/store.h>
#include <sonopack/study.h>
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

static void hash_of_known_texts(void **state) {
    (void)state;
    char name[SP_NAME_MAX];
    sp_hash128("", 0, name); /* the published values of FNV-1a, 128 bits */
    assert_string_equal(name, "6c62272e07bb014262b821756295c58d");
    sp_hash128("a", 1, name);
    assert_string_equal(name, "d228cb696f1a8caf78912b704e4a8964");
    sp_hash128("foobar", 6, name);
    assert_string_equal(name, "343e1662793c64bf6f0d3597ba446f18");
}

static void every_combination_has_its_first_seed_first(void **state) {
    (void)state;
    sp_scene study = parse(chains);
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
    sp_scene_free(&study);
}

static void a_name_says_what_decides_the_numbers_and_no_more(void **state) {
    (void)state;
    static const char *const deciding[] = {
        "packing.grains=21",      "packing.pressure=2e-4",      "packing.seed=6",           "packing.poisson=0.1",
        "packing.tolerance=1e-9", "network.threshold=2e-4",     "network.prestress=true",   "network.sliding_free=true",
        "packing.damping=0.7",    "signal.source=displacement", "packing.time_step=0.0999", "packing.friction=0.1"};
    static const char *const silent[] = {"signal.until=100",  "signal.points=77",  "signal.tolerance=1e-9",
                                         "study.samples=100", "study.want=moduli", "packing.grains=20"};
    sp_scene study = parse(chains);
    char own[SP_NAME_MAX], other[SP_NAME_MAX];
    sp_sample_name(&study, own);
    sp_scene_free(&study);
    for (int silently = 0; silently < 2; silently++) {
        size_t count = silently ? sizeof silent / sizeof *silent : sizeof deciding / sizeof *deciding;
        for (size_t k = 0; k < count; k++) {
            char set[64];
            snprintf(set, sizeof set, "%s", silently ? silent[k] : deciding[k]);
            char *sets[] = {set};
            sp_scene changed;
            assert_ok(sp_scene_parse(chains, "test", 1, sets, &changed, &err));
            sp_sample_name(&changed, other);
            sp_scene_free(&changed);
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

static bool shelf_has(void *user, const char *name, unsigned want) {
    shelf *s = user;
    enter(s);
    int k = find(s, name);
    bool has = !s->broken && k >= 0 && (s->sample[k].failed || (s->sample[k].have & want) == want);
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
                            const sp_signal *signal, sp_error *err) {
    shelf *s = user;
    enter(s);
    char name[SP_NAME_MAX];
    sp_sample_name(scene, name); /* empty where a test lets it have no memory */
    s->wrong += name[0] && strcmp(name, sample->name) != 0;
    s->wrong += sample->failed != (packing == NULL) || sample->failed != (sample->reason[0] != '\0');
    s->wrong += packing && !packing->scene;
    sp_status status = SP_OK;
    int k = find(s, sample->name);
    if (k < 0)
        k = s->n++;
    if (k >= ROOM)
        return sp_fail(err, SP_EIO, "no room");
    sp_packing_free(&s->packing[k]);
    s->sample[k] = *sample;
    s->signal_points[k] = signal ? signal->n : 0;
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

static sp_study_sink sink_of(shelf *s) { return (sp_study_sink){s, shelf_has, shelf_load, shelf_save}; }

static sp_study_progress run(const sp_scene *scene, shelf *s, int jobs, int shard, int shards) {
    sp_study_options o = {jobs, shard, shards};
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
    assert_ok(sp_study_table(name, s->n, s->sample, &t, &err));
    return t;
}

/* ---- running ----------------------------------------------------------------------------------------------------- */

static void threads_and_shards_change_nothing(void **state) {
    (void)state;
    sp_scene scene = parse(chains);
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
        sp_table a = table_of(names[k], one), b = table_of(names[k], many), c = table_of(names[k], parts);
        assert_same_table(&a, &b);
        assert_same_table(&a, &c);
        sp_table_free(&a);
        sp_table_free(&b);
        sp_table_free(&c);
    }
    /* first seeds first */
    for (int k = 0; k < 18; k++)
        assert_int_equal(one->sample[k].seed, 5 + k / 6);
    shelf_free(one);
    shelf_free(many);
    shelf_free(parts);
    sp_scene_free(&scene);
}

static void only_what_is_missing_is_made(void **state) {
    (void)state;
    sp_scene scene = parse(chains);
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
    scene.want = SP_WANT_STATICS; /* a file written anew keeps the signal that it had */
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
    sp_scene_free(&scene);
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

static void stopping_keeps_what_is_finished(void **state) {
    (void)state;
    /* packings that take for ever: given up within moments, and not saved */
    sp_scene scene = parse("packing = { grains = 5000; width = 100; pressure = 1e-7; }; study = { samples = 4; };");
    shelf *s = shelf_new();
    sp_study_sink sink = sink_of(s);
    sp_study_options o = {2, 1, 1};
    sp_study_progress done = {0};
    guard g = {.caller = pthread_self(), .stop_at = 0};
    double begun = sp_clock_wall();
    assert_fails(sp_study_run(&scene, &o, &sink, watch, &g, &done, &err), SP_EINTERRUPTED, "0 of 4");
    assert_true(sp_clock_wall() - begun < 30);
    assert_int_equal(s->saves, 0);
    assert_int_equal(done.total, 4);
    assert_int_equal(done.done, 0);
    assert_true(g.calls >= 1);
    sp_scene_free(&scene);
    shelf_free(s);
}

static void the_watch_sees_the_end(void **state) {
    (void)state;
    sp_scene scene = parse(chains);
    shelf *s = shelf_new();
    sp_study_sink sink = sink_of(s);
    sp_study_options o = {2, 1, 1};
    guard g = {.caller = pthread_self(), .stop_at = INT64_MAX};
    assert_ok(sp_study_run(&scene, &o, &sink, watch, &g, NULL, &err));
    assert_int_equal(g.last, 18);
    sp_scene_free(&scene);
    shelf_free(s);
}

static void a_failed_packing_is_recorded(void **state) {
    (void)state;
    sp_scene scene = parse("packing = { grains = 30; width = 6; max_steps = 20; };"
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
    sp_table t = table_of("ctof", s);
    assert_int_equal(t.rows, 1);
    assert_true(isnan(sp_table_number(&t, 0, 2)));
    assert_string_equal(sp_table_comment_value(&t, "failed"), "2");
    sp_table_free(&t);
    shelf_free(s);
    sp_scene_free(&scene);
}

static void a_failed_part_leaves_the_others(void **state) {
    (void)state;
    /* no contact carries ten times the load: no network, hence no front */
    sp_scene scene = parse("packing = { kind = \"chain\"; grains = 20; friction = 0; };"
                           "study = { want = [\"ctof\", \"statics\"]; };");
    scene.network.threshold = 10;
    shelf *s = shelf_new();
    assert_int_equal(run(&scene, s, 1, 1, 1).failed, 1);
    assert_false(s->sample[0].failed);
    assert_int_equal(s->sample[0].have, SP_WANT_STATICS);
    assert_true(s->packing[0].n == 20);
    sp_study_progress done = run(&scene, s, 1, 1, 1);
    assert_int_equal(done.failed, 1);
    assert_int_equal(s->saves, 1); /* nothing new to save */
    scene.want = SP_WANT_STATICS;
    assert_int_equal(run(&scene, s, 1, 1, 1).computed, 0);
    shelf_free(s);
    sp_scene_free(&scene);
}

static void a_sink_that_fails_ends_the_study(void **state) {
    (void)state;
    sp_scene scene = parse(chains);
    shelf *s = shelf_new();
    s->fail_at = 5;
    sp_study_sink sink = sink_of(s);
    sp_study_options o = {1, 1, 1};
    sp_study_progress done = {0};
    assert_fails(sp_study_run(&scene, &o, &sink, NULL, NULL, &done, &err), SP_EIO, "disk full");
    assert_int_equal(done.done, 4);
    assert_int_equal(s->saves, 5);
    shelf_free(s);
    sp_scene_free(&scene);
}

static void wrong_runs(void **state) {
    (void)state;
    sp_scene scene = parse(chains);
    shelf *s = shelf_new();
    sp_study_sink sink = sink_of(s), none = {0};
    const sp_study_options bad[] = {{0, 1, 1}, {-1, 1, 1}, {1, 0, 1}, {1, 3, 2}, {1, 1, 0}};
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++)
        assert_fails(sp_study_run(&scene, &bad[k], &sink, NULL, NULL, NULL, &err), SP_EINVAL, k < 2 ? "jobs" : "shard");
    sp_study_options o = {1, 1, 1};
    assert_fails(sp_study_run(&scene, &o, &none, NULL, NULL, NULL, &err), SP_EINVAL, "save");
    scene.sweep[1].values[2] = -5; /* a combination that is none, found before any work */
    assert_fails(sp_study_run(&scene, &o, &sink, NULL, NULL, NULL, &err), SP_EINVAL, "grains");
    assert_int_equal(s->saves, 0);
    scene.samples = 0;
    assert_fails(sp_study_run(&scene, &o, &sink, NULL, NULL, NULL, &err), SP_EINVAL, "samples");
    scene.samples = 40; /* shards without work are done at once */
    scene.sweep[1].values[2] = 30;
    o = (sp_study_options){1, 1000, 1000};
    assert_ok(sp_study_run(&scene, &o, &sink, NULL, NULL, NULL, &err));
    assert_int_equal(s->saves, 0);
    shelf_free(s);
    sp_scene_free(&scene);
}

/* ---- one sample -------------------------------------------------------------------------------------------------- */

/* Every allocation that a sample needs may fail: a reason each time, nothing leaks, nothing is half there. */
static void a_sample_without_memory(void **state) {
    (void)state;
    sp_scene scene = parse(chains);
    sp_status status = SP_ENOMEM;
    int64_t failures = 0;
    for (int64_t k = 0; status != SP_OK; k++) {
        sp_packing packing = sp_packing_none();
        sp_sample sample = {0};
        sp_signal signal = sp_signal_none();
        sp_error err = {0};
        sp_alloc_fail_after(k);
        status = sp_sample_make(&scene, SP_WANT_CTOF | SP_WANT_SIGNAL, &packing, &sample, &signal, &err);
        sp_alloc_fail_after(-1);
        if (status != SP_OK) {
            assert_int_equal(status, SP_ENOMEM);
            assert_non_null(strstr(err.text, "memory"));
            assert_false(sample.failed); /* it may go well another time */
            failures++;
        }
        sp_packing_free(&packing);
        sp_signal_free(&signal);
        assert_true(k < 1000);
    }
    assert_true(failures > 10);
    sp_scene_free(&scene);
}

/* A lack of memory goes before a part that is refused: what is missing then is no property of the sample. */
static void a_refused_part_without_memory(void **state) {
    (void)state;
    sp_scene scene = parse(chains);
    scene.network.threshold = 10;
    int lacking = 0;
    for (int64_t k = 0; k < 60; k++) {
        sp_packing packing = sp_packing_none();
        sp_sample sample = {0};
        sp_alloc_fail_after(k);
        sp_status status = sp_sample_make(&scene, SP_WANT_CTOF | SP_WANT_STATICS, &packing, &sample, NULL, NULL);
        sp_alloc_fail_after(-1);
        assert_true(status == SP_ENOMEM || status == SP_EREFUSED);
        assert_true(sample.failed == (status == SP_EREFUSED));
        if (status == SP_EREFUSED)
            assert_int_equal(sample.have, SP_WANT_STATICS);
        lacking += status == SP_ENOMEM;
        sp_packing_free(&packing);
    }
    assert_true(lacking > 5 && lacking < 60);
    sp_scene_free(&scene);
}

static void a_study_without_memory(void **state) {
    (void)state;
    sp_scene scene = parse(chains);
    scene.samples = 1;
    sp_status status = SP_ENOMEM;
    for (int64_t k = 0; status != SP_OK; k += 7) {
        shelf *s = shelf_new();
        sp_study_options o = {2, 1, 1};
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
    sp_scene_free(&scene);
}

/* A chain's front is known: the Airy front (16) of [S] gives its arrival at the far wall within the grid's error of a
 * dense eigensolution; here, the marks on the default grid against those on a grid 50 times finer. */
static void marks_on_the_default_grid(void **state) {
    (void)state;
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
            sp_packing p = sp_packing_none();
            sp_network net = sp_network_none();
            sp_network_options options = sp_network_options_default();
            sp_front coarse, fine;
            assert_ok(sp_packing_make(&spec, NULL, NULL, &p, &err));
            assert_ok(sp_network_make(&p, &options, &net, &err));
            assert_ok(sp_network_front(&net, SP_SOURCE_IMPULSE, 0, &coarse, &err));
            sp_signal_options o = sp_signal_options_default();
            sp_signal signal = sp_signal_none();
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
            sp_signal_free(&signal);
            sp_network_free(&net);
            sp_packing_free(&p);
        }
}

/* ---- tables ------------------------------------------------------------------------------------------------------ */

/* Samples of fronts with speed 0.3 (p/1e-4)^(1/6) between heights near 8 and 25, and known statics and moduli. */
static sp_sample made_up(double p, int grains, int seed, double offset) {
    double c = 0.3 * pow(p / 1e-4, 1.0 / 6), height = grains == 200 ? 8 : 25;
    sp_sample s = {.dim = 2, .grains = grains, .width = 24, .pressure = p, .friction = 0.5, .seed = (uint64_t)seed};
    snprintf(s.name, sizeof s.name, "%08x%08x%016x", (unsigned)(-1000 * log10(p)), (unsigned)grains, (unsigned)seed);
    s.height = height + offset;
    s.have = SP_WANT_CTOF | SP_WANT_STATICS | SP_WANT_MODULI;
    s.front.t10 = 5 / c + s.height / c;
    s.front.t_peak = 10 / c + 1.25 * s.height / c;
    s.front.t_zero = 15 / c + 1.5 * s.height / c;
    s.front.amplitude = 1 / s.height;
    s.front.width = s.front.t_zero - s.front.t10;
    s.statics = (sp_statics){0.81, 0.55, 0.5, 3.2 + offset, 10, 1.2, 1.5, 2.8, 0.52, 0.56, 0.8};
    s.moduli = (sp_moduli){1, 2, 3, 4, grains == 600 ? 0.2 + offset : 9, grains == 600 ? 0.1 : 9, 0};
    return s;
}

enum { MADE = 4 * 2 * 5 };

static void make_up(sp_sample s[MADE]) {
    int n = 0;
    for (int seed = 1; seed <= 5; seed++)
        for (int e = -7; e <= -4; e++)
            for (int grains = 200; grains <= 600; grains += 400)
                s[n++] = made_up(pow(10, e), grains, seed, 0.1 * (seed - 3));
}

static double cell(const sp_table *t, int64_t row, const char *column) {
    int c = sp_table_find_column(t, column);
    assert_true(c >= 0);
    return sp_table_number(t, row, c);
}

static void table_of_speeds(void **state) {
    (void)state;
    sp_sample s[MADE];
    make_up(s);
    sp_table t = sp_table_none();
    assert_ok(sp_study_table("ctof", MADE, s, &t, &err));
    static const char *const columns[] = {"p", "samples", "c_tof", "c_tof_err", "c_peak", "c_zero", "c_l", "c_t"};
    assert_int_equal(t.columns, 8);
    for (int c = 0; c < 8; c++)
        assert_string_equal(t.column[c].name, columns[c]);
    assert_int_equal(t.rows, 4);
    for (int k = 0; k < 4; k++) {
        double p = pow(10, k - 7), c = 0.3 * pow(p / 1e-4, 1.0 / 6);
        assert_true(cell(&t, k, "p") == p);
        assert_close(cell(&t, k, "samples"), 5, 0);
        assert_relative(cell(&t, k, "c_tof"), c, 1e-12);
        assert_relative(cell(&t, k, "c_peak"), c / 1.25, 1e-12);
        assert_relative(cell(&t, k, "c_zero"), c / 1.5, 1e-12);
        assert_relative(cell(&t, k, "c_l"), 0.2, 1e-12); /* of the high boxes */
        assert_relative(cell(&t, k, "c_t"), 0.1, 1e-12);
        assert_close(cell(&t, k, "c_tof_err"), 0, 1e-12); /* heights scatter, the speed does not */
    }
    assert_close(strtod(sp_table_comment_value(&t, "exponent"), NULL), 1.0 / 6, 1e-6);
    assert_string_equal(sp_table_comment_value(&t, "failed"), "0");
    sp_table_free(&t);
}

/* Arrival times that scatter by dt: the error of c = dH/dT is c sqrt(2 dt^2/n)/T. */
static void error_of_the_speed(void **state) {
    (void)state;
    sp_sample s[MADE];
    make_up(s);
    for (int k = 0; k < MADE; k++)
        s[k].front.t10 += s[k].seed % 2 ? 2 : -3; /* mean 0, squares 30 over the five */
    sp_table t = sp_table_none();
    assert_ok(sp_study_table("ctof", MADE, s, &t, &err));
    for (int k = 0; k < 4; k++) {
        double c = 0.3 * pow(10, (k - 3) / 6.0), flight = 17 / c;
        assert_relative(cell(&t, k, "c_tof"), c, 1e-12);
        /* heights scatter by 0.02 d^2, which moves H and t10 together and c not at all */
        assert_relative(cell(&t, k, "c_tof_err"), c * sqrt(2 * 30.0 / (5 * 4)) / flight, 0.15);
    }
    sp_table_free(&t);
    int n = 0; /* two high boxes, without scatter, leave the error of the five low ones */
    make_up(s);
    for (int k = 0; k < MADE; k++) {
        if (s[k].grains == 200)
            s[k].front.t10 += s[k].seed % 2 ? 2 : -3;
        if (s[k].grains == 200 || s[k].seed <= 2)
            s[n++] = s[k];
    }
    assert_ok(sp_study_table("ctof", n, s, &t, &err));
    for (int k = 0; k < 4; k++) {
        double c = 0.3 * pow(10, (k - 3) / 6.0);
        assert_relative(cell(&t, k, "c_tof_err"), c * sqrt(30.0 / (5 * 4)) * c / 17, 0.15);
        assert_close(cell(&t, k, "samples"), 2, 0);
    }
    sp_table_free(&t);
}

static void any_order_of_samples(void **state) {
    (void)state;
    static const char *const names[] = {"ctof", "statics", "moduli", "ensemble"};
    sp_sample s[MADE], mixed[MADE + 3];
    make_up(s);
    for (int k = 0; k < MADE; k++) {
        s[k].front.t10 += sin(k); /* irregular, so that sums depend on their order */
        s[k].statics.phi2 += 0.01 * cos(k);
        s[k].moduli.c22 += 1e-3 * cos(3 * k);
    }
    s[7].failed = true;
    s[7].have = 0;
    snprintf(s[7].reason, sizeof s[7].reason, "it failed");
    for (int n = 0; n < 4; n++) {
        sp_table t = sp_table_none();
        assert_ok(sp_study_table(names[n], MADE, s, &t, &err));
        for (int trial = 1; trial < 8; trial++) {
            for (int k = 0; k < MADE; k++)
                mixed[k] = s[k];
            for (int k = MADE - 1; k > 0; k--) { /* a shuffle by a small generator */
                int other = (int)((unsigned)(trial * 7919 + k * 104729) % (unsigned)(k + 1));
                sp_sample swap = mixed[k];
                mixed[k] = mixed[other];
                mixed[other] = swap;
            }
            for (int k = 0; k < 3; k++)
                mixed[MADE + k] = mixed[k * trial]; /* the same sample again counts once */
            sp_table again = sp_table_none();
            assert_ok(sp_study_table(names[n], MADE + 3, mixed, &again, &err));
            assert_same_table(&t, &again);
            sp_table_free(&again);
        }
        sp_table_free(&t);
    }
}

static void groups_with_holes(void **state) {
    (void)state;
    sp_sample s[MADE];
    make_up(s);
    for (int k = 0; k < MADE; k++) {
        if (s[k].pressure < 2e-7 && s[k].grains == 600) { /* no front in any high box */
            s[k].have &= ~(unsigned)SP_WANT_CTOF;
            s[k].failed = true;
        }
        if (s[k].pressure > 5e-7 && s[k].pressure < 2e-6 && s[k].seed > 2) { /* three of five failed */
            s[k].failed = true;
            s[k].have = 0;
        }
        if (s[k].pressure > 5e-6 && s[k].pressure < 2e-5 && s[k].seed == 4) { /* no zero crossing, no moduli */
            s[k].front.t_zero = s[k].front.width = NAN;
            s[k].have &= ~(unsigned)SP_WANT_MODULI;
        }
        if (s[k].pressure > 5e-5 && s[k].seed > 1) /* one sample only */
            s[k] = made_up(1e-4, s[k].grains, 1, -0.2);
    }
    sp_table t = sp_table_none();
    assert_ok(sp_study_table("ctof", MADE, s, &t, &err));
    assert_int_equal(t.rows, 4);
    assert_true(isnan(cell(&t, 0, "c_tof")) && isnan(cell(&t, 0, "c_tof_err")) && isnan(cell(&t, 0, "c_zero")));
    for (int k = 1; k < 4; k++) {
        double c = 0.3 * pow(10, (k - 3) / 6.0);
        assert_relative(cell(&t, k, "c_tof"), c, 1e-12);
        assert_relative(cell(&t, k, "c_zero"), c / 1.5, 1e-12);
    }
    assert_close(cell(&t, 1, "samples"), 2, 0);
    assert_close(cell(&t, 1, "c_l"), 0.2 - 0.15, 1e-12); /* seeds 1 and 2 */
    assert_close(cell(&t, 2, "samples"), 5, 0);
    assert_close(cell(&t, 2, "c_l"), 0.2 - 0.025, 1e-12); /* seeds 1, 2, 3 and 5 */
    assert_close(cell(&t, 3, "samples"), 1, 0);
    assert_true(isnan(cell(&t, 3, "c_tof_err"))); /* one sample has no spread */
    assert_string_equal(sp_table_comment_value(&t, "failed"), "11");
    sp_table_free(&t);
    assert_ok(sp_study_table("moduli", MADE, s, &t, &err));
    const int with_moduli[8] = {5, 5, 2, 2, 4, 4, 1, 1};
    assert_int_equal(t.rows, 8);
    for (int k = 0; k < 8; k++)
        assert_close(cell(&t, k, "samples"), with_moduli[k], 0);
    assert_close(cell(&t, 5, "c_l"), 0.2 - 0.025, 1e-12);
    sp_table_free(&t);
    /* one size only */
    assert_ok(sp_study_table("ctof", 1, s, &t, &err));
    assert_int_equal(t.rows, 1);
    assert_true(isnan(cell(&t, 0, "c_tof")));
    assert_non_null(strstr(t.comment[1], "two heights"));
    sp_table_free(&t);
    /* nothing at all is an empty table */
    assert_ok(sp_study_table("ctof", 0, s, &t, &err));
    assert_int_equal(t.rows, 0);
    assert_int_equal(t.columns, 8);
    sp_table_free(&t);
}

/* The highest boxes that have fronts count, however many they are. */
static void three_sizes(void **state) {
    (void)state;
    sp_sample s[16];
    int n = 0;
    for (int seed = 1; seed <= 9; seed++)
        s[n++] = made_up(1e-4, 200, seed, 0.1 * seed);
    for (int seed = 1; seed <= 3; seed++) {
        s[n++] = made_up(1e-4, 400, seed, -5); /* height 20 */
        s[n] = made_up(1e-4, 600, seed, 0);
        s[n].have = 0;
        s[n++].failed = true;
    }
    sp_table t = sp_table_none();
    assert_ok(sp_study_table("ctof", n, s, &t, &err));
    assert_int_equal(t.rows, 1);
    assert_close(cell(&t, 0, "samples"), 3, 0);
    assert_relative(cell(&t, 0, "c_tof"), 0.3, 1e-12);
    assert_true(cell(&t, 0, "c_tof_err") < 1e-12);
    assert_non_null(strstr(t.comment[1], "grains 200 and 400"));
    sp_table_free(&t);
    /* the same sample twice, once with what it lacked before */
    s[n] = s[n - 1];
    s[n].failed = false;
    s[n++].have = SP_WANT_CTOF;
    assert_ok(sp_study_table("ctof", n, s, &t, &err));
    assert_non_null(strstr(t.comment[1], "grains 200 and 600"));
    assert_close(cell(&t, 0, "samples"), 1, 0);
    assert_string_equal(sp_table_comment_value(&t, "failed"), "2");
    sp_table_free(&t);
}

static void table_of_means(void **state) {
    (void)state;
    sp_sample s[MADE];
    make_up(s);
    sp_table t = sp_table_none();
    assert_ok(sp_study_table("statics", MADE, s, &t, &err));
    assert_int_equal(t.columns, 3 + 2 * 11);
    assert_int_equal(t.rows, 8);
    for (int k = 0; k < 8; k++) {
        assert_relative(cell(&t, k, "p"), pow(10, k / 2 - 7), 1e-15);
        assert_close(cell(&t, k, "grains"), k % 2 ? 600 : 200, 0);
        assert_close(cell(&t, k, "samples"), 5, 0);
        assert_close(cell(&t, k, "zs"), 3.2, 1e-14);
        assert_close(cell(&t, k, "zs_sd"), 0.1 * sqrt(2.5), 1e-14);
        assert_close(cell(&t, k, "Phi2"), 0.81, 1e-15);
        assert_close(cell(&t, k, "s1_over_s2"), 0.8, 1e-15);
        assert_close(cell(&t, k, "s1_over_s2_sd"), 0, 1e-15);
    }
    sp_table_free(&t);
    assert_ok(sp_study_table("moduli", MADE, s, &t, &err));
    assert_int_equal(t.columns, 3 + 2 * 6);
    assert_close(cell(&t, 0, "C12"), 2, 0);
    assert_close(cell(&t, 0, "C33"), 4, 0);
    assert_close(cell(&t, 1, "c_l"), 0.2, 1e-15);
    assert_close(cell(&t, 1, "c_l_sd"), 0.1 * sqrt(2.5), 1e-14);
    sp_table_free(&t);
    assert_ok(sp_study_table("ensemble", MADE, s, &t, &err));
    assert_int_equal(t.rows, MADE);
    for (int k = 1; k < MADE; k++) {
        double p = cell(&t, k, "p"), before = cell(&t, k - 1, "p");
        double g = cell(&t, k, "grains"), g_before = cell(&t, k - 1, "grains");
        assert_true(p > before || (p == before && g > g_before) ||
                    (p == before && g == g_before && cell(&t, k, "seed") > cell(&t, k - 1, "seed")));
    }
    assert_relative(cell(&t, 0, "width"), s[0].front.width, 1e-15);
    sp_table_free(&t);
}

static void what_is_not_averaged(void **state) {
    (void)state;
    sp_sample s[MADE];
    sp_table t = sp_table_none();
    make_up(s);
    s[3].friction = 0;
    assert_fails(sp_study_table("ctof", MADE, s, &t, &err), SP_EREFUSED, "friction");
    assert_fails(sp_study_table("statics", MADE, s, &t, &err), SP_EREFUSED, "friction");
    assert_ok(sp_study_table("ensemble", MADE, s, &t, &err));
    sp_table_free(&t);
    make_up(s);
    s[3].width = 48;
    assert_fails(sp_study_table("ctof", MADE, s, &t, &err), SP_EREFUSED, "width");
    make_up(s);
    s[8] = s[0]; /* the same seed under another name: of another scene */
    s[8].name[0] = 'f';
    assert_fails(sp_study_table("moduli", MADE, s, &t, &err), SP_EREFUSED, "different scenes");
    assert_fails(sp_study_table("spectra", MADE, s, &t, &err), SP_EINVAL, "spectra");
    assert_null(t.cells);
}

static void tables_without_memory(void **state) {
    (void)state;
    static const char *const names[] = {"ctof", "statics", "moduli", "ensemble"};
    sp_sample s[MADE];
    make_up(s);
    for (int n = 0; n < 4; n++) {
        sp_status status = SP_ENOMEM;
        int64_t k;
        for (k = 0; status != SP_OK; k++) {
            sp_table t = sp_table_none();
            sp_error err = {0};
            sp_alloc_fail_after(k);
            status = sp_study_table(names[n], MADE, s, &t, &err);
            sp_alloc_fail_after(-1);
            if (status != SP_OK)
                assert_int_equal(status, SP_ENOMEM);
            else
                sp_table_free(&t);
            assert_true(k < 10000);
        }
        assert_true(k > 5);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hash_of_known_texts),
        cmocka_unit_test(every_combination_has_its_first_seed_first),
        cmocka_unit_test(a_name_says_what_decides_the_numbers_and_no_more),
        cmocka_unit_test(threads_and_shards_change_nothing),
        cmocka_unit_test(only_what_is_missing_is_made),
        cmocka_unit_test(stopping_keeps_what_is_finished),
        cmocka_unit_test(the_watch_sees_the_end),
        cmocka_unit_test(a_failed_packing_is_recorded),
        cmocka_unit_test(a_failed_part_leaves_the_others),
        cmocka_unit_test(a_sink_that_fails_ends_the_study),
        cmocka_unit_test(wrong_runs),
        cmocka_unit_test(a_sample_without_memory),
        cmocka_unit_test(a_refused_part_without_memory),
        cmocka_unit_test(a_study_without_memory),
        cmocka_unit_test(marks_on_the_default_grid),
        cmocka_unit_test(table_of_speeds),
        cmocka_unit_test(error_of_the_speed),
        cmocka_unit_test(any_order_of_samples),
        cmocka_unit_test(groups_with_holes),
        cmocka_unit_test(three_sizes),
        cmocka_unit_test(table_of_means),
        cmocka_unit_test(what_is_not_averaged),
        cmocka_unit_test(tables_without_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
