/* Writes the data file of LAMMPS, the gas and the piston, and saves it with the input script. */
#include "base/base.h"
#include "base/file.h"
#include "base/text.h"
#include "foreign/engine.h"
#include "packing/prepare.h"

#include <sonopack/version.h>

/* ---- gas -------------------------------------------------------------------------------------------------------- */

static void add_row(sp_text *t, int32_t id, int type, double diameter, double density, const double *x) {
    const double row[] = {diameter, density, x[0], x[1], x[2]};
    sp_text_add(t, "%d %d", id, type);
    for (int k = 0; k < 5; k++) {
        sp_text_add(t, " ");
        sp_text_number(t, row[k]);
    }
    sp_text_add(t, "\n");
}

static void add_edge(sp_text *t, char axis, double low, double high) {
    sp_text_number(t, low);
    sp_text_add(t, " ");
    sp_text_number(t, high);
    sp_text_add(t, " %clo %chi\n", axis, axis);
}

/* The grains, and the atom that is the piston, of the smallest diameter so that it widens no list. */
static void add_gas(sp_text *t, const sp_engine_deck *d, const double *r, const double *x) {
    const double pi = 3.14159265358979323846, small = d->smallest;
    double at[3] = {0.5 * d->period[0], d->dim == 3 ? 0.5 * d->period[1] : 0, 0};
    at[d->dim - 1] = d->height;
    sp_text_add(t, "gas of grains, and the piston: written by sonopack %s\n\n%d atoms\n2 atom types\n\n", sp_version(),
                d->grains + 1);
    for (int a = 0; a < d->dim - 1; a++)
        add_edge(t, (char)('x' + a), 0, d->period[a]);
    add_edge(t, (char)('x' + d->dim - 1), -1, d->height + 1);
    if (d->dim == 2)
        add_edge(t, 'z', -0.5, 0.5);
    sp_text_add(t, "\nAtoms # sphere\n\n");
    for (int32_t i = 0; i < d->grains; i++)
        add_row(t, i + 1, 1, 2 * r[i], 1, x + 3 * (size_t)i);
    add_row(t, d->grains + 1, 2, small, d->piston_mass / (pi / 6 * small * small * small), at);
}

static sp_status save(const char *folder, sp_engine_file file, const sp_text *t, sp_error *err) {
    char path[SP_PATH_MAX];
    sp_status status = t->failed ? sp_fail_memory(err, t->size) : sp_engine_path(folder, file, path, err);
    return status == SP_OK ? sp_file_write(path, t->data, t->size, err) : status;
}

sp_status sp_engine_write(const sp_pack_spec *given, const char *folder, sp_error *err) {
    sp_status status = sp_engine_check(given, err);
    if (status != SP_OK)
        return status;
    const sp_pack_spec s = sp_pack_spec_resolve(given);
    const size_t n = (size_t)s.grains;
    double *r = sp_alloc(n, sizeof *r), *x = sp_alloc(3 * n, sizeof *x), height = 0;
    sp_text gas = {0}, deck = {0};
    sp_locale locale = sp_locale_enter();
    status = r && x ? SP_OK : sp_fail_memory(err, 32 * n);
    if (status == SP_OK) {
        sp_radii_draw(&s, r);
        status = sp_gas_make(&s, r, x, &height, err);
    }
    if (status == SP_OK) {
        const sp_engine_deck d = sp_engine_plan(&s, height);
        add_gas(&gas, &d, r, x);
        sp_engine_add_deck(&deck, &d);
        status = save(folder, SP_ENGINE_GAS, &gas, err);
    }
    if (status == SP_OK)
        status = save(folder, SP_ENGINE_INPUT, &deck, err);
    sp_locale_leave(&locale);
    sp_text_free(&gas);
    sp_text_free(&deck);
    sp_free(x);
    sp_free(r);
    return status;
}
