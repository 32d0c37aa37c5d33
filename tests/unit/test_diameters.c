/* Lists of diameters: in the scene, in a file of their own, and what a wrong one is told. */
#include "test.h"

#include "base/base.h"
#include "ensemble/sample.h"
#include <sonopack/study/study.h>
#include <unistd.h>

static char folder[] = "/tmp/sonopack-test-diameters-XXXXXX";

static void write_file(const char *name, const char *text) {
    char path[256];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

/* A scene of five grains in a list, further keys in `more`. */
static sp_status read_scene(const char *more, const char *override, sp_scene *s, sp_error *err) {
    char path[256], text[600], copy[600];
    snprintf(text, sizeof text, "packing = { kind = \"chain\"; grains = 5; sizes = \"list\";\n%s };\n", more);
    write_file("s.cfg", text);
    snprintf(path, sizeof path, "%s/s.cfg", folder);
    snprintf(copy, sizeof copy, "%s", override ? override : "");
    char *list[] = {copy};
    return sp_scene_read(path, override ? 1 : 0, list, s, err);
}

static bool owns(const sp_scene *s, const double *list) {
    for (int k = 0; k < SP_LISTS_MAX; k++)
        if (s->owned[k] == list)
            return true;
    return false;
}

static void assert_list(const sp_scene *s, int32_t count, const double *numbers) {
    assert_int_equal(s->pack.diameter_count, count);
    assert_true(owns(s, s->pack.diameters));
    assert_memory_equal(s->pack.diameters, numbers, (size_t)count * sizeof *numbers);
}

TEST(numbers_are_read_from_both) {
    const double numbers[] = {0.9, 1.1, 1, 0.1, 0.8, 1.2};
    char absolute[600];
    sp_scene s;
    assert_ok(read_scene("diameters = [0.9, 1.1, 1, 1e-1, 0.8, 1.2];", NULL, &s, &err));
    assert_list(&s, 6, numbers);
    sp_scene_free(&s);
    assert_null(s.pack.diameters);
    assert_int_equal(s.pack.diameter_count, 0);
    write_file("d.txt", "\xef\xbb\xbf# sizes\n\n 0.9\t# first\r\n1.1\n+1.0\n1e-1\n.8\n1.2");
    assert_ok(read_scene("diameter_file = \"d.txt\";", NULL, &s, &err)); /* beside the scene */
    assert_list(&s, 6, numbers);
    sp_scene_free(&s);
    /* an override takes the place of either, relative to the current folder */
    write_file("worse.txt", "1\nworse\n");
    snprintf(absolute, sizeof absolute, "packing.diameter_file=%s/d.txt", folder);
    assert_ok(read_scene("diameter_file = \"worse.txt\";", absolute, &s, &err));
    assert_list(&s, 6, numbers);
    sp_scene_free(&s);
    assert_ok(read_scene("diameters = [2.0];", absolute, &s, &err));
    assert_list(&s, 6, numbers);
    sp_scene_free(&s);
    assert_ok(read_scene("diameter_file = \"worse.txt\";", "packing.diameters=[0.9, 1.1, 1, 0.1, 0.8, 1.2]", &s, &err));
    assert_list(&s, 6, numbers);
    sp_scene_free(&s);
    char before[1024];
    assert_non_null(getcwd(before, sizeof before));
    assert_int_equal(chdir(folder), 0);
    write_file("a \"b\\.txt", "0.9\n1.1\n1\n0.1\n0.8\n1.2\n");
    const sp_status status = read_scene("", "packing.diameter_file=a \"b\\.txt", &s, NULL);
    assert_int_equal(chdir(before), 0);
    assert_int_equal(status, SP_OK);
    assert_list(&s, 6, numbers);
    sp_scene_free(&s);
}

TEST(the_numbers_decide_the_sample) {
    const char *lists[] = {"0.9\n1.1\n1\n1\n1\n", "0.9\n1.1\n1\n1\n1.0000000000000002\n", "0.90 \n1.1\n1\n1\n1"};
    char names[3][SP_NAME_MAX];
    for (int k = 0; k < 3; k++) {
        FREED(sp_scene) s, back, one;
        write_file("d.txt", lists[k]);
        assert_ok(read_scene("diameter_file = \"d.txt\";", NULL, &s, &err));
        sp_sample_name(&s, names[k]);
        /* the stored text holds the numbers, and needs the file no more */
        char *text = sp_scene_text(&s, NULL);
        assert_null(strstr(text, "d.txt"));
        assert_ok(sp_scene_parse(text, "stored", 0, NULL, &back, &err));
        char *again = sp_scene_text(&back, NULL);
        assert_string_equal(text, again);
        assert_list(&back, 5, s.pack.diameters);
        /* samples of a study share the list, and leave it to the study */
        assert_ok(sp_study_scene(&s, 0, &one, &err));
        assert_ptr_equal(one.pack.diameters, s.pack.diameters);
        assert_false(owns(&one, one.pack.diameters));
        FREED(sp_packing) p = sp_packing_none();
        assert_ok(sp_packing_make(&one.pack, NULL, NULL, &p, &err));
        for (int i = 0; i < 5; i++)
            assert_true(2 * p.r[i] == s.pack.diameters[i]);
        sp_free(again);
        sp_free(text);
    }
    assert_string_not_equal(names[0], names[1]);
    assert_string_equal(names[0], names[2]);
}

TEST(wrong_files_are_refused) {
    static const struct {
        const char *text, *reason;
    } forged[] = {
        {"", "d.txt"},
        {"# nothing\n\n  \n", "d.txt"},
        {"1\n1\n1\n1\n", "packing.diameters 4 packing.grains 5"},
        {"1\none\n", "d.txt:2 one 0.01 100"},
        {"1\n1\n-1\n", "d.txt:3 -1"},
        {"1\n0\n", "d.txt:2 0"},
        {"# c\n\nnan\n", "d.txt:3 nan"},
        {"inf", "d.txt:1 inf"},
        {"1e999", "d.txt:1 1e999"},
        {"101", "d.txt:1 101"},
        {"0x1", "d.txt:1 0x1"},
        {"1 2\n", "d.txt:1 1 2"},
        {"1,1\n", "d.txt:1 1,1"},
        {"1..2\n", "d.txt:1 1..2"},
        {"1e\n", "d.txt:1 1e"},
        {"+-1\n", "d.txt:1 +-1"},
        {"1111111111111111111111111111111111111111111111111111111111111111111111111111\n", "d.txt:1"},
    };
    sp_scene s;
    for (size_t k = 0; k < sizeof forged / sizeof *forged; k++) {
        write_file("d.txt", forged[k].text);
        assert_fails(read_scene("diameter_file = \"d.txt\";", NULL, &s, &err), SP_EINVAL, forged[k].reason);
        assert_fails(read_scene("diameter_file = \"d.txt\";", NULL, &s, &err), SP_EINVAL, "s.cfg");
        assert_int_equal(read_scene("diameter_file = \"d.txt\";", NULL, &s, NULL), SP_EINVAL);
    }
    assert_fails(read_scene("\ndiameter_file = \"absent.txt\";", NULL, &s, &err), SP_EINVAL,
                 "s.cfg:3 packing.diameter_file");
    assert_fails(read_scene("diameter_file = \"absent.txt\";", NULL, &s, &err), SP_EINVAL, "absent.txt No such file");
    assert_fails(read_scene("diameter_file = \".\";", NULL, &s, &err), SP_EINVAL, "Is a directory");
    assert_fails(read_scene("diameter_file = \"/dev/zero\";", NULL, &s, &err), SP_EINVAL, "/dev/zero zero byte");
    assert_fails(read_scene("", "packing.diameter_file=absent.txt", &s, &err), SP_EINVAL,
                 "--set packing.diameter_file absent.txt No such file");
    char name[20000];
    memset(name, 'a', sizeof name);
    memcpy(name, "packing.diameter_file=", 22);
    name[5000] = '\0';
    char *list[] = {name};
    assert_fails(sp_scene_read(NULL, 1, list, &s, &err), SP_EINVAL, "--set packing.diameter_file");
}

TEST(wrong_lists_are_refused) {
    sp_scene s;
    write_file("d.txt", "1\n1\n1\n1\n1\n");
#define REFUSED(more, reason) assert_fails(read_scene(more, NULL, &s, &err), SP_EINVAL, reason)
    REFUSED("", "packing.diameters 0 packing.grains 5");
    REFUSED("diameters = [1, 1, 1];", "packing.diameters 3");
    REFUSED("diameters = [1, 1,\n -1];", "s.cfg:3 packing.diameters -1");
    REFUSED("diameters = [1, 1, 1e3];", "packing.diameters 1000");
    REFUSED("diameters = [1, \"two\"];", "packing.diameters two");
    REFUSED("diameters = 1;", "packing.diameters 1");
    REFUSED("diameter_file = 1;", "packing.diameter_file 1");
    REFUSED("diameters = [1]; diameter_file = \"d.txt\";", "packing.diameters");
    REFUSED("diameters = [1, 1, 1, 1, 1]; diameter_min = 0.5;", "packing.diameter_min 0.5 0");
#undef REFUSED
    assert_fails(read_scene("diameter_file = \"d.txt\";", "packing.sizes=uniform", &s, &err), SP_EINVAL,
                 "packing.sizes uniform list");
    assert_fails(
        read_scene("diameter_file = \"d.txt\"; }; study = { sweep = ( { key = \"packing.grains\"; values = [5, "
                   "6]; } );",
                   NULL, &s, &err),
        SP_EINVAL, "packing.grains 6");
}

/* A reason, no leak (the sanitizers look). */
TEST(lack_of_memory) {
    sp_scene s;
    write_file("d.txt", "1\n1\n1\n1\n1\n");
    EACH_ALLOCATION_FAILS(2, read_scene("diameters = [1, 1, 1, 1, 1];", "packing.diameter_file=", &s, &err),
                          lacks ? (void)0 : sp_scene_free(&s));
    EACH_ALLOCATION_FAILS(2, read_scene("diameter_file = \"d.txt\";", NULL, &s, &err),
                          lacks ? (void)0 : sp_scene_free(&s));
}

static int make_folder(void **state) {
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state) {
    (void)state;
    const char *names[] = {"s.cfg", "d.txt", "worse.txt", "a \"b\\.txt"};
    char path[256];
    for (int k = 0; k < 4; k++) {
        snprintf(path, sizeof path, "%s/%s", folder, names[k]);
        unlink(path);
    }
    return rmdir(folder);
}

RUN_TESTS(make_folder, remove_folder)
