/* Sweeps of a study: words, booleans, lists and ranges, in study.sweep and in the place of a key's value. */
#include "test.h"

#include "base/base.h"
#include "scene/field.h"
#include <sonopack/study/scene.h>
#include <sonopack/study/study.h>

static sp_scene parsed(const char *text) {
    sp_scene s;
    assert_ok(sp_scene_parse(text, "s.cfg", 0, NULL, &s, &err));
    return s;
}

static sp_scene parsed_set(const char *text, const char *override) {
    char *list[] = {(char *)(uintptr_t) override};
    sp_scene s;
    assert_ok(sp_scene_parse(text, "s.cfg", 1, list, &s, &err));
    return s;
}

/* The sweeps as they stand in messages: "key=value|value; key=value". */
static void check_sweeps(const sp_scene *s, const char *expected) {
    char text[2000] = "", value[100];
    for (int k = 0; k < s->sweeps; k++) {
        const sp_sweep *sweep = &s->sweep[k];
        size_t used = strlen(text);
        snprintf(text + used, sizeof text - used, "%s%s=", k > 0 ? "; " : "", sweep->key);
        for (int i = 0; i < sweep->count; i++) {
            used = strlen(text);
            snprintf(text + used, sizeof text - used, "%s%s", i > 0 ? "|" : "",
                     sp_sweep_text(sweep, i, value, sizeof value));
        }
    }
    assert_string_equal(text, expected);
}

/* Sweeps and every sample of the scene are the same after text and back. */
static void check_round_trip(const sp_scene *s) {
    char *text = sp_scene_text(s, NULL);
    FREED(sp_scene) back = parsed(text);
    char *again = sp_scene_text(&back, NULL);
    assert_string_equal(text, again);
    assert_int_equal(back.sweeps, s->sweeps);
    const int64_t count = sp_study_count(s);
    assert_int_equal(sp_study_count(&back), count);
    for (int64_t k = 0; k < count; k++) {
        sp_scene a, b;
        assert_ok(sp_study_scene(s, k, &a, &err));
        assert_ok(sp_study_scene(&back, k, &b, &err));
        char *one = sp_scene_text(&a, NULL), *other = sp_scene_text(&b, NULL);
        assert_string_equal(one, other);
        sp_free(one);
        sp_free(other);
    }
    sp_free(again);
    sp_free(text);
}

static void is_swept(const char *text, const char *expected) {
    FREED(sp_scene) s = parsed(text);
    check_sweeps(&s, expected);
    check_round_trip(&s);
}

/* ---- values ----------------------------------------------------------------------------------------------------- */

TEST(words_booleans_and_lists) {
    is_swept("study = { sweep = ( { key = \"packing.sizes\"; values = [\"uniform\", \"bidisperse\"]; },"
             "{ key = \"network.prestress\"; values = [false, true]; },"
             "{ key = \"signal.source\"; values = [\"velocity\", \"impulse\"]; },"
             "{ key = \"packing.history\"; values = ( [], [1e-4], [1e-3, 1e-4] ); } ); };",
             "packing.sizes=uniform|bidisperse; network.prestress=false|true; signal.source=velocity|impulse; "
             "packing.history=[]|[0.0001]|[0.001, 0.0001]");
    is_swept("packing = { sizes = \"list\"; kind = \"chain\"; grains = 2; };"
             "study = { sweep = ( { key = \"packing.diameters\"; values = ( [1, 1.1], [1.1, 0.9, 1] ); } ); };",
             "packing.diameters=[1, 1.1]|[1.1, 0.9, 1]");
}

TEST(samples_get_the_values) {
    FREED(sp_scene) s = parsed("packing = { seed = 7; history = [1e-5]; }; study = { samples = 2; sweep = ("
                               "{ key = \"packing.history\"; values = ( [1e-3, 1e-4], [] ); },"
                               "{ key = \"packing.compression\"; values = [\"isotropic\", \"piston\"]; },"
                               "{ key = \"packing.reference\"; values = [true, false]; } ); };");
    assert_int_equal(sp_study_count(&s), 16);
    for (int k = 0; k < 16; k++) {
        sp_scene one;
        assert_ok(sp_study_scene(&s, k, &one, &err));
        assert_int_equal(one.pack.seed, 7 + k / 8);
        assert_int_equal(one.pack.reference, k % 2 == 0);
        assert_int_equal(one.pack.compression, k / 2 % 2 == 0 ? SP_COMPRESSION_ISOTROPIC : SP_COMPRESSION_PISTON);
        assert_int_equal(one.pack.history_count, k % 8 < 4 ? 2 : 0);
        if (k % 8 < 4)
            assert_true(one.pack.history[0] == 1e-3 && one.pack.history[1] == 1e-4);
        else
            assert_null(one.pack.history);
    }
    assert_int_equal(s.pack.history_count, 1); /* of a packing that is made alone */
}

TEST(each_kind_has_its_dimension) {
    static const char *const first[] = {"\"piston\", \"chain\", \"triangular\"",
                                        "\"chain\", \"triangular\", \"piston\""};
    for (int k = 0; k < 2; k++) {
        char text[200];
        snprintf(text, sizeof text, "packing = { kind = [%s]; grains = 240; friction = 0; };", first[k]);
        FREED(sp_scene) s = parsed(text);
        assert_int_equal(s.pack.dim, k == 0 ? 2 : 1);
        for (int i = 0; i < 3; i++) {
            sp_scene one;
            assert_ok(sp_study_scene(&s, i, &one, &err));
            assert_int_equal(one.pack.dim, one.pack.kind == SP_PACK_CHAIN ? 1 : 2);
        }
        check_round_trip(&s);
        char *text_alone = sp_scene_text(&s, "packing"); /* kept with a packing that is made alone */
        assert_non_null(strstr(text_alone, "dimension = "));
        sp_free(text_alone);
    }
    is_swept("packing = { dimension = [2, 3]; width = 6; };", "packing.dimension=2|3");
}

/* What only the scene's own packing lacks is no matter of a study. */
TEST(combinations_count) {
    const char *text =
        "packing = { sizes = \"list\"; grains = 3; kind = \"chain\"; };"
        "study = { sweep = ( { key = \"packing.diameters\"; values = ( [1, 1, 1], [1, 1, 1.1] ); } ); };";
    FREED(sp_scene) s = parsed(text);
    assert_int_equal(sp_study_count(&s), 2);
    assert_fails(sp_pack_spec_check(&s.pack, &err), SP_EINVAL, "packing.diameters 0");
    check_round_trip(&s);
}

TEST(seeds) {
    FREED(sp_scene) s = parsed("packing = { seed = [100, 1]; }; study = { samples = 99; };");
    check_sweeps(&s, "packing.seed=100|1");
    sp_scene one;
    assert_ok(sp_study_scene(&s, 197, &one, &err));
    assert_int_equal(one.pack.seed, 99);
    assert_ok(sp_study_scene(&s, 196, &one, &err));
    assert_int_equal(one.pack.seed, 198);
    check_round_trip(&s);
    is_swept("packing = { seed = [9007199254740991, 9007199254740992, 4503599627370497]; };",
             "packing.seed=9007199254740991|9007199254740992|4503599627370497");
    is_swept("packing = { seed = { from = 9007199254740980; to = 9007199254740992; step = 4; }; };",
             "packing.seed=9007199254740980|9007199254740984|9007199254740988|9007199254740992");
}

/* ---- ranges ----------------------------------------------------------------------------------------------------- */

TEST(ranges) {
    is_swept("packing = { pressure = { from = 1e-7; to = 1e-4; count = 4; spacing = \"log\"; }; };",
             "packing.pressure=1e-07|1e-06|1e-05|0.0001");
    is_swept("packing = { friction = { from = 0; to = 0.5; step = 0.1; }; };",
             "packing.friction=0|0.1|0.2|0.3|0.4|0.5");
    is_swept("packing = { friction = { to = 0.5; from = 0; spacing = \"linear\", count = 6; }; };",
             "packing.friction=0|0.1|0.2|0.3|0.4|0.5");
    is_swept("packing = { friction = { from = 0.3; to = 0; step = -0.1; }; };", "packing.friction=0.3|0.2|0.1|0");
    is_swept("packing = { drag = { from = -0.03; to = 0.03; count = 7; }; };",
             "packing.drag=-0.03|-0.02|-0.01|0|0.01|0.02|0.03");
    is_swept("packing = { grains = { from = 100; to = 1e3; count = 5; }; };", "packing.grains=100|325|550|775|1000");
    is_swept("packing = { grains = { from = 100; to = 1000; count = 4; spacing = \"log\"; }; };",
             "packing.grains=100|215|464|1000");
    is_swept("study = { sweep = ( { from = 200; key = \"packing.grains\"; to = 600; step = 200; } ); };",
             "packing.grains=200|400|600");
    is_swept("packing = { pressure = { from = 1e-10; to = 1e-2; count = 9; spacing = \"log\"; }; };",
             "packing.pressure=1e-10|1e-09|1e-08|1e-07|1e-06|1e-05|0.0001|0.001|0.01");
}

/* Ends to the bit; what lies between, to two units in the last place of a formula in another arithmetic. */
TEST(ranges_are_exact) {
    const double from = 1.0 / 3 * 1e-9, to = 0.00987654321012345678;
    char text[200];
    for (int log_ = 0; log_ < 2; log_++) {
        snprintf(text, sizeof text,
                 "packing = { pressure = { from = %.17g; to = %.17g; count = 1000; spacing = \"%s\"; }; };", from, to,
                 log_ ? "log" : "linear");
        FREED(sp_scene) s = parsed(text);
        const double *p = s.sweep[0].values;
        assert_int_equal(s.sweep[0].count, 1000);
        assert_true(p[0] == from && p[999] == to && s.pack.pressure == from);
        for (int k = 1; k < 999; k++) {
            const double expected =
                log_ ? exp((log(from) * (999 - k) + log(to) * k) / 999) : from + (to - from) * k / 999;
            /* logarithms up to 22 are rounded to 4e-15, what is neat to 1e-14 */
            assert_relative(p[k], expected, 3e-14);
        }
    }
}

/* Every number of few digits that a range goes through is met to the bit. */
TEST(neat_values_are_met) {
    char text[200], value[32];
    for (int low = -10; low < -2; low++)
        for (int high = low + 1; high <= -2; high++)
            for (int part = 1; part <= 2; part++) {
                snprintf(text, sizeof text,
                         "packing = { pressure = { from = 1e%d; to = 1e%d; count = %d; spacing = \"log\"; }; };", low,
                         high, part * (high - low) + 1);
                FREED(sp_scene) s = parsed(text);
                for (int k = 0; k <= high - low; k++) {
                    snprintf(value, sizeof value, "1e%d", low + k);
                    assert_true(s.sweep[0].values[part * k] == strtod(value, NULL));
                }
            }
    for (int count = 2; count <= 200; count++) { /* steps of 0.01 .. 0.07 from -1 on */
        const int step = count % 7 + 1;
        const int last = 100 - step * (count - 1);
        if (last <= 0)
            continue;
        snprintf(text, sizeof text, "packing = { drag = { from = -1; to = -0.%02d; count = %d; }; };", last, count);
        FREED(sp_scene) s = parsed(text);
        for (int k = 0; k < count; k++) {
            const int cents = 100 - step * k;
            snprintf(value, sizeof value, "-%d.%02d", cents / 100, cents % 100);
            assert_true(s.sweep[0].values[k] == strtod(value, NULL));
        }
    }
}

/* ---- keys that are given lists or ranges ------------------------------------------------------------------------ */

TEST(lists_in_the_place_of_values) {
    const char *text = "packing = { pressure = [1e-7, 1e-4]; friction = { from = 0; to = 0.5; count = 2; };"
                       "sizes = [\"bidisperse\", \"uniform\"]; }; network = { prestress = [true]; };"
                       "study = { sweep = ( { key = \"packing.grains\"; values = [200, 600]; } ); };";
    is_swept(text, "packing.grains=200|600; packing.pressure=1e-07|0.0001; packing.friction=0|0.5; "
                   "packing.sizes=bidisperse|uniform; network.prestress=true");
    FREED(sp_scene) s = parsed(text);
    assert_true(s.pack.pressure == 1e-7 && s.pack.friction == 0 && s.pack.sizes == SP_SIZES_BIDISPERSE);
    assert_true(s.network.prestress && s.pack.grains == 600); /* the default */
    assert_int_equal(sp_study_count(&s), 16);
    assert_ok(sp_scene_check_sweeps(&s, &err));
}

TEST(overrides) {
    const char *text = "packing = { pressure = [1e-7, 1e-4]; friction = [0, 0.5]; };"
                       "study = { sweep = ( { key = \"packing.grains\"; values = [200, 600]; } ); };";
    static const char *const sets[][2] = {
        {"packing.pressure=1e-5", "packing.grains=200|600; packing.friction=0|0.5"},
        {"packing.friction=0.3", "packing.grains=200|600; packing.pressure=1e-07|0.0001"},
        {"packing.pressure=[1e-6, 1e-5]",
         "packing.grains=200|600; packing.pressure=1e-06|1e-05; packing.friction=0|0.5"},
        {"packing.friction={from=0;to=1;count=3;}",
         "packing.grains=200|600; packing.pressure=1e-07|0.0001; packing.friction=0|0.5|1"},
        {"packing.sizes=[uniform,bidisperse]",
         "packing.grains=200|600; packing.pressure=1e-07|0.0001; packing.friction=0|0.5; "
         "packing.sizes=uniform|bidisperse"},
        {"packing.protocol=( \"default\", somfai2005 )",
         "packing.grains=200|600; packing.pressure=1e-07|0.0001; packing.friction=0|0.5; "
         "packing.protocol=default|somfai2005"},
        {"study.sweep=( { key = \"packing.width\"; values = [20, 24]; } )",
         "packing.width=20|24; packing.pressure=1e-07|0.0001; packing.friction=0|0.5"},
    };
    for (size_t k = 0; k < sizeof sets / sizeof *sets; k++) {
        FREED(sp_scene) s = parsed_set(text, sets[k][0]);
        check_sweeps(&s, sets[k][1]);
        assert_ok(sp_scene_check_sweeps(&s, &err));
        check_round_trip(&s);
    }
    sp_scene s = parsed_set(text, "packing.grains=100"); /* study.sweep is not replaced */
    assert_fails(sp_scene_check_sweeps(&s, &err), SP_EINVAL, "--set packing.grains study.sweep");
    sp_scene_free(&s);
    char grains[] = "packing.grains=300", *other[] = {grains};
    assert_fails(sp_scene_parse("packing = { height = [10, 20]; };", "s.cfg", 1, other, &s, &err), SP_EINVAL,
                 "s.cfg:1 packing.height packing.grains 300");
    FREED(sp_scene) lists =
        parsed_set("packing = { kind = \"chain\"; sizes = \"list\"; diameters = [1, 1]; grains = 2; };"
                   "study = { sweep = ( { key = \"packing.diameters\"; values = ([1, 1], [1, 2]); } ); };",
                   "packing.diameters=1,3");
    assert_fails(sp_scene_check_sweeps(&lists, &err), SP_EINVAL, "--set packing.diameters");
}

/* ---- the functions alone ---------------------------------------------------------------------------------------- */

TEST(take_and_text) {
    double pressures[] = {1e-6, -1}, words[] = {1, 77}, list[] = {1e-3, 0.1, 1e-4};
    int32_t begin[] = {0, 0, 1, 3};
    char buf[64], small[11];
    FREED(sp_scene) s = sp_scene_default();
    sp_sweep pressure = {.key = "packing.pressure", .count = 2, .values = pressures};
    assert_ok(sp_scene_set_swept(&s, &pressure, 0, &err));
    assert_true(s.pack.pressure == 1e-6);
    assert_fails(sp_scene_set_swept(&s, &pressure, 1, &err), SP_EINVAL, "packing.pressure -1");
    assert_fails(sp_scene_set_swept(&s, &pressure, 2, &err), SP_EINVAL, "3 2");
    assert_fails(sp_scene_set_swept(&s, &pressure, -1, &err), SP_EINVAL, "0 2");
    assert_string_equal(sp_sweep_text(&pressure, 2, buf, sizeof buf), "");
    sp_sweep sizes = {.key = "packing.sizes", .count = 2, .values = words};
    assert_ok(sp_scene_set_swept(&s, &sizes, 0, &err));
    assert_int_equal(s.pack.sizes, SP_SIZES_BIDISPERSE);
    assert_fails(sp_scene_set_swept(&s, &sizes, 1, &err), SP_EINVAL, "uniform bidisperse");
    sp_sweep history = {.key = "packing.history", .count = 3, .values = list, .begin = begin};
    assert_ok(sp_scene_set_swept(&s, &history, 1, &err));
    assert_true(s.pack.history_count == 1 && s.pack.history == list);
    assert_ok(sp_scene_set_swept(&s, &history, 0, &err));
    assert_true(s.pack.history_count == 0 && !s.pack.history);
    assert_fails(sp_scene_set_swept(&s, &history, 2, &err), SP_EINVAL, "packing.history 0.1");
    assert_string_equal(sp_sweep_text(&history, 2, buf, sizeof buf), "[0.1, 0.0001]");
    assert_string_equal(sp_sweep_text(&history, 2, small, sizeof small), "[...]");
    history.begin = NULL;
    assert_fails(sp_scene_set_swept(&s, &history, 0, &err), SP_EINVAL, "packing.history");
    sp_sweep none = {.key = "packing.nothing", .count = 1, .values = list};
    assert_fails(sp_scene_set_swept(&s, &none, 0, &err), SP_EINVAL, "study.sweep packing.nothing");
    assert_string_equal(sp_sweep_text(&none, 0, buf, sizeof buf), "");
    sp_sweep grains = {.key = "packing.grains", .count = 1, .values = (double[]){50}};
    s.height = 20;
    assert_ok(sp_scene_set_swept(&s, &grains, 0, &err));
    assert_true(s.height == 0 && s.pack.grains == 50); /* the last one decides */
}

/* Every allocation fails once: a reason, no leak (the sanitizers look), nothing written. */
TEST(lack_of_memory) {
    char set[] = "packing.friction=[0.1, 0.2]", again[] = "packing.pressure=1e-4", want[] = "study.want=ctof",
         mass[] = "column.mass=[1, 2]", radius[] = "column.radius=2", *list[] = {set, again, want, mass, radius};
    const char *text =
        "packing = { pressure = [1e-7, 1e-4]; friction = { from = 0; to = 1; count = 3; }; seed = [1, 2]; };"
        "study = { sweep = ( { key = \"packing.history\"; values = ([], [1e-4]); } ); };";
    sp_status status = SP_ENOMEM;
    int64_t failures = 0;
    for (int64_t after = 0; status == SP_ENOMEM; after++) {
        sp_scene s;
        sp_alloc_fail_after(after);
        status = sp_scene_parse(text, "s.cfg", 5, list, &s, NULL);
        sp_alloc_fail_after(-1);
        failures += status == SP_ENOMEM;
        if (status == SP_OK)
            sp_scene_free(&s);
    }
    assert_int_equal(status, SP_OK);
    assert_true(failures >= 19);
}

RUN_TESTS(NULL, NULL)
