/* Scenes: the field table, the parser, overrides, and what a hostile or mistaken scene gets told. */
#include "test.h"

#include "base/base.h"
#include "ensemble/sample.h"
#include "scene/field.h"
#include <sonopack/study/scene.h>
#include <sonopack/study/study.h>
#include <unistd.h>

static sp_status parse(const char *text, sp_scene *out, sp_error *err) {
    return sp_scene_parse(text, "s.cfg", 0, NULL, out, err);
}

static sp_status set(const char *override, sp_scene *out, sp_error *err) {
    char *list[] = {(char *)(uintptr_t) override};
    return sp_scene_read(NULL, 1, list, out, err);
}

/* ---- values ------------------------------------------------------------------------------------------------- */

TEST(defaults_are_those_of_the_rooms) {
    const sp_pack_spec pack = sp_pack_spec_default();
    const sp_network_options network = sp_network_options_default();
    const sp_signal_options signal = sp_signal_options_default();
    FREED(sp_scene) s;
    assert_ok(sp_scene_read(NULL, 0, NULL, &s, &err));
    assert_true(s.pack.grains == pack.grains && s.pack.pressure == pack.pressure && s.pack.dim == pack.dim);
    assert_true(s.network.threshold == network.threshold && s.network.prestress == network.prestress);
    assert_true(s.signal.points == signal.points && s.signal.tolerance == signal.tolerance);
    assert_true(s.signal.until == 0 && s.sweeps == 0 && s.samples >= 1);
    for (int k = 0; k < SP_FIELDS; k++) { /* every default is one that the table would accept */
        if (!sp_field_is_number(&sp_fields[k]))
            continue;
        const sp_number number = sp_field_load(&s, &sp_fields[k]);
        assert_ok(sp_field_check(&sp_fields[k], &number, &err));
    }
}

TEST(integers_and_reals_stand_for_each_other) {
    FREED(sp_scene) s;
    assert_ok(parse("packing = { grains = 1e3; width = 30; seed = 3000000000; max_steps = 5e12; };"
                    "signal : { until = 7, points = 0x10 };",
                    &s, &err));
    assert_int_equal(s.pack.grains, 1000);
    assert_true(s.pack.width == 30 && s.pack.seed == 3000000000u && s.pack.max_steps == 5000000000000);
    assert_true(s.signal.until == 7 && s.signal.points == 16);
}

TEST(every_word_and_switch_is_read) {
    sp_scene s;
    assert_ok(
        parse("packing = { kind = \"triangular\"; width = 10; grains = 100; diameter_min = 1; diameter_max = 1; };"
              "network = { prestress = true; sliding_free = TRUE; };"
              "signal = { method = \"dense\"; source = \"displacement\"; };"
              "study = { want = [\"statics\", \"signal\", \"moduli\"]; };",
              &s, &err));
    assert_int_equal(s.pack.kind, SP_PACK_TRIANGULAR);
    assert_true(s.network.prestress && s.network.sliding_free);
    assert_int_equal(s.signal.method, SP_SIGNAL_DENSE);
    assert_int_equal(s.signal.source, SP_SOURCE_DISPLACEMENT);
    assert_int_equal(s.want, SP_WANT_STATICS | SP_WANT_SIGNAL | SP_WANT_MODULI);
    sp_scene_free(&s);
    assert_ok(parse("study = { want = \"packings\"; };", &s, &err));
    assert_int_equal(s.want, 0);
    sp_scene_free(&s);
    assert_ok(
        parse("\xef\xbb\xbf# a mark of the byte order, CRLF\r\nstudy = { want = (\"ctof\") }\r\n# the end", &s, &err));
    assert_int_equal(s.want, SP_WANT_CTOF);
    sp_scene_free(&s);
}

TEST(seeds_keep_their_64_bits) {
    const uint64_t seed = (UINT64_C(1) << 62) + 1; /* no double */
    FREED(sp_scene) s, again;
    assert_ok(set("packing.seed=4611686018427387905", &s, &err));
    assert_true(s.pack.seed == seed);
    char *text = sp_scene_text(&s, "packing");
    assert_non_null(strstr(text, "4611686018427387905L"));
    assert_ok(parse(text, &again, &err));
    assert_true(again.pack.seed == seed);
    sp_free(text);
}

/* ---- text and back ------------------------------------------------------------------------------------------ */

static uint64_t draw(uint64_t *state) { /* xorshift64* */
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    return *state * UINT64_C(2685821657736338717);
}

static void draw_number(sp_scene *s, const sp_field *f, uint64_t *random) {
    const double u = (double)(draw(random) >> 11) * 0x1p-53;
    const sp_key *range = sp_field_limits(f);
    const double low = range->low > 0 ? log(range->low) : -30; /* evenly over the decades of the range */
    double value = exp(low + u * (log(range->high) - low));
    value = fmin(fmax(f->type == SP_FIELD_REAL ? value : floor(value), range->low),
                 f->type == SP_FIELD_REAL ? range->high : 1e6);
    assert_ok(sp_field_store(s, f, &(sp_number){.real = value}, &err));
}

/* Every key: the column has to be asked for. */
static char *text_of_all(const sp_scene *s) {
    char *samples = sp_scene_text(s, NULL), *column = sp_scene_text(s, "column");
    assert_non_null(samples);
    assert_non_null(column);
    assert_null(strstr(samples, "column"));
    char *text = sp_alloc(strlen(samples) + strlen(column) + 1, 1);
    assert_non_null(text);
    strcat(strcpy(text, samples), column);
    sp_free(samples);
    sp_free(column);
    return text;
}

TEST(text_reads_back_bit_for_bit) {
    uint64_t random = 20240607;
    print_message("seed %llu\n", (unsigned long long)random);
    for (int trial = 0; trial < 300; trial++) {
        sp_scene s = sp_scene_default(), back;
        for (int k = 0; k < SP_FIELDS; k++)
            if (sp_field_is_number(&sp_fields[k]))
                draw_number(&s, &sp_fields[k], &random);
        s.pack.diameter_min = s.pack.diameter_max = fmin(fmax(s.pack.diameter_max, 0.1), 10);
        s.pack.grains = s.pack.grains > 100 ? s.pack.grains : 100; /* fewer cannot carry any pressure */
        s.pack.depth = 0;
        s.height = 0; /* in place of the grains: test_scene_heights */
        s.pack.compression = draw(&random) % 2;
        s.pack.gravity *= s.pack.compression == SP_COMPRESSION_PISTON;
        s.pack.strain_rate = s.pack.fraction = 0; /* of other cells and kinds */
        s.pack.law_exponent = 1.5;
        s.pack.strain_steps = s.pack.stages = 0; /* of paths */
        s.pack.protocol = draw(&random) % 2;
        s.pack.sizes = draw(&random) % 2;
        s.pack.reference = draw(&random) & 1;
        s.pack.tolerance = fmin(fmax(s.pack.tolerance, 0.01 * s.pack.pressure), 0.1 * s.pack.pressure);
        s.pack.calm = fmax(s.pack.calm, 1e-6);
        s.pack.width = 10 * s.pack.diameter_max;
        s.pack.dim = 2;
        s.pack.seed = draw(&random) >> 2;
        s.planes = (int32_t)(draw(&random) % (SP_PLANES_MAX + 1));
        for (int k = 0; k < s.planes; k++)
            s.plane[k] = (k > 0 ? s.plane[k - 1] : 0.01) + 100 * ((double)(draw(&random) >> 11) * 0x1p-53) + 1e-6;
        s.want = (unsigned)draw(&random) % 256 & ~(unsigned)(s.planes > 0 ? 0 : SP_WANT_PLANES);
        s.network.prestress = draw(&random) & 1;
        s.signal.method = draw(&random) % 3;
        double lists[8];
        for (int k = 0; k < 8; k++)
            lists[k] = exp(4 * ((double)(draw(&random) >> 11) * 0x1p-53) - 2);
        s.tapped.masses = 1 + (int32_t)(draw(&random) % 4);
        s.tapped.radii = 1 + (int32_t)(draw(&random) % 4);
        s.tapped.mass = lists;
        s.tapped.radius = lists + 4;
        s.tapped.output = draw(&random) % 7;
        s.tapped.parameter = draw(&random) % 4;
        char *text = text_of_all(&s);
        assert_ok(parse(text, &back, &err));
        char *again = text_of_all(&back);
        assert_string_equal(text, again);
        assert_true(s.tapped.output == back.tapped.output && s.tapped.parameter == back.tapped.parameter);
        assert_true(s.tapped.masses == back.tapped.masses && s.tapped.radii == back.tapped.radii);
        assert_memory_equal(lists, back.tapped.mass, sizeof *lists * (size_t)s.tapped.masses);
        assert_memory_equal(lists + 4, back.tapped.radius, sizeof *lists * (size_t)s.tapped.radii);
        for (int k = 0; k < SP_FIELDS; k++) {
            const double drawn = sp_field_is_number(&sp_fields[k]) ? sp_field_load(&s, &sp_fields[k]).real : 0;
            const double read = sp_field_is_number(&sp_fields[k]) ? sp_field_load(&back, &sp_fields[k]).real : 0;
            assert_memory_equal(&drawn, &read, sizeof drawn);
        }
        assert_true(s.want == back.want && s.signal.method == back.signal.method && s.planes == back.planes);
        assert_memory_equal(s.plane, back.plane, sizeof s.plane[0] * (size_t)s.planes);
        assert_true(s.pack.sizes == back.pack.sizes && s.pack.compression == back.pack.compression);
        assert_true(s.pack.protocol == back.pack.protocol && s.pack.reference == back.pack.reference);
        sp_free(again);
        sp_free(text);
        sp_scene_free(&back);
    }
}

TEST(help_names_every_key) {
    char *help = sp_scene_help();
    assert_non_null(help);
    for (int k = 0; k < SP_FIELDS; k++) {
        char key[128];
        snprintf(key, sizeof key, "\n%s = ", sp_fields[k].key);
        assert_non_null(strstr(help, key));
        assert_non_null(strstr(help, sp_fields[k].meaning));
    }
    sp_free(help);
}

TEST(unknown_names_meet_the_nearest) {
    assert_int_equal(sp_edit_distance("pressure", "presusre"), 1);
    assert_int_equal(sp_edit_distance("kitten", "sitting"), 3);
    assert_int_equal(sp_edit_distance("", "abc"), 3);
}

/* ---- overrides and single keys ------------------------------------------------------------------------------ */

TEST(overrides_win_and_are_checked) {
    char pressure[] = "packing.pressure=1e-6", grains[] = " packing.grains = 200", want[] = "study.want=ctof,statics";
    char source[] = "signal.source=\"velocity\"", prestress[] = "network.prestress=true";
    char sweep[] = "study.sweep=( { key = \"packing.grains\"; values = [3, 4, 5]; } )";
    char *list[] = {pressure, want, source, prestress, sweep, grains + 1};
    sp_scene s;
    assert_ok(sp_scene_parse("packing = { pressure = 1e-5; };"
                             "study = { sweep = ( { key = \"packing.pressure\"; values = [1e-5, 1e-6]; } ); };",
                             "s.cfg", 6, list, &s, &err));
    assert_true(s.pack.pressure == 1e-6 && s.pack.grains == 200);
    assert_int_equal(s.want, SP_WANT_CTOF | SP_WANT_STATICS);
    assert_int_equal(s.signal.source, SP_SOURCE_VELOCITY);
    assert_true(s.network.prestress);
    assert_int_equal(s.sweeps, 1);
    assert_int_equal(s.sweep[0].count, 3);
    assert_fails(sp_scene_check_sweeps(&s, &err), SP_EINVAL, "--set packing.grains study.sweep");
    sp_scene_free(&s);
    assert_ok(sp_scene_parse("packing = { grains = 100; };", "s.cfg", 5, list, &s, &err)); /* none of a swept key */
    assert_ok(sp_scene_check_sweeps(&s, &err));
    sp_scene_free(&s);
}

TEST(set_and_get_one_key) {
    FREED(sp_scene) s = sp_scene_default();
    assert_ok(sp_scene_set(&s, "packing.pressure", 1e-6, &err));
    assert_ok(sp_scene_set(&s, "packing.grains", 200, &err));
    assert_ok(sp_scene_set(&s, "packing.poisson", -0.0, &err));
    assert_true(sp_scene_get(&s, "packing.pressure") == 1e-6 && sp_scene_get(&s, "packing.grains") == 200);
    assert_false(signbit(s.pack.poisson));
    assert_fails(sp_scene_set(&s, "packing.grains", 200.5, &err), SP_EINVAL, "packing.grains 200.5");
    assert_fails(sp_scene_set(&s, "packing.grains", NAN, &err), SP_EINVAL, "packing.grains nan");
    assert_fails(sp_scene_set(&s, "packing.pressure", INFINITY, &err), SP_EINVAL, "packing.pressure inf");
    assert_fails(sp_scene_set(&s, "packing.seed", 0x1p63, &err), SP_EINVAL, "packing.seed");
    assert_fails(sp_scene_set(&s, "packing.kind", 1, &err), SP_EINVAL, "packing.kind");
    assert_fails(sp_scene_set(&s, "", 1, &err), SP_EINVAL, "");
    assert_int_equal(s.pack.grains, 200);
    assert_true(isnan(sp_scene_get(&s, "packing.kind")) && isnan(sp_scene_get(&s, "grains")));
}

/* ---- the group column ------------------------------------------------------------------------------------------- */

static sp_status column_of(const char *override, sp_scene *out, sp_error *err) {
    char *list[] = {(char *)(uintptr_t) override};
    return sp_scene_read_tapped(NULL, override ? 1 : 0, list, out, err);
}

TEST(lists_are_one_number_or_several) {
    sp_scene s;
    assert_ok(parse("column = { mass = 2; radius = [1, 0.5, 1]; };", &s, &err));
    assert_int_equal(s.tapped.masses, 1);
    assert_int_equal(s.tapped.radii, 3);
    assert_true(s.tapped.mass[0] == 2 && s.tapped.radius[1] == 0.5);
    sp_scene_free(&s);
    assert_ok(column_of("column.mass=1,2, 3", &s, &err));
    assert_true(s.tapped.masses == 3 && s.tapped.mass[2] == 3);
    sp_scene_free(&s);
    assert_ok(column_of("column.mass=0.5", &s, &err));
    assert_true(s.tapped.masses == 1 && s.tapped.mass[0] == 0.5);
    sp_scene_free(&s);
}

TEST(each_check_is_for_its_own) {
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

/* A store that was made without this group is found again with it. */
TEST(samples_do_not_know_it) {
    FREED(sp_scene) plain, other;
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
}

RUN_TESTS(NULL, NULL)
