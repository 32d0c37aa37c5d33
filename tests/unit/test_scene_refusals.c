/* Every scene that is refused: SP_EINVAL with the place, the key and what it must be; nothing is written. */
#include "test.h"

#include <sonopack/study/scene.h>
#include <unistd.h>

#define SWEEP(entry)  "study = { sweep = (\n { " entry "; } ); };"
#define RANGE(inside) "packing = {\n " inside "; };"

/* A scene, what --set adds (NULL: nothing), and words of the reason. */
static const struct {
    const char *text, *set, *reason;
} refused[] = {
    /* numbers */
    {"packing = {\n  pressure = 10;\n};", NULL, "s.cfg:2 packing.pressure 10 1e-10 0.01 E*"},
    {"packing = { pressure = -1e-4; };", NULL, "s.cfg:1 packing.pressure -0.0001"},
    {"packing = { pressure = 1e999; };", NULL, "packing.pressure inf"},
    {"packing = { pressure = nan; };", NULL, "s.cfg:1"},
    {"packing = { grains = 2.5; };", NULL, "packing.grains 2.5"},
    {"packing = { grains = 4294967297; };", NULL, "packing.grains 4294967297"},
    {"packing = { seed = 1e30; };", NULL, "packing.seed 1e+30"},
    {"packing = { seed = 99999999999999999999; };", NULL, "s.cfg:1 64"},
    {"packing = { grains = 0xFFFFFFFFFFFFFFFFFF; };", NULL, "64"},
    {"packing = { seed = 9223372036854775807; }; study = { samples = 2; };", NULL, "packing.seed 9223372036854775807"},
    {"packing = { width = 3; };", NULL, "s.cfg:1 packing.width 3"},
    {"study = { samples = 6000000; }; packing = { grains = [200, 600]; };", NULL, "study.samples 6000000 10000000"},
    {"packing = { kind = \"chain\";\n dimension = 2; };", NULL, "s.cfg:2 packing.dimension 2 1"},
    /* types */
    {"packing = { pressure = \"high\"; };", NULL, "packing.pressure high 1e-10 0.01 E*"},
    {"packing = { pressure = true; };", NULL, "packing.pressure true"},
    {"packing = { pressure = [{ a = 1; }]; };", NULL, "packing.pressure"},
    {"packing = { kind = \"Piston\"; };", NULL, "packing.kind Piston piston triangular chain"},
    {"network = { prestress = 1; };", NULL, "network.prestress 1 true false"},
    {"study = { want = [\"modes\"]; };", NULL, "study.want modes"},
    {"study = { want = (1); };", NULL, "study.want 1"},
    {"packing = 3;", NULL, "packing"},
    {"packing = { file = [\"a.h5\"]; };", NULL, "packing.file"},
    /* names */
    {"packing = {\n pressur = 1e-4; };", NULL, "s.cfg:2 packing.pressur packing.pressure"},
    {"network = { pressure = 1e-4; };", NULL, "network.pressure packing.pressure"},
    {"pressure = 1e-4;", NULL, "s.cfg:1 pressure packing.pressure"},
    {"packin = { pressure = 1e-4; };", NULL, "packin packing"},
    {"packing = { xyzzy = 1; };", NULL, "packing.xyzzy"},
    {"packing = { };", "packing.presure=1e-4", "--set packing.pressure"},
    {"packing = { };", "=1", "--set"},
    {"packing = { };", "packing.pressure", "--set"},
    /* text */
    {"", NULL, "s.cfg"},
    {"# nothing but a comment\n", NULL, "s.cfg"},
    {"packing = { pressure = 1e-4; pressure = 1e-5; };", NULL, "s.cfg:1"},
    {"packing = {\n pressure = 1e-4;\n", NULL, "s.cfg"},
    {"packing = {};\r\n \t@include \"/dev/zero\"\n", NULL, "s.cfg:2"},
    {"packing = { kind = \"piston\n", NULL, "s.cfg:1"},
    {"packing = { };\n/* and on and on", NULL, "s.cfg:2"},
    {"packing = { grains = 200, \"lost\" };", NULL, "s.cfg:1"},
    {"\x01\x02\x03", NULL, "s.cfg:1"},
    /* study.sweep */
    {"study = { sweep = ( 3 ); };", NULL, "study.sweep"},
    {"study = { sweep = 3; };", NULL, "study.sweep 3"},
    {SWEEP("key = \"packing.width\""), NULL, "study.sweep"},
    {SWEEP("key = \"packing.content\"; values = [1]"), NULL, "packing.content"},
    {SWEEP("key = \"column.e\"; values = [0, 0.1]"), NULL, "study.sweep column.e"},
    {SWEEP("key = \"signal.sourse\"; values = [1]"), NULL, "s.cfg:2 signal.sourse signal.source"},
    {SWEEP("key = \"packing.grains\"; values = [200, 200]"), NULL, "packing.grains 200"},
    {SWEEP("key = \"packing.grains\"; values = [200,\n 0]"), NULL, "s.cfg:3 packing.grains 0"},
    {SWEEP("key = \"packing.width\"; values = [24, 2]"), NULL, "packing.width 2"},
    {SWEEP("key = \"packing.grains\"; values = [2]; }, { key = \"packing.grains\"; values = [6]"), NULL,
     "packing.grains"},
    {SWEEP("key = \"packing.friction\"; values = { from = 0; to = 1; count = 3; }"), NULL, "study.sweep"},
    {SWEEP("key = \"packing.sizes\"; values = [\"uniform\", 1]"), NULL, "packing.sizes 1 uniform"},
    {SWEEP("key = \"packing.history\"; values = [1e-3, 1e-4]"), NULL, "packing.history 0.001"},
    {SWEEP("key = \"packing.history\"; values = ([1e-3], [1])"), NULL, "packing.history 1"},
    {SWEEP("key = \"packing.history\"; values = ([], [])"), NULL, "packing.history"},
    /* lists and ranges in place of values */
    {RANGE("pressure = []"), NULL, "packing.pressure"},
    {RANGE("friction = [0.0, -0.0]"), NULL, "packing.friction 0"},
    {RANGE("reference = [true, false, true]"), NULL, "packing.reference true"},
    {RANGE("pressure = [1e-4, [1e-5]]"), NULL, "packing.pressure 1e-10 0.01 E*"},
    {RANGE("history = ([1e-3], [1e-4])"), NULL, "s.cfg:2 packing.history"},
    {RANGE("seed = [1, 9007199254740993]"), NULL, "9007199254740992"},
    {RANGE("seed = [100, 1]; }; study = { samples = 100"), NULL, "s.cfg:2 packing.seed 1 100 study.samples 100"},
    {RANGE("kind = [\"piston\", \"file\"]"), NULL, "packing.kind file"},
    {RANGE("file = \"p.h5\"; kind = [\"piston\", \"chain\"]"), NULL, "s.cfg:2 packing.kind"},
    {RANGE("height = [10, 20]; grains = 200"), NULL, "packing.height"},
    {RANGE("pressure = [1e-5]; };" SWEEP("key = \"packing.pressure\"; values = [1e-7]") "a = {"), NULL, "s.cfg"},
    {"signal = {\n method = [\"dense\"]; };", NULL, "s.cfg:2 signal.method"},
    {RANGE("damping = [1]; calm = [1]; drag = [0]; poisson = [0]; tolerance = [0]; width = [24]; friction = [0];"
           "seed = [1]; pressure = [1e-4]"),
     NULL, "packing.pressure 8"},
    {RANGE("pressure = { }"), NULL, "packing.pressure"},
    {RANGE("pressure = { from = 1e-7; to = 1e-4; }"), NULL, "packing.pressure"},
    {RANGE("pressure = { from = 1e-7; to = 1e-4; count = 1; }"), NULL, "packing.pressure 2 10000"},
    {RANGE("pressure = { from = 1e-7; to = 1e-7; count = 4; }"), NULL, "packing.pressure"},
    {RANGE("pressure = { from = 1e-7; to = 1; count = 4; }"), NULL, "packing.pressure 1 1e-10 0.01 E*"},
    {RANGE("pressure = { from = 1e-7; to = 1e-4; count = 4; spacing = 3; }"), NULL, "packing.pressure linear log"},
    {RANGE("pressure = { from = 1e-7; to = 1e-4; cuont = 4; }"), NULL, "s.cfg:2 packing.pressure cuont"},
    {RANGE("friction = { from = 0; to = 1; count = 4; spacing = \"log\"; }"), NULL, "packing.friction 0"},
    {RANGE("friction = { from = 0.1; to = 1; step = 0.1; spacing = \"log\"; }"), NULL, "packing.friction"},
    {RANGE("friction = { from = 0; to = 1; step = 0.3; }"), NULL, "packing.friction 0.3 1 3.33333"},
    {RANGE("friction = { from = 0; to = 1; step = -0.1; }"), NULL, "packing.friction -0.1 0 1"},
    {RANGE("friction = { from = 0; to = 1; step = 0; }"), NULL, "packing.friction 0"},
    {RANGE("friction = { from = 0; to = 1; step = 1e-9; }"), NULL, "packing.friction 1e+09 10000"},
    {RANGE("grains = { from = 200; to = 601; count = 3; }"), NULL, "packing.grains 400.5 2 3"},
    {RANGE("grains = { from = 1; to = 10; count = 30; spacing = \"log\"; }"), NULL, "packing.grains 1"},
    {RANGE("sizes = { from = 1; to = 2; count = 2; }"), NULL, "packing.sizes"},
    {"packing = { };", "packing.pressure={ from = 1e-7; to = 1e-4; }", "--set packing.pressure"},
    {"packing = { };", "packing.pressure=[1e-6, x]", "--set packing.pressure"},
    {"packing = { };", "packing.sizes=[uniform, box]", "--set packing.sizes box uniform bidisperse"},
    {"packing = { };", "packing.kind=\"piston\"junk", "--set packing.kind"},
    {"packing = { };", "packing.kind=piston\"", "--set packing.kind"},
    {"packing = { };", "packing.kind=pis\"\"ton", "--set packing.kind"},
    {"packing = { };", "packing.kind=pis ton", "--set packing.kind"},
    {"packing = { };", "packing.kind=piston\\n", "--set packing.kind"},
    {"packing = { };", "packing.sizes=uniform\" bidisperse", "--set packing.sizes"},
    {"packing = { };", "study.want=[\"ctof\"", "--set study.want"},
    {"packing = { };", "study.want=[\"ctof\" \"moduli\"]", "--set study.want"},
    {"packing = { };", "study.want=[[ctof],[moduli", "--set study.want"},
    {"packing = { };", "study.want=ctof]", "--set study.want"},
    {"packing = { };", "study.want=ctof; moduli", "--set study.want"},
    /* heights */
    {"packing = {\n height = 25;\n grains = 200; };", NULL, "s.cfg:2 packing.height 25"},
    {"packing = { grains = 200; };", "packing.height=25", "--set packing.grains 200"},
    {"packing = { kind = \"chain\"; height = 25; };", NULL, "packing.grains"},
    {"packing = { kind = \"triangular\"; height = 25; };", NULL, "packing.kind"},
    {"packing = { compression = \"isotropic\"; height = 25; };", NULL, "packing.compression"},
    {"packing = { height = 1e6; width = 1e6; };", NULL, "1e8"},
    /* planes, diameters */
    {"signal = {\n planes = [2, 1]; };", NULL, "s.cfg:2 signal.planes 1 2"},
    {"signal = { planes = [0]; };", NULL, "signal.planes 0"},
    {"signal = { planes = 3; };", NULL, "signal.planes 3"},
    {"study = { want = [\"planes\"]; };", NULL, "signal.planes"},
    {"signal = { planes = [1]; };", "signal.planes=1;2", "--set signal.planes"},
    {"packing = { diameter_file = \"/dev/null\"; };", NULL, "packing.diameter_file /dev/null"},
    {"packing = { diameter_file = \"a\"; diameters = [1]; };", NULL, "packing.diameter_file packing.diameters"},
    /* material */
    {"packing = { pressure = \"100 kPa\"; };", NULL, "packing.pressure"},
    {"material = { E = 70e9; };", NULL, "material.nu"},
};

TEST(scenes) {
    for (size_t k = 0; k < sizeof refused / sizeof *refused; k++) {
        char set[200], *sets[] = {set};
        sp_scene s;
        snprintf(set, sizeof set, "%s", refused[k].set ? refused[k].set : "");
        memset(&s, 0x5a, sizeof s);
        const sp_scene before = s;
        const int count = refused[k].set ? 1 : 0;
        assert_fails(sp_scene_parse(refused[k].text, "s.cfg", count, sets, &s, &err), SP_EINVAL, refused[k].reason);
        assert_memory_equal(&s, &before, sizeof s); /* outputs are written on success only */
        assert_int_equal(sp_scene_parse(refused[k].text, "s.cfg", count, sets, &s, NULL), SP_EINVAL);
    }
}

TEST(columns) {
    static const char *const wrong[][2] = {{"column.mass=0", "column.mass 0"},
                                           {"column.mass=[1, 0]", "column.mass 0"},
                                           {"column.radius=1e13", "1e-12 1000000000000"},
                                           {"column.mass=heavy", "column.mass heavy"},
                                           {"column.particles=0", "column.particles 0 1"},
                                           {"column.e=1", "column.e 1 0 1"},
                                           {"column.e=nan", "column.e nan"},
                                           {"column.stiffness=4903", "4903."},
                                           {"column.period=0.05", "column.frequency"},
                                           {"column.model=string", "eq35 eq37"},
                                           {"column.amplitude=[1, 1.06]", "column.amplitude column.parameter"},
                                           {"column.model=[lattice, bsr]", "column.model"},
                                           {"column.mass=([1], [2])", "column.mass"}};
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
        char set[100], *sets[] = {set};
        sp_scene s;
        snprintf(set, sizeof set, "%s", wrong[k][0]);
        assert_fails(sp_scene_read_tapped(NULL, 1, sets, &s, &err), SP_EINVAL, wrong[k][1]);
    }
}

/* As deep, as many and as long as memory allows: refused, and at once. */
TEST(large_texts) {
    const size_t size = 200000;
    static const char *const repeated[][2] = {{"a = ", "("}, {"", "a=1;"}, {"a = ", "9"}, {"", "a"}};
    for (int k = 0; k < 4; k++) {
        RELEASED char *text = calloc(size + 16, 1);
        const size_t head = strlen(repeated[k][0]), unit = strlen(repeated[k][1]);
        memcpy(text, repeated[k][0], head);
        for (size_t at = head; at + unit <= size; at += unit)
            memcpy(text + at, repeated[k][1], unit);
        sp_scene s;
        assert_fails(sp_scene_parse(text, "s.cfg", 0, NULL, &s, &err), SP_EINVAL, "s.cfg");
    }
}

TEST(files_that_are_no_scene) {
    char path[] = "/tmp/sonopack-test-scene-XXXXXX";
    const int file = mkstemp(path);
    assert_true(file >= 0);
    sp_scene s;
    assert_fails(sp_scene_read(path, 0, NULL, &s, &err), SP_EINVAL, "");
    assert_int_equal(write(file, "packing\0= {};", 13), 13);
    assert_fails(sp_scene_read(path, 0, NULL, &s, &err), SP_EINVAL, "");
    close(file);
    unlink(path);
    assert_fails(sp_scene_read(path, 0, NULL, &s, &err), SP_EINVAL, "No such file");
    assert_fails(sp_scene_read("/tmp", 0, NULL, &s, &err), SP_EINVAL, "Is a directory");
}

RUN_TESTS(NULL, NULL)
