/* The scene of each sample of a study. */
#include "base/base.h"
#include "ensemble/sample.h"

#include <sonopack/study/study.h>
#include <string.h>

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
    scene.diameters = scene.history = scene.stress = scene.masses = scene.radii = NULL; /* owned by the study */
    int64_t left = k % combinations(study); /* the last sweep varies fastest */
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
