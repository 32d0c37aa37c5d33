/* A scene as text, and the table of fields as help. */
#include "base/base.h"
#include "scene/field.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* Text that grows; failed once memory lacks, and then stays as it is. */
typedef struct writer {
    char *text;
    size_t used, room;
    bool failed;
} writer;

static void put(writer *w, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void put(writer *w, const char *format, ...) {
    va_list args, again;
    va_start(args, format);
    va_copy(again, args);
    const size_t length = (size_t)vsnprintf(NULL, 0, format, args);
    va_end(args);
    if (!w->failed && w->used + length + 1 > w->room) {
        const size_t room = 2 * (w->used + length) + 1024;
        char *more = sp_alloc(room, 1);
        w->failed = more == NULL;
        if (more) {
            if (w->used > 0)
                memcpy(more, w->text, w->used);
            sp_free(w->text);
            w->text = more;
            w->room = room;
        }
    }
    if (!w->failed) {
        vsnprintf(w->text + w->used, w->room - w->used, format, again);
        w->used += length;
    }
    va_end(again);
}

/* The finished text, NULL if memory lacked. */
static char *finish(writer *w) {
    put(w, "%s", "");
    if (!w->failed)
        return w->text;
    sp_free(w->text);
    return NULL;
}

static void put_list(writer *w, const sp_field *f, unsigned bits) {
    const char *comma = "";
    put(w, "[");
    for (const sp_word *word = f->words; word->word; word++) {
        if (bits == 0 ? word->value == 0 : (bits & word->value) != 0) {
            put(w, "%s\"%s\"", comma, word->word);
            comma = ", ";
        }
    }
    put(w, "]");
}

static void put_reals(writer *w, const double *values, int32_t count) {
    char value[32];
    put(w, "(");
    for (int32_t k = 0; k < count; k++)
        put(w, "%s%s", k == 0 ? "" : k % 8 ? ", " : ",\n    ", sp_number_text(values[k], value));
    put(w, ")");
}

/* Value k of a sweep as it is read. */
static void put_swept(writer *w, const sp_sweep *sweep, int k) {
    const sp_field *f = sp_field_find(sweep->key);
    const char *quote = f && f->type == SP_FIELD_WORD ? "\"" : "";
    char value[64];
    if (sweep->begin)
        put_reals(w, sweep->values + sweep->begin[k], sweep->begin[k + 1] - sweep->begin[k]);
    else
        put(w, "%s%s%s", quote, sp_sweep_text(sweep, k, value, sizeof value), quote);
}

static void put_sweeps(writer *w, const sp_scene *s) {
    put(w, "(");
    for (int k = 0; k < s->sweeps; k++) {
        put(w, "%s\n    { key = \"%s\"; values = (", k > 0 ? "," : "", s->sweep[k].key);
        for (int i = 0; i < s->sweep[k].count; i++) {
            put(w, i > 0 ? ", " : "");
            put_swept(w, &s->sweep[k], i);
        }
        put(w, "); }");
    }
    put(w, s->sweeps > 0 ? "\n  )" : ")");
}

/* A name as a string of libconfig. */
static void put_name(writer *w, const char *name) {
    put(w, "\"");
    for (; *name; name++)
        put(w, "%s%c", *name == '"' || *name == '\\' ? "\\" : "", *name);
    put(w, "\"");
}

static void put_value(writer *w, const sp_scene *s, const sp_field *f) {
    const char *place = (const char *)s + f->offset;
    const double *values;
    int32_t count;
    char value[32];
    unsigned bits;
    switch (f->type) {
    case SP_FIELD_REAL: put(w, "%s", sp_number_text(sp_field_load(s, f).real, value)); break;
    case SP_FIELD_INT: put(w, "%lld", (long long)sp_field_load(s, f).integer); break;
    case SP_FIELD_INT64: put(w, "%lldL", (long long)sp_field_load(s, f).integer); break;
    case SP_FIELD_BOOL: put(w, "%s", *(const bool *)place ? "true" : "false"); break;
    case SP_FIELD_WORD:
        memcpy(&bits, place, sizeof bits);
        for (const sp_word *word = f->words; word->word; word++)
            if (word->value == bits)
                put(w, "\"%s\"", word->word);
        break;
    case SP_FIELD_LIST:
        memcpy(&bits, place, sizeof bits);
        put_list(w, f, bits);
        break;
    case SP_FIELD_SWEEP: put_sweeps(w, s); break;
    case SP_FIELD_REALS:
        values = sp_field_list(s, f, &count);
        put_reals(w, values, count);
        break;
    case SP_FIELD_PATH: put_name(w, place); break;
    case SP_FIELD_FILE: put(w, "\"\""); break; /* its numbers stand in the list */
    }
}

/* Of grains and height the one that decides: a scene says the same, whichever it was given by, once it is resolved. Of
 * a whole scene the dimension that is each kind's own. */
static bool left_out(const sp_scene *s, const sp_field *f, const char *group) {
    if (strcmp(f->key, "packing.dimension") == 0 && !group && !s->dimension_given)
        for (int k = 0; k < s->sweeps; k++)
            if (strcmp(s->sweep[k].key, "packing.kind") == 0)
                return true;
    return (strcmp(f->key, "packing.height") == 0 && !(s->height > 0)) ||
           (strcmp(f->key, "packing.grains") == 0 && s->height > 0);
}

char *sp_scene_text(const sp_scene *s, const char *group) {
    writer w = {0};
    for (int g = 0; g < SP_GROUPS; g++) {
        if (group ? strcmp(group, sp_groups[g]) != 0 : strcmp(sp_groups[g], "column") == 0)
            continue;
        put(&w, "%s = {\n", sp_groups[g]);
        for (const sp_field *f = sp_fields; f < sp_fields + SP_FIELDS; f++) {
            if (!sp_field_in_group(f, sp_groups[g]) || left_out(s, f, group))
                continue;
            put(&w, "  %s = ", sp_field_name(f));
            put_value(&w, s, f);
            put(&w, ";\n");
        }
        put(&w, "};\n");
    }
    return finish(&w);
}

char *sp_scene_help(void) {
    static const char head[] =
        "A scene says what to make, in libconfig syntax:\n\n"
        "  packing = { kind = \"piston\"; grains = 600; pressure = 1e-4; };\n"
        "  study = { samples = 30; want = [\"ctof\", \"statics\"]; sweep = (\n"
        "    { key = \"packing.pressure\"; values = [1e-7, 1e-6, 1e-5, 1e-4]; },\n"
        "    { key = \"packing.grains\"; values = [200, 600]; } ); };\n\n"
        "Every key may be left out; --set key=value overrides it. # begins a comment.\n"
        "Lengths in mean grain diameters d, pressures in E*, times in d/sqrt(E* / rho).\n\n"
        "A study sweeps every key that is given a list of values or a range in the place of its value, and those of\n"
        "study.sweep; it makes every combination:\n\n"
        "  packing = { pressure = { from = 1e-7; to = 1e-4; count = 4; spacing = \"log\"; };\n"
        "    friction = { from = 0; to = 0.5; step = 0.1; }; sizes = [\"uniform\", \"bidisperse\"]; };\n"
        "  study = { sweep = ( { key = \"packing.grains\"; from = 200; to = 600; count = 3; },\n"
        "    { key = \"packing.history\"; values = ( [], [1e-3], [1e-3, 1e-5] ); } ); };\n\n"
        "A range has equal steps, or equal ratios (spacing = \"log\", which rounds integers), and both of its ends.\n"
        "Keys that are lists themselves are swept by study.sweep. What makes another sample may be swept: packing and\n"
        "network, without packing.file, packing.content and packing.diameter_file, and signal.source. Values of\n"
        "packing.seed must differ by study.samples. The packing that `sonopack pack' makes has the first value of a\n"
        "list or range in the place of a value. --set takes both, too.\n\n"
        "The group column is that of `sonopack column' alone, in cm, g and s; what is made of the other groups does "
        "not\n"
        "depend on it, nor the column on them.\n";
    writer w = {0};
    sp_scene s = sp_scene_default();
    put(&w, "%s", head);
    for (int k = 0; k < SP_FIELDS; k++) {
        const sp_field *f = &sp_fields[k];
        char right[200];
        put(&w, "\n%s = ", f->key);
        put_value(&w, &s, f);
        put(&w, "\n    %s\n", f->meaning);
        if (f->type != SP_FIELD_SWEEP)
            put(&w, "    must be %s\n", sp_field_right(f, right, sizeof right));
    }
    sp_scene_free(&s);
    return finish(&w);
}
