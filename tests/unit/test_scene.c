/* Scenes: the field table, the parser, overrides, and what a hostile or mistaken scene gets told. */
#include "test.h"

#include "base/base.h"
#include "scene/field.h"
#include <sonopack/study/scene.h>
#include <unistd.h>

static sp_status parse(const char *text, sp_scene *out, sp_error *err) {
    return sp_scene_parse(text, "s.cfg", 0, NULL, out, err);
}

static sp_status set(const char *override, sp_scene *out, sp_error *err) {
    char *list[] = {(char *)(uintptr_t) override};
    return sp_scene_read(NULL, 1, list, out, err);
}

static void refuses(const char *text, const char *reason) {
    sp_scene s;
    memset(&s, 0x5a, sizeof s);
    const sp_scene before = s;
    assert_fails(parse(text, &s, &err), SP_EINVAL, reason);
    assert_memory_equal(&s, &before, sizeof s); /* outputs are written on success only */
    assert_int_equal(parse(text, &s, NULL), SP_EINVAL);
}

static void refuses_set(const char *override, const char *reason) {
    sp_scene s;
    assert_fails(set(override, &s, &err), SP_EINVAL, "--set");
    assert_fails(set(override, &s, &err), SP_EINVAL, reason);
}

/* ---- values ------------------------------------------------------------------------------------------------- */

static void defaults_are_those_of_the_rooms(void **state) {
    (void)state;
    const sp_pack_spec pack = sp_pack_spec_default();
    const sp_network_options network = sp_network_options_default();
    const sp_signal_options signal = sp_signal_options_default();
    sp_scene s;
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
    sp_scene_free(&s);
}

static void integers_and_reals_stand_for_each_other(void **state) {
    (void)state;
    sp_scene s;
    assert_ok(parse("packing = { grains = 1e3; width = 30; seed = 3000000000; max_steps = 5e12; };"
                    "signal : { until = 7, points = 0x10 };",
                    &s, &err));
    assert_int_equal(s.pack.grains, 1000);
    assert_true(s.pack.width == 30 && s.pack.seed == 3000000000u && s.pack.max_steps == 5000000000000);
    assert_true(s.signal.until == 7 && s.signal.points == 16);
    sp_scene_free(&s);
}

static void every_word_and_switch_is_read(void **state) {
    (void)state;
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

static void seeds_keep_their_64_bits(void **state) {
    (void)state;
    const uint64_t seed = (UINT64_C(1) << 62) + 1; /* no double */
    sp_scene s, again;
    assert_ok(set("packing.seed=4611686018427387905", &s, &err));
    assert_true(s.pack.seed == seed);
    char *text = sp_scene_text(&s, "packing");
    assert_non_null(strstr(text, "4611686018427387905L"));
    assert_ok(parse(text, &again, &err));
    assert_true(again.pack.seed == seed);
    sp_free(text);
    sp_scene_free(&again);
    sp_scene_free(&s);
}

static void a_chain_has_one_dimension(void **state) {
    (void)state;
    sp_scene s;
    assert_ok(parse("packing = { kind = \"chain\"; };", &s, &err));
    assert_int_equal(s.pack.dim, 1);
    sp_scene_free(&s);
    assert_ok(set("packing.kind=chain", &s, &err));
    assert_int_equal(s.pack.dim, 1);
    sp_scene_free(&s);
    refuses("packing = { kind = \"chain\";\n dimension = 2; };", "s.cfg:2 packing.dimension 2 1");
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

static void text_reads_back_bit_for_bit(void **state) {
    (void)state;
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

static void sweeps_read_back(void **state) {
    (void)state;
    const char *source = "study = { samples = 3; sweep = (\n"
                         "{ key = \"packing.pressure\"; values = [1e-7, 1e-4]; },\n"
                         "{ key = \"packing.grains\"; values = [200, 6e2]; } ); };";
    sp_scene s, back;
    assert_ok(parse(source, &s, &err));
    char *text = sp_scene_text(&s, NULL);
    assert_ok(parse(text, &back, &err));
    assert_int_equal(back.sweeps, 2);
    assert_int_equal(back.samples, 3);
    assert_string_equal(back.sweep[1].key, "packing.grains");
    assert_int_equal(back.sweep[0].count, 2);
    assert_true(back.sweep[0].values[0] == 1e-7 && back.sweep[0].values[1] == 1e-4);
    assert_true(back.sweep[1].values[0] == 200 && back.sweep[1].values[1] == 600);
    char *again = sp_scene_text(&back, NULL);
    assert_string_equal(text, again);
    sp_free(again);
    sp_free(text);
    sp_scene_free(&back);
    sp_scene_free(&s);
}

static void text_of_one_group(void **state) {
    (void)state;
    sp_scene s = sp_scene_default();
    char *text = sp_scene_text(&s, "network");
    assert_non_null(strstr(text, "threshold"));
    assert_null(strstr(text, "pressure"));
    sp_free(text);
    text = sp_scene_text(&s, "nowhere");
    assert_string_equal(text, "");
    sp_free(text);
}

static void help_names_every_key(void **state) {
    (void)state;
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

/* ---- mistakes ----------------------------------------------------------------------------------------------- */

static void numbers_out_of_range(void **state) {
    (void)state;
    sp_scene s;
    refuses("packing = {\n  pressure = 10;\n};", "s.cfg:2 packing.pressure 10 1e-10 0.01 E*");
    refuses("packing = { pressure = 1e-12; };", "s.cfg:1 packing.pressure 1e-12 1e-10 0.01 E*");
    refuses("packing = { pressure = -1e-4; };", "packing.pressure -0.0001");
    refuses("packing = { pressure = 1e999; };", "packing.pressure inf");
    refuses("packing = { pressure = nan; };", "s.cfg:1");
    refuses("packing = { grains = 0; };", "packing.grains 0 1 100000000");
    refuses("packing = { grains = 2.5; };", "packing.grains 2.5");
    refuses("packing = { grains = 4294967297; };", "packing.grains 4294967297");
    refuses("packing = { seed = -1; };", "packing.seed -1");
    refuses("packing = { seed = 1e30; };", "packing.seed 1e+30");
    refuses("packing = { seed = 99999999999999999999; };", "64");
    assert_ok(parse("packing = { seed = 9223372036854775807; };", &s, &err)); /* the last one that there is */
    sp_scene_free(&s);
    refuses("packing = { seed = 9223372036854775807; }; study = { samples = 2; };", "packing.seed 9223372036854775807");
    refuses("packing = { width = 3; };", "s.cfg:1 packing.width 3");
    refuses("signal = { points = 1; };", "signal.points 1 2");
    refuses("study = { samples = 0; };", "study.samples 0 1");
}

static void values_of_the_wrong_type(void **state) {
    (void)state;
    refuses("packing = { pressure = \"high\"; };", "packing.pressure high 1e-10 0.01 E*");
    refuses("packing = { pressure = true; };", "packing.pressure true");
    refuses("packing = { pressure = [[1e-4]]; };", "packing.pressure");
    refuses("packing = { pressure = [{ a = 1; }]; };", "packing.pressure");
    refuses("packing = { kind = 1; };", "packing.kind 1 piston triangular chain");
    refuses("packing = { kind = \"Piston\"; };", "packing.kind Piston piston triangular chain");
    refuses("network = { prestress = 1; };", "network.prestress 1 true false");
    refuses("study = { want = [\"modes\"]; };", "study.want modes");
    refuses("study = { want = (1); };", "study.want 1");
    refuses("packing = 3;", "packing");
}

static void unknown_names_meet_the_nearest(void **state) {
    (void)state;
    refuses("packing = {\n pressur = 1e-4; };", "s.cfg:2 packing.pressur packing.pressure");
    refuses("network = { pressure = 1e-4; };", "network.pressure packing.pressure");
    refuses("pressure = 1e-4;", "s.cfg:1 pressure packing.pressure");
    refuses("packin = { pressure = 1e-4; };", "packin packing");
    refuses("qqqqqqqqqq = { pressure = 1e-4; };", "qqqqqqqqqq packing network signal study column");
    refuses("packing = { xyzzy = 1; };", "packing.xyzzy");
    refuses_set("packing.presure=1e-4", "packing.pressure");
    refuses_set("=1", "");
    assert_int_equal(sp_edit_distance("pressure", "presusre"), 1);
    assert_int_equal(sp_edit_distance("kitten", "sitting"), 3);
    assert_int_equal(sp_edit_distance("", "abc"), 3);
}

static void sweeps_that_make_no_sense(void **state) {
    (void)state;
    refuses("study = { sweep = ( { key = \"packing.kind\"; values = [1]; } ); };", "packing.kind 1 piston");
    refuses("study = { sweep = ( { key = \"packing.content\"; values = [1]; } ); };", "packing.content");
    refuses("study = { sweep = ( { key = \"packing.presure\"; values = [1]; } ); };", "packing.pressure");
    refuses("study = { sweep = ( { key = \"packing.grains\"; values = [200]; },\n"
            "{ key = \"packing.grains\"; values = [600]; } ); };",
            "s.cfg:2 study.sweep packing.grains");
    refuses("study = { sweep = ( { key = \"packing.grains\"; values = [200, 200]; } ); };", "packing.grains 200");
    refuses("study = { sweep = ( { key = \"packing.grains\"; values = [200,\n 0]; } ); };", "s.cfg:2 packing.grains 0");
    refuses("study = { sweep = ( { key = \"packing.grains\"; values = []; } ); };", "packing.grains");
    refuses("study = { sweep = ( { key = \"packing.width\"; values = [24, 2]; } ); };", "packing.width 2");
    refuses("study = { sweep = ( { key = \"packing.width\"; } ); };", "study.sweep");
    refuses("study = { sweep = ( 3 ); };", "study.sweep");
    refuses("study = { sweep = 3; };", "study.sweep 3");
    refuses("study = { samples = 6000000; sweep = ( { key = \"packing.grains\"; values = [200, 600]; } ); };",
            "study.samples 6000000 6000000 samples 2 10000000");
}

static void hostile_text(void **state) {
    (void)state;
    refuses("", "s.cfg");
    refuses("# nothing but a comment\n", "s.cfg");
    refuses("packing = { pressure = 1e-4; pressure = 1e-5; };", "s.cfg:1");
    refuses("packing = {\n pressure = 1e-4;\n", "s.cfg");
    refuses("\n@include \"/etc/passwd\"\n", "s.cfg:2");
    refuses("packing = {};\r\n \t@include \"/dev/zero\"\n", "s.cfg:2");
    refuses("packing = { kind = \"piston\n", "s.cfg:1");
    refuses("packing = { };\n/* and on and on", "s.cfg:2");
    refuses("packing = { grains = 200, \"lost\" };", "s.cfg:1");
    refuses("\"lost\" = 3;", "s.cfg:1");
    refuses("\x01\x02\x03", "s.cfg:1");
    refuses("packing = { grains = 0xFFFFFFFFFFFFFFFFFF; };", "64");

    const size_t deep = 200000;
    char *text = calloc(deep + 16, 1);
    memcpy(text, "a = ", 4);
    memset(text + 4, '(', deep);
    refuses(text, "s.cfg");
    memset(text, 0, deep + 16);
    for (size_t k = 0; k + 8 <= deep; k += 8)
        snprintf(text + k, 9, "a%05zu=1", k % 100000); /* no separators: digits run on into the next name */
    refuses(text, "s.cfg:1");
    for (size_t k = 0; k + 4 <= deep; k += 4)
        memcpy(text + k, "a=1;", 4);
    refuses(text, "s.cfg");
    memset(text, '9', deep);
    memcpy(text, "a = ", 4);
    refuses(text, "64");
    free(text);
}

static void files_that_are_no_scene(void **state) {
    (void)state;
    char path[] = "/tmp/sonopack-test-scene-XXXXXX";
    const int file = mkstemp(path);
    assert_true(file >= 0);
    sp_scene s;
    assert_fails(sp_scene_read(path, 0, NULL, &s, &err), SP_EINVAL, "");
    assert_int_equal(write(file, "packing\0= {};", 13), 13);
    assert_fails(sp_scene_read(path, 0, NULL, &s, &err), SP_EINVAL, "");
    assert_int_equal(ftruncate(file, 33 << 20), 0);
    assert_fails(sp_scene_read(path, 0, NULL, &s, &err), SP_EINVAL, "");
    close(file);
    unlink(path);
    assert_fails(sp_scene_read(path, 0, NULL, &s, &err), SP_EINVAL, "No such file");
    assert_fails(sp_scene_read("/tmp", 0, NULL, &s, &err), SP_EINVAL, "Is a directory");
    assert_fails(sp_scene_read("", 0, NULL, &s, &err), SP_EINVAL, "No such file");
}

/* ---- overrides and single keys ------------------------------------------------------------------------------ */

static void overrides_win_and_are_checked(void **state) {
    (void)state;
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

    refuses_set("packing.pressure=10", "packing.pressure 10 1e-10 0.01 E*");
    refuses_set("packing.pressure=nan", "packing.pressure nan");
    refuses_set("packing.pressure=-inf", "packing.pressure");
    refuses_set("packing.pressure=", "packing.pressure");
    refuses_set("packing.pressure=1e-4; friction = 0", "packing.pressure 1e-4 friction 0");
    refuses_set("packing.pressure=1e-4 1e-5", "packing.pressure");
    refuses_set("packing.pressure", "packing.pressure");
    refuses_set("packing.width=3", "packing.width 3");
    refuses_set("packing.kind=box", "packing.kind box piston triangular chain");
    refuses_set("network.prestress=yes", "true false");
    refuses_set("study.want=ctof,nothing", "nothing");
    refuses_set("packing=3", "");
}

static void set_and_get_one_key(void **state) {
    (void)state;
    sp_scene s = sp_scene_default();
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
    sp_scene_free(&s);
}

/* Every allocation fails once: a reason, no leak (the sanitizers look), nothing written. */
static void lack_of_memory(void **state) {
    (void)state;
    char want[] = "study.want=ctof", *list[] = {want};
    const char *text = "study = { sweep = ( { key = \"packing.pressure\"; values = [1e-7, 1e-4]; } ); };";
    sp_status status = SP_ENOMEM;
    int64_t failures = 0;
    for (int64_t after = 0; status == SP_ENOMEM; after++) {
        sp_scene s;
        sp_alloc_fail_after(after);
        status = sp_scene_parse(text, "s.cfg", 1, list, &s, NULL);
        sp_alloc_fail_after(-1);
        failures += status == SP_ENOMEM;
        if (status == SP_OK)
            sp_scene_free(&s);
    }
    assert_int_equal(status, SP_OK);
    assert_true(failures >= 3);
    for (int64_t after = 0; after < 2; after++) {
        sp_alloc_fail_after(after);
        assert_null(sp_scene_help());
        sp_alloc_fail_after(-1);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(defaults_are_those_of_the_rooms),
        cmocka_unit_test(integers_and_reals_stand_for_each_other),
        cmocka_unit_test(every_word_and_switch_is_read),
        cmocka_unit_test(seeds_keep_their_64_bits),
        cmocka_unit_test(a_chain_has_one_dimension),
        cmocka_unit_test(text_reads_back_bit_for_bit),
        cmocka_unit_test(sweeps_read_back),
        cmocka_unit_test(text_of_one_group),
        cmocka_unit_test(help_names_every_key),
        cmocka_unit_test(numbers_out_of_range),
        cmocka_unit_test(values_of_the_wrong_type),
        cmocka_unit_test(unknown_names_meet_the_nearest),
        cmocka_unit_test(sweeps_that_make_no_sense),
        cmocka_unit_test(hostile_text),
        cmocka_unit_test(files_that_are_no_scene),
        cmocka_unit_test(overrides_win_and_are_checked),
        cmocka_unit_test(set_and_get_one_key),
        cmocka_unit_test(lack_of_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
