/* Explains the keys of scenes: all of them, or one. */
#include "base/base.h"
#include "base/text.h"
#include "scene/field.h"

#include <stdio.h>
#include <string.h>

static const char head[] =
    "A scene says what to make, in libconfig syntax:\n\n"
    "  packing = { kind = \"piston\"; grains = 600; pressure = 1e-4; };\n"
    "  study = { samples = 30; want = [\"ctof\", \"statics\"]; sweep = (\n"
    "    { key = \"packing.pressure\"; values = [1e-7, 1e-6, 1e-5, 1e-4]; },\n"
    "    { key = \"packing.grains\"; values = [200, 600]; } ); };\n\n"
    "Every key may be left out; --set key=value overrides it. # begins a comment.\n"
    "Lengths in mean grain diameters d, pressures in E*, times in d/sqrt(E* / rho). With a material, every key with a\n"
    "unit takes a number with an SI unit in quotes:\n\n"
    "  material = { E = 70e9; nu = 0.22; rho = 2500; d = 1e-3; };\n"
    "  packing = { pressure = \"100 kPa\"; width = \"20 mm\"; };\n\n"
    "A study sweeps the keys of study.sweep, and every key with a list of values or a range in place of its "
    "value.\n"
    "It makes every combination:\n\n"
    "  packing = { pressure = { from = 1e-7; to = 1e-4; count = 4; spacing = \"log\"; };\n"
    "    friction = { from = 0; to = 0.5; step = 0.1; }; sizes = [\"uniform\", \"bidisperse\"]; };\n"
    "  study = { sweep = ( { key = \"packing.grains\"; from = 200; to = 600; count = 3; },\n"
    "    { key = \"packing.history\"; values = ( [], [1e-3], [1e-3, 1e-5] ); } ); };\n\n"
    "A range has equal steps, or equal ratios (spacing = \"log\", which rounds integers), and includes both ends.\n"
    "Keys that are lists themselves can be swept by study.sweep only. A study may sweep the keys that change its\n"
    "samples: those of packing and network, but not packing.file, packing.content and packing.diameter_file; and\n"
    "signal.source. Values of packing.seed must differ by at least study.samples. `sonopack pack' makes the "
    "packing\n"
    "with the first value of each list or range in place of a value. --set takes lists and ranges, too.\n\n"
    "The group column is for `sonopack column' only, in cm, g and s. It is independent of the other groups.\n";

/* The value as people write it: the text of a scene marks 64 bits with L, and printf pads exponents. */
static void put_plain(sp_text *t, const sp_scene *s, const sp_field *f) {
    char value[SP_NUMBER_TEXT];
    if (f->type == SP_FIELD_REAL)
        sp_text_add(t, "%s", sp_number_plain(sp_field_load(s, f).real, value));
    else if (f->type == SP_FIELD_INT64)
        sp_text_add(t, "%lld", (long long)sp_field_load(s, f).integer);
    else
        sp_field_put(t, s, f);
}

char *sp_scene_help(void) {
    sp_text t = {0};
    sp_scene s = sp_scene_default();
    sp_text_add(&t, "%s", head);
    for (int k = 0; k < SP_FIELDS; k++) {
        const sp_field *f = &sp_fields[k];
        char right[200];
        sp_text_add(&t, "\n%s = ", f->key);
        put_plain(&t, &s, f);
        sp_text_add(&t, "\n    %s\n", f->meaning);
        if (f->type != SP_FIELD_SWEEP)
            sp_text_add(&t, "    must be %s\n", sp_field_right(f, right, sizeof right));
    }
    sp_scene_free(&s);
    return sp_field_text_end(&t);
}

/* ---- one key ---------------------------------------------------------------------------------------------------- */

#define PAPER "Somfai et al. 2005, section III"

/* For the help of one key: a value to try, in the syntax of --set, and where the default comes from. */
static const struct example {
    const char *key, *value, *source;
} examples[] = {
    {"packing.kind", "triangular", PAPER},
    {"packing.cell", "periodic", PAPER},
    {"packing.file", "P.h5", "none: only kind = file needs it"},
    {"packing.content", "0", "none: any packing"},
    {"packing.dimension", "3", PAPER ": disks in the plane"},
    {"packing.grains", "1000", PAPER},
    {"packing.width", "12", PAPER},
    {"packing.depth", "10", "physics.md, Preparation: a square base"},
    {"packing.height", "25", "none: packing.grains decides"},
    {"packing.pressure", "1e-6", "the largest of the four pressures of Somfai et al. 2005"},
    {"packing.stress", "[1e-4, 1.2e-4, 1e-5]", "none: packing.pressure decides"},
    {"packing.gravity", "1e-6", PAPER},
    {"packing.history", "[1e-3, 1e-5]", "none: a single pressure"},
    {"packing.path.strain", "[0, 0, 0.1]", "none: the packing is not strained"},
    {"packing.path.turns", "[1, 0]", "none: the path ends at its strain"},
    {"packing.path.steps", "100", "physics.md, Paths of strain"},
    {"packing.path.lateral", "stress", "physics.md, Paths of strain"},
    {"packing.stages", "3", "none: the whole path"},
    {"packing.friction", "0.3", PAPER},
    {"packing.tangential", "history", PAPER},
    {"packing.poisson", "0.3", PAPER ": k_t = k_n at nu = 0"},
    {"packing.types.fraction", "[0.5, 0.5]", "none: one material"},
    {"packing.types.diameter", "[1, 1.4]", "none: packing.sizes decides"},
    {"packing.types.modulus", "[1, 0.1]", "none: equal materials"},
    {"packing.types.poisson", "[0, 0.3]", "none: packing.poisson"},
    {"packing.types.density", "[1, 0.4]", "none: equal materials"},
    {"packing.types.friction", "[0.5, 0.3, 0.1]", "none: packing.friction"},
    {"packing.shape", "disk", PAPER ": balls in a plane"},
    {"packing.sizes", "bidisperse", PAPER},
    {"packing.diameter_min", "0.7", PAPER ": 0.8 to 1.2"},
    {"packing.diameter_max", "1.4", PAPER ": 0.8 to 1.2"},
    {"packing.large_fraction", "0.3", "physics.md, Sizes of grains: as many large grains as small ones"},
    {"packing.size_spread", "0.1", "physics.md, Sizes of grains"},
    {"packing.diameters", "[0.9, 1.1]", "none: only sizes = list needs it"},
    {"packing.diameter_file", "sizes.txt", "none: only sizes = list needs it"},
    {"packing.compression", "isotropic", PAPER},
    {"packing.protocol", "quick", "physics.md, Preparation: the motion of Somfai et al. 2005 in longer steps"},
    {"packing.reference", "true", "physics.md, Preparation"},
    {"packing.seed", "7", "none: any seed is as good"},
    {"packing.tolerance", "1e-11",
     "Somfai et al. 2005 have 1e-10; physics.md, Preparation, says why less at small pressures"},
    {"packing.damping", "0.5", "physics.md, Preparation: chosen for the tables of Somfai et al. 2005"},
    {"packing.piston_mass", "5", "physics.md, Preparation: chosen for the tables of Somfai et al. 2005"},
    {"packing.gas_fraction", "0.2", "physics.md, Preparation: chosen for the tables of Somfai et al. 2005"},
    {"packing.time_step", "0.5", "physics.md, Preparation: the largest that does not change the packings"},
    {"packing.lag", "0.5", "physics.md, Preparation: the largest that does not change the packings"},
    {"packing.calm", "0.1", "physics.md, Preparation"},
    {"packing.drag", "0.005", "physics.md, Preparation: the fastest in boxes of 24 d"},
    {"packing.calm_damping", "0.4", "physics.md, Preparation"},
    {"packing.viscous_limit", "1", "physics.md, Preparation"},
    {"packing.strain_rate", "0.001", "physics.md, Cells without a piston, and gravity"},
    {"packing.fraction", "0.9", "physics.md, Minima of the energy"},
    {"packing.law.exponent", "1", "physics.md, Minima of the energy"},
    {"packing.max_steps", "2000000", "physics.md, Preparation: generous"},
    {"material.E", "70e9", "none: units.md"},
    {"material.nu", "0.22", "none: units.md"},
    {"material.rho", "2500", "none: units.md"},
    {"material.d", "1e-3", "none: units.md"},
    {"network.threshold", "1e-5", "physics.md, The network"},
    {"network.prestress", "true", "physics.md, The network"},
    {"network.sliding_free", "true", "physics.md, The network"},
    {"network.tangential", "loading", PAPER},
    {"signal.method", "dense", "physics.md, The signal: the fastest that keeps the tolerance"},
    {"signal.source", "displacement", "physics.md, The signal"},
    {"signal.until", "500", "physics.md, The signal: (8 H + 40)(p/1e-4)^(-1/6), after the first front"},
    {"signal.points", "2001", "physics.md, The signal"},
    {"signal.tolerance", "1e-6", "physics.md, The signal"},
    {"signal.planes", "[8, 12, 16]", "none: only study.want with planes needs it"},
    {"study.samples", "30", "none; Somfai et al. 2005 have 30"},
    {"study.want", "[\"ctof\", \"moduli\"]", "tutorial.md: the speed of the front"},
    {"study.sweep", "( { key = \"packing.pressure\"; values = [1e-7, 1e-4]; } )", "none: one combination"},
    {"column.particles", "10", "physics.md, The tapped column"},
    {"column.frequency", "10", "Blackmore et al. 2011"},
    {"column.period", "0.5", "physics.md, The tapped column"},
    {"column.taps", "100", "physics.md, The tapped column"},
    {"column.amplitude", "0.5", "Blackmore et al. 2011"},
    {"column.e", "0.5", "Blackmore et al. 2011"},
    {"column.stiffness", "1e7", "physics.md, The tapped column"},
    {"column.gravity", "981", "standard gravity"},
    {"column.drop", "2", "physics.md, The tapped column: at rest"},
    {"column.mass", "[1, 2]", "physics.md, The tapped column"},
    {"column.radius", "[1, 0.8]", "physics.md, The tapped column"},
    {"column.model", "longwave", "physics.md, The tapped column: the particles themselves"},
    {"column.method", "smooth", "physics.md, The tapped column: exact"},
    {"column.bsr", "signed", "physics.md, The tapped column: the only one that carries a column"},
    {"column.output", "strobe", "guide.md"},
    {"column.step", "0.01", "guide.md"},
    {"column.alpha_v", "10", "physics.md, The tapped column"},
    {"column.alpha_x", "1e3", "physics.md, The tapped column: the step itself"},
    {"column.time_step", "1e-5", "physics.md, The tapped column: the largest stable one"},
    {"column.tolerance", "1e-6", "physics.md, The tapped column"},
    {"column.cells", "16", "physics.md, The tapped column"},
    {"column.parameter", "frequency", "guide.md"},
    {"column.from", "0.5", "none: the value in the scene"},
    {"column.to", "2", "none: the value in the scene"},
    {"column.points", "101", "none: one value"},
    {"column.transient", "500", "physics.md, The tapped column"},
};

static const struct example *example_of(const sp_field *f) {
    for (size_t k = 0; k < sizeof examples / sizeof *examples; k++)
        if (strcmp(examples[k].key, f->key) == 0)
            return &examples[k];
    return NULL;
}

static void put_key(sp_text *t, const sp_scene *s, const sp_field *f) {
    const struct example *example = example_of(f);
    const sp_key *limits = sp_field_limits(f);
    char right[200];
    sp_text_add(t, "%s\n  meaning  %s\n", f->key, f->meaning);
    sp_text_add(t, "  unit     %s\n", limits && limits->unit[0] ? limits->unit : "none");
    sp_text_add(t, "  range    %s\n  default  ", sp_field_right(f, right, sizeof right));
    put_plain(t, s, f);
    if (example)
        sp_text_add(t, "\n  source   %s\n  example  --set '%s=%s'", example->source, f->key, example->value);
    sp_text_add(t, "\n");
}

/* "friction" is the key of every group that has one of that name, "packing.types" all keys of this group. */
static bool means(const sp_field *f, const char *word) {
    size_t length = strlen(word);
    bool group = strncmp(f->key, word, length) == 0 && f->key[length] == '.';
    return group || strcmp(f->key, word) == 0 || strcmp(sp_field_name(f), word) == 0;
}

char *sp_scene_help_key(const char *word) {
    sp_text t = {0};
    sp_scene s = sp_scene_default();
    int found = 0;
    for (const sp_field *f = sp_fields; f < sp_fields + SP_FIELDS; f++) {
        if (!means(f, word))
            continue;
        sp_text_add(&t, "%s", found++ > 0 ? "\n" : "");
        put_key(&t, &s, f);
    }
    sp_scene_free(&s);
    return sp_field_text_end(&t);
}

const char *sp_scene_key(int k) { return k >= 0 && k < SP_FIELDS ? sp_fields[k].key : NULL; }
