#include "base/base.h"
#include "test.h"

#include <sonopack/figure/plot.h>
#include <unistd.h>

#if defined(__SANITIZE_ADDRESS__)
/* fontconfig, behind cairo, keeps offsets in place of pointers: the leak checker cannot see that its memory is held. */
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) { return "leak:libfontconfig"; }
const char *__lsan_default_options(void);
const char *__lsan_default_options(void) { return "print_suppressions=0"; }
#endif

static char path[] = "/tmp/sonopack-pareto-XXXXXX/figure.svg";
static char *folder;

static int setup(void **state) {
    static char name[sizeof path];
    (void)state;
    memcpy(name, path, sizeof name);
    *strrchr(name, '/') = '\0';
    folder = mkdtemp(name);
    memcpy(path, name, strlen(name));
    return folder ? 0 : 1;
}
static int teardown(void **state) {
    (void)state;
    remove(path);
    return rmdir(folder);
}

static sp_table bench_table(void) {
    sp_table t = sp_table_none();
    static const char *const names[] = {"case", "method", "parameter", "seconds", "error", "memory_MB"};
    for (int k = 0; k < 6; k++)
        assert_ok(sp_table_add_column(&t, names[k], "", k < 2 ? SP_COLUMN_TEXT : SP_COLUMN_NUMBER, &err));
    return t;
}

static void add(sp_table *t, const char *name, const char *method, double seconds, double error) {
    assert_ok(sp_table_add_row(t, &err, name, method, (double)NAN, seconds, error, 1.0));
}

static bool drawn(const char *word) {
    char text[200000];
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    text[fread(text, 1, sizeof text - 1, file)] = '\0';
    fclose(file);
    return strstr(text, word) != NULL;
}

/* Methods and the case are named; auto, and rows of other cases or without a number, are not drawn. */
TEST(test_rows) {
    sp_table t = bench_table();
    add(&t, "signal:a", "auto", 1e-3, 1e-12);
    add(&t, "signal:a", "expansion", 1e-3, 1e-12);
    add(&t, "signal:a", "expansion", 2e-3, 0);
    add(&t, "signal:a", "other DOP853", 1e-1, 1e-6);
    add(&t, "signal:a", "nothing", NAN, 1e-6);
    add(&t, "signal:a", "never", 0, 1e-6);
    add(&t, "signal:b", "elsewhere", 1, 1);
    assert_ok(sp_plot_pareto(&t, NULL, path, &err));
    assert_true(drawn("expansion") && drawn("other DOP853") && drawn("signal:a"));
    assert_false(drawn("auto") || drawn("nothing") || drawn("never") || drawn("elsewhere"));
    assert_ok(sp_plot_pareto(&t, "signal:b", path, &err));
    assert_true(drawn("elsewhere") && !drawn("expansion"));
    assert_fails(sp_plot_pareto(&t, "signal:c", path, &err), SP_EREFUSED, "signal:c");
    sp_table_free(&t);
}

TEST(test_refusals) {
    sp_table t = bench_table();
    assert_fails(sp_plot_pareto(&t, NULL, path, &err), SP_EREFUSED, "");
    for (int k = 0; k < 40; k++) {
        char name[16];
        snprintf(name, sizeof name, "m%d", k);
        add(&t, "c", name, 1 + k, 1e-3);
    }
    assert_fails(sp_plot_pareto(&t, NULL, path, &err), SP_EREFUSED, "methods");
    sp_table_free(&t);
    t = sp_table_none();
    assert_ok(sp_table_add_column(&t, "case", "", SP_COLUMN_TEXT, &err));
    assert_fails(sp_plot_pareto(&t, NULL, path, &err), SP_EINVAL, "columns");
    sp_table_free(&t);
}

TEST(test_no_memory) {
    sp_table t = bench_table();
    add(&t, "c", "m", 1, 1e-3);
    for (int k = 0; k < 2; k++) {
        sp_error err = {0};
        sp_alloc_fail_after(k);
        assert_int_equal(sp_plot_pareto(&t, NULL, path, &err), SP_ENOMEM);
        sp_alloc_fail_after(-1);
    }
    sp_table_free(&t);
}

RUN_TESTS(setup, teardown)
