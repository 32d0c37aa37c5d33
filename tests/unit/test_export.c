/* Files for other programs, by the library: names, what is refused, and lack of memory. tests/cli/test_export.py
 * compares the numbers. */
#include "test_store_fixture.h"

#include <sonopack/study/export_file.h>
#include <sys/stat.h>

static void names_and_endings(void **state) {
    (void)state;
    assert_int_equal(sp_export_form_of("a/b.vtp"), SP_EXPORT_VTP);
    assert_int_equal(sp_export_form_of("B.VTP"), SP_EXPORT_VTP);
    assert_int_equal(sp_export_form_of("x.lammps"), SP_EXPORT_LAMMPS_DATA);
    assert_int_equal(sp_export_form_of("x.extxyz"), SP_EXPORT_XYZ);
    assert_int_equal(sp_export_form_of("a.vtp/b"), SP_EXPORT_NONE);
    assert_int_equal(sp_export_form_of(".vtp"), SP_EXPORT_NONE);
    assert_int_equal(sp_export_form_of("x.h5"), SP_EXPORT_NONE);
    for (int k = 0; sp_export_form_name(k); k++) {
        char path[32];
        snprintf(path, sizeof path, "x%s", sp_export_form_ending(k));
        assert_int_equal(sp_export_form_of(path), k);
        assert_int_equal(sp_export_form_named(sp_export_form_name(k)), k);
    }
    assert_int_equal(sp_export_form_named("paraview"), SP_EXPORT_NONE);
    assert_null(sp_export_form_name(-1));
    static char name[SP_EXPORT_FILES_MAX][SP_EXPORT_PATH_MAX], longest[SP_EXPORT_PATH_MAX];
    assert_int_equal(sp_export_files(SP_EXPORT_VTP, "a.b/c.d.vtp", name), 4);
    assert_string_equal(name[0], "a.b/c.d.vtp");
    assert_string_equal(name[1], "a.b/c.d-contacts.vtp");
    assert_string_equal(name[3], "a.b/c.d.vtm");
    assert_int_equal(sp_export_files(SP_EXPORT_XYZ, "a.b/c", name), 1);
    assert_int_equal(sp_export_files(SP_EXPORT_NONE, "a", name), 0);
    memset(longest, 'x', sizeof longest - 1);
    assert_int_equal(sp_export_files(SP_EXPORT_XYZ, longest, name), 1);
    assert_int_equal(sp_export_files(SP_EXPORT_VTP, longest, name), 0);
    sp_export_frame_name("a/b.pvd", 7, name[0]);
    assert_string_equal(name[0], "a/b-0007.vtp");
    sp_export_frame_name(longest, 7, name[0]);
    assert_string_equal(name[0], "");
}

static void what_is_not_finite_is_refused(void **state) {
    (void)state;
    sp_packing p = fixture_packing(3, 3, 12);
    double u[36] = {0}, w[36] = {0};
    const sp_grain_vectors moved = {u, w};
    const sp_export_options v = {.vectors = &moved};
    for (int k = 0; k < 4; k++) {
        sp_error err = {0};
        *(k & 1 ? &u[17] : &w[17]) = k & 2 ? NAN : INFINITY;
        assert_int_equal(sp_export(&p, SP_EXPORT_VTP, &v, fixture_path(folder, "o.vtp"), &err), SP_EINVAL);
        assert_true(test_names(err.text, "5"));
        assert_int_equal(fixture_count_files(folder), 0);
        u[17] = w[17] = 0;
    }
    sp_error err = {0};
    assert_int_equal(sp_export(&p, SP_EXPORT_LAMMPS_DATA, &v, fixture_path(folder, "o.data"), &err), SP_EINVAL);
    assert_int_equal(sp_export(&p, SP_EXPORT_NONE, NULL, fixture_path(folder, "o"), &err), SP_EINVAL);
    p.r[3] = NAN;
    assert_int_equal(sp_export(&p, SP_EXPORT_XYZ, NULL, fixture_path(folder, "o.xyz"), &err), SP_EFORMAT);
    assert_int_equal(fixture_count_files(folder), 0);
    sp_packing_free(&p);
}

/* ---- series ----------------------------------------------------------------------------------------------------- */

static void frame(void *user, int k, double *displacement, double *rotation) {
    const int32_t n = *(const int32_t *)user;
    for (int32_t i = 0; i < 3 * n; i++)
        displacement[i] = k == 3 && i == 7 ? NAN : 0.1 * k;
    if (rotation)
        memset(rotation, 0, 3 * (size_t)n * sizeof *rotation);
}

static void a_series_is_whole_or_not_there(void **state) {
    (void)state;
    sp_packing p = fixture_packing(5, 2, 10);
    const double time[4] = {0, 1, 2, 3};
    sp_export_series s = {.frames = 4, .time = time, .scale = 1, .frame = frame, .rotations = true, .user = &p.n};
    sp_error why = {0};
    assert_int_equal(sp_export_pvd(&p, &s, fixture_path(folder, "o.pvd"), &why), SP_EINVAL);
    assert_true(test_names(why.text, "3 2"));
    assert_int_equal(fixture_count_files(folder), 0);
    fixture_write(fixture_path(folder, "o-0001.vtp"), "older");
    assert_int_equal(sp_export_pvd(&p, &s, fixture_path(folder, "o.pvd"), &why), SP_EINVAL);
    assert_int_equal(fixture_count_files(folder), 1); /* what was there before stays */
    s.frames = 3;
    assert_ok(sp_export_pvd(&p, &s, fixture_path(folder, "o.pvd"), &err));
    assert_int_equal(fixture_count_files(folder), 4);
    s.frames = 0;
    assert_int_equal(sp_export_pvd(&p, &s, fixture_path(folder, "q.pvd"), &why), SP_EINVAL);
    s.frames = 3;
    s.scale = INFINITY;
    assert_int_equal(sp_export_pvd(&p, &s, fixture_path(folder, "q.pvd"), &why), SP_EINVAL);
    assert_int_equal(fixture_count_files(folder), 4);
    sp_packing_free(&p);
    fixture_remove(folder);
    mkdir(folder, 0700);
}

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
    static const char *const files[] = {"o.vtp", "o.data", "o.dump", "o.xyz", "o.csv", "o.mat"};
    enum { SERIES = sizeof files / sizeof *files, TABLE, SAC, SLIST, ACTIONS };
    sp_packing p = fixture_packing(9, 2, 20);
    sp_table t = some_table();
    double u[60] = {0}, value[4] = {0, 1, 2, 3};
    const double time[3] = {0, 1, 2};
    const sp_grain_vectors moved = {u, u};
    const sp_material glass = {.young = 7e10, .poisson = 0.2, .density = 2500, .diameter = 1e-3};
    const sp_export_options v = {.vectors = &moved, .si = &glass}, plain = {.si = &glass};
    const sp_export_series s = {
        .frames = 3, .time = time, .scale = 1, .si = &glass, .frame = frame, .rotations = true, .user = &p.n};
    const sp_trace trace = trace_of(4, value);
    for (int action = 0; action < ACTIONS; action++) {
        sp_status status = SP_ENOMEM;
        for (int64_t k = 0; status != SP_OK; k++) {
            sp_error err = {0};
            sp_alloc_fail_after(k);
            if (action < SERIES)
                status = sp_export(&p, (sp_export_form)action, action == SP_EXPORT_LAMMPS_DATA ? &plain : &v,
                                   fixture_path(folder, files[action]), &err);
            else if (action == SERIES)
                status = sp_export_pvd(&p, &s, fixture_path(folder, "o.pvd"), &err);
            else if (action == TABLE)
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
    sp_packing_free(&p);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_and_endings), cmocka_unit_test(what_is_not_finite_is_refused),
        cmocka_unit_test(a_series_is_whole_or_not_there), cmocka_unit_test(signals_are_checked),
        cmocka_unit_test(lack_of_memory_is_an_error)};
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
