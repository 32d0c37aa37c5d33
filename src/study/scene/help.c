/* Explains the keys of scenes: all of them, or one. */
#include "base/base.h"
#include "base/text.h"
#include "scene/example.h"
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

/* The finished text; NULL without memory. */
static char *finish(sp_text *t) {
    sp_text_add(t, "%s", "");
    if (!t->failed)
        return t->data;
    sp_text_free(t);
    return NULL;
}

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
    return finish(&t);
}

/* ---- one key ---------------------------------------------------------------------------------------------------- */

static void put_key(sp_text *t, const sp_scene *s, const sp_field *f) {
    const sp_example *example = sp_field_example(f);
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

/* "friction" is the key of every group that has one of that name. */
static bool means(const sp_field *f, const char *word) {
    return strcmp(f->key, word) == 0 || strcmp(sp_field_name(f), word) == 0;
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
    return finish(&t);
}

const char *sp_scene_key(int k) { return k >= 0 && k < SP_FIELDS ? sp_fields[k].key : NULL; }
