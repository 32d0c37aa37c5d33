/* The libraries beside the core through their headers alone: a scene, its packing in a file and back, its modes, and
 * the tapped column at rest. */
#include <sonopack/sonopack.h>
#include <sonopack/study/modes_file.h>
#include <sonopack/study/store.h>
#include <sonopack/tapped/tapped.h>
#include <stdio.h>
#include <string.h>

static sp_status modes_in_a_file(const sp_packing *p, const char *file, sp_error *err) {
    const sp_modes_made how = {.network = sp_network_options_default()};
    const sp_modes_options o = sp_modes_options_default();
    sp_network net = sp_network_none();
    sp_modes m = sp_modes_none();
    sp_modes_file f = sp_modes_file_none();
    sp_status status = sp_network_make(p, &how.network, &net, err);
    if (status == SP_OK)
        status = sp_modes_dense(&net, &o, &m, err);
    if (status == SP_OK)
        status = sp_modes_save(&m, p, &net, &how, file, err);
    if (status == SP_OK)
        status = sp_modes_file_read(file, p, &f, err);
    if (status == SP_OK)
        status = sp_modes_file_vectors(file, &f, f.modes.n_rattler, 1, m.vectors, err);
    sp_modes_file_free(&f);
    sp_modes_free(&m);
    sp_network_free(&net);
    return status;
}

static sp_status packing_in_a_file(const char *folder, sp_error *err) {
    static const char text[] = "packing: { kind = \"triangular\"; width = 6.0; grains = 48; pressure = 1e-4; };";
    char file[1000], modes[1000];
    snprintf(file, sizeof file, "%s/packing.h5", folder);
    snprintf(modes, sizeof modes, "%s/modes.h5", folder);

    sp_scene scene = sp_scene_default();
    sp_packing made = sp_packing_none(), read = sp_packing_none();
    sp_status status = sp_scene_parse(text, "text", 0, NULL, &scene, err);
    if (status == SP_OK)
        status = sp_packing_make(&scene.pack, NULL, NULL, &made, err);
    if (status == SP_OK)
        status = sp_packing_save(&made, file, err);
    if (status == SP_OK)
        status = sp_packing_read(file, &read, err);
    if (status == SP_OK)
        status = modes_in_a_file(&read, modes, err);
    if (status == SP_OK)
        printf("%d grains\n", (int)read.n);
    sp_packing_free(&read);
    sp_packing_free(&made);
    sp_scene_free(&scene);
    return status;
}

int main(int argc, char **argv) {
    sp_error err = {0};
    sp_tapped_spec column = sp_tapped_spec_default();
    sp_status status = sp_tapped_check(&column, &err);
    if (status == SP_OK)
        status = packing_in_a_file(argc > 1 ? argv[1] : ".", &err);
    if (status != SP_OK)
        fprintf(stderr, "%s: %s\n", sp_status_name(status), err.text);
    return status == SP_OK && strcmp(sp_version(), SONOPACK_VERSION) == 0 ? 0 : 1;
}
