/* The box: periods beside the axis up, and walls on it. */
#include "base/base.h"
#include "foreign/work.h"

#include <math.h>

void sp_work_separation(const sp_work *w, int32_t i, int32_t j, double d[3]) {
    for (int a = 0; a < 3; a++)
        d[a] = w->grain[j].x[a] - w->grain[i].x[a];
    for (int a = w->dim - 1; a >= 0; a--) {
        const double periods = w->periodic[a] ? nearbyint(d[a] / w->edge[a]) : 0;
        d[a] -= w->edge[a] * periods;
        if (a == 1)
            d[0] -= w->tilt[0] * periods;
        if (a == 2) {
            d[0] -= w->tilt[1] * periods;
            d[1] -= w->tilt[2] * periods;
        }
    }
}

static void extent(const sp_work *w, int a, double *low, double *high) {
    *low = INFINITY;
    *high = -INFINITY;
    for (int32_t k = 0; k < w->n; k++) {
        *low = fmin(*low, w->grain[k].x[a] - w->grain[k].r);
        *high = fmax(*high, w->grain[k].x[a] + w->grain[k].r);
    }
}

/* ---- beside -------------------------------------------------------------------------------------------------- */

/* Without a period the box is wider than the grains, so that none touches another across its sides. */
static void open_side(sp_work *w, int a) {
    double low, high;
    extent(w, a, &low, &high);
    w->low[a] = low - 0.25;
    w->edge[a] = high - low + 0.5;
    w->periodic[a] = w->open[a] = true;
}

static sp_status find_period(sp_work *w, int a, sp_error *err) {
    const sp_number_sheet *s = &w->grains;
    const double given = a == 0 ? w->o->width : w->o->depth;
    const int f = w->axis[a];
    static const char *const key[2] = {"width", "depth"};
    w->periodic[a] = true;
    if (isfinite(given)) {
        w->low[a] = s->box[f] ? s->low[f] * w->scale : 0;
        w->edge[a] = given * w->scale;
    } else if (w->o->open || w->form == SP_FORM_PHOTOELASTIC) {
        open_side(w, a);
        sp_work_note(w, "%c: no period; the box is %.6g d wide, half a diameter more than the grains", "xyz"[f],
                     w -> edge[a]);
    } else if (s->box[f] && s->periodic[f] == 0) {
        open_side(w, a);
        sp_work_note(
            w,
            "%c is not periodic in the file: contacts with side walls are not taken, the box is %.6g d wide, half "
            "a diameter more than the grains",
            "xyz"[f], w -> edge[a]);
    } else if (s->box[f]) {
        w->low[a] = s->low[f] * w->scale;
        w->edge[a] = (s->high[f] - s->low[f]) * w->scale;
        if (s->periodic[f] < 0)
            sp_work_note(w, "%c: taken as periodic, %.6g d; --set sides=open if it is not", "xyz"[f], w -> edge[a]);
    } else {
        return sp_fail_key(err, SP_EINVAL, key[a],
                           ": %s has no box along %c; must be given, --set %s=LENGTH for the "
                           "period in the file's units, or --set sides=open if there is none",
                           w->path, "xyz"[f], key[a]);
    }
    if (!(w->edge[a] > 0))
        return sp_fail_key(err, SP_EINVAL, key[a], " = %g: must be positive", given);
    for (int32_t k = 0; k < w->n; k++)
        w->grain[k].x[a] -= w->low[a];
    return SP_OK;
}

/* ---- walls --------------------------------------------------------------------------------------------------- */

/* The position of a wall: from the options, or a face of the box. */
static void find_wall(sp_work *w, int side, double *place) {
    const sp_number_sheet *s = &w->grains;
    const int f = w->axis[w->dim - 1];
    const double given = side == 0 ? w->o->bottom : w->o->top;
    w->has_wall[side] = true;
    if (isfinite(given))
        *place = given * w->scale;
    else if (s->box[f] && s->periodic[f] != 1)
        *place = (side == 0 ? s->low[f] : s->high[f]) * w->scale;
    else
        w->has_wall[side] = false;
}

static sp_status find_piston(sp_work *w, sp_error *err) {
    const int up = w->dim - 1, f = w->axis[up];
    const sp_number_sheet *s = &w->grains;
    const bool turned = s->periodic[f] == 1 && !isfinite(w->o->bottom) && !isfinite(w->o->top);
    sp_status status = SP_OK;
    for (int a = 0; status == SP_OK && a < up; a++)
        status = find_period(w, a, err);
    if (status != SP_OK)
        return status;
    if (turned && !w->o->cut)
        return sp_fail_key(
            err, SP_EINVAL, "across",
            ": %s is periodic along %c too, where a piston has walls: --set across=drop cuts it at the face of "
            "the box and leaves out the contacts across, --set up=AXIS takes another axis, --set cell=periodic "
            "keeps it",
            w->path, "xyz"[f]);
    double place[2] = {0, 0}, low, high;
    find_wall(w, 0, &place[0]);
    find_wall(w, 1, &place[1]);
    extent(w, up, &low, &high);
    if (turned) {
        place[0] = s->low[f] * w->scale;
        place[1] = s->high[f] * w->scale;
    } else {
        place[0] = w->has_wall[0] ? place[0] : low;
        if (isfinite(w->o->height)) {
            place[1] = place[0] + w->o->height * w->scale;
            w->has_wall[1] = true;
        }
        place[1] = w->has_wall[1] ? place[1] : high;
    }
    w->low[up] = place[0];
    w->edge[up] = place[1] - place[0];
    w->periodic[up] = w->cut = turned;
    if (!(w->edge[up] > 0))
        return sp_fail_key(err, SP_EINVAL, "top", ": the upper wall at %g lies below the lower at %g",
                           place[1] / w->scale, place[0] / w->scale);
    for (int32_t k = 0; k < w->n; k++)
        w->grain[k].x[up] -= w->low[up];
    return SP_OK;
}

sp_status sp_box_find(sp_work *w, sp_error *err) {
    sp_status status = sp_cell_choose(w, err);
    if (status == SP_OK)
        status = w->cell == SP_CELL_PERIODIC ? sp_cell_find_periods(w, err)
                 : w->cell == SP_CELL_BOX    ? sp_cell_find_walls(w, err)
                                             : find_piston(w, err);
    return status == SP_OK ? sp_cell_check_periods(w, err) : status;
}
