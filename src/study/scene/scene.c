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
                  .column = sp_tapped_spec_default()};
    s.signal.until = 0; /* as far as each packing needs: sp_signal_window() */
    return s;
}

void sp_scene_free_sweeps(sp_scene *s) {
    for (int k = 0; k < SP_SWEEPS_MAX; k++)
        sp_sweep_free(&s->sweep[k]);
    s->sweeps = 0;
}

void sp_scene_take_diameters(sp_scene *s, double *diameters, int32_t count) {
    sp_free(s->diameters);
    s->diameters = diameters;
    s->pack.diameters = diameters;
    s->pack.diameter_count = count;
}

void sp_scene_take_history(sp_scene *s, double *history, int32_t count) {
    sp_free(s->history);
    s->history = history;
    s->pack.history = history;
    s->pack.history_count = count;
}

void sp_scene_take_masses(sp_scene *s, double *masses, int32_t count) {
    sp_free(s->masses);
    s->masses = masses;
    s->column.mass = masses;
    s->column.masses = count;
}

void sp_scene_take_radii(sp_scene *s, double *radii, int32_t count) {
    sp_free(s->radii);
    s->radii = radii;
    s->column.radius = radii;
    s->column.radii = count;
}

void sp_scene_free(sp_scene *s) {
    if (s->history)
        sp_scene_take_history(s, NULL, 0);
    if (s->masses)
        sp_scene_take_masses(s, NULL, 0);
    if (s->radii)
        sp_scene_take_radii(s, NULL, 0);
    sp_scene_free_sweeps(s);
    if (s->diameters)
        sp_scene_take_diameters(s, NULL, 0);
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
