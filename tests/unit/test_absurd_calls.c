/* One process that calls the library's functions again and again, most of all where they fail: the memory that is in
 * use and the files that are open stay as they were after the first rounds. */
#include "base/base.h"
#include "test.h"

#include <dirent.h>
#include <malloc.h>
#include <sonopack/sonopack.h>
#include <sonopack/study/store.h>
#include <sys/resource.h>
#include <unistd.h>

#ifndef ROUNDS
#define ROUNDS 60
#endif
/* Bytes: the lists of other libraries may grow now and then, but what is lost in every round has 32 at the least. */
enum { WARM = 20, SLACK = 60000 + 8 * ROUNDS };

static char folder[] = "/tmp/sonopack-calls-XXXXXX", packing_h5[64], packing_txt[64], table[64], broken[64],
            store_path[64];

static int setup(void **state) {
    (void)state;
    if (!mkdtemp(folder))
        return 1;
    snprintf(packing_h5, sizeof packing_h5, "%s/p.h5", folder);
    snprintf(packing_txt, sizeof packing_txt, "%s/p.txt", folder);
    snprintf(table, sizeof table, "%s/t.tsv", folder);
    snprintf(broken, sizeof broken, "%s/broken.h5", folder);
    snprintf(store_path, sizeof store_path, "%s/store", folder);
    FILE *f = fopen(broken, "w");
    return !f || fputs("\211HDF\r\n\032\nnothing that follows is HDF5", f) < 0 || fclose(f) != 0;
}

static int teardown(void **state) {
    (void)state;
    char manifest[80];
    snprintf(manifest, sizeof manifest, "%s/manifest.tsv", store_path);
    const char *const all[] = {packing_h5, packing_txt, table, broken, manifest, store_path, folder};
    for (size_t k = 0; k < sizeof all / sizeof *all; k++)
        remove(all[k]);
    return 0;
}

/* ---- what a round does ------------------------------------------------------------------------------------------- */

static void scenes(void) {
    static const char *const texts[] = {
        "packing: { kind = \"chain\"; grains = 12; };",
        "packing: { grains = [20, 30]; pressure = { from = 1e-7; to = 1e-4; count = 4; }; };", "packing: { grains = ;",
        "packing: { grains = -1; };", "nonsense = 1;"};
    for (size_t k = 0; k < sizeof texts / sizeof *texts; k++) {
        FREED(sp_scene) scene = sp_scene_default();
        sp_error reason = {0};
        const sp_status status = sp_scene_parse(texts[k], "text", 0, NULL, &scene, &reason);
        assert_int_equal(status == SP_OK, k < 2);
    }
}

static void files(const sp_packing *p) {
    sp_packing read = sp_packing_none();
    sp_store *store = NULL;
    sp_error reason = {0};
    assert_ok(sp_packing_save(p, packing_h5, &err));
    assert_ok(sp_packing_save_text(p, packing_txt, &err));
    assert_ok(sp_packing_read(packing_h5, &read, &err));
    sp_packing_free(&read);
    assert_ok(sp_packing_read(packing_txt, &read, &err));
    sp_packing_free(&read);
    assert_int_not_equal(sp_packing_read(broken, &read, &reason), SP_OK);
    assert_int_not_equal(sp_packing_read("/proc/nowhere/p.h5", &read, &reason), SP_OK);
    assert_int_not_equal(sp_packing_save(p, "/proc/nowhere/p.h5", &reason), SP_OK);
    assert_ok(sp_store_open(store_path, true, &store, &err));
    sp_store_close(store);
}

static void tables(const sp_signal *s) {
    FREED(sp_table) t = sp_table_none(), back = sp_table_none();
    sp_error reason = {0};
    assert_ok(sp_table_add_column(&t, "t", "", SP_COLUMN_NUMBER, &err));
    assert_ok(sp_table_add_column(&t, "F", "", SP_COLUMN_NUMBER, &err));
    for (int32_t k = 0; k < s->n; k++)
        assert_ok(sp_table_add_row(&t, &err, s->t[k], s->f[k]));
    char *text = sp_table_text(&t, SP_TSV);
    assert_non_null(text);
    assert_ok(sp_text_save(table, text, strlen(text), &err));
    sp_free(text);
    assert_ok(sp_table_read(table, &back, &err));
    assert_int_not_equal(sp_table_read(broken, &back, &reason), SP_OK);
}

static void sound(const sp_network *net) {
    sp_signal s = sp_signal_none();
    sp_signal_options o = sp_signal_options_default();
    sp_modes_options how = sp_modes_options_default();
    sp_modes m = sp_modes_none();
    sp_front_options rule = sp_front_options_default();
    sp_front front;
    sp_error reason = {0};
    o.until = 100;
    assert_ok(sp_signal_make(net, &o, &s, &err));
    assert_ok(sp_front_find(s.n, s.t, s.f, &rule, &front, &err));
    tables(&s);
    sp_signal_free(&s);
    o.until = -1;
    assert_int_equal(sp_signal_make(net, &o, &s, &reason), SP_EINVAL);
    how.vectors = true;
    assert_ok(sp_modes_dense(net, &how, &m, &err));
    sp_modes_free(&m);
    for (int64_t fail = 0; fail < 8; fail++) { /* memory that is short leaves nothing behind */
        sp_alloc_fail_after(fail);
        const sp_status status = sp_modes_dense(net, &how, &m, &reason);
        sp_alloc_fail_after(-1);
        assert_true(status == SP_OK || status == SP_ENOMEM);
        sp_modes_free(&m);
    }
}

static void one_round(uint64_t seed) {
    sp_pack_spec spec = sp_pack_spec_default();
    FREED(sp_packing) p = sp_packing_none();
    FREED(sp_network) net = sp_network_none();
    sp_network_options o = sp_network_options_default();
    spec.kind = SP_PACK_CHAIN;
    spec.dim = 1;
    spec.grains = 12;
    spec.diameter_min = 0.9;
    spec.diameter_max = 1.1;
    spec.seed = seed;
    scenes();
    assert_ok(sp_packing_make(&spec, NULL, NULL, &p, &err));
    assert_ok(sp_network_make(&p, &o, &net, &err));
    files(&p);
    sound(&net);
}

/* ---- what must stay ---------------------------------------------------------------------------------------------- */

static size_t bytes_in_use(void) {
    const struct mallinfo2 info = mallinfo2();
    return info.uordblks + info.hblkhd;
}

static int open_files(void) {
    int count = 0;
    DIR *all = opendir("/proc/self/fd");
    while (all && readdir(all))
        count++;
    if (all)
        closedir(all);
    return count;
}

TEST(rounds_leave_nothing) {
    size_t bytes = 0;
    int files_open = 0;
    for (int k = 0; k < WARM + ROUNDS; k++) {
        if (k == WARM) {
            bytes = bytes_in_use();
            files_open = open_files();
        }
        one_round((uint64_t)k + 1);
    }
    assert_int_equal(open_files(), files_open);
    if (bytes_in_use() > bytes + SLACK)
        fail_msg("%zu bytes in use after %d rounds, %zu before", bytes_in_use(), ROUNDS, bytes);
    print_message("%d rounds: %zu bytes in use, %zu before\n", ROUNDS, bytes_in_use(), bytes);
}

/* All modes of 6000 balls need 0.9 GB, which are asked for before anything is taken. */
TEST(modes_ask_for_memory) {
    const struct rlimit little = {(rlim_t)600 << 20, RLIM_INFINITY};
    struct rlimit before;
    sp_pack_spec spec = sp_pack_spec_default();
    FREED(sp_packing) p = sp_packing_none();
    FREED(sp_network) net = sp_network_none();
    sp_network_options o = sp_network_options_default();
    sp_modes_options how = sp_modes_options_default();
    sp_modes m = sp_modes_none();
    sp_error reason = {0};
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    skip(); /* they map terabytes */
#endif
    how.vectors = true;
    spec.kind = SP_PACK_CHAIN;
    spec.dim = 1;
    spec.grains = 6000;
    assert_ok(sp_packing_make(&spec, NULL, NULL, &p, &err));
    assert_ok(sp_network_make(&p, &o, &net, &err));
    assert_int_equal(getrlimit(RLIMIT_AS, &before), 0);
    assert_int_equal(setrlimit(RLIMIT_AS, &little), 0);
    assert_int_equal(sp_modes_dense(&net, &how, &m, &reason), SP_ENOMEM);
    assert_int_equal(setrlimit(RLIMIT_AS, &before), 0);
    assert_non_null(strstr(reason.text, "6000"));
}

RUN_TESTS(setup, teardown)
