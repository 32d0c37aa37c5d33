/* Packings as extended XYZ, which OVITO and ASE read. */
#include "base/base.h"
#include "foreign/export.h"
#include "packing/geometry.h"

static void add_key(sp_text *t, const char *key, double value) {
    sp_text_add(t, " %s=", key);
    sp_text_number(t, value);
}

static char is_periodic(const sp_packing *p, int axis) {
    return axis < p->dim && sp_packing_periodic(p, axis) ? 'T' : 'F';
}

/* The lattice has three vectors in any dimension; an axis that the packing has not is 1 long and not periodic. */
static void add_head(sp_text *t, const sp_export_data *e) {
    const sp_packing *p = e->packing;
    sp_text_add(t, "%d\nLattice=\"", p->n);
    for (int a = 0; a < 9; a++) {
        if (a > 0)
            sp_text_add(t, " ");
        if (a % 4 == 0)
            sp_text_number(t, p->box[a / 4]);
        else if (a / 3 > a % 3) /* rows of lattice vectors: xy, xz, yz are entries 3, 6, 7 */
            sp_text_number(t, p->tilt[a == 3 ? 0 : a - 5]);
        else
            sp_text_add(t, "0");
    }
    sp_text_add(t,
                "\" pbc=\"%c %c %c\" Properties=species:S:1:pos:R:3:id:I:1:radius:R:1:mass:R:1:forces:R:3:contacts:I:1:"
                "rattler:I:1%s%s dimension=%d",
                is_periodic(p, 0), is_periodic(p, 1), is_periodic(p, 2), e->vectors ? ":displacement:R:3" : "",
                e->vectors && e->vectors->rotation ? ":rotation:R:3" : "", p->dim);
    add_key(t, "pressure", p->pressure);
    add_key(t, "friction", p->friction);
    add_key(t, "poisson", p->poisson);
    if (p->cell != SP_CELL_PISTON || p->gravity != 0) {
        sp_text_add(t, " cell=%s", sp_cell_names[p->cell]);
        add_key(t, "gravity", p->gravity);
    }
    sp_text_add(t, " wall=%s units=\"%s\"\n", sp_wall_names[p->wall], e->units->all);
}

static void add_numbers(sp_text *t, int count, const double *value) {
    for (int k = 0; k < count; k++) {
        sp_text_add(t, " ");
        sp_text_number(t, value[k]);
    }
}

sp_status sp_export_xyz(const sp_export_data *e, sp_text text[SP_EXPORT_FILES_MAX], sp_error *err) {
    const sp_packing *p = e->packing;
    const sp_derived *d = e->derived;
    sp_text *t = &text[0];
    (void)err;
    add_head(t, e);
    for (size_t i = 0; i < (size_t)p->n; i++) {
        sp_text_add(t, "X"); /* ASE's name for no element */
        add_numbers(t, 3, p->x + 3 * i);
        sp_text_add(t, " %zu", i);
        add_numbers(t, 1, &p->r[i]);
        add_numbers(t, 1, &d->mass[i]);
        add_numbers(t, 3, d->net + 3 * i);
        sp_text_add(t, " %d %d", d->contacts[i], d->rattler[i]);
        if (e->vectors)
            add_numbers(t, 3, e->vectors->displacement + 3 * i);
        if (e->vectors && e->vectors->rotation)
            add_numbers(t, 3, e->vectors->rotation + 3 * i);
        sp_text_add(t, "\n");
    }
    return SP_OK;
}
