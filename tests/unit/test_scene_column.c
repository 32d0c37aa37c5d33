/* The group column of a scene: its lists, its check, and that nothing else depends on it. */
#include "test.h"

#include "base/base.h"
#include "ensemble/sample.h"
#include "scene/field.h"

#include <sonopack/study/scene.h>
#include <sonopack/study/study.h>

static sp_status parse(const char *text, sp_scene *out, sp_error *err) {
    return sp_scene_parse(text, "s.cfg", 0, NULL, out, err);
}

static sp_status column_of(const char *override, sp_scene *out, sp_error *err) {
    char *list[] = {(char *)(uintptr_t) override};
    return sp_scene_read_tapped(NULL, override ? 1 : 0, list, out, err);
}

static void defaults_are_those_of_the_column(void **state) {
    (void)state;
    const sp_tapped_spec c = sp_tapped_spec_default();
    sp_scene s;
    assert_ok(column_of(NULL, &s, &err));
    assert_true(s.tapped.particles == c.particles && s.tapped.frequency == c.frequency && s.tapped.e == c.e);
    assert_true(s.tapped.masses == 1 && s.tapped.mass[0] == 1 && s.tapped.radii == 1 && s.tapped.radius[0] == 1);
    assert_true(s.masses == NULL && s.radii == NULL);
    sp_scene_free(&s);
    assert_true(sp_scene_get(&s, "column.amplitude") == c.amplitude);
}

static void lists_are_one_number_or_several(void **state) {
    (void)state;
    sp_scene s;
    assert_ok(parse("column = { mass = 2; radius = [1, 0.5, 1]; };", &s, &err));
    assert_int_equal(s.tapped.masses, 1);
    assert_int_equal(s.tapped.radii, 3);
    assert_true(s.tapped.mass[0] == 2 && s.tapped.radius[1] == 0.5);
    assert_ptr_equal(s.tapped.mass, s.masses);
    sp_scene_free(&s);
    assert_ok(column_of("column.mass=1,2, 3", &s, &err));
    assert_true(s.tapped.masses == 3 && s.tapped.mass[2] == 3);
    sp_scene_free(&s);
    assert_ok(column_of("column.mass=0.5", &s, &err));
    assert_true(s.tapped.masses == 1 && s.tapped.mass[0] == 0.5);
    sp_scene_free(&s);
}

static void each_check_is_for_its_own(void **state) {
    (void)state;
    char bad_packing[] = "packing.width=1", bad_column[] = "column.e=1", *packing[] = {bad_packing},
         *column[] = {bad_column};
    sp_scene s;
    assert_ok(sp_scene_read(NULL, 1, column, &s, &err)); /* a packing has nothing to do with it */
    sp_scene_free(&s);
    assert_fails(sp_scene_read_tapped(NULL, 1, column, &s, &err), SP_EINVAL, "column.e 1");
    assert_fails(sp_scene_read(NULL, 1, packing, &s, &err), SP_EINVAL, "packing.width");
    assert_ok(sp_scene_read_tapped(NULL, 1, packing, &s, &err));
    sp_scene_free(&s);
}

static void columns_are_not_swept(void **state) {
    (void)state;
    sp_scene s;
    assert_fails(parse("study = { sweep = ( { key = \"column.e\"; values = [0, 0.1]; } ); };", &s, &err), SP_EINVAL,
                 "study.sweep column.e");
}

/* A store that was made without this group is found again with it. */
static void samples_do_not_know_it(void **state) {
    (void)state;
    sp_scene plain, other;
    char names[2][SP_NAME_MAX];
    assert_ok(parse("packing = { kind = \"chain\"; grains = 5; };", &plain, &err));
    assert_ok(parse("packing = { kind = \"chain\"; grains = 5; };"
                    "column = { e = 0.5; mass = [1, 2]; output = \"energy\"; };",
                    &other, &err));
    sp_sample_name(&plain, names[0]);
    sp_sample_name(&other, names[1]);
    assert_string_equal(names[0], names[1]);
    assert_string_not_equal(names[0], "");
    assert_true(sp_signal_keys(&plain) == sp_signal_keys(&other));
    char *one = sp_scene_text(&plain, NULL), *two = sp_scene_text(&other, NULL);
    assert_string_equal(one, two);
    sp_free(one);
    sp_free(two);
    sp_scene sample;
    assert_ok(sp_study_scene(&other, 0, &sample, &err));
    sp_scene_free(&sample); /* lists stay the study's */
    assert_true(other.tapped.mass[1] == 2);
    sp_scene_free(&plain);
    sp_scene_free(&other);
}

static void lack_of_memory(void **state) {
    (void)state;
    char mass[] = "column.mass=[1, 2]", radius[] = "column.radius=2", *list[] = {mass, radius};
    sp_status status = SP_ENOMEM;
    int failures = 0;
    for (int64_t after = 0; status == SP_ENOMEM; after++) {
        sp_scene s;
        sp_alloc_fail_after(after);
        status = sp_scene_read_tapped(NULL, 2, list, &s, NULL);
        sp_alloc_fail_after(-1);
        failures += status == SP_ENOMEM;
        if (status == SP_OK)
            sp_scene_free(&s);
    }
    assert_int_equal(status, SP_OK);
    assert_true(failures >= 4); /* texts and lists of two keys */
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(defaults_are_those_of_the_column), cmocka_unit_test(lists_are_one_number_or_several),
        cmocka_unit_test(each_check_is_for_its_own),        cmocka_unit_test(columns_are_not_swept),
        cmocka_unit_test(samples_do_not_know_it),           cmocka_unit_test(lack_of_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
