/* HDF5 files: packings, samples of a store, vectors of modes. The input is a list of edits of a file that the program
 * itself made: damage by bytes alone would end at HDF5's checksums. Byte 0 chooses the file; then each edit has eight
 * bytes: what to do, to which object, and four of operands (edits.c). */
#include "edits.h"
#include "guided.h"

#include "store/folder.h"
#include <math.h>
#include <sonopack/study/modes_file.h>
#include <sonopack/study/scene.h>
#include <sonopack/study/store.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ---- the files -------------------------------------------------------------------------------------------------- */

enum { PACKINGS = 3, SAMPLE = PACKINGS, MODES, KINDS };
static edited_file file[KINDS];
static sp_packing whole; /* to which the modes belong */
static char name[SP_NAME_MAX];

static const char *const scenes[PACKINGS] = {
    "packing = { kind = \"chain\"; grains = 12; friction = 0; };",
    "packing = { kind = \"piston\"; grains = 12; width = 5; friction = 0.3; pressure = 1e-3; };",
    "packing = { kind = \"piston\"; cell = \"periodic\"; grains = 36; friction = 0; };"};

static sp_packing make(const char *text) {
    sp_error err = guided_error();
    sp_scene scene;
    sp_packing p;
    must(guided_good(sp_scene_parse(text, "scene", 0, NULL, &scene, &err), &err));
    must(guided_good(sp_packing_make(&scene.pack, NULL, NULL, &p, &err), &err));
    sp_scene_free(&scene);
    return p;
}

static bool look(const sp_study_progress *progress, void *user) { return progress != NULL && user == NULL; }

/* A sample with every part, in a store of its own. */
static void make_sample(const char *folder) {
    static const char text[] =
        "packing = { kind = \"piston\"; grains = 12; width = 5; friction = 0.3; pressure = 1e-3; };"
        "signal = { points = 50; planes = [1, 2]; };"
        "study = { want = [\"ctof\", \"statics\", \"moduli\", \"signal\", \"probes\", \"planes\", "
        "\"spectrum\"]; };";
    sp_error err = guided_error();
    sp_scene study, scene;
    sp_store *store;
    const sp_study_options o = {.jobs = 1, .shard = 1, .shards = 1};
    char path[4096];
    must(guided_good(sp_scene_parse(text, "scene", 0, NULL, &study, &err), &err));
    must(guided_good(sp_study_scene(&study, 0, &scene, &err), &err));
    must(guided_good(sp_store_open(folder, true, &store, &err), &err));
    const sp_study_sink sink = sp_store_sink(store);
    must(guided_good(sp_study_run(&study, &o, &sink, look, NULL, NULL, &err), &err));
    sp_store_close(store);
    sp_sample_name(&scene, name);
    snprintf(path, sizeof path, "%s/%s.h5", folder, name);
    file[SAMPLE] = edited_read(path);
    sp_scene_free(&study);
}

static void make_modes(const char *path) {
    sp_error err = guided_error();
    sp_network net;
    sp_modes m;
    const sp_modes_made made = {.network = sp_network_options_default(), .source = SP_SOURCE_VELOCITY};
    const sp_modes_options o = {.vectors = true, .source = made.source};
    const sp_modes_range all = sp_modes_range_all();
    whole = make(scenes[1]);
    must(guided_good(sp_network_make(&whole, &made.network, &net, &err), &err));
    must(guided_good(sp_modes_make(&net, &o, &all, &m, &err), &err));
    must(guided_good(sp_modes_save(&m, &whole, &net, &made, path, &err), &err));
    file[MODES] = edited_read(path);
    sp_modes_free(&m);
    sp_network_free(&net);
}

int LLVMFuzzerInitialize(int *count, char ***words) {
    const char *folder = guided_folder();
    sp_error err = guided_error();
    must(count && words);
    for (int k = 0; k < PACKINGS; k++) {
        sp_packing p = make(scenes[k]);
        const char *path = guided_output(0);
        must(guided_good(sp_packing_save(&p, path, &err), &err));
        file[k] = edited_read(path);
        sp_packing_free(&p);
    }
    make_modes(guided_output(0));
    make_sample(folder);
    return 0;
}

/* ---- the readers ------------------------------------------------------------------------------------------------ */

static void try_packing(const char *path) {
    sp_error err = guided_error();
    sp_packing p, again;
    if (!guided_good(sp_packing_read(path, &p, &err), &err))
        return;
    must(guided_good(sp_packing_check(&p, &err), &err));
    const char *out = guided_output(1);
    must(guided_good(sp_packing_save(&p, out, &err), &err));
    must(guided_good(sp_packing_read(out, &again, &err), &err));
    must(sp_packing_hash(&p) == sp_packing_hash(&again));
    sp_packing_free(&again);
    sp_packing_free(&p);
}

static void check_sample(const sp_sample *s) {
    must(s->dim >= 1 && s->dim <= 3 && s->grains >= 1 && s->width > 0 && isfinite(s->width));
    must(s->pressure > 0 && isfinite(s->pressure) && s->friction >= 0 && isfinite(s->friction));
    must(s->planes >= 0 && s->planes <= SP_PLANES_MAX && strlen(s->name) < SP_NAME_MAX);
}

static void try_sample(const char *path) {
    sp_error err = guided_error();
    for (int with_arrays = 0; with_arrays < 2; with_arrays++) {
        sp_h5 h;
        sp_record r;
        if (sp_h5_open(&h, path, &err) == SP_OK)
            sp_record_get(&h, with_arrays, &r);
        if (!guided_good(sp_h5_close(&h), &err))
            return;
        check_sample(&r.sample);
        must(r.arrays.signal.n >= 0 && r.arrays.modes >= 0);
        sp_record_free(&r);
    }
    try_packing(path);
}

static void try_modes(const char *path) {
    sp_error err = guided_error();
    sp_modes_file f;
    if (!guided_good(sp_modes_file_read(path, &whole, &f, &err), &err))
        return;
    const int64_t first = f.modes.n_rattler, rows = f.modes.n - first;
    must(rows >= 0 && f.n >= 1 && f.n <= whole.n && f.modes.dofs == (int64_t)f.n * f.dof);
    double *e = malloc((size_t)(rows * f.modes.dofs + 1) * sizeof *e);
    must(e != NULL);
    guided_good(sp_modes_file_vectors(path, &f, first, rows, e, &err), &err);
    free(e);
    sp_modes_file_free(&f);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    if (size == 0)
        return 0;
    const int kind = data[0] % KINDS;
    size_t bytes = 0;
    uint8_t *image = edited_apply(&file[kind], data + 1, size - 1, &bytes);
    const char *path = guided_file(0, image, bytes);
    free(image);
    if (kind < PACKINGS)
        try_packing(path);
    else if (kind == SAMPLE)
        try_sample(path);
    else
        try_modes(path);
    return 0;
}
