/* Reads the contacts that a file lists. */
#include "base/base.h"
#include "base/vector.h"
#include "foreign/work.h"
#include "packing/geometry.h"
#include "store/exchange.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The columns of a list of contacts. */
typedef struct link_columns {
    sp_place id1, id2, overlap, fn, ft, kn, kt, force[3], normal[3], tangent[3], along[3], point[3];
    bool has_force, has_normal, has_tangent, has_along, has_point;
} link_columns;

static sp_status find_columns(sp_work *w, link_columns *c, sp_error *err) {
    const sp_number_sheet *s = &w->contacts;
    sp_status status = sp_role_need(w, s, "id1", &c->id1, err);
    if (status == SP_OK)
        status = sp_role_need(w, s, "id2", &c->id2, err);
    if (status == SP_OK)
        status = sp_role_vector(w, s, "fn", c->normal, &c->has_normal, err);
    if (status == SP_OK)
        status = sp_role_vector(w, s, "f", c->force, &c->has_force, err);
    if (status == SP_OK)
        status = sp_role_vector(w, s, "ft", c->tangent, &c->has_tangent, err);
    if (status == SP_OK)
        status = sp_role_vector(w, s, "t", c->along, &c->has_along, err);
    if (status == SP_OK)
        status = sp_role_vector(w, s, "p", c->point, &c->has_point, err);
    c->overlap = sp_role_find(w, s, "overlap");
    c->fn = sp_role_find(w, s, "fn");
    c->ft = sp_role_find(w, s, "ft");
    if (!c->has_along && w->dim == 2 && !sp_role_is_named(w, "ft")) /* t turns when one axis does */
        c->ft.sign *= sp_axis_sign(w, w->axis[0]) * sp_axis_sign(w, w->axis[1]);
    c->kn = sp_role_find(w, s, "kn");
    c->kt = sp_role_find(w, s, "kt");
    return status;
}

enum { WALL_UNKNOWN = -100 }; /* far from the numbers of walls */

static bool is_wall(const sp_work *w, int64_t wall) {
    const sp_packing cell = sp_work_cell(w);
    return wall < 0 && wall >= SP_BACK && sp_packing_has_wall(&cell, (int32_t)wall);
}

/* ---- rows ------------------------------------------------------------------------------------------------------ */

/* Finds the grain of an id. *skip: it belongs to a type that was left out. Walls have negative ids in MercuryDPM (which
 * of them is not known: WALL_UNKNOWN), and may be named: bottom, top, left, ... */
static sp_status find_grain(sp_work *w, int64_t row, sp_place at, int32_t *grain, bool *skip, sp_error *err) {
    int64_t id;
    if (isnan(sp_sheet_value(&w->contacts, row, at.index))) {
        char word[SP_SHEET_NAME];
        sp_sheet_word(&w->contacts, row, at.index, word);
        if (sp_side_read(word, grain) && is_wall(w, *grain))
            return SP_OK;
    }
    sp_status status = sp_sheet_integer(&w->contacts, row, at.index, &id, err);
    if (status != SP_OK)
        return status;
    *grain = sp_grain_of_id(w, id);
    if (*grain >= 0)
        return SP_OK;
    if (w->form == SP_FORM_CSV && is_wall(w, id)) { /* our own */
        *grain = (int32_t)id;
        return SP_OK;
    }
    *grain = WALL_UNKNOWN;
    *skip = w->report.left_out > 0;
    if (*skip || (id < 0 && w->form == SP_FORM_MERCURY))
        return SP_OK;
    return sp_sheet_fail(&w->contacts, row, at.index, "the id of a grain in the file of grains", err);
}

/* A contact with a wall that the list has: which one, by where the contact lies. */
static sp_status place_at_wall(sp_work *w, const link_columns *column, sp_raw_contact *c, bool *skip, sp_error *err) {
    const int up = w->dim - 1;
    int axis = up;
    double p[3];
    if (!column->has_point)
        return sp_fail(err, SP_EFORMAT, "%s:%lld: a contact with a wall without the point of contact, p_x p_y",
                       w->contacts.file, (long long)w->contacts.number[c->row]);
    sp_status status = sp_place_vector(&w->contacts, c->row, column->point, p, err);
    for (int a = 0; a < 3; a++)
        p[a] = a < w->dim ? p[a] * w->scale - w->low[a] - w->grain[c->i].x[a] : 0;
    for (int a = 0; a < up && w->cell == SP_CELL_BOX; a++)
        axis = fabs(p[a]) > fabs(p[axis]) ? a : axis;
    *skip = fabs(p[axis]) < 0.7 * length3(p); /* a side wall, or an edge */
    c->j = sp_work_wall(w, axis, p[axis]);
    return status;
}

/* The vectors of a row, turned to act on grain i. Normal forces are taken along n, whatever their sense. */
static sp_status read_vectors(sp_work *w, const link_columns *column, sp_raw_contact *c, double turn, double *sense,
                              sp_error *err) {
    const sp_number_sheet *s = &w->contacts;
    double f[3];
    sp_status status = SP_OK;
    if (column->has_normal || column->has_force) {
        status = sp_place_vector(s, c->row, column->has_force ? column->force : column->normal, f, err);
        const double along = -turn * dot3(f, c->n) * w->force;
        *sense += along;
        c->fn = along;
        for (int a = 0; a < 3 && column->has_force; a++)
            c->ft[a] = turn * f[a] * w->force + along * c->n[a];
    }
    if (status == SP_OK && column->has_tangent) {
        status = sp_place_vector(s, c->row, column->tangent, f, err);
        for (int a = 0; a < 3; a++)
            c->ft[a] = turn * f[a] * w->force;
    }
    double size = NAN;
    if (status == SP_OK && !column->has_tangent && !column->has_force)
        status = sp_place_number(s, c->row, column->ft, &size, err);
    if (status != SP_OK || isnan(size))
        return status;
    if (column->has_along)
        status = sp_place_vector(s, c->row, column->along, f, err);
    else if (w->dim == 2) /* along t, which turns with n */
        f[0] = -turn * c->n[1], f[1] = turn * c->n[0], f[2] = 0;
    else
        return sp_fail(err, SP_EFORMAT,
                       "%s: column %s alone; in three dimensions tangential forces must be vectors, ft_x ft_y ft_z",
                       s->file, s->name[column->ft.index]);
    for (int a = 0; a < 3; a++)
        c->ft[a] = turn * size * f[a] * w->force;
    return status;
}

static sp_status read_numbers(sp_work *w, const link_columns *column, sp_raw_contact *c, sp_error *err) {
    const sp_number_sheet *s = &w->contacts;
    const double spring = w->force / w->scale;
    sp_status status = sp_place_number(s, c->row, column->overlap, &c->overlap, err);
    if (status == SP_OK)
        status = sp_place_number(s, c->row, column->kn, &c->kn, err);
    if (status == SP_OK)
        status = sp_place_number(s, c->row, column->kt, &c->kt, err);
    if (status == SP_OK)
        status = sp_place_number(s, c->row, column->fn, &c->fn, err);
    c->overlap *= w->scale;
    c->kn *= spring;
    c->kt *= spring;
    c->fn *= w->force;
    return status;
}

static sp_status read_row(sp_work *w, const link_columns *column, int64_t row, double *sense, int64_t *beside,
                          sp_error *err) {
    sp_raw_contact c = {.row = row, .overlap = NAN, .fn = NAN, .ft = {NAN, NAN, NAN}, .kn = NAN, .kt = NAN};
    bool skip = false;
    int32_t grain[2];
    sp_status status = find_grain(w, row, column->id1, &grain[0], &skip, err);
    if (status == SP_OK)
        status = find_grain(w, row, column->id2, &grain[1], &skip, err);
    if (status != SP_OK || skip)
        return status;
    if (grain[0] == grain[1])
        return sp_sheet_fail(&w->contacts, row, column->id2.index, "another grain than the first", err);
    if (grain[0] < 0 && grain[1] < 0)
        return sp_sheet_fail(&w->contacts, row, column->id2.index, "a grain, if the first is a wall", err);
    const bool swap = grain[0] < 0 || (grain[1] >= 0 && grain[0] > grain[1]);
    c.i = grain[swap];
    c.j = grain[!swap];
    if (c.j == WALL_UNKNOWN)
        status = place_at_wall(w, column, &c, &skip, err);
    *beside += skip;
    if (status != SP_OK || skip)
        return status;
    sp_work_geometry(w, &c);
    status = read_numbers(w, column, &c, err);
    if (status == SP_OK)
        status = read_vectors(w, column, &c, swap ? -1 : 1, sense, err);
    if (status != SP_OK)
        return status;
    const bool none = c.fn == 0 && !(c.depth > 0);
    if (none || (isnan(c.fn) && !(c.depth > 0) && !(c.overlap > 0)))
        return SP_OK; /* a pair of neighbours that do not touch */
    const bool across = c.j >= 0 && w->cut &&
                        fabs(w->grain[c.j].x[w->dim - 1] - w->grain[c.i].x[w->dim - 1]) > 0.5 * w->edge[w->dim - 1];
    w->report.across += across;
    return across ? SP_OK : sp_work_add(w, &c, err);
}

/* ---- the whole list -------------------------------------------------------------------------------------------- */

static int by_pair(const void *a, const void *b) {
    const sp_raw_contact *p = a, *q = b;
    if (p->i != q->i)
        return p->i < q->i ? -1 : 1;
    if (p->j != q->j)
        return p->j < q->j ? -1 : 1;
    return (p->row > q->row) - (p->row < q->row);
}

/* Removes contacts that are listed once for each grain. Others that come twice are errors. */
static sp_status remove_twins(sp_work *w, sp_error *err) {
    int32_t kept = 0;
    if (w->found > 0)
        qsort(w->contact, (size_t)w->found, sizeof *w->contact, by_pair);
    for (int32_t k = 0; k < w->found; k++) {
        const sp_raw_contact *c = &w->contact[k], *last = kept > 0 ? &w->contact[kept - 1] : NULL;
        const bool twin = last && last->i == c->i && last->j == c->j;
        if (twin && !(fabs(c->fn - last->fn) <= 1e-5 * fabs(last->fn)) && !isnan(c->fn))
            return sp_fail(err, SP_EFORMAT,
                           "%s:%lld: grains %lld and %lld touch already in line %lld, with another force",
                           w->contacts.file, (long long)w->contacts.number[c->row], (long long)w->grain[c->i].id,
                           c->j >= 0 ? (long long)w->grain[c->j].id : -1LL, (long long)w->contacts.number[last->row]);
        if (!twin)
            w->contact[kept++] = *c;
    }
    if (kept < w->found)
        sp_work_note(w, "%d contacts are listed twice, with the same force: taken once", w->found - kept);
    w->found = kept;
    return SP_OK;
}

/* Forces on the second grain instead of the first are turned. Negative ones that remain are attractions. */
static sp_status turn_sense(sp_work *w, double sense, sp_error *err) {
    for (int32_t k = 0; k < w->found; k++) {
        sp_raw_contact *c = &w->contact[k];
        if (sense < 0) {
            c->fn = -c->fn;
            for (int a = 0; a < 3; a++)
                c->ft[a] = -c->ft[a];
        }
        if (c->fn < 0)
            return sp_fail(err, SP_EFORMAT,
                           "%s:%lld: the normal force of grains %lld and %lld is %.6g: an attraction; must be >= 0",
                           w->contacts.file, (long long)w->contacts.number[c->row], (long long)w->grain[c->i].id,
                           c->j >= 0 ? (long long)w->grain[c->j].id : -1LL, c->fn / w->force);
    }
    if (sense < 0)
        sp_work_note(w, "the forces of %s act on the second grain of each row: turned", w->contacts.file);
    return SP_OK;
}

static bool has_pairs(const sp_work *w) {
    for (int32_t k = 0; k < w->found; k++)
        if (w->contact[k].j >= 0)
            return true;
    return false;
}

sp_status sp_read_links(sp_work *w, sp_error *err) {
    link_columns column = {0};
    double sense = 0;
    int64_t beside = 0;
    sp_status status = find_columns(w, &column, err);
    for (int64_t row = 0; status == SP_OK && row < w->contacts.rows; row++)
        status = read_row(w, &column, row, &sense, &beside, err);
    if (status == SP_OK && !has_pairs(w))
        return sp_fail(err, SP_EFORMAT, "%s: lists no contact between two grains of %s; --contacts overlap finds them",
                       w->contacts.file, w->path);
    if (status == SP_OK)
        status = turn_sense(w, sense, err);
    if (status == SP_OK)
        status = remove_twins(w, err);
    if (status != SP_OK)
        return status;
    w->has_forces = column.fn.index >= 0 || column.has_normal || column.has_force;
    w->has_ft = column.has_tangent || column.has_force || column.ft.index >= 0;
    const sp_place at = column.has_force ? column.force[0] : column.has_normal ? column.normal[0] : column.fn;
    w->force_place = w->has_forces ? pow(10, 1 - fmin(w->contacts.digits[at.index], 17)) : NAN;
    if (beside > 0)
        sp_work_note(w, "%lld contacts with side walls are left out", (long long)beside);
    return SP_OK;
}
