/* Tables and signals for other programs, by the library: what is refused, and lack of memory. tests/cli/test_export.py
 * compares the numbers. */
#include "test_store_fixture.h"

#include <sonopack/study/export_file.h>
#include <sys/stat.h>

/* ---- signals ---------------------------------------------------------------------------------------------------- */

static sp_trace trace_of(int64_t n, const double *value) {
    return (sp_trace){.station = "top",
                      .component = "F",
                      .event = "impulse",
                      .unit = "N",
                      .time_unit = "s",
                      .step = 0.25,
                      .n = n,
                      .value = value,
                      .pressure = NAN,
                      .height = NAN};
}

static void signals_are_checked(void **state) {
    (void)state;
    const char *sac = fixture_path(folder, "o.sac"), *slist = fixture_path(folder, "o.slist");
    double value[4] = {0, 1e-300, -2, 3};
    sp_error why = {0};
    sp_trace t = trace_of(4, value);
    const double bad[] = {NAN, INFINITY, -INFINITY, 1e39};
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        value[2] = bad[k];
        assert_int_equal(sp_trace_save_sac(&t, sac, &why), SP_EINVAL);
        assert_int_equal(sp_traces_save_slist(1, &t, slist, &why), k < 3 ? SP_EINVAL : SP_OK);
        unlink(slist);
    }
    value[2] = -2;
    t.n = 1;
    assert_int_equal(sp_trace_save_sac(&t, sac, &why), SP_EINVAL);
    t = trace_of(4, value);
    t.step = 0;
    assert_int_equal(sp_trace_save_sac(&t, sac, &why), SP_EINVAL);
    assert_int_equal(sp_traces_save_slist(1, &t, slist, &why), SP_EINVAL);
    t = trace_of(4, value);
    t.begin = 61;
    assert_int_equal(sp_traces_save_slist(1, &t, slist, &why), SP_EINVAL);
    assert_int_equal(fixture_count_files(folder), 0);
    assert_ok(sp_trace_save_sac(&t, sac, &err));
    struct stat info;
    assert_int_equal(stat(sac, &info), 0);
    assert_int_equal(info.st_size, 632 + 4 * 4);
    unlink(sac);
}

/* ---- lack of memory --------------------------------------------------------------------------------------------- */

static sp_table some_table(void) {
    sp_table t = sp_table_none();
    assert_ok(sp_table_add_column(&t, "t", "s", SP_COLUMN_NUMBER, &err));
    assert_ok(sp_table_add_column(&t, "1 name", "", SP_COLUMN_TEXT, &err));
    assert_ok(sp_table_add_comment(&t, &err, "pressure = 1 \xc2\xb5Pa"));
    for (int k = 0; k < 3; k++)
        assert_ok(sp_table_add_row(&t, &err, 0.5 * k, k == 1 ? "" : "word"));
    return t;
}

/* Each allocation in turn fails: an error, and no file. */
static void lack_of_memory_is_an_error(void **state) {
    (void)state;
    enum { TABLE, SAC, SLIST, ACTIONS };
    sp_table t = some_table();
    const double value[4] = {0, 1, 2, 3};
    const sp_trace trace = trace_of(4, value);
    for (int action = 0; action < ACTIONS; action++) {
        sp_status status = SP_ENOMEM;
        for (int64_t k = 0; status != SP_OK; k++) {
            sp_error err = {0};
            sp_alloc_fail_after(k);
            if (action == TABLE)
                status = sp_table_save_mat(&t, fixture_path(folder, "t.mat"), &err);
            else if (action == SAC)
                status = sp_trace_save_sac(&trace, fixture_path(folder, "o.sac"), &err);
            else
                status = sp_traces_save_slist(1, &trace, fixture_path(folder, "o.slist"), &err);
            sp_alloc_fail_after(-1);
            assert_true(k < 2000);
            if (status != SP_OK) {
                assert_int_equal(status, SP_ENOMEM);
                assert_int_equal(fixture_count_files(folder), 0);
            }
        }
        assert_true(fixture_count_files(folder) > 0);
        fixture_remove(folder);
        mkdir(folder, 0700);
    }
    sp_table_free(&t);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(signals_are_checked),
                                       cmocka_unit_test(lack_of_memory_is_an_error)};
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
