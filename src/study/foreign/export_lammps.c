/* Packings as LAMMPS reads and writes them: a data file of atom style sphere, and a dump. LAMMPS counts atoms from 1.
 */
#include "base/base.h"
#include "foreign/export.h"
#include "packing/contact.h"
#include "packing/geometry.h"

#include <math.h>

static const char axis_name[3] = {'x', 'y', 'z'};

typedef struct bounds {
    double low, high;
    bool periodic;
} bounds;

/* LAMMPS knows two or three dimensions. Axes that the packing has not are periodic, and wide enough that no grain
 * touches its own image. */
static void find_bounds(const sp_export_data *e, bounds b[3]) {
    const sp_packing *p = e->packing;
    double largest = 0.25 * e->units->length; /* in 2D the layer is one diameter thick, as always */
    for (int32_t i = 0; i < p->n && p->dim == 1; i++)
        largest = fmax(largest, p->r[i]);
    for (int a = 0; a < 3; a++)
        b[a] =
            a < p->dim ? (bounds){0, p->box[a], sp_packing_periodic(p, a)} : (bounds){-2 * largest, 2 * largest, true};
}

/* What the file cannot say otherwise, in its first line, which LAMMPS skips. */
static void add_title(sp_text *t, const sp_packing *p, const sp_export_units *u) {
    sp_text_add(t, "sonopack packing in %s: dimension=%d pressure=", u->all, p->dim);
    sp_text_number(t, p->pressure);
    sp_text_add(t, " friction=");
    sp_text_number(t, p->friction);
    sp_text_add(t, " poisson=");
    sp_text_number(t, p->poisson);
    sp_text_add(t, " wall=%s", sp_wall_names[p->wall]);
    if (p->cell != SP_CELL_PISTON || p->gravity != 0) {
        sp_text_add(t, " cell=%s gravity=", sp_cell_names[p->cell]);
        sp_text_number(t, p->gravity);
    }
    sp_text_add(t, "\n");
}

static bool is_tilted(const sp_packing *p) { return p->tilt[0] != 0 || p->tilt[1] != 0 || p->tilt[2] != 0; }

static void add_tilt(sp_text *t, const sp_packing *p) {
    for (int k = 0; k < 3; k++) {
        sp_text_number(t, p->tilt[k]);
        sp_text_add(t, " ");
    }
    sp_text_add(t, "xy xz yz\n");
}

static void add_atom(sp_text *t, const sp_export_data *e, int32_t i) {
    const sp_packing *p = e->packing;
    const double density = p->mass ? p->mass[i] / grain_mass(p->r[i]) : e->units->density;
    sp_text_add(t, "%d 1 ", i + 1);
    sp_text_number(t, 2 * p->r[i]);
    sp_text_add(t, " ");
    sp_text_number(t, density);
    for (int a = 0; a < 3; a++) {
        sp_text_add(t, " ");
        sp_text_number(t, p->x[3 * (size_t)i + (size_t)a]);
    }
    sp_text_add(t, "\n");
}

sp_status sp_export_lammps_data(const sp_export_data *e, sp_text text[SP_EXPORT_FILES_MAX], sp_error *err) {
    const sp_packing *p = e->packing;
    sp_text *t = &text[0];
    bounds b[3];
    (void)err;
    find_bounds(e, b);
    add_title(t, p, e->units);
    sp_text_add(t, "\n%d atoms\n1 atom types\n\n", p->n);
    for (int a = 0; a < 3; a++) {
        sp_text_number(t, b[a].low);
        sp_text_add(t, " ");
        sp_text_number(t, b[a].high);
        sp_text_add(t, " %clo %chi\n", axis_name[a], axis_name[a]);
    }
    if (is_tilted(p))
        add_tilt(t, p);
    sp_text_add(t, "\nAtoms # sphere\n\n");
    for (int32_t i = 0; i < p->n; i++)
        add_atom(t, e, i);
    return SP_OK;
}

/* ---- dump ------------------------------------------------------------------------------------------------------- */

static void add_vector(sp_text *t, const double *v) {
    for (int a = 0; a < 3; a++) {
        sp_text_add(t, " ");
        sp_text_number(t, v[a]);
    }
}

static void add_row(sp_text *t, const sp_export_data *e, size_t i) {
    const sp_derived *d = e->derived;
    sp_text_add(t, "%zu 1", i + 1);
    add_vector(t, e->packing->x + 3 * i);
    sp_text_add(t, " ");
    sp_text_number(t, e->packing->r[i]);
    sp_text_add(t, " ");
    sp_text_number(t, d->mass[i]);
    add_vector(t, d->net + 3 * i);
    sp_text_add(t, " %d %d", d->contacts[i], d->rattler[i]);
    if (e->vectors)
        add_vector(t, e->vectors->displacement + 3 * i);
    if (e->vectors && e->vectors->rotation)
        add_vector(t, e->vectors->rotation + 3 * i);
    sp_text_add(t, "\n");
}

/* The bounds of a tilted box in a dump are those of the smallest box with right angles around it. */
static void widen(const sp_packing *p, bounds b[3]) {
    const double *t = p->tilt;
    b[0].low += fmin(fmin(0, t[0]), fmin(t[1], t[0] + t[1]));
    b[0].high += fmax(fmax(0, t[0]), fmax(t[1], t[0] + t[1]));
    b[1].low += fmin(0, t[2]);
    b[1].high += fmax(0, t[2]);
}

sp_status sp_export_lammps_dump(const sp_export_data *e, sp_text text[SP_EXPORT_FILES_MAX], sp_error *err) {
    sp_text *t = &text[0];
    bounds b[3];
    (void)err;
    find_bounds(e, b);
    const sp_packing *p = e->packing;
    const bool tilted = is_tilted(p);
    if (tilted)
        widen(p, b);
    sp_text_add(t, "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n%d\nITEM: BOX BOUNDS%s", p->n, tilted ? " xy xz yz" : "");
    for (int a = 0; a < 3; a++)
        sp_text_add(t, " %s", b[a].periodic ? "pp" : "ff");
    sp_text_add(t, "\n");
    for (int a = 0; a < 3; a++) {
        sp_text_number(t, b[a].low);
        sp_text_add(t, " ");
        sp_text_number(t, b[a].high);
        sp_text_add(t, tilted ? " " : "\n");
        if (tilted) {
            sp_text_number(t, p->tilt[a]);
            sp_text_add(t, "\n");
        }
    }
    sp_text_add(t, "ITEM: ATOMS id type x y z radius mass fx fy fz contacts rattler%s%s\n",
                e->vectors ? " ux uy uz" : "", e->vectors && e->vectors->rotation ? " rx ry rz" : "");
    for (int32_t i = 0; i < e->packing->n; i++)
        add_row(t, e, (size_t)i);
    return SP_OK;
}
