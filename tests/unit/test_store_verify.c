/* The check of a store's files, and failures that are tried again. */
#include "test_store_fixture.h"

#include <sys/stat.h>

enum { SAMPLES = 4 };

/* A store of chains, which are made in no time and hold to rounding; with the results that `wants' names. */
static sp_store *chains_with(const char *wants, char name[SAMPLES][SP_NAME_MAX]) {
    sp_store *store;
    FREED(sp_scene) study;
    char text[200];
    snprintf(text, sizeof text,
             "packing = { kind = \"chain\"; grains = 9; friction = 0; }; study = { samples = 4; want = [%s]; };",
             wants);
    assert_ok(sp_store_open(folder, true, &store, &err));
    assert_ok(sp_scene_parse(text, "test", 0, NULL, &study, &err));
    sp_study_sink sink = sp_store_sink(store);
    const sp_study_options options = {.jobs = 1, .shard = 1, .shards = 1};
    assert_ok(sp_study_run(&study, &options, &sink, NULL, NULL, NULL, &err));
    for (int k = 0; k < SAMPLES; k++) {
        sp_scene one;
        assert_ok(sp_study_scene(&study, k, &one, &err));
        sp_sample_name(&one, name[k]);
    }
    return store;
}

static sp_store *chains(char name[SAMPLES][SP_NAME_MAX]) { return chains_with("\"ctof\", \"signal\"", name); }

/* What the check said, and when it is to stop. */
typedef struct notes {
    int files, sound, faulty, damaged, aside, records, most;
    char last[SP_ERROR_TEXT];
} notes;

static bool note(const sp_store_finding *f, void *user) {
    notes *n = user;
    n->files++;
    n->sound += f->verdict == SP_SOUND;
    n->faulty += f->verdict == SP_FAULTY;
    n->damaged += f->verdict == SP_DAMAGED;
    n->aside += f->aside;
    n->records += f->record;
    assert_true(f->done >= 1 && f->done <= f->names);
    assert_true((f->verdict == SP_SOUND && !f->record) == (*f->reason == '\0'));
    snprintf(n->last, sizeof n->last, "%s", f->reason);
    return n->most == 0 || n->files < n->most;
}

static notes verify(sp_store *store, int64_t names, const char (*name)[SP_NAME_MAX]) {
    notes n = {0};
    const sp_store_check check = {.names = names, .name = name, .tolerance = 1e-9, .found = note, .user = &n};
    assert_ok(sp_store_verify(store, &check, &err));
    return n;
}

TEST_IN_FOLDER(verdicts) {
    char name[SAMPLES][SP_NAME_MAX], path[600], other[600];
    sp_store *store = chains(name);
    notes n = verify(store, -1, NULL);
    assert_true(n.files == SAMPLES && n.sound == SAMPLES && n.aside == 0);
    n = verify(store, 2, (const char(*)[SP_NAME_MAX])name);
    assert_true(n.files == 2 && n.sound == 2);

    /* another sample's packing: the results say nothing of it; balance that it does not have */
    sp_study_sink sink = sp_store_sink(store);
    FREED(sp_packing) arbitrary = fixture_packing(1, 2, 20), chain = sp_packing_none();
    sp_sample sample;
    assert_ok(sp_store_read(store, name[0], &chain, &sample, NULL, &err));
    assert_ok(sink.save(sink.user, NULL, &sample, &arbitrary, NULL, &err));
    n = verify(store, 1, (const char(*)[SP_NAME_MAX])name);
    assert_true(n.faulty == 1 && n.aside == 0);
    assert_true(test_names(n.last, "dim 1 2"));
    const double force = chain.contacts[0].fn;
    chain.contacts[0].fn *= 1 + 1e-6;
    assert_ok(sink.save(sink.user, NULL, &sample, &chain, NULL, &err));
    n = verify(store, 1, (const char(*)[SP_NAME_MAX])name);
    assert_true(n.faulty == 1 && n.aside == 0);
    assert_true(*n.last);
    chain.contacts[0].fn = force;
    sample.front.t10 = NAN;
    assert_ok(sink.save(sink.user, NULL, &sample, &chain, NULL, &err));
    n = verify(store, 1, (const char(*)[SP_NAME_MAX])name);
    assert_true(test_names(n.last, "t10 nan"));

    /* another file's content: aside, under the first name that is free */
    snprintf(path, sizeof path, "%s/%s.h5", folder, name[1]);
    snprintf(other, sizeof other, "%s/%s.bad", folder, name[1]);
    fixture_write(path, "no HDF5 file");
    assert_int_equal(mkdir(other, 0777), 0);
    n = verify(store, -1, NULL);
    assert_true(n.files == SAMPLES && n.damaged == 1 && n.aside == 1 && n.faulty == 1);
    assert_int_equal(rmdir(other), 0);
    snprintf(other, sizeof other, "%s/%s.bad2", folder, name[1]);
    assert_true(access(path, F_OK) != 0 && access(other, F_OK) == 0);
    n = verify(store, -1, NULL);
    assert_true(n.files == SAMPLES - 1 && n.damaged == 0);
    sp_store_close(store);
}

TEST_IN_FOLDER(records_and_retries) {
    char path[600];
    sp_store *store;
    assert_ok(sp_store_open(folder, true, &store, &err));
    sp_study_sink sink = sp_store_sink(store);
    sp_sample s = {.name = "0123456789abcdef0123456789abcdef",
                   .dim = 2,
                   .grains = 20,
                   .width = 24,
                   .pressure = 1e-4,
                   .failed = true};
    snprintf(s.reason, sizeof s.reason, "no equilibrium");
    assert_ok(sink.save(sink.user, NULL, &s, NULL, NULL, &err));
    notes n = verify(store, -1, NULL);
    assert_true(n.files == 1 && n.records == 1 && n.sound == 1);
    assert_string_equal(n.last, "no equilibrium");
    assert_true(fixture_has(&sink, s.name, SP_WANT_CTOF));
    sp_store_retry(store, true);
    assert_false(fixture_has(&sink, s.name, SP_WANT_CTOF));
    sp_store_retry(store, false);
    assert_true(fixture_has(&sink, s.name, SP_WANT_CTOF));
    snprintf(path, sizeof path, "%s/%s.failed", folder, s.name);
    fixture_write(path, "seed = many\n");
    n = verify(store, -1, NULL);
    assert_true(n.damaged == 1 && n.aside == 1);
    assert_false(fixture_has(&sink, s.name, SP_WANT_CTOF));
    sp_store_close(store);
}

/* Adds statics to all samples while the check, which has read two of them, tells of the first. */
static bool add_statics(const sp_store_finding *f, void *user) {
    char name[SAMPLES][SP_NAME_MAX];
    int *files = user;
    if ((*files)++ == 0)
        sp_store_close(chains_with("\"ctof\", \"signal\", \"statics\"", name));
    return f->verdict == SP_SOUND;
}

TEST_IN_FOLDER(files_replaced_meanwhile) {
    char name[SAMPLES][SP_NAME_MAX];
    int files = 0;
    sp_store_close(chains(name));
    assert_int_equal(unlink(fixture_path(folder, "manifest.tsv")), 0);
    sp_store *store;
    assert_ok(sp_store_open(folder, true, &store, &err));
    const sp_store_check check = {.names = -1, .tolerance = 1e-9, .jobs = 2, .found = add_statics, .user = &files};
    assert_ok(sp_store_verify(store, &check, &err));
    assert_int_equal(files, SAMPLES);
    sp_store_close(store);

    assert_ok(sp_store_open(folder, false, &store, &err)); /* as another process sees it */
    const sp_study_sink sink = sp_store_sink(store);
    for (int k = 0; k < SAMPLES; k++)
        assert_true(fixture_has(&sink, name[k], SP_WANT_STATICS));
    sp_store_close(store);
}

TEST_IN_FOLDER(stopping_and_lack_of_memory) {
    char name[SAMPLES][SP_NAME_MAX];
    sp_store *store = chains(name);
    notes n = {.most = 2};
    sp_store_check check = {.names = -1, .tolerance = 1e-9, .found = note, .user = &n};
    assert_fails(sp_store_verify(store, &check, &err), SP_EINTERRUPTED, "2 4 samples");
    assert_int_equal(n.files, 2);
    check.names = 1;
    check.name = (const char(*)[SP_NAME_MAX])name;
    sp_status status = SP_ENOMEM;
    for (int64_t k = 0; status != SP_OK; k++) {
        sp_error err = {0};
        n = (notes){0};
        sp_alloc_fail_after(k);
        status = sp_store_verify(store, &check, &err);
        sp_alloc_fail_after(-1);
        assert_true(k < 1000 && (status == SP_OK || status == SP_ENOMEM));
        assert_int_equal(n.sound, status == SP_OK); /* never called damaged for a lack of memory */
        assert_int_equal(n.files, n.sound);
    }
    assert_int_equal(fixture_count_files(folder), SAMPLES);
    sp_store_close(store);
}

RUN_TESTS(NULL, NULL)
