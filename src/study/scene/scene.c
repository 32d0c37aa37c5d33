/* Scenes as values: defaults, memory, and single keys. */
#include "scene/field.h"

#include "base/base.h"

#include <math.h>
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

/* The scene's pointer to a list of this field, if it owns one; NULL for fields that are no such list. */
static double **owner_of(sp_scene *s, const sp_field *f) {
    const struct {
        const char *key;
        double **owner;
    } owners[] = {{"packing.diameters", &s->diameters},
                  {"packing.history", &s->history},
                  {"packing.stress", &s->stress},
                  {"column.mass", &s->masses},
                  {"column.radius", &s->radii}};
    for (size_t k = 0; k < sizeof owners / sizeof *owners; k++)
        if (strcmp(f->key, owners[k].key) == 0)
            return owners[k].owner;
    return NULL;
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
