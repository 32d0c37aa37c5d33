/* Writes a packing as two tables. */
#include "base/base.h"
#include "packing/geometry.h"
#include "store/exchange.h"

#include <sonopack/study/store.h>
#include <string.h>
#include <unistd.h>

static const char *const axis[3] = {"x", "y", "z"};
static const char *const edge_key[3] = {"width", "depth", "height"};

static void add_numbers(sp_text *t, const double *value, int count) {
    for (int k = 0; k < count; k++) {
        sp_text_add(t, "\t");
        sp_text_number(t, value[k]);
    }
}

/* Nothing for a piston without gravity. */
static void add_cell(sp_text *t, const sp_packing *p) {
    static const char *const tilt[3] = {"xy", "xz", "yz"};
    if (p->cell != SP_CELL_PISTON || p->gravity != 0)
        sp_text_add(t, "# cell = %s\n", sp_cell_names[p->cell]);
    for (int k = 0; k < 3; k++)
        if (p->tilt[k] != 0)
            sp_text_add(t, "# %s = %.17g\n", tilt[k], p->tilt[k]);
    if (p->gravity != 0)
        sp_text_add(t, "# gravity = %.17g\n", p->gravity);
}

static void add_grains(sp_text *t, const sp_packing *p) {
    sp_text_add(t, "# lengths in mean grain diameters d, pressure in E*\n# dimension = %d\n", p->dim);
    for (int a = 0; a < p->dim; a++)
        sp_text_add(t, "# %s = %.17g\n", edge_key[a == p->dim - 1 ? 2 : a], p->box[a]);
    add_cell(t, p);
    sp_text_add(t, "# pressure = %.17g\n# friction = %.17g\n# poisson = %.17g\n# wall = %s\n", p->pressure, p->friction,
                p->poisson, sp_wall_names[p->wall]);
    char material[SP_MATERIAL_TEXT];
    if (p->material.young > 0)
        sp_text_add(t, "# material = %s\n", sp_material_text(&p->material, material));
    if (p->seed)
        sp_text_add(t, "# seed = %llu\n", (unsigned long long)p->seed);
    sp_text_add(t, "id");
    for (int a = 0; a < p->dim; a++)
        sp_text_add(t, "\t%s", axis[a]);
    sp_text_add(t, "\tradius%s\n", p->mass ? "\tmass\tinertia" : "");
    for (int32_t i = 0; i < p->n; i++) {
        sp_text_add(t, "%d", i);
        add_numbers(t, p->x + 3 * i, p->dim);
        add_numbers(t, &p->r[i], 1);
        if (p->mass) {
            add_numbers(t, &p->mass[i], 1);
            add_numbers(t, &p->inertia[i], 1);
        }
        sp_text_add(t, "\n");
    }
}

static void add_contacts(sp_text *t, const sp_packing *p) {
    static const char *const header[4] = {"", "i\tj\tnx\toverlap\tFn", "i\tj\tnx\tny\toverlap\tFn\tFt",
                                          "i\tj\tnx\tny\tnz\toverlap\tFn\tFtx\tFty\tFtz"};
    const bool stiffnesses = sp_packing_has_stiffnesses(p);
    sp_text_add(t, "# n from i to j; overlap in d, forces in E* d^2%s%s\n%s%s\n",
                stiffnesses ? ", stiffnesses in E* d (0: Hertz and Mindlin)" : "",
                p->dim == 1   ? ""
                : p->dim == 2 ? "; Ft: force on i along t = (-ny, nx)"
                              : "; Ft: force on i",
                header[p->dim], stiffnesses ? "\tkn\tkt" : "");
    for (int32_t c = 0; c < p->n_contacts; c++) {
        const sp_contact *k = &p->contacts[c];
        sp_text_add(t, "%d\t", k->i);
        if (k->j >= 0)
            sp_text_add(t, "%d", k->j);
        else
            sp_text_add(t, "%s", sp_side_names[-1 - k->j]);
        add_numbers(t, k->n, p->dim);
        add_numbers(t, &k->overlap, 1);
        add_numbers(t, &k->fn, 1);
        const double scalar = p->dim == 2 ? sp_tangent_scalar(k->n, k->ft) : 0.0;
        if (p->dim > 1)
            add_numbers(t, p->dim == 2 ? &scalar : k->ft, p->dim == 2 ? 1 : 3);
        if (stiffnesses) {
            add_numbers(t, &k->kn, 1);
            add_numbers(t, &k->kt, 1);
        }
        sp_text_add(t, "\n");
    }
}

sp_status sp_packing_save_tables(const sp_packing *p, const char *grains, const char *contacts, sp_error *err) {
    sp_text g = {0}, c = {0};
    sp_status status = sp_packing_check(p, err);
    if (status == SP_OK && strcmp(grains, contacts) == 0)
        status = sp_fail(err, SP_EINVAL, "%s: grains and contacts need a file each", grains);
    if (status != SP_OK)
        return status;
    sp_locale locale = sp_locale_enter();
    add_grains(&g, p);
    add_contacts(&c, p);
    sp_locale_leave(&locale);
    bool is_new = access(grains, F_OK) != 0;
    status =
        g.failed || c.failed ? sp_fail_memory(err, g.capacity + c.capacity) : sp_text_save(grains, g.data, g.size, err);
    if (status == SP_OK) {
        status = sp_text_save(contacts, c.data, c.size, err);
        if (status != SP_OK && is_new)
            unlink(grains); /* it is useless without the contacts */
    }
    sp_text_free(&g);
    sp_text_free(&c);
    return status;
}
