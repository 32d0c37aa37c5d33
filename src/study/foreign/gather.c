/* Takes the grains out of the rows of their file: types, ids, positions, radii, masses; and finds the axes. */
#include "base/base.h"
#include "foreign/work.h"
#include "packing/contact.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- types ----------------------------------------------------------------------------------------------------- */

static bool in_list(const char *list, const char *word) {
    const size_t n = strlen(word);
    while (*list) {
        const size_t length = strcspn(list, ",");
        if (length == n && strncmp(list, word, n) == 0)
            return true;
        list += length;
        list += *list == ',';
    }
    return false;
}

/* Marks the rows of the types wanted. */
static sp_status choose_rows(sp_work *w, uint8_t *wanted, int64_t *count, sp_error *err) {
    const sp_number_sheet *s = &w->grains;
    sp_place type = {-1, 1};
    sp_status status = w->o->types ? sp_role_need(w, s, "type", &type, err) : SP_OK;
    *count = 0;
    for (int64_t row = 0; status == SP_OK && row < s->rows; row++) {
        char word[SP_SHEET_NAME];
        wanted[row] = !w->o->types || in_list(w->o->types, sp_sheet_word(s, row, type.index, word));
        *count += wanted[row];
    }
    w->report.left_out = s->rows - *count;
    if (status == SP_OK && *count == 0)
        status = sp_fail(err, SP_EFORMAT, "%s: no grain%s%s", s->file,
                         w->o->types ? " of type " : "; must be 1 or more", w->o->types ? w->o->types : "");
    if (status == SP_OK && *count > INT32_MAX / 4)
        status = sp_fail(err, SP_EFORMAT, "%s: %lld grains; at most %d", s->file, (long long)*count, INT32_MAX / 4);
    return status;
}

/* ---- ids ------------------------------------------------------------------------------------------------------- */

static int by_id(const void *a, const void *b) {
    const sp_raw_grain *p = a, *q = b;
    if (p->id != q->id)
        return p->id < q->id ? -1 : 1;
    return (p->row > q->row) - (p->row < q->row);
}

int32_t sp_grain_of_id(const sp_work *w, int64_t id) {
    int32_t low = 0, high = w->n - 1;
    while (low <= high) {
        const int32_t middle = low + (high - low) / 2;
        if (w->grain[middle].id == id)
            return middle;
        if (w->grain[middle].id < id)
            low = middle + 1;
        else
            high = middle - 1;
    }
    return -1;
}

/* Ids number the grains; without them the rows do. */
static sp_status read_ids(sp_work *w, const uint8_t *wanted, int32_t count, sp_error *err) {
    w->grain = sp_alloc((size_t)count, sizeof *w->grain);
    if (!w->grain)
        return sp_fail_memory(err, (size_t)count * sizeof *w->grain);
    w->n = count;
    const sp_number_sheet *s = &w->grains;
    const sp_place id = sp_role_find(w, s, "id");
    const bool from_zero = w->form == SP_FORM_MERCURY || w->form == SP_FORM_YADE;
    const int64_t first = w->o->first_id >= 0 ? w->o->first_id : from_zero ? 0 : 1;
    sp_status status = SP_OK;
    int32_t k = 0;
    for (int64_t row = 0; status == SP_OK && row < s->rows; row++) {
        if (!wanted[row])
            continue;
        w->grain[k].row = row;
        w->grain[k].id = first + row;
        if (id.index >= 0)
            status = sp_sheet_integer(s, row, id.index, &w->grain[k].id, err);
        k++;
    }
    if (status != SP_OK)
        return status;
    qsort(w->grain, (size_t)w->n, sizeof *w->grain, by_id);
    for (k = 1; k < w->n; k++)
        if (w->grain[k].id == w->grain[k - 1].id)
            return sp_fail(err, SP_EFORMAT, "%s:%lld: id %lld stands already in line %lld; must be there once", s->file,
                           (long long)s->number[w->grain[k].row], (long long)w->grain[k].id,
                           (long long)s->number[w->grain[k - 1].row]);
    return SP_OK;
}

/* ---- positions ------------------------------------------------------------------------------------------------- */

/* Positions xs are fractions of the box. */
static sp_status unscale(const sp_work *w, const char *column, int axis, double *x, sp_error *err) {
    if (column[0] == '\0' || column[1] != 's')
        return SP_OK;
    const sp_number_sheet *s = &w->grains;
    if (!s->box[axis])
        return sp_fail(err, SP_EFORMAT, "%s: scaled coordinates %s without a box; must be x y z", s->file, column);
    *x = s->low[axis] + *x * (s->high[axis] - s->low[axis]);
    return SP_OK;
}

/* In a tilted box the fractions along y and z move a grain along x too, those along z also along y. */
static void shear(const sp_work *w, const bool scaled[3]) {
    const sp_number_sheet *s = &w->grains;
    if (s->tilt[0] == 0 && s->tilt[1] == 0 && s->tilt[2] == 0)
        return;
    for (int32_t k = 0; k < w->n; k++) {
        double *x = w->grain[k].x, y = 0, z = 0;
        if (scaled[1])
            y = (x[1] - s->low[1]) / (s->high[1] - s->low[1]);
        if (scaled[2])
            z = (x[2] - s->low[2]) / (s->high[2] - s->low[2]);
        x[0] += s->tilt[0] * y + s->tilt[1] * z;
        x[1] += s->tilt[2] * z;
    }
}

static sp_status read_positions(sp_work *w, sp_error *err) {
    static const char *const name[3] = {"x", "y", "z"};
    const sp_number_sheet *s = &w->grains;
    bool scaled[3] = {false};
    sp_status status = SP_OK;
    for (int a = 0; a < 3 && status == SP_OK; a++) {
        sp_place at = sp_role_find(w, s, name[a]);
        if (a < 2)
            status = sp_role_need(w, s, name[a], &at, err);
        for (int32_t k = 0; status == SP_OK && k < w->n && at.index >= 0; k++) {
            status = sp_place_number(s, w->grain[k].row, at, &w->grain[k].x[a], err);
            if (status == SP_OK)
                status = unscale(w, s->name[at.index], a, &w->grain[k].x[a], err);
        }
        scaled[a] = at.index >= 0 && s->name[at.index][0] != '\0' && s->name[at.index][1] == 's';
    }
    if (status == SP_OK)
        shear(w, scaled);
    return status;
}

/* The axis along which all grains lie in one place; -1: none, -2: more than one. */
static int flat_axis(const sp_work *w) {
    int flat = -1;
    for (int a = 2; a >= 0; a--) {
        bool same = true;
        for (int32_t k = 1; k < w->n && same; k++)
            same = w->grain[k].x[a] == w->grain[0].x[a];
        if (same)
            flat = flat == -1 ? a : -2;
    }
    return flat;
}

/* Chooses the dimension and turns the axes, so that the last is the one between the walls. */
static sp_status choose_axes(sp_work *w, sp_error *err) {
    const int flat = flat_axis(w), dim = w->o->dim ? w->o->dim : flat == -1 ? 3 : 2;
    const int out = dim == 3 ? -1 : flat >= 0 ? flat : 2; /* the axis that a layer does not have */
    const int up = w->o->up >= 0 ? w->o->up : dim == 3 ? 2 : out == 2 ? 1 : 2;
    if (dim == 2 && flat == -1)
        return sp_fail(err, SP_EINVAL,
                       "%s: dimension = 2, but the grains do not lie in one plane; must be 3, or a file of one layer",
                       w->path);
    if (up == out)
        return sp_fail(err, SP_EINVAL, "up = %c: the grains lie in a plane normal to it; must be one of the others",
                       "xyz"[up]);
    w->dim = dim;
    int k = 0;
    for (int a = 0; a < 3; a++)
        if (a != up && a != out)
            w->axis[k++] = a;
    w->axis[dim - 1] = up;
    for (int32_t i = 0; i < w->n; i++) {
        double x[3] = {0, 0, 0};
        for (int a = 0; a < dim; a++)
            x[a] = w->grain[i].x[w->axis[a]];
        memcpy(w->grain[i].x, x, sizeof x);
    }
    return SP_OK;
}

/* ---- sizes and masses ------------------------------------------------------------------------------------------ */

static sp_status read_sizes(sp_work *w, sp_error *err) {
    const sp_number_sheet *s = &w->grains;
    sp_place radius = sp_role_find(w, s, "radius"), diameter = sp_role_find(w, s, "diameter");
    sp_status status = radius.index < 0 && diameter.index < 0 ? sp_role_need(w, s, "radius", &radius, err) : SP_OK;
    const sp_place at = radius.index >= 0 ? radius : diameter;
    for (int32_t k = 0; status == SP_OK && k < w->n; k++) {
        sp_raw_grain *g = &w->grain[k];
        status = sp_place_number(s, g->row, at, &g->r, err);
        if (status == SP_OK && !(g->r > 0))
            status = sp_sheet_fail(s, g->row, at.index, "positive", err);
        g->r *= radius.index >= 0 ? 1 : 0.5;
    }
    return status;
}

static sp_status read_masses(sp_work *w, sp_error *err) {
    const sp_number_sheet *s = &w->grains;
    const sp_place mass = sp_role_find(w, s, "mass"), inertia = sp_role_find(w, s, "inertia");
    const sp_place density = sp_role_find(w, s, "density"), boundary = sp_role_find(w, s, "boundary");
    sp_status status = SP_OK;
    if ((mass.index >= 0 || density.index >= 0) && !w->o->exact)
        w->mass_place = pow(10, 1 - fmin(s->digits[mass.index >= 0 ? mass.index : density.index], 17));
    for (int32_t k = 0; status == SP_OK && k < w->n; k++) {
        sp_raw_grain *g = &w->grain[k];
        double value;
        status = sp_place_number(s, g->row, mass, &g->mass, err);
        if (status == SP_OK)
            status = sp_place_number(s, g->row, inertia, &g->inertia, err);
        if (status == SP_OK && density.index >= 0 && mass.index < 0) {
            status = sp_place_number(s, g->row, density, &g->mass, err);
            g->mass *= grain_mass(g->r);
        }
        if (status == SP_OK && ((mass.index >= 0 && !(g->mass > 0)) || (inertia.index >= 0 && !(g->inertia > 0))))
            status = sp_sheet_fail(s, g->row, mass.index >= 0 && !(g->mass > 0) ? mass.index : inertia.index,
                                   "positive", err);
        if (status == SP_OK && boundary.index >= 0) {
            status = sp_place_number(s, g->row, boundary, &value, err);
            g->boundary = value != 0;
        }
    }
    return status;
}

sp_status sp_gather_grains(sp_work *w, sp_error *err) {
    uint8_t *wanted = sp_alloc((size_t)w->grains.rows, 1);
    int64_t count = 0;
    if (!wanted)
        return sp_fail_memory(err, (size_t)w->grains.rows);
    sp_status status = choose_rows(w, wanted, &count, err);
    if (status == SP_OK)
        status = read_ids(w, wanted, (int32_t)count, err);
    sp_free(wanted);
    if (status == SP_OK)
        status = read_positions(w, err);
    if (status == SP_OK)
        status = choose_axes(w, err);
    if (status == SP_OK)
        status = read_sizes(w, err);
    return status == SP_OK ? read_masses(w, err) : status;
}
