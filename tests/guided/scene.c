/* Scenes, with what --set adds: what is accepted is written as text, and that text read again gives the same text. */
#include "guided.h"

#include <sonopack/study/scene.h>
#include <sonopack/study/study.h>
#include <string.h>

int LLVMFuzzerInitialize(int *count, char ***words) { return count == NULL || words == NULL; }

static void check_again(const sp_scene *scene) {
    sp_error err = guided_error();
    sp_scene again;
    char *text = sp_scene_text(scene, NULL);
    must(text != NULL);
    must(guided_good(sp_scene_parse(text, "again", 0, NULL, &again, &err), &err));
    char *second = sp_scene_text(&again, NULL);
    must(second != NULL && strcmp(text, second) == 0);
    sp_free(text);
    sp_free(second);
    sp_scene_free(&again);
}

static void check_samples(const sp_scene *study) {
    sp_error err = guided_error();
    const int64_t count = sp_study_count(study);
    must(count >= 1);
    for (int64_t k = 0; k < count; k = k < 2 ? k + 1 : k < count - 1 ? count - 1 : count) {
        sp_scene sample;
        if (guided_good(sp_study_scene(study, k, &sample, &err), &err))
            must(guided_good(sp_pack_spec_check(&sample.pack, &err), &err));
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    guided_parts in = guided_split(data, size, 2);
    char *set[GUIDED_WORDS];
    sp_error err = guided_error();
    sp_scene scene;
    const int sets = in.count > 1 ? guided_words(in.part[1], set) : 0;
    if (guided_good(sp_scene_parse(in.part[0], "scene", sets, set, &scene, &err), &err)) {
        check_again(&scene);
        if (guided_good(sp_scene_check_sweeps(&scene, &err), &err))
            check_samples(&scene);
        sp_scene_free(&scene);
    }
    if (guided_good(sp_scene_read_tapped(guided_file(0, in.part[0], in.size[0]), sets, set, &scene, &err), &err)) {
        must(guided_good(sp_tapped_check(&scene.tapped, &err), &err));
        sp_scene_free(&scene);
    }
    guided_free(&in);
    return 0;
}
