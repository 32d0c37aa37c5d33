/* packing.height, which stands for packing.grains, and signal.planes. */
#include "base/base.h"
#include "making.h"
#include "test.h"

#include <sonopack/study/study.h>

static sp_status with(const char *text, const char *set, sp_scene *out, sp_error *err) {
    char value[200];
    char *sets[] = {value};
    snprintf(value, sizeof value, "%s", set ? set : "");
    return sp_scene_parse(text, "s.cfg", set ? 1 : 0, sets, out, err);
}

static sp_scene parsed(const char *text, const char *set) {
    sp_scene s;
    assert_ok(with(text, set, &s, &err));
    return s;
}

/* The number that the scene's own words say: height x width (x depth) x fraction over the mean grain, <d^2> and <d^3>
 * of uniform diameters being (b^3 - a^3)/3(b - a) and (b^4 - a^4)/4(b - a). */
TEST(grains_fill_the_height) {
    sp_scene s = parsed("packing = { height = 25; width = 24; };", NULL);
    const double area = M_PI / 4 * (1.728 - 0.512) / 3 / 0.4;
    assert_int_equal(s.pack.grains, (int)lround(25 * 24 * 0.815 / area));
    assert_true(s.height == 0 && s.pack.grains > 600 && s.pack.grains < 620); /* 600 are about 25 high */
    sp_scene_free(&s);
    s = parsed("packing = { dimension = 3; height = 12.5; width = 8.0; depth = 6.0; };", NULL);
    const double volume = M_PI / 6 * (2.0736 - 0.4096) / 4 / 0.4;
    assert_int_equal(s.pack.grains, (int)lround(12.5 * 48 * 0.6 / volume));
    sp_scene_free(&s);
    s = parsed(
        "packing = { height = 8; width = 8; sizes = \"list\"; diameters = (1.0, 2.0, 1.0, 2.0, 1.0, 2.0, 1.0, 2.0,"
        " 1.0, 2.0, 1.0, 2.0, 1.0, 2.0, 1.0, 2.0, 1.0, 2.0, 1.0, 2.0, 1.0, 2.0, 1.0, 2.0, 1.0, 2.0, 1.0, 2.0); };",
        NULL);
    assert_int_equal(s.pack.grains, (int)lround(64 * 0.815 / (M_PI / 4 * 2.5))); /* the mean of the list */
    sp_scene_free(&s);
    s = parsed("packing = { height = 0.001; };", NULL); /* one grain at the least */
    assert_int_equal(s.pack.grains, 1);
    sp_scene_free(&s);
}

/* The same packing has the same name, by whichever of the two it was asked for. */
TEST(names_do_not_tell) {
    char by_height[SP_NAME_MAX], by_grains[SP_NAME_MAX], set[64];
    FREED(sp_scene) high = parsed("packing = { height = 25; };", NULL);
    snprintf(set, sizeof set, "packing.grains=%d", high.pack.grains);
    FREED(sp_scene) many = parsed("packing = { pressure = 1e-4; };", set);
    sp_sample_name(&high, by_height);
    sp_sample_name(&many, by_grains);
    assert_string_equal(by_height, by_grains);
    char *a = sp_scene_text(&high, NULL), *b = sp_scene_text(&many, NULL);
    assert_string_equal(a, b);
    assert_null(strstr(a, "height"));
    sp_free(a);
    sp_free(b);
    /* set by a program, it is resolved by whoever needs the grains */
    assert_ok(sp_scene_set(&high, "packing.grains", 100, &err));
    assert_ok(sp_scene_set(&high, "packing.height", 25, &err));
    sp_sample_name(&high, by_height);
    assert_string_equal(by_height, by_grains);
    assert_ok(sp_scene_set(&high, "packing.grains", 100, &err)); /* the last one decides */
    assert_true(high.height == 0);
    sp_sample_name(&high, by_height);
    assert_string_not_equal(by_height, by_grains);
}

/* Names of samples that stores hold already: those since SONOPACK_ALGORITHM 8. */
/* name: of the sample of a scene; the default scene for "". */
static void name_of(const char *text, char name[SP_NAME_MAX]) {
    FREED(sp_scene) s = *text ? parsed(text, NULL) : sp_scene_default();
    sp_sample_name(&s, name);
}

TEST(names_stay) {
    char name[SP_NAME_MAX];
    name_of("", name);
    assert_string_equal(name, "7acecf30e8591ca4e8d4e10558d4e3c1");
    name_of("packing = { kind = \"chain\"; grains = 20; friction = 0; seed = 5; pressure = 1e-6; };", name);
    assert_string_equal(name, "d593e1af7502e5fb529fe74fdc35e9a5");
    name_of("packing = { dimension = 3; grains = 100; width = 8; seed = 5; };", name);
    assert_string_equal(name, "3913f43c0873bacf42330da69424b2ef");
    name_of("packing = { grains = 100; gravity = 1e-6; seed = 5; };", name);
    assert_string_equal(name, "68791cbef02871dbd9110a80bff21e4b");
}

TEST(heights_and_widths_are_swept_together) {
    sp_scene study = parsed("study = { samples = 2; sweep = ( { key = \"packing.width\"; values = [12, 24]; },"
                            "{ key = \"packing.height\"; values = [10, 20, 0]; } ); };",
                            NULL);
    assert_int_equal(sp_study_count(&study), 12);
    for (int64_t k = 0; k < 12; k++) {
        const double width = k % 6 < 3 ? 12 : 24, height = 10.0 * (double)(k % 3 + 1);
        sp_scene one;
        assert_ok(sp_study_scene(&study, k, &one, &err));
        char set[2][64], name[2][SP_NAME_MAX];
        snprintf(set[0], sizeof set[0], k % 3 == 2 ? "packing.grains=600" : "packing.height=%g", height);
        snprintf(set[1], sizeof set[1], "packing.width=%g", width);
        char *sets[] = {set[0], set[1]};
        FREED(sp_scene) alone;
        assert_ok(sp_scene_parse("packing = { seed = 1; };", "s.cfg", 2, sets, &alone, &err));
        alone.pack.seed += (uint64_t)(k / 6);
        assert_int_equal(one.pack.grains, alone.pack.grains);
        assert_true(one.height == 0 && one.pack.width == width);
        sp_sample_name(&one, name[0]);
        sp_sample_name(&alone, name[1]);
        assert_string_equal(name[0], name[1]);
    }
    /* as text and back, with its sweeps */
    char *text = sp_scene_text(&study, NULL);
    sp_scene back = parsed(text, NULL);
    char *again = sp_scene_text(&back, NULL);
    assert_string_equal(text, again);
    sp_free(text);
    sp_free(again);
    sp_scene_free(&back);
    sp_scene_free(&study);
    /* one height for several widths */
    study = parsed(
        "packing = { height = 20; }; study = { sweep = ( { key = \"packing.width\"; values = [12, 24]; } ); };", NULL);
    assert_true(study.height == 20);
    text = sp_scene_text(&study, NULL);
    assert_null(strstr(text, "grains"));
    back = parsed(text, NULL);
    assert_true(back.height == 20);
    sp_free(text);
    for (int64_t k = 0; k < 2; k++) {
        sp_scene one;
        assert_ok(sp_study_scene(&back, k, &one, &err));
        assert_close(one.pack.grains, 20 * one.pack.width * 0.815 / 0.79587, 0.6);
    }
    sp_scene_free(&back);
    sp_scene_free(&study);
}

/* One packing of a swept scene takes the override of either; a study takes none. */
TEST(overrides_of_swept_heights) {
    static const char *const swept[] = {"packing.height", "packing.grains"};
    static const char *const set[] = {"packing.grains=30", "packing.height=9"};
    for (int k = 0; k < 4; k++) {
        char text[200];
        snprintf(text, sizeof text, "study = { sweep = ( { key = \"%s\"; values = [10, 20]; } ); };", swept[k / 2]);
        FREED(sp_scene) s = parsed(text, set[k % 2]);
        assert_true(k % 2 ? s.pack.grains > 200 && s.height == 9 : s.pack.grains == 30);
        assert_ok(sp_scene_resolve(&s, &err));
        assert_true(s.height == 0);
        assert_fails(sp_scene_check_sweeps(&s, &err), SP_EINVAL, swept[k / 2]);
    }
}

/* The height that comes out, for packings small enough to be made here. */
TEST(boxes_come_out_that_high) {
    const char *const scene[] = {"packing = { height = 12; width = 12; tolerance = 1e-7; };",
                                 "packing = { height = 12; width = 12; tolerance = 1e-9; pressure = 1e-6; };",
                                 "packing = { dimension = 3; height = 9; width = 5; tolerance = 1e-7; };"};
    for (int k = 0; k < 3; k++) {
        FREED(sp_scene) s = parsed(scene[k], NULL);
        FREED(sp_packing) p = sp_packing_none();
        assert_ok(sp_packing_make(&s.pack, NULL, NULL, &p, &err));
        /* walls leave gaps of about a third of a diameter, and low pressure leaves more room; narrow boxes even more */
        assert_relative(sp_packing_height(&p), k < 2 ? 12.0 : 9.0, k < 2 ? 0.06 : 0.08);
    }
}

/* ---- planes ------------------------------------------------------------------------------------------------------ */

TEST(planes_are_read) {
    static const char *const same[] = {"signal.planes=12.5,25", "signal.planes=[12.5, 25.0]",
                                       "signal.planes=(1.25e1, 25)"};
    for (int k = 0; k < 3; k++) {
        FREED(sp_scene) s = parsed("signal = { planes = [1, 2, 3]; }; study = { want = [\"planes\"]; };", same[k]);
        assert_int_equal(s.planes, 2);
        assert_true(s.plane[0] == 12.5 && s.plane[1] == 25 && s.want == SP_WANT_PLANES);
    }
    sp_scene s = parsed("signal = { planes = [7]; };", NULL);
    assert_true(s.planes == 1 && s.plane[0] == 7);
    sp_scene_free(&s);
    s = parsed("packing = { history = [1e-5]; };", "packing.history=1e-3,1e-5"); /* as all lists of numbers */
    assert_true(s.pack.history_count == 2 && s.pack.history[0] == 1e-3);
    sp_scene_free(&s);
    s = parsed("signal = { planes = [7]; };", "signal.planes=[]");
    assert_int_equal(s.planes, 0);
    sp_scene_free(&s);
}

RUN_TESTS(NULL, NULL)
