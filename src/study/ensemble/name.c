/* Names of samples, and hashes of what they have in common. */
#include "base/base.h"
#include "ensemble/sample.h"

#include <sonopack/version.h>
#include <stdio.h>
#include <string.h>

static unsigned __int128 hash_of(const void *data, size_t size) {
    /* offset basis and prime of FNV-1a, 128 bits (Fowler, Noll, Vo, Eastlake) */
    unsigned __int128 hash = (unsigned __int128)0x6c62272e07bb0142u << 64 | 0x62b821756295c58du;
    const unsigned __int128 prime = (unsigned __int128)1 << 88 | 0x13bu;
    const unsigned char *byte = data;
    for (size_t k = 0; k < size; k++)
        hash = (hash ^ byte[k]) * prime;
    return hash;
}

void sp_hash128(const void *data, size_t size, char text[SP_NAME_MAX]) {
    const unsigned __int128 hash = hash_of(data, size);
    snprintf(text, SP_NAME_MAX, "%016llx%016llx", (unsigned long long)(hash >> 64), (unsigned long long)hash);
}

void sp_sample_name(const sp_scene *scene, char name[SP_NAME_MAX]) {
    name[0] = '\0';
    sp_scene nameless = *scene;
    nameless.from[0] = '\0'; /* packing.content identifies the file, wherever it is */
    if (sp_scene_resolve(&nameless, NULL) != SP_OK)
        return;
    char *packing = sp_scene_text(&nameless, "packing"), *network = sp_scene_text(scene, "network");
    if (packing && network) {
        char tail[64];
        snprintf(tail, sizeof tail, "signal.source = %d\nalgorithm = %d\n", (int)scene->signal.source,
                 SONOPACK_ALGORITHM);
        size_t size = strlen(packing) + strlen(network) + strlen(tail) + 1;
        char *text = sp_alloc(size, 1);
        if (text) {
            snprintf(text, size, "%s%s%s", packing, network, tail);
            sp_hash128(text, strlen(text), name);
        }
        sp_free(text);
    }
    sp_free(packing);
    sp_free(network);
}

uint64_t sp_signal_keys(const sp_scene *scene) {
    char *text = sp_scene_text(scene, "signal");
    const uint64_t hash = text ? (uint64_t)hash_of(text, strlen(text)) : 0;
    sp_free(text);
    return hash;
}

uint64_t sp_sample_material(const sp_scene *scene) {
    const sp_pack_spec plain = sp_pack_spec_default();
    sp_scene rest = *scene;
    rest.from[0] = '\0';
    rest.height = 0;
    rest.pack.grains = plain.grains;
    rest.pack.pressure = plain.pressure;
    rest.pack.fraction = plain.fraction;
    rest.pack.stages = plain.stages;
    rest.pack.width = plain.width;
    rest.pack.friction = plain.friction;
    rest.pack.seed = plain.seed;
    rest.pack.content = plain.content;
    rest.pack.max_steps = plain.max_steps;
    char *packing = sp_scene_text(&rest, "packing"), *network = sp_scene_text(&rest, "network");
    uint64_t hash = 0;
    if (packing && network) {
        const uint64_t part[3] = {(uint64_t)hash_of(packing, strlen(packing)),
                                  (uint64_t)hash_of(network, strlen(network)), (uint64_t)scene->signal.source};
        hash = (uint64_t)hash_of(part, sizeof part);
    }
    sp_free(packing);
    sp_free(network);
    return hash;
}
