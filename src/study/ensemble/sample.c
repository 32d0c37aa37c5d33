/* Makes one sample: its packing, and the results that a scene asks for. */
#include "ensemble/sample.h"

#include "base/base.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

sp_sample_arrays sp_sample_arrays_none(void) { return (sp_sample_arrays){.signal = sp_signal_none()}; }

void sp_sample_arrays_free(sp_sample_arrays *a) {
    sp_signal_free(&a->signal);
    sp_free(a->omega);
    *a = sp_sample_arrays_none();
}

sp_status sp_sample_describe(const sp_scene *scene, sp_sample *sample, sp_error *err) {
    sp_sample_name(scene, sample->name);
    if (sample->name[0] == '\0')
        return sp_fail_memory(err, 4096);
    sample->kind = (int32_t)scene->pack.kind;
    sample->dim = scene->pack.dim;
    sample->grains = scene->pack.grains;
    sample->width = scene->pack.width;
    const int32_t stages = sp_pack_stages(&scene->pack);
    sample->pressure = sp_pack_stage_pressure(&scene->pack, stages - 1);
    sample->fraction = scene->pack.fraction;
    sample->stage = scene->pack.strain_count > 0 || scene->pack.stages > 0 ? stages : 0;
    sample->strain = sp_pack_stage_strain(&scene->pack, stages - 1);
    sample->mean_stress = 0;
    sample->friction = scene->pack.friction;
    sample->seed = scene->pack.seed;
    sample->material = sp_sample_material(scene);
    if (sample->material == 0)
        return sp_fail_memory(err, 4096);
    sample->failed = false;
    sample->reason[0] = '\0';
    return SP_OK;
}

void sp_sample_measure(const sp_packing *p, sp_sample *sample) {
    if (sample->fraction > 0)
        sample->pressure = p->pressure;
    if (sample->fraction > 0 || sample->stage > 0)
        sample->mean_stress = p->pressure;
}

/* Whether a failure is one of the sample itself, so that it would fail again. */
static bool of_the_sample(sp_status status) {
    return status == SP_EFAILED || status == SP_EREFUSED || status == SP_EINVAL || status == SP_EFORMAT;
}

sp_status sp_sample_make_with(const sp_scene *given, unsigned want, const sp_pack_hooks *hooks, sp_packing *packing,
                              sp_sample *sample, sp_sample_arrays *arrays, sp_error *err) {
    sp_error reason = {0};
    sp_scene resolved = *given, *scene = &resolved;
    sp_status status = sp_scene_resolve(scene, err);
    if (status == SP_OK)
        status = sp_sample_describe(scene, sample, err);
    if (status != SP_OK)
        return status;
    want = sp_want_parts(want);
    if (want & SP_WANT_PROBES) /* their ratios need the moduli */
        want |= SP_WANT_MODULI;
    if (want & SP_WANT_MODULI) /* they need Phi_3* */
        want |= SP_WANT_STATICS;
    if (packing->n == 0) {
        sample->have = 0;
        sample->height = NAN;
        status = sp_packing_make_with(&scene->pack, hooks, packing, &reason);
        packing->material = scene->material;
    }
    if (status == SP_OK && !packing->scene && !(packing->scene = sp_scene_text(scene, NULL)))
        status = sp_fail_memory(&reason, 4096);
    if (status == SP_OK) {
        sample->height = sp_packing_height(packing);
        sp_sample_measure(packing, sample);
        sample->have = sp_sample_parts(scene, sample);
        unsigned missing = want & ~sample->have;
        if (!arrays)
            missing &= ~(unsigned)(SP_WANT_SIGNAL | SP_WANT_SPECTRUM);
        status = sp_parts_make(scene, missing, packing, sample, arrays, &reason);
    }
    if (of_the_sample(status)) {
        sample->failed = true;
        snprintf(sample->reason, sizeof sample->reason, "%.255s", reason.text);
    }
    if (status != SP_OK && err)
        *err = reason;
    return status;
}

sp_status sp_sample_make(const sp_scene *scene, unsigned want, sp_packing *packing, sp_sample *sample,
                         sp_sample_arrays *arrays, sp_error *err) {
    const sp_pack_hooks hooks = {0};
    return sp_sample_make_with(scene, want, &hooks, packing, sample, arrays, err);
}

/* ---- the samples of a study ---------------------------------------------------------------------------------------
 */

/* Combinations of the swept values; 0 where that overflows or a sweep is empty. */
static int64_t combinations(const sp_scene *scene) {
    int64_t count = 1;
    for (int s = 0; s < scene->sweeps; s++)
        if (__builtin_mul_overflow(count, (int64_t)scene->sweep[s].count, &count) || count < 1)
            return 0;
    return count;
}

int64_t sp_study_count(const sp_scene *scene) {
    int64_t count = 0;
    if (scene->samples < 1 || __builtin_mul_overflow(combinations(scene), (int64_t)scene->samples, &count))
        return 0;
    return count;
}

sp_status sp_study_scene(const sp_scene *study, int64_t k, sp_scene *out, sp_error *err) {
    int64_t count = sp_study_count(study);
    if (k < 0 || k >= count)
        return sp_fail(err, SP_EINVAL, "sample %lld of a study with %lld samples", (long long)k, (long long)count);
    sp_scene scene = *study;
    scene.sweeps = 0;
    scene.samples = 1;
    memset(scene.sweep, 0, sizeof scene.sweep);
    memset(scene.owned, 0, sizeof scene.owned); /* the study's */
    int64_t left = k % combinations(study);     /* the last sweep varies fastest */
    for (int s = study->sweeps - 1; s >= 0; s--) {
        const sp_sweep *sweep = &study->sweep[s];
        sp_status status = sp_scene_set_swept(&scene, sweep, (int)(left % sweep->count), err);
        if (status != SP_OK)
            return status;
        left /= sweep->count;
    }
    scene.pack.seed += (uint64_t)(k / combinations(study));
    sp_status status = sp_scene_resolve(&scene, err);
    if (status == SP_OK)
        status = sp_pack_spec_check(&scene.pack, err);
    if (status != SP_OK)
        return status;
    *out = scene;
    return SP_OK;
}

sp_status sp_study_sample(const sp_scene *study, int64_t k, sp_scene *scene, char name[SP_NAME_MAX], sp_error *err) {
    sp_status status = sp_study_scene(study, k, scene, err);
    if (status == SP_OK)
        sp_sample_name(scene, name);
    return status == SP_OK && name[0] == '\0' ? sp_fail_memory(err, 4096) : status;
}
