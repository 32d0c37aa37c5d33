/* Scenes as values: defaults, memory, and single keys. */
#include "scene/field.h"

#include "base/base.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

sp_scene sp_scene_default(void) {
    sp_scene s = {.pack = sp_pack_spec_default(),
                  .network = sp_network_options_default(),
                  .signal = sp_signal_options_default(),
                  .samples = 1,
                  .want = SP_WANT_CTOF,
                  .tapped = sp_tapped_spec_default()};
    s.signal.until = 0; /* until the first front has passed: sp_signal_window() */
    return s;
}

void sp_scene_free_sweeps(sp_scene *s) {
    for (int k = 0; k < SP_SWEEPS_MAX; k++)
        sp_sweep_free(&s->sweep[k]);
    s->sweeps = 0;
}

/* The scene's pointer to a list of this field; NULL for fields that are no such list. */
static double **owner_of(sp_scene *s, const sp_field *f) {
    int before = 0;
    for (const sp_field *g = sp_fields; g < f; g++)
        before += g->type == SP_FIELD_REALS;
    return f->type == SP_FIELD_REALS && !sp_field_is_planes(f) ? &s->owned[before] : NULL;
}

void sp_scene_own_list(sp_scene *s, const sp_field *f, double *values, int32_t count) {
    double **owner = owner_of(s, f);
    sp_free(*owner);
    *owner = values;
    sp_field_set_list(s, f, values, count);
}

void sp_scene_free(sp_scene *s) {
    for (const sp_field *f = sp_fields; f < sp_fields + SP_FIELDS; f++) {
        double **owner = owner_of(s, f);
        if (owner && *owner)
            sp_scene_own_list(s, f, NULL, 0);
    }
    sp_scene_free_sweeps(s);
}

sp_status sp_scene_check_sweeps(const sp_scene *s, sp_error *err) {
    for (int k = 0; k < s->sweeps; k++)
        if (s->sweep[k].overridden) {
            const char *key = s->sweep[k].key;
            const bool grains = strcmp(key, "packing.height") == 0 || strcmp(key, "packing.grains") == 0;
            sp_fail_key(err, SP_EINVAL, key,
                        ": the key is swept by study.sweep: set another key, or take it out of the sweep%s",
                        grains ? " (packing.grains and packing.height say the same)" : "");
            return sp_fail_prefix(err, "--set");
        }
    return SP_OK;
}

sp_status sp_scene_resolve(sp_scene *s, sp_error *err) {
    sp_status status = s->height > 0 ? sp_pack_spec_fill(&s->pack, s->height, &s->pack.grains, err) : SP_OK;
    if (status == SP_OK)
        s->height = 0;
    sp_pack_spec all = s->pack; /* so that the end of a path has one name */
    all.stages = 0;
    if (s->pack.stages > 0 && s->pack.stages == sp_pack_stages(&all))
        s->pack.stages = 0;
    return status;
}

sp_status sp_scene_set(sp_scene *s, const char *key, double value, sp_error *err) {
    const sp_field *f = sp_field_find(key);
    if (!f || !sp_field_is_number(f))
        return sp_fail_key(err, SP_EINVAL, key, ": must be a numeric key of a scene");
    sp_status status = sp_field_store(s, f, &(sp_number){.real = value}, err);
    if (status == SP_OK && strcmp(key, "packing.grains") == 0)
        s->height = 0;
    return status;
}

double sp_scene_get(const sp_scene *s, const char *key) {
    const sp_field *f = sp_field_find(key);
    return f && sp_field_is_number(f) ? sp_field_load(s, f).real : NAN;
}

/* ---- values of sweeps -------------------------------------------------------------------------------------------- */

void sp_sweep_free(sp_sweep *sweep) {
    sp_free(sweep->values);
    sp_free(sweep->begin);
    *sweep = (sp_sweep){0};
}

static sp_status store_list(sp_scene *s, const sp_field *f, const sp_sweep *sweep, int k, sp_error *err) {
    if (!sweep->begin)
        return sp_fail_key(err, SP_EINVAL, f->key, ": a sweep of it must be one of lists");
    const int32_t count = sweep->begin[k + 1] - sweep->begin[k];
    const double *list = count > 0 ? sweep->values + sweep->begin[k] : NULL;
    for (int32_t i = 0; i < count; i++) {
        sp_status status = sp_field_check(f, &(sp_number){.real = list[i]}, err);
        if (status != SP_OK)
            return status;
    }
    sp_field_set_list(s, f, list, count);
    return SP_OK;
}

static const sp_word *word_of(const sp_field *f, double code) {
    for (const sp_word *word = f->words; word->word; word++)
        if ((double)word->value == code)
            return word;
    return NULL;
}

sp_status sp_sweep_store(sp_scene *s, const sp_field *f, const sp_sweep *sweep, int k, sp_error *err) {
    if (f->type == SP_FIELD_REALS)
        return store_list(s, f, sweep, k, err);
    const double value = sweep->values[k];
    if (sp_field_is_number(f))
        return sp_field_store(s, f, &(sp_number){.real = value}, err);
    char *place = (char *)s + f->offset, right[200];
    const sp_word *word = f->type == SP_FIELD_WORD ? word_of(f, value) : NULL;
    if (word) {
        memcpy(place, &word->value, sizeof word->value);
        return SP_OK;
    }
    if (f->type == SP_FIELD_BOOL && (value == 0 || value == 1)) {
        *(bool *)place = value != 0;
        return SP_OK;
    }
    return sp_fail_key(err, SP_EINVAL, f->key, " = (value %d of its sweep): must be %s", k + 1,
                       sp_field_right(f, right, sizeof right));
}

/* Unless the scene gives the dimension, a chain has one and every other packing two. */
static void set_dimension(sp_scene *s) {
    if (s->dimension_given)
        return;
    if (s->pack.kind == SP_PACK_CHAIN)
        s->pack.dim = 1;
    else if (s->pack.dim == 1)
        s->pack.dim = sp_pack_spec_default().dim;
}

sp_status sp_scene_set_swept(sp_scene *s, const sp_sweep *sweep, int k, sp_error *err) {
    const sp_field *f = sp_field_find(sweep->key);
    const char *reason = f ? sp_field_not_swept(f) : "there is no such key";
    if (reason)
        return sp_fail_key(err, SP_EINVAL, "study.sweep", ": key \"%.60s\" cannot be swept: %s", sweep->key, reason);
    if (k < 0 || k >= sweep->count)
        return sp_fail_key(err, SP_EINVAL, "study.sweep", " of %s: value %d of %d", sweep->key, k + 1, sweep->count);
    sp_status status = sp_sweep_store(s, f, sweep, k, err);
    if (status == SP_OK && strcmp(f->key, "packing.grains") == 0)
        s->height = 0;
    if (status == SP_OK && strcmp(f->key, "packing.kind") == 0)
        set_dimension(s);
    return status;
}

/* Appends as much of the text as fits. */
static void append(char *buf, size_t size, const char *text) {
    const size_t used = strlen(buf);
    snprintf(buf + used, size - used, "%s", text);
}

static void list_text(const sp_sweep *sweep, int k, char *buf, size_t size) {
    char value[SP_NUMBER_TEXT];
    append(buf, size, "[");
    for (int32_t i = sweep->begin[k]; i < sweep->begin[k + 1]; i++) {
        const bool more = i + 1 < sweep->begin[k + 1];
        sp_number_text(sweep->values[i], value);
        if (strlen(buf) + strlen(value) + sizeof ", ...]" >= size) {
            append(buf, size, "...");
            break;
        }
        append(buf, size, value);
        append(buf, size, more ? ", " : "");
    }
    append(buf, size, "]");
}

const char *sp_sweep_text(const sp_sweep *sweep, int k, char *buf, size_t size) {
    const sp_field *f = sp_field_find(sweep->key);
    char value[SP_NUMBER_TEXT];
    if (size == 0)
        return "";
    buf[0] = '\0';
    if (!f || k < 0 || k >= sweep->count)
        return buf;
    const sp_word *word = f->type == SP_FIELD_WORD ? word_of(f, sweep->values[k]) : NULL;
    if (f->type == SP_FIELD_REALS && sweep->begin)
        list_text(sweep, k, buf, size);
    else if (f->type == SP_FIELD_BOOL)
        append(buf, size, sweep->values[k] != 0 ? "true" : "false");
    else if (word)
        append(buf, size, word->word);
    else if (f->type == SP_FIELD_INT || f->type == SP_FIELD_INT64)
        snprintf(buf, size, "%.0f", sweep->values[k]);
    else
        append(buf, size, sp_number_text(sweep->values[k], value));
    return buf;
}
