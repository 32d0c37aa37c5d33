/* Packings as VTK XML PolyData: grains as points, contacts and wall contacts as lines. */
#include "base/base.h"
#include "foreign/export.h"
#include "foreign/vtk.h"
#include "packing/contact.h"

#include <stdio.h>
#include <string.h>

/* What units the numbers have, for who reads the file. */
static void begin(sp_text *t, const sp_export_units *u) {
    char note[300];
    snprintf(note, sizeof note,
             "sonopack: lengths in %s, forces in %s, stiffnesses in %s, stresses in %s, masses in %s; the normal of a "
             "contact points from its grain id1, on which the force acts",
             u->length_name, u->force_name, u->stiffness_name, u->stress_name, u->mass_name);
    sp_vtk_begin(t, note);
}

static void add_number(sp_text *t, const char *name, int count, const double *value) {
    sp_vtk_array(t, name, SP_VTK_F64, count, 1, value);
}

/* The numbers of the whole packing, which ParaView shows as field data. */
static void add_field(sp_text *t, const sp_packing *p) {
    const int32_t dim = p->dim;
    sp_vtk_field(t);
    sp_vtk_array(t, "dimension", SP_VTK_I32, 1, 1, &dim);
    add_number(t, "box", 3, p->box);
    add_number(t, "pressure", 1, &p->pressure);
    add_number(t, "friction", 1, &p->friction);
    add_number(t, "poisson", 1, &p->poisson);
    if (p->cell != SP_CELL_PISTON || p->gravity != 0) {
        const int32_t cell = (int32_t)p->cell;
        sp_vtk_array(t, "cell", SP_VTK_I32, 1, 1, &cell);
        add_number(t, "tilt", 3, p->tilt);
        add_number(t, "gravity", 1, &p->gravity);
    }
    sp_vtk_end(t);
}

/* ---- grains ----------------------------------------------------------------------------------------------------- */

static void add_ids(sp_text *t, int64_t n) {
    int64_t *id = sp_alloc((size_t)n, sizeof *id);
    t->failed = t->failed || !id;
    for (int64_t k = 0; id && k < n; k++)
        id[k] = k;
    if (id)
        sp_vtk_array(t, "id", SP_VTK_I64, 1, n, id);
    sp_free(id);
}

static void add_grains(const sp_export_data *e, sp_text *t) {
    const sp_packing *p = e->packing;
    const sp_derived *d = e->derived;
    begin(t, e->units);
    sp_vtk_piece(t, SP_VTK_VERTICES, p->n);
    sp_text_add(t, "<PointData Scalars=\"radius\">\n");
    add_ids(t, p->n);
    sp_vtk_array(t, "radius", SP_VTK_F64, 1, p->n, p->r);
    sp_vtk_array(t, "mass", SP_VTK_F64, 1, p->n, d->mass);
    sp_vtk_array(t, "contacts", SP_VTK_I32, 1, p->n, d->contacts);
    sp_vtk_array(t, "rattler", SP_VTK_I32, 1, p->n, d->rattler);
    sp_vtk_array(t, "pressure", SP_VTK_F64, 1, p->n, d->pressure);
    sp_vtk_array(t, "stress", SP_VTK_F64, 9, p->n, d->stress);
    sp_vtk_array(t, "net_force", SP_VTK_F64, 3, p->n, d->net);
    if (e->vectors)
        sp_vtk_array(t, "displacement", SP_VTK_F64, 3, p->n, e->vectors->displacement);
    if (e->vectors && e->vectors->rotation)
        sp_vtk_array(t, "rotation", SP_VTK_F64, 3, p->n, e->vectors->rotation);
    sp_text_add(t, "</PointData>\n");
    sp_vtk_points(t, SP_VTK_VERTICES, p->n, p->x);
    add_field(t, p);
}

/* ---- contacts --------------------------------------------------------------------------------------------------- */

/* Contacts first .. last - 1, with memory for one array. */
typedef struct lines {
    const sp_export_data *e;
    sp_text *text;
    int32_t first, count;
    double *numbers;   /* [count][6] */
    int64_t *integers; /* [count] */
} lines;

static const sp_contact *contact(const lines *l, int32_t k) { return &l->e->packing->contacts[l->first + k]; }

static void add_partner(const lines *l, const char *name, bool second) {
    for (int32_t k = 0; k < l->count; k++)
        l->integers[k] = second ? contact(l, k)->j : contact(l, k)->i;
    sp_vtk_array(l->text, name, SP_VTK_I64, 1, l->count, l->integers);
}

/* A flag for each contact: whether it carries force, or whether it crosses a periodic edge. */
static void add_flag(const lines *l, const char *name, bool crossing) {
    double end[3];
    for (int32_t k = 0; k < l->count; k++)
        l->integers[k] =
            crossing ? sp_contact_end(l->e->packing, contact(l, k), end) : l->e->derived->carrying[l->first + k];
    sp_vtk_array(l->text, name, SP_VTK_I64, 1, l->count, l->integers);
}

/* A number or a vector that is a member of sp_contact. */
static void add_member(const lines *l, const char *name, int components, size_t offset) {
    const size_t size = (size_t)components * sizeof(double);
    for (int32_t k = 0; k < l->count; k++)
        memcpy(l->numbers + (size_t)components * (size_t)k, (const char *)contact(l, k) + offset, size);
    sp_vtk_array(l->text, name, SP_VTK_F64, components, l->count, l->numbers);
}

static void add_forces(const lines *l) {
    for (int32_t k = 0; k < l->count; k++)
        sp_contact_force(contact(l, k), l->numbers + 3 * (size_t)k);
    sp_vtk_array(l->text, "force", SP_VTK_F64, 3, l->count, l->numbers);
}

static void add_stiffnesses(const lines *l) {
    const sp_packing *p = l->e->packing;
    for (int32_t k = 0; k < l->count; k++)
        l->numbers[k] = contact_kn(p, contact(l, k));
    sp_vtk_array(l->text, "kn", SP_VTK_F64, 1, l->count, l->numbers);
    for (int32_t k = 0; k < l->count; k++)
        l->numbers[k] = sp_contact_kt(p, contact(l, k));
    sp_vtk_array(l->text, "kt", SP_VTK_F64, 1, l->count, l->numbers);
}

static void add_ends(const lines *l) {
    const sp_packing *p = l->e->packing;
    for (int32_t k = 0; k < l->count; k++) {
        memcpy(l->numbers + 6 * (size_t)k, p->x + 3 * (size_t)contact(l, k)->i, 3 * sizeof(double));
        sp_contact_end(p, contact(l, k), l->numbers + 6 * (size_t)k + 3);
    }
    sp_vtk_points(l->text, SP_VTK_LINES, l->count, l->numbers);
    add_field(l->text, p);
}

/* OVITO takes a file of lines with id1 and id2 for the bonds of its particles. Walls are no particles: theirs is
 * another name. */
static void add_contacts(const lines *l, bool walls) {
    sp_text *t = l->text;
    begin(t, l->e->units);
    sp_vtk_piece(t, SP_VTK_LINES, l->count);
    sp_text_add(t, "<CellData Scalars=\"normal_force\">\n");
    add_partner(l, "id1", false);
    add_partner(l, walls ? "wall" : "id2", true);
    add_member(l, "normal_force", 1, offsetof(sp_contact, fn));
    add_forces(l);
    add_member(l, "tangential_force", 3, offsetof(sp_contact, ft));
    add_member(l, "normal", 3, offsetof(sp_contact, n));
    add_member(l, "overlap", 1, offsetof(sp_contact, overlap));
    add_stiffnesses(l);
    add_flag(l, "carrying", false);
    if (!walls)
        add_flag(l, "periodic", true);
    sp_text_add(t, "</CellData>\n");
    add_ends(l);
}

static sp_status add_lines(const sp_export_data *e, int32_t first, int32_t count, bool walls, sp_text *t,
                           sp_error *err) {
    lines l = {.e = e, .text = t, .first = first, .count = count};
    l.numbers = sp_alloc(6 * (size_t)count, sizeof *l.numbers);
    l.integers = sp_alloc((size_t)count, sizeof *l.integers);
    const bool good = l.numbers && l.integers;
    if (good)
        add_contacts(&l, walls);
    sp_free(l.numbers);
    sp_free(l.integers);
    return good ? SP_OK : sp_fail_memory(err, (size_t)count * 56);
}

/* The file that OVITO opens to get grains and contacts at once. */
static void add_blocks(const sp_export_data *e, sp_text *t) {
    char contacts[SP_EXPORT_PATH_MAX];
    sp_export_beside(e->path, "-contacts.vtp", contacts); /* its length has been checked */
    const char *const name[2] = {"grains", "contacts"}, *const file[2] = {e->path, contacts};
    sp_text_add(t, "<?xml version=\"1.0\"?>\n<VTKFile type=\"vtkMultiBlockDataSet\" version=\"1.0\">\n"
                   "<vtkMultiBlockDataSet>\n");
    for (int k = 0; k < 2; k++) {
        sp_text_add(t, "<DataSet index=\"%d\" name=\"%s\" file=\"", k, name[k]);
        sp_vtk_escaped(t, sp_export_base(file[k]));
        sp_text_add(t, "\"/>\n");
    }
    sp_text_add(t, "</vtkMultiBlockDataSet>\n</VTKFile>\n");
}

sp_status sp_export_vtp(const sp_export_data *e, sp_text text[SP_EXPORT_FILES_MAX], sp_error *err) {
    const sp_packing *p = e->packing;
    int32_t pairs = 0;
    while (pairs < p->n_contacts && p->contacts[pairs].j >= 0)
        pairs++;
    add_grains(e, &text[0]);
    sp_status status = add_lines(e, 0, pairs, false, &text[1], err);
    if (status == SP_OK)
        status = add_lines(e, pairs, p->n_contacts - pairs, true, &text[2], err);
    add_blocks(e, &text[3]);
    return status;
}
