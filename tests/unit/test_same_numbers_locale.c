/* The library in a program that has set a locale with a decimal comma: what it reads and what it writes has points. */
#include "test.h"

#include "base/base.h"
#include "base/text.h"
#include "comma.h"

#include <sonopack/network.h>
#include <sonopack/packing.h>
#include <sonopack/study/scene.h>
#include <sonopack/table.h>

static char folder[] = "/tmp/sonopack-comma-XXXXXX";

static void write_file(const char *name, const char *text, char *path, size_t size) {
    snprintf(path, size, "%s/%s", folder, name);
    FILE *out = fopen(path, "w");
    assert_non_null(out);
    fputs(text, out);
    assert_int_equal(fclose(out), 0);
}

TEST(test_damping) {
    sp_damping law = {0};
    assert_ok(sp_damping_read("zeta:0.25", &law, &err));
    assert_true(law.value == 0.25);
    assert_ok(sp_damping_read("gamma:0.5:0.125", &law, &err));
    assert_true(law.value == 0.5 && law.ratio == 0.25);
}

TEST(test_scene) {
    char sizes[64], path[64];
    write_file("sizes.txt", "0.75\n1\n1.25\n", sizes, sizeof sizes);
    write_file("scene.cfg",
               "packing = { kind = \"chain\"; sizes = \"list\"; diameter_file = \"sizes.txt\"; grains = 3; "
               "pressure = 2.5e-4; };\n",
               path, sizeof path);
    FREED(sp_scene) scene = sp_scene_default();
    assert_ok(sp_scene_read(path, 0, NULL, &scene, &err));
    assert_true(scene.pack.pressure == 2.5e-4 && scene.pack.diameters[0] == 0.75 && scene.pack.diameters[2] == 1.25);
}

TEST(test_texts) {
    FREED(sp_table) t = sp_table_none();
    assert_ok(sp_table_add_comment(&t, &err, "gamma = %g", 0.625));
    assert_string_equal(t.comment[0], "gamma = 0.625");
    sp_error why = {0};
    sp_fail(&why, SP_EINVAL, "value %g", 0.5);
    sp_fail_prefix(&why, "limit %g", 1.5);
    assert_string_equal(why.text, "limit 1.5: value 0.5");
    char reason[256];
    const sp_audit audit = {.force_residual = 0.5};
    assert_true(sp_audit_worst(&audit, 0.25, reason, sizeof reason) == 0.5);
    assert_non_null(strstr(reason, "0.5"));
    assert_non_null(strstr(reason, "0.25"));
}

int main(void) {
    if (!mkdtemp(folder) || !comma_set(folder))
        return 77; /* skipped: no locale of C to start from */
    const int failed = _cmocka_run_group_tests("tests", test_all, test_count, NULL, NULL);
    char command[64];
    snprintf(command, sizeof command, "rm -r %s", folder);
    return system(command) == 0 ? failed : 1;
}
