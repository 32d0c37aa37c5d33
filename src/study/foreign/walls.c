/* Contacts with the walls: by overlaps, from the per-atom output of fix wall/gran, from a file, or by what is missing
 * in the balance of forces. */
#include "base/base.h"
#include "base/vector.h"
#include "foreign/work.h"
#include "packing/geometry.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* The force of a wall on a grain, in the units of the file. */
typedef struct wall_force {
    int32_t grain;
    int64_t row;
    double force[3], point[3]; /* point: NAN if it is not known */
} wall_force;

/* The wall that pushes a grain. In a box it is the nearest of those that push in the direction of the force. */
static int32_t pushing_wall(const sp_work *w, const wall_force *f) {
    const sp_raw_grain *g = &w->grain[f->grain];
    int32_t best = f->force[w->dim - 1] > 0 ? SP_BOTTOM : SP_TOP;
    double nearest = INFINITY;
    for (int a = 0; a < w->dim && w->cell == SP_CELL_BOX; a++) {
        const int32_t wall = sp_work_wall(w, a, -f->force[a]);
        const double distance = f->force[a] > 0 ? g->x[a] : w->edge[a] - g->x[a];
        if (f->force[a] != 0 && distance < nearest) {
            nearest = distance;
            best = wall;
        }
    }
    return best;
}

static sp_status add_force(sp_work *w, const wall_force *f, int side, int64_t *beside, sp_error *err) {
    const sp_raw_grain *g = &w->grain[f->grain];
    sp_raw_contact c = {.i = f->grain,
                        .j = side < 0 ? pushing_wall(w, f) : SP_BOTTOM - side,
                        .row = f->row,
                        .overlap = NAN,
                        .kn = NAN,
                        .kt = NAN};
    const int axis = sp_work_wall_axis(w, c.j);
    double d[3] = {0, 0, 0};
    for (int a = 0; a < w->dim; a++)
        d[a] = f->point[a] * w->scale - w->low[a] - g->x[a];
    sp_work_geometry(w, &c);
    if (isfinite(d[0]) && length3(d) > 0) { /* the normal points to the point of contact */
        for (int a = 0; a < w->dim - 1 && w->periodic[a]; a++)
            d[a] -= w->edge[a] * nearbyint(d[a] / w->edge[a]);
        if (fabs(d[axis]) < 0.7 * length3(d)) {
            ++*beside;
            return SP_OK;
        }
        if (fabs(d[axis]) < (1 - 1e-12) * length3(d))
            for (int a = 0; a < 3; a++)
                c.n[a] = d[a] / length3(d);
        if (isnan(c.depth))
            c.depth = g->r - length3(d);
    }
    const double along = -dot3(f->force, c.n);
    c.fn = along * w->force;
    for (int a = 0; a < 3; a++)
        c.ft[a] = (f->force[a] + along * c.n[a]) * w->force;
    if (c.fn < 0)
        return sp_fail(err, SP_EFORMAT, "the force of a wall on grain %lld pulls (%g); must push it away from the wall",
                       (long long)g->id, along);
    return sp_work_add(w, &c, err);
}

/* ---- fix wall/gran contacts ------------------------------------------------------------------------------------ */

/* The columns f_ID[1] ... f_ID[7]: touches, force, point. */
typedef struct fix_columns {
    sp_place touches, force[3], point[3];
} fix_columns;

static bool find_fix(const sp_work *w, const char *name, fix_columns *c) {
    int index[8];
    for (int k = 1; k < 8; k++) {
        char column[SP_SHEET_NAME];
        snprintf(column, sizeof column, "%.40s[%d]", name, k);
        index[k] = sp_sheet_find(&w->grains, column);
    }
    if (index[1] < 0)
        return false;
    c->touches = (sp_place){index[1], 1};
    for (int a = 0; a < 3; a++) {
        const double sign = a < w->dim ? sp_axis_sign(w, w->axis[a]) : 1;
        c->force[a] = a < w->dim ? (sp_place){index[2 + w->axis[a]], sign} : (sp_place){-1, 1};
        c->point[a] = a < w->dim ? (sp_place){index[5 + w->axis[a]], sign} : (sp_place){-1, 1};
        if (a < w->dim && index[2 + w->axis[a]] < 0)
            return false;
    }
    return true;
}

static bool find_side(const sp_work *w, int side, fix_columns *c) {
    static const char *const usual[6][3] = {{"f_floor", "f_bottom", NULL},
                                            {"f_roof", "f_top", NULL},
                                            {"f_left", NULL},
                                            {"f_right", NULL},
                                            {"f_front", NULL},
                                            {"f_back", NULL}};
    for (int k = 0; k < w->roles; k++)
        if (strcmp(w->role[k].role, sp_side_names[side]) == 0)
            return find_fix(w, w->role[k].column, c);
    for (int k = 0; usual[side][k]; k++)
        if (find_fix(w, usual[side][k], c))
            return true;
    return false;
}

static sp_status read_fix_row(sp_work *w, const fix_columns *c, int32_t k, wall_force *f, bool *touches,
                              sp_error *err) {
    const sp_number_sheet *s = &w->grains;
    double flag;
    *f = (wall_force){.grain = k, .row = -1, .point = {NAN, NAN, NAN}};
    sp_status status = sp_place_number(s, w->grain[k].row, c->touches, &flag, err);
    *touches = flag != 0;
    if (status == SP_OK)
        status = sp_place_vector(s, w->grain[k].row, c->force, f->force, err);
    if (status == SP_OK && c->point[0].index >= 0)
        status = sp_place_vector(s, w->grain[k].row, c->point, f->point, err);
    return status;
}

/* Takes the position of a wall from its points of contact, if these lie in a plane, and moves the box to it. */
static sp_status place_wall(sp_work *w, const fix_columns *c, int side, sp_error *err) {
    const int axis = sp_work_wall_axis(w, SP_BOTTOM - side);
    const bool far = sp_packing_wall_side(SP_BOTTOM - side) > 0;
    double low = INFINITY, high = -INFINITY;
    const double given = sp_work_wall_given(w, SP_BOTTOM - side);
    const double size = axis == w->dim - 1 ? w->o->height : axis == 0 ? w->o->width : w->o->depth;
    sp_status status = SP_OK;
    for (int32_t k = 0; status == SP_OK && k < w->n && c->point[axis].index >= 0; k++) {
        wall_force f;
        bool touches;
        status = read_fix_row(w, c, k, &f, &touches, err);
        low = touches ? fmin(low, f.point[axis] * w->scale) : low;
        high = touches ? fmax(high, f.point[axis] * w->scale) : high;
    }
    const bool plane = high >= low && high - low <= 1e-6; /* high < low: no grain touches it */
    if (status != SP_OK || isfinite(given) || !plane || isfinite(size))
        return status;
    const double other = far ? w->low[axis] : w->low[axis] + w->edge[axis], move = far ? 0 : low - w->low[axis];
    w->low[axis] = far ? other : low;
    w->edge[axis] = far ? low - other : other - low;
    w->has_wall[side] = true;
    for (int32_t k = 0; k < w->n; k++)
        w->grain[k].x[axis] -= move;
    return SP_OK;
}

static sp_status read_fixes(sp_work *w, const bool given[6], const fix_columns fix[6], sp_error *err) {
    int64_t beside = 0;
    sp_status status = SP_OK;
    for (int side = 0; status == SP_OK && side < 6; side++)
        if (given[side])
            status = place_wall(w, &fix[side], side, err);
    for (int side = 0; status == SP_OK && side < 6; side++)
        for (int32_t k = 0; status == SP_OK && given[side] && k < w->n; k++) {
            wall_force f;
            bool touches;
            status = read_fix_row(w, &fix[side], k, &f, &touches, err);
            if (status == SP_OK && touches)
                status = add_force(w, &f, side, &beside, err);
        }
    return status;
}

/* ---- a file ---------------------------------------------------------------------------------------------------- */

static sp_status read_wall_file(sp_work *w, sp_error *err) {
    const sp_number_sheet *s = &w->walls;
    sp_place id, force[3], point[3];
    bool has_force = false, has_point = false;
    int64_t beside = 0;
    sp_status status = sp_role_need(w, s, "id", &id, err);
    if (status == SP_OK)
        status = sp_role_vector(w, s, "f", force, &has_force, err);
    if (status == SP_OK)
        status = sp_role_vector(w, s, "p", point, &has_point, err);
    if (status == SP_OK && !has_force)
        status = sp_role_need(w, s, "f_x", &force[0], err);
    for (int64_t row = 0; status == SP_OK && row < s->rows; row++) {
        wall_force f = {.row = -1, .point = {NAN, NAN, NAN}};
        int64_t number;
        status = sp_sheet_integer(s, row, id.index, &number, err);
        if (status != SP_OK)
            break;
        f.grain = sp_grain_of_id(w, number);
        if (f.grain < 0 && w->report.left_out > 0)
            continue;
        if (f.grain < 0)
            return sp_sheet_fail(s, row, id.index, "the id of a grain in the file of grains", err);
        status = sp_place_vector(s, row, force, f.force, err);
        if (status == SP_OK && has_point)
            status = sp_place_vector(s, row, point, f.point, err);
        const double along = length3(f.force);
        const bool from_side = w->cell == SP_CELL_PISTON && fabs(f.force[w->dim - 1]) < 0.5 * along;
        if (status == SP_OK && !has_point && from_side)
            beside++;
        else if (status == SP_OK && along > 0 && add_force(w, &f, -1, &beside, err) != SP_OK)
            status = sp_fail_prefix(err, "%s:%lld", s->file, (long long)s->number[row]);
    }
    if (status == SP_OK && beside > 0)
        sp_work_note(w, "%lld contacts with side walls are left out", (long long)beside);
    return status;
}

/* ---- balance --------------------------------------------------------------------------------------------------- */

/* The sum of the forces of contacts on every grain, force[3 k]. */
static double *sum_forces(const sp_work *w) {
    double *sum = sp_alloc((size_t)w->n * 3, sizeof *sum);
    for (int32_t k = 0; sum && k < w->found; k++) {
        const sp_raw_contact *c = &w->contact[k];
        for (int a = 0; a < w->dim; a++) {
            const double f = (isfinite(c->ft[a]) ? c->ft[a] : 0) - c->fn * c->n[a];
            sum[3 * (size_t)c->i + (size_t)a] += f;
            if (c->j >= 0)
                sum[3 * (size_t)c->j + (size_t)a] -= f;
        }
    }
    return sum;
}

/* Grains at the boundary are pushed by walls that the file does not list: with the force that they lack. */
static sp_status balance_walls(sp_work *w, sp_error *err) {
    const int up = w->dim - 1;
    double mean = 0;
    int64_t beside = 0, inner = 0;
    for (int32_t k = 0; k < w->found; k++)
        mean += w->contact[k].fn / w->found;
    if (!w->has_forces)
        return sp_fail(err, SP_EINVAL, "--walls balance: %s has no forces; must have them", w->path);
    double *sum = sum_forces(w);
    sp_status status = sum ? SP_OK : sp_fail_memory(err, (size_t)w->n * 24);
    for (int32_t k = 0; status == SP_OK && k < w->n; k++) {
        const double *lack = sum + 3 * (size_t)k, length = length3(lack);
        if (!(length > 0.05 * mean))
            continue;
        inner += !w->grain[k].boundary;
        if (!w->grain[k].boundary)
            continue;
        int axis = up;
        for (int a = 0; a < up && w->cell == SP_CELL_BOX; a++)
            axis = fabs(lack[a]) > fabs(lack[axis]) ? a : axis;
        if (fabs(lack[axis]) < 0.5 * length) {
            beside++;
            continue;
        }
        sp_raw_contact c = {.i = k, /* the others push it up: what holds it is above */
                            .j = sp_work_wall(w, axis, lack[axis]),
                            .row = -1,
                            .depth = NAN,
                            .overlap = NAN,
                            .fn = length,
                            .kn = NAN,
                            .kt = NAN};
        for (int a = 0; a < 3; a++)
            c.n[a] = lack[a] / length;
        status = sp_work_add(w, &c, err);
    }
    sp_free(sum);
    if (beside > 0)
        sp_work_note(w, "%lld boundary grains are pushed from the side: this force is left out", (long long)beside);
    if (inner > 0)
        sp_work_note(w, "%lld grains that are not marked as boundary lack more than 5%% of the mean force",
                     (long long)inner);
    return status;
}

/* ---- choice ---------------------------------------------------------------------------------------------------- */

static bool has_wall_contacts(const sp_work *w) {
    for (int32_t k = 0; k < w->found; k++)
        if (w->contact[k].j < 0)
            return true;
    return false;
}

static sp_status overlap_walls(sp_work *w, sp_error *err) {
    if (!w->has_wall[0] && !w->has_wall[1] && w->o->walls)
        return sp_fail(err, SP_EINVAL,
                       "--walls overlap: %s has no box along %c; must be given: --set bottom=PLACE, --set top=PLACE",
                       w->path, "xyz"[w->axis[w->dim - 1]]);
    return sp_touch_walls(w, err);
}

sp_status sp_read_walls(sp_work *w, sp_error *err) {
    const char *walls = w->o->walls;
    fix_columns fix[6];
    bool given[6] = {false}, any = false;
    if (walls && strcmp(walls, "none") == 0)
        return SP_OK;
    if (walls && w->cell == SP_CELL_PERIODIC)
        return sp_fail(err, SP_EINVAL,
                       "--walls %s: the cell of %s is periodic along all axes and has no walls: --set cell=piston or "
                       "box, if it should have",
                       walls, w->path);
    if (w->cell == SP_CELL_PERIODIC)
        return SP_OK;
    for (int side = 0; side < 2 * (w->cell == SP_CELL_BOX ? w->dim : 1); side++) {
        given[side] = find_side(w, side, &fix[side]);
        any = any || given[side];
    }
    if (walls && strcmp(walls, "overlap") == 0)
        return overlap_walls(w, err);
    if (walls && strcmp(walls, "balance") == 0)
        return balance_walls(w, err);
    if (walls)
        return read_wall_file(w, err);
    if (any)
        return read_fixes(w, given, fix, err);
    return w->form == SP_FORM_PHOTOELASTIC || has_wall_contacts(w) ? SP_OK : overlap_walls(w, err);
}
