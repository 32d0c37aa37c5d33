/* The cache of a store: what it says is what the files say, or it says nothing; and the claims of samples. */
#include "base/file.h"
#include "store/claim.h"
#include "store/records.h"
#include "store/sample_h5.h"
#include "test_store_fixture.h"

#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <sys/wait.h>

static char *folder;

static int setup(void **state) {
    (void)state;
    folder = fixture_folder();
    return 0;
}

static int teardown(void **state) {
    (void)state;
    fixture_remove(folder);
    return 0;
}

/* A sample with numbers of all magnitudes in everything that it has. */
static sp_sample example(unsigned have, uint64_t number) {
    uint64_t random = number;
    sp_sample s = sp_sample_blank();
    sp_result result[SP_RESULTS_MAX];
    const int results = sp_results(result);
    for (int k = 0; k < results; k++) {
        const double x = k % 7 == 3 ? NAN : ldexp(fixture_uniform(&random), (int)(fixture_next(&random) % 200) - 100);
        if (result[k].field->type == SP_H5_F64 && (!result[k].want || have & result[k].want))
            memcpy((char *)&s + result[k].offset, &x, sizeof x);
    }
    snprintf(s.name, sizeof s.name, "%016llx%016llx", (unsigned long long)fixture_next(&random),
             (unsigned long long)fixture_next(&random));
    s.have = have;
    s.dim = 3;
    s.width = 8;
    s.pressure = 1e-4;
    s.friction = 0.5;
    s.height = 20;
    s.grains = 600;
    s.kind = 2;
    s.seed = fixture_next(&random);
    s.lacks = SP_WANT_MODULI & ~have;
    s.lacks_signal = fixture_next(&random);
    if (s.lacks)
        snprintf(s.reason, sizeof s.reason, "no contact, \"that\" carries");
    if (have & SP_WANT_SIGNAL)
        s.signal = (sp_signal_made){.points = 801, .method = SP_SIGNAL_FABER, .until = 1.0 / 3, .tolerance = NAN};
    if (have & SP_WANT_SPECTRUM)
        s.spectrum = (sp_spectrum_made){.carrying = 533, .dof = 6, .zero_modes = 7, .omega_max = 1.0 / 3};
    s.planes = have & SP_WANT_PLANES ? SP_PLANES_MAX : 0;
    for (int32_t k = 0; k < s.planes; k++) {
        s.plane[k] = k + fixture_uniform(&random);
        s.plane_front[k] = (sp_front){1.0 / (k + 3), fixture_uniform(&random), NAN, 1e-300, -0.1, 0};
    }
    return s;
}

static struct stat file_of(int64_t size, int64_t seconds) {
    struct stat info = {0};
    info.st_size = size;
    info.st_mtim = (struct timespec){.tv_sec = seconds, .tv_nsec = 123456789};
    return info;
}

/* All that is kept, by the text of a line: every bit of a number shows there. */
static void assert_same(const sp_sample *a, const sp_sample *b) {
    const struct stat file = file_of(1, 2);
    FREED(sp_text) left = {0}, right = {0};
    sp_manifest_put(&left, &file, a);
    sp_manifest_put(&right, &file, b);
    assert_string_equal(left.data, right.data);
}

TEST_BETWEEN(lines_keep_every_bit, setup, teardown) {
    const unsigned all = SP_WANT_CTOF | SP_WANT_STATICS | SP_WANT_MODULI | SP_WANT_SIGNAL | SP_WANT_PROBES |
                         SP_WANT_PLANES | SP_WANT_SPECTRUM;
    const struct stat file = file_of(12345, 1700000000);
    for (unsigned have = 0; have <= all; have += have < 8 ? 1 : 7) {
        const sp_sample s = example(have & all, have + 1);
        sp_sample back;
        FREED(sp_text) text = {0};
        sp_manifest_put(&text, &file, &s);
        assert_false(text.failed);
        assert_true(text.size < 16384 && text.data[text.size - 1] == '\n');
        text.data[text.size - 1] = '\0';
        assert_true(sp_manifest_get(text.data, s.name, false, &file, &back));
        assert_same_bits("front", &s.front.t10, &back.front.t10, 5);
        assert_same_bits("statics", &s.statics.phi2, &back.statics.phi2, sizeof s.statics / 8);
        assert_int_equal(back.signal.points, s.signal.points);
        assert_same(&s, &back);
    }
}

static sp_manifest *open_manifest(bool adding) {
    sp_manifest *m;
    assert_ok(sp_manifest_open(folder, adding, &m, &err));
    return m;
}

TEST_BETWEEN(speaks_of_files_as_they_are, setup, teardown) {
    const sp_sample s = example(SP_WANT_CTOF | SP_WANT_SIGNAL, 5);
    sp_sample changed = s, back,
              failed = {.failed = true, .dim = 2, .grains = 20, .width = 8, .pressure = 1e-4, .reason = "no\trest"};
    memcpy(failed.name, example(0, 9).name, SP_NAME_MAX);
    const struct stat file = file_of(1000, 50), longer = file_of(1001, 50), later = file_of(1000, 51);
    sp_manifest *m = open_manifest(true), *other = open_manifest(false);
    assert_false(sp_manifest_find(m, s.name, false, &file, &back));
    sp_manifest_add(m, &file, &s);
    sp_manifest_add(m, &file, &failed);
    assert_false(sp_manifest_find(other, s.name, false, &file, &back));
    sp_manifest_refresh(other);
    for (int turn = 0; turn < 2; turn++) { /* one who opened it before, and one who opens it now */
        assert_true(sp_manifest_find(other, s.name, false, &file, &back));
        assert_same(&s, &back);
        assert_false(sp_manifest_find(other, s.name, false, &longer, &back));
        assert_false(sp_manifest_find(other, s.name, false, &later, &back));
        assert_false(sp_manifest_find(other, s.name, true, &file, &back));
        assert_true(sp_manifest_find(other, failed.name, true, &file, &back));
        assert_string_equal(back.reason, "no rest");
        assert_true(back.failed);
        assert_false(sp_manifest_find(other, "no name of a sample, but 32 long", false, &file, &back));
        sp_manifest_close(other);
        other = open_manifest(false);
    }
    changed.height = 77;
    sp_manifest_add(other, &later, &changed); /* which may not add */
    assert_false(sp_manifest_find(other, s.name, false, &later, &back));
    sp_manifest_add(m, &later, &changed);
    sp_manifest_refresh(other);
    assert_true(sp_manifest_find(other, s.name, false, &later, &back) && back.height == 77);
    assert_false(sp_manifest_find(other, s.name, false, &file, &back));
    sp_manifest_close(m);
    sp_manifest_close(other);
}

static char *read_text(size_t *size) {
    char path[200], *text;
    snprintf(path, sizeof path, "%s/manifest.tsv", folder);
    assert_ok(sp_file_read(path, &text, size, &err));
    return text;
}

static void write_text(const char *text, size_t size) {
    char path[200];
    snprintf(path, sizeof path, "%s/manifest.tsv", folder);
    assert_ok(sp_text_save(path, text, size, &err));
}

/* Any byte changed, and cut anywhere: the samples are found as they are, or not at all; and can be added again. */
TEST_BETWEEN(damage_is_never_believed, setup, teardown) {
    enum { SAMPLES = 3 };
    const struct stat file = file_of(1000, 50);
    sp_sample s[SAMPLES], back;
    sp_manifest *m = open_manifest(true);
    for (int k = 0; k < SAMPLES; k++) {
        s[k] = example(SP_WANT_CTOF | SP_WANT_MODULI, (uint64_t)k + 1);
        sp_manifest_add(m, &file, &s[k]);
    }
    sp_manifest_close(m);
    size_t size;
    char *whole = read_text(&size), *text = sp_alloc(size + 1, 1);
    int kept = 0, lost = 0;
    for (size_t at = 0; at < size; at += at < 64 ? 1 : 31)
        for (int kind = 0; kind < 4; kind++) { /* another byte, an end of line, cut, cut and added to */
            memcpy(text, whole, size);
            text[at] = (char)(kind == 0 ? whole[at] ^ 4 : kind == 1 ? '\n' : whole[at]);
            write_text(text, kind < 2 ? size : at);
            m = open_manifest(kind == 3);
            for (int k = 0; k < SAMPLES; k++) {
                if (kind == 3)
                    sp_manifest_add(m, &file, &s[k]);
                const bool there = sp_manifest_find(m, s[k].name, false, &file, &back);
                kept += there;
                lost += !there;
                if (there)
                    assert_same(&s[k], &back);
                assert_true(there || kind < 3);
            }
            sp_manifest_close(m);
        }
    assert_true(4 * kept > lost && lost > 0);
    sp_free(text);
    sp_free(whole);
}

/* Of another form, it is made anew; where a folder, a link or a pipe stands, nothing is known, and nothing is harmed.
 */
TEST_BETWEEN(of_another_form, setup, teardown) {
    const struct stat file = file_of(1000, 50);
    char path[200];
    struct stat info;
    sp_sample s = example(SP_WANT_STATICS, 3), back;
    snprintf(path, sizeof path, "%s/manifest.tsv", folder);
    for (int kind = 0; kind < 4; kind++) {
        if (kind == 3)
            write_text("name\tfile\n", 10);
        else
            assert_int_equal(kind == 0   ? mkdir(path, 0777)
                             : kind == 1 ? symlink("/dev/zero", path)
                                         : mkfifo(path, 0666),
                             0);
        sp_manifest *m = open_manifest(true);
        sp_manifest_add(m, &file, &s);
        assert_true(sp_manifest_find(m, s.name, false, &file, &back) == (kind == 3));
        sp_manifest_close(m);
        assert_int_equal(lstat(path, &info), 0);
        assert_true(kind == 0   ? S_ISDIR(info.st_mode)
                    : kind == 1 ? S_ISLNK(info.st_mode)
                                : kind == 3 || S_ISFIFO(info.st_mode));
        assert_int_equal(kind == 0 ? rmdir(path) : unlink(path), 0);
    }
}

/* Many samples, each with several lines: the last one counts. */
TEST_BETWEEN(grows, setup, teardown) {
    enum { SAMPLES = 1500 };
    sp_sample back;
    sp_manifest *m = open_manifest(true);
    for (int turn = 0; turn < 2; turn++)
        for (uint64_t k = 0; k < SAMPLES; k++) {
            const sp_sample s = example(SP_WANT_CTOF, k);
            sp_manifest_add(m, &(struct stat){.st_size = turn}, &s);
        }
    sp_manifest *other = open_manifest(false);
    for (uint64_t k = 0; k < SAMPLES; k++) {
        const sp_sample s = example(SP_WANT_CTOF, k);
        assert_true(sp_manifest_find(k % 2 ? m : other, s.name, false, &(struct stat){.st_size = 1}, &back));
        assert_same(&s, &back);
    }
    sp_manifest_close(m);
    sp_manifest_close(other);
}

/* ---- claims ------------------------------------------------------------------------------------------------------ */

/* A child that takes the sample, says so, and keeps it until it is killed. */
static pid_t holder(const char *name) {
    int ready[2];
    char byte;
    assert_int_equal(pipe(ready), 0);
    const pid_t child = fork();
    if (child == 0) {
        sp_claims c = {.fd = -1};
        byte = sp_claim_take(&c, folder, name, false) == SP_CLAIM_MINE ? '1' : '0';
        if (write(ready[1], &byte, 1) == 1)
            pause();
        _exit(0);
    }
    assert_int_equal(read(ready[0], &byte, 1), 1);
    assert_int_equal(byte, '1');
    close(ready[0]);
    close(ready[1]);
    return child;
}

TEST_BETWEEN(claims_end_with_their_process, setup, teardown) {
    const sp_sample a = example(0, 1), b = example(0, 2);
    sp_claims mine = {.fd = -1};
    pid_t child = holder(a.name);
    assert_int_equal(sp_claim_take(&mine, folder, a.name, false), SP_CLAIM_OTHERS);
    assert_false(sp_claim_holds(&mine, a.name));
    assert_int_equal(sp_claim_take(&mine, folder, b.name, false), SP_CLAIM_MINE);
    kill(child, SIGKILL);
    assert_int_equal(waitpid(child, NULL, 0), child);
    assert_int_equal(sp_claim_take(&mine, folder, a.name, false), SP_CLAIM_MINE);
    assert_true(sp_claim_holds(&mine, a.name) && sp_claim_holds(&mine, b.name));
    sp_claim_release(&mine, a.name);
    sp_claim_release(&mine, a.name);
    assert_false(sp_claim_holds(&mine, a.name));
    child = holder(a.name); /* which it could take, but not b */
    kill(child, SIGKILL);
    assert_int_equal(waitpid(child, NULL, 0), child);
    assert_int_equal(sp_claim_take(&mine, folder, a.name, true), SP_CLAIM_MINE);
    sp_claims_close(&mine);
    sp_claims nowhere = {.fd = -1};
    assert_int_equal(sp_claim_take(&nowhere, "/proc", a.name, true), SP_CLAIM_FREE);
    sp_claim_release(&nowhere, a.name);
    sp_claims_close(&nowhere);
}

RUN_TESTS(NULL, NULL)
