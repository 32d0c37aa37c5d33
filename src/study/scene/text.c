/* Writes a scene as text. */
#include "base/text.h"
#include "base/base.h"
#include "scene/field.h"

#include <stdio.h>
#include <string.h>

char *sp_field_text_end(sp_text *t) {
    sp_text_add(t, "%s", "");
    if (!t->failed)
        return t->data;
    sp_text_free(t);
    return NULL;
}

static void put_list(sp_text *t, const sp_field *f, unsigned bits) {
    const char *comma = "";
    sp_text_add(t, "[");
    for (const sp_word *word = f->words; word->word; word++) {
        if (bits == 0 ? word->value == 0 : (bits & word->value) != 0) {
            sp_text_add(t, "%s\"%s\"", comma, word->word);
            comma = ", ";
        }
    }
    sp_text_add(t, "]");
}

static void put_reals(sp_text *t, const double *values, int32_t count) {
    char value[32];
    sp_text_add(t, "(");
    for (int32_t k = 0; k < count; k++)
        sp_text_add(t, "%s%s", k == 0 ? "" : k % 8 ? ", " : ",\n    ", sp_number_text(values[k], value));
    sp_text_add(t, ")");
}

/* Writes value k of a sweep in the syntax of a scene. */
static void put_swept(sp_text *t, const sp_sweep *sweep, int k) {
    const sp_field *f = sp_field_find(sweep->key);
    const char *quote = f && f->type == SP_FIELD_WORD ? "\"" : "";
    char value[64];
    if (sweep->begin)
        put_reals(t, sweep->values + sweep->begin[k], sweep->begin[k + 1] - sweep->begin[k]);
    else
        sp_text_add(t, "%s%s%s", quote, sp_sweep_text(sweep, k, value, sizeof value), quote);
}

static void put_sweeps(sp_text *t, const sp_scene *s) {
    sp_text_add(t, "(");
    for (int k = 0; k < s->sweeps; k++) {
        sp_text_add(t, "%s\n    { key = \"%s\"; values = (", k > 0 ? "," : "", s->sweep[k].key);
        for (int i = 0; i < s->sweep[k].count; i++) {
            sp_text_add(t, i > 0 ? ", " : "");
            put_swept(t, &s->sweep[k], i);
        }
        sp_text_add(t, "); }");
    }
    sp_text_add(t, s->sweeps > 0 ? "\n  )" : ")");
}

/* Writes a file name as a string in the syntax of libconfig. */
static void put_name(sp_text *t, const char *name) {
    sp_text_add(t, "\"");
    for (; *name; name++)
        sp_text_add(t, "%s%c", *name == '"' || *name == '\\' ? "\\" : "", *name);
    sp_text_add(t, "\"");
}

void sp_field_put(sp_text *t, const sp_scene *s, const sp_field *f) {
    const char *place = (const char *)s + f->offset;
    const double *values;
    int32_t count;
    char value[32];
    unsigned bits;
    switch (f->type) {
    case SP_FIELD_REAL: sp_text_add(t, "%s", sp_number_text(sp_field_load(s, f).real, value)); break;
    case SP_FIELD_INT: sp_text_add(t, "%lld", (long long)sp_field_load(s, f).integer); break;
    case SP_FIELD_INT64: sp_text_add(t, "%lldL", (long long)sp_field_load(s, f).integer); break;
    case SP_FIELD_BOOL: sp_text_add(t, "%s", *(const bool *)place ? "true" : "false"); break;
    case SP_FIELD_WORD:
        memcpy(&bits, place, sizeof bits);
        for (const sp_word *word = f->words; word->word; word++)
            if (word->value == bits)
                sp_text_add(t, "\"%s\"", word->word);
        break;
    case SP_FIELD_LIST:
        memcpy(&bits, place, sizeof bits);
        put_list(t, f, bits);
        break;
    case SP_FIELD_SWEEP: put_sweeps(t, s); break;
    case SP_FIELD_REALS:
        values = sp_field_list(s, f, &count);
        put_reals(t, values, count);
        break;
    case SP_FIELD_PATH: put_name(t, place); break;
    case SP_FIELD_FILE: sp_text_add(t, "\"\""); break; /* its numbers are in packing.diameters */
    }
}

/* Of packing.grains and packing.height only the one that counts is written, so that equal packings have equal texts.
 * Scenes name cell, stress, strain rate, path, gravity, law, types, shape and fraction where they are not those of a
 * piston without weight, and loading history where there is one. The dimension is not written where packing.kind is
 * swept and each kind has its own. */
static bool left_out(const sp_scene *s, const sp_field *f, const char *group) {
    if (strcmp(f->key, "packing.dimension") == 0 && !group && !s->dimension_given)
        for (int k = 0; k < s->sweeps; k++)
            if (strcmp(s->sweep[k].key, "packing.kind") == 0)
                return true;
    if ((strcmp(f->key, "packing.cell") == 0 && s->pack.cell == SP_CELL_PISTON) ||
        (strcmp(f->key, "packing.gravity") == 0 && s->pack.gravity == 0) ||
        (strcmp(f->key, "packing.tangential") == 0 && s->pack.tangential == SP_TANGENTIAL_CONSTANT) ||
        (strcmp(f->key, "network.tangential") == 0 && s->network.tangential == SP_SPRINGS_CONSTANT) ||
        (strcmp(f->key, "packing.fraction") == 0 && s->pack.fraction == 0) ||
        (strcmp(f->key, "packing.law.exponent") == 0 && s->pack.law_exponent == 1.5) ||
        (strcmp(f->key, "packing.strain_rate") == 0 && s->pack.strain_rate == 0) ||
        (strcmp(f->key, "packing.stress") == 0 && s->pack.stress_count == 0) ||
        (strcmp(f->key, "packing.stages") == 0 && s->pack.stages == 0) ||
        (strcmp(f->key, "packing.shape") == 0 && s->pack.shape == SP_SHAPE_SPHERE) ||
        (strncmp(f->key, "packing.types.", 14) == 0 && s->pack.types.fractions == 0) ||
        (strncmp(f->key, "packing.path.", 13) == 0 && s->pack.strain_count == 0))
        return true;
    return (strcmp(f->key, "packing.height") == 0 && !(s->height > 0)) ||
           (strcmp(f->key, "packing.grains") == 0 && s->height > 0);
}

/* Groups that a stored scene does not need. */
static bool is_apart(const sp_scene *s, const char *group) {
    return strcmp(group, "column") == 0 || (strcmp(group, "material") == 0 && !(s->material.young > 0));
}

static bool same_inner(const sp_field *a, const sp_field *b, size_t length) {
    return strncmp(a->key, b->key, length) == 0 && b->key[length] == '.';
}

/* A key, or one of a group within the group, whose keys follow each other and are all there or all left out. */
static void put_key(sp_text *t, const sp_scene *s, const sp_field *f) {
    const char *name = sp_field_name(f), *inner = strchr(name, '.');
    const size_t length = inner ? (size_t)(inner - f->key) : 0;
    const bool opens = inner && !(f > sp_fields && same_inner(f, f - 1, length));
    const bool closes = inner && !(f + 1 < sp_fields + SP_FIELDS && same_inner(f, f + 1, length));
    if (opens)
        sp_text_add(t, "  %.*s = {", (int)(inner - name), name);
    sp_text_add(t, inner ? " %s = " : "  %s = ", inner ? inner + 1 : name);
    sp_field_put(t, s, f);
    sp_text_add(t, closes ? "; };\n" : inner ? ";" : ";\n");
}

char *sp_scene_text(const sp_scene *s, const char *group) {
    sp_text t = {0};
    for (int g = 0; g < SP_GROUPS; g++) {
        if (group ? strcmp(group, sp_groups[g]) != 0 : is_apart(s, sp_groups[g]))
            continue;
        sp_text_add(&t, "%s = {\n", sp_groups[g]);
        for (const sp_field *f = sp_fields; f < sp_fields + SP_FIELDS; f++) {
            if (!sp_field_in_group(f, sp_groups[g]) || left_out(s, f, group))
                continue;
            put_key(&t, s, f);
        }
        sp_text_add(&t, "};\n");
    }
    return sp_field_text_end(&t);
}
