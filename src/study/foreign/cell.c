/* Periodic cells and boxes with walls on all sides: which of them a file means, and where their edges are. */
#include "base/base.h"
#include "foreign/work.h"
#include "packing/geometry.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

int sp_work_wall_axis(const sp_work *w, int32_t wall) {
    const sp_packing cell = {.dim = w->dim};
    return sp_packing_wall_axis(&cell, wall);
}

int32_t sp_work_wall(const sp_work *w, int axis, double sign) {
    const int32_t low = axis == w->dim - 1 ? SP_BOTTOM : axis == 0 ? SP_LEFT : SP_FRONT;
    return sign < 0 ? low : low - 1;
}

double sp_work_wall_given(const sp_work *w, int32_t wall) {
    const sp_import_options *o = w->o;
    return wall == SP_BOTTOM ? o->bottom : wall == SP_TOP ? o->top : o->side[SP_LEFT - wall];
}

sp_packing sp_work_cell(const sp_work *w) {
    sp_packing cell = {.dim = w->dim, .cell = w->cell, .box = {1, 1, 1}};
    memcpy(cell.box, w->edge, (size_t)w->dim * sizeof *cell.box);
    memcpy(cell.tilt, w->tilt, sizeof cell.tilt);
    return cell;
}

/* ---- which kind ------------------------------------------------------------------------------------------------ */

/* Whether grains lean on a face of the box as on a wall: some touch it, and none lies deeper than half of its radius.
 * Grains at a periodic face, or at that of a box which is as large as the centres need, do lie deeper. */
static bool is_wall(const sp_work *w, int a, double place, double sign) {
    bool touched = false;
    for (int32_t k = 0; k < w->n; k++) {
        const sp_raw_grain *g = &w->grain[k];
        const double depth = g->r - sign * (place - g->x[a]);
        if (depth > 0.5 * g->r)
            return false;
        touched = touched || depth > 0;
    }
    return touched;
}

/* MercuryDPM lists contacts with walls as those with negative numbers, and where they are. */
static bool lists_wall(sp_work *w, int a, double place) {
    const sp_number_sheet *s = &w->contacts;
    const sp_place id1 = sp_role_find(w, s, "id1"), id2 = sp_role_find(w, s, "id2");
    sp_place point[3];
    bool given = false;
    if (w->form != SP_FORM_MERCURY || s->rows == 0 || id1.index < 0 || id2.index < 0 ||
        sp_role_vector(w, s, "p", point, &given, NULL) != SP_OK || !given)
        return false;
    for (int64_t row = 0; row < s->rows; row++) {
        const bool wall = sp_sheet_value(s, row, id1.index) < 0 || sp_sheet_value(s, row, id2.index) < 0;
        if (wall && fabs(point[a].sign * sp_sheet_value(s, row, point[a].index) * w->scale - place) < 0.1)
            return true;
    }
    return false;
}

static bool has_walls(sp_work *w, int a) {
    const sp_number_sheet *s = &w->grains;
    const int f = w->axis[a];
    if (!s->box[f] || s->periodic[f] == 1)
        return false;
    const double low = s->low[f] * w->scale, high = s->high[f] * w->scale;
    if (s->periodic[f] < 0 && a < w->dim - 1 && !(lists_wall(w, a, low) && lists_wall(w, a, high)))
        return false;
    return is_wall(w, a, low, -1) && is_wall(w, a, high, 1);
}

static bool is_tilted(const sp_work *w) {
    const sp_number_sheet *s = &w->grains;
    for (int k = 0; k < 3; k++)
        if (isfinite(w->o->tilt[k]) ? w->o->tilt[k] != 0 : s->tilt[k] != 0)
            return true;
    return false;
}

/* Whether the options speak of a piston: of its walls, or of sides that are cut. */
static bool means_piston(const sp_import_options *o) {
    return o->open || o->cut || isfinite(o->bottom) || isfinite(o->top) || isfinite(o->height);
}

static sp_cell choose(sp_work *w) {
    const sp_import_options *o = w->o;
    int periodic = 0, open = 0, walled = 0;
    for (int k = 0; k < 4; k++)
        if (isfinite(o->side[k]))
            return SP_CELL_BOX;
    if (means_piston(o))
        return SP_CELL_PISTON;
    for (int a = 0; a < w->dim; a++) {
        periodic += w->grains.periodic[w->axis[a]] == 1;
        open += w->grains.periodic[w->axis[a]] == 0;
        walled += has_walls(w, a);
    }
    if (periodic == w->dim || (is_tilted(w) && open == 0))
        return SP_CELL_PERIODIC;
    return walled == w->dim ? SP_CELL_BOX : SP_CELL_PISTON;
}

sp_status sp_cell_choose(sp_work *w, sp_error *err) {
    w->cell = w->o->cell >= 0 ? (sp_cell)w->o->cell : choose(w);
    if (w->cell != SP_CELL_PERIODIC && is_tilted(w))
        return sp_fail(err, SP_EFORMAT, "%s: a tilted box (xy xz yz); must have right angles in a cell with walls",
                       w->path);
    return SP_OK;
}

/* ---- periods --------------------------------------------------------------------------------------------------- */

/* The edge along an axis: from the options, or the box of the file. */
static sp_status find_edge(sp_work *w, int a, sp_error *err) {
    static const char *const key[3] = {"width", "depth", "height"};
    const sp_number_sheet *s = &w->grains;
    const int up = w->dim - 1, f = w->axis[a];
    const double given = a == up ? w->o->height : a == 0 ? w->o->width : w->o->depth;
    if (!isfinite(given) && !s->box[f])
        return sp_fail_key(
            err, SP_EINVAL, key[a == up ? 2 : a],
            ": %s has no box along %c; must be given, --set %s=LENGTH for the period in the file's units", w->path,
            "xyz"[f], key[a == up ? 2 : a]);
    w->low[a] = s->box[f] ? s->low[f] * w->scale : 0;
    w->edge[a] = isfinite(given) ? given * w->scale : (s->high[f] - s->low[f]) * w->scale;
    w->periodic[a] = true;
    if (!(w->edge[a] > 0))
        return sp_fail_key(err, SP_EINVAL, key[a == up ? 2 : a], " = %g: must be positive", given);
    return SP_OK;
}

/* The component along axis a of the lattice vector of axis b. Files have lattice vectors of which the first lies along
 * x, the second in the plane of x and y: so must those of the packing. */
static sp_status find_tilt(sp_work *w, int a, int b, double *out, sp_error *err) {
    const int fa = w->axis[a], fb = w->axis[b];
    const int pair = fa + fb - 1; /* xy, xz, yz */
    const double given = w->o->tilt[pair], value = isfinite(given) ? given : w->grains.tilt[pair];
    *out = value * w->scale;
    if (value != 0 && (fa > fb || sp_axis_sign(w, fa) < 0 || sp_axis_sign(w, fb) < 0))
        return sp_fail(err, SP_EINVAL,
                       "%s: a tilted box whose axes are turned (up, or a minus in --columns): must be x, y, z in this "
                       "order",
                       w->path);
    return SP_OK;
}

/* Other lattice vectors of the same lattice, whose tilt is at most half of the edge. */
static void reduce_tilt(sp_work *w) {
    w->tilt[0] -= w->edge[0] * nearbyint(w->tilt[0] / w->edge[0]);
    if (w->dim == 3) {
        const double turns = nearbyint(w->tilt[2] / w->edge[1]);
        w->tilt[2] -= w->edge[1] * turns;
        w->tilt[1] -= w->tilt[0] * turns;
        w->tilt[1] -= w->edge[0] * nearbyint(w->tilt[1] / w->edge[0]);
    }
}

sp_status sp_cell_find_periods(sp_work *w, sp_error *err) {
    char tilt[100] = "";
    sp_status status = SP_OK;
    for (int a = 0; status == SP_OK && a < w->dim; a++)
        status = find_edge(w, a, err);
    for (int b = 1; status == SP_OK && b < w->dim; b++)
        for (int a = 0; status == SP_OK && a < b; a++)
            status = find_tilt(w, a, b, &w->tilt[a + b - 1], err);
    if (status != SP_OK)
        return status;
    reduce_tilt(w);
    if (w->tilt[0] != 0 || w->tilt[1] != 0 || w->tilt[2] != 0)
        snprintf(tilt, sizeof tilt, ", tilted by %.6g%s%.6g%s%.6g d", w->tilt[0], ", ", w->tilt[1], ", ", w->tilt[2]);
    sp_work_note(w, "cell: periodic along all axes%s", tilt);
    for (int32_t k = 0; k < w->n; k++)
        for (int a = 0; a < w->dim; a++)
            w->grain[k].x[a] -= w->low[a];
    return SP_OK;
}

sp_status sp_cell_check_periods(const sp_work *w, sp_error *err) {
    static const char *const key[3] = {"width", "depth", "height"};
    double largest = 0;
    for (int32_t k = 0; k < w->n; k++)
        largest = fmax(largest, 2 * w->grain[k].r);
    for (int a = 0; a < w->dim; a++)
        if (w->periodic[a] && !w->open[a] && w->edge[a] <= 2 * largest)
            return sp_fail_key(err, SP_EINVAL, key[a == w->dim - 1 ? 2 : a],
                               ": the period along %c is %.6g; must be more than two of the largest grains, %.6g: in a "
                               "smaller cell two grains could touch twice",
                               "xyz"[w->axis[a]], w -> edge[a] / w -> scale, 2 * largest / w -> scale);
    return SP_OK;
}

/* ---- walls on all sides ---------------------------------------------------------------------------------------- */

/* The two walls of an axis: from the options, or the faces of the box. Photoelastic disks have neither: the walls are
 * then where the outermost disks end, and their overlaps are not known. */
static sp_status find_walls(sp_work *w, int a, sp_error *err) {
    const sp_number_sheet *s = &w->grains;
    const int f = w->axis[a];
    const double size = a == w->dim - 1 ? w->o->height : a == 0 ? w->o->width : w->o->depth;
    double place[2] = {INFINITY, -INFINITY};
    for (int side = 0; side < 2; side++) {
        const int32_t wall = sp_work_wall(w, a, side ? 1 : -1);
        const double given = sp_work_wall_given(w, wall);
        w->has_wall[-1 - wall] = true;
        if (isfinite(given))
            place[side] = given * w->scale;
        else if (side == 1 && isfinite(size))
            place[side] = place[0] + size * w->scale;
        else if (s->box[f])
            place[side] = (side ? s->high[f] : s->low[f]) * w->scale;
        else if (side == 0 && isfinite(size))
            place[side] = 0;
        else if (w->form == SP_FORM_PHOTOELASTIC) {
            w->has_wall[-1 - wall] = false;
            for (int32_t k = 0; k < w->n; k++) {
                const sp_raw_grain *g = &w->grain[k];
                place[side] = side ? fmax(place[side], g->x[a] + g->r) : fmin(place[side], g->x[a] - g->r);
            }
        } else
            return sp_fail_key(err, SP_EINVAL, sp_side_names[-1 - wall],
                               ": %s has no box along %c; must be given, --set %s=PLACE in the file's units", w->path,
                               "xyz"[f], sp_side_names[-1 - wall]);
    }
    w->low[a] = place[0];
    w->edge[a] = place[1] - place[0];
    if (!(w->edge[a] > 0))
        return sp_fail_key(err, SP_EINVAL, sp_side_names[-1 - sp_work_wall(w, a, 1)],
                           ": this wall at %g lies below the opposite one at %g", place[1] / w->scale,
                           place[0] / w->scale);
    return SP_OK;
}

sp_status sp_cell_find_walls(sp_work *w, sp_error *err) {
    sp_status status = SP_OK;
    for (int a = 0; status == SP_OK && a < w->dim; a++)
        status = find_walls(w, a, err);
    if (status != SP_OK)
        return status;
    sp_work_note(w, "cell: a box with walls on all sides; --set sides=open leaves those beside out");
    for (int32_t k = 0; k < w->n; k++)
        for (int a = 0; a < w->dim; a++)
            w->grain[k].x[a] -= w->low[a];
    return SP_OK;
}
