/* Finds what overlaps. */
#include "base/base.h"
#include "foreign/work.h"
#include "packing/geometry.h"

#include <math.h>
#include <string.h>

sp_status sp_work_add(sp_work *w, const sp_raw_contact *c, sp_error *err) {
    if (w->found == INT32_MAX / 4)
        return sp_fail(err, SP_EFORMAT, "%s: more than %d contacts", w->path, INT32_MAX / 4);
    size_t room = (size_t)w->room;
    sp_raw_contact *larger = sp_grow(w->contact, (size_t)w->found + 1, &room, sizeof *larger);
    if (!larger)
        return sp_fail_memory(err, 2 * room * sizeof *larger);
    w->contact = larger;
    w->room = (int64_t)room;
    w->contact[w->found++] = *c;
    return SP_OK;
}

void sp_work_geometry(const sp_work *w, sp_raw_contact *c) {
    if (c->j < 0) {
        const int axis = sp_work_wall_axis(w, c->j);
        const bool far = sp_packing_wall_side(c->j) > 0;
        const double place = w->grain[c->i].x[axis];
        memset(c->n, 0, sizeof c->n);
        c->n[axis] = far ? 1 : -1;
        c->depth = w->has_wall[-1 - c->j] ? w->grain[c->i].r - (far ? w->edge[axis] - place : place) : NAN;
        return;
    }
    double d[3];
    sp_work_separation(w, c->i, c->j, d);
    const double length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    for (int a = 0; a < 3; a++)
        c->n[a] = length > 0 ? d[a] / length : 0;
    c->depth = w->grain[c->i].r + w->grain[c->j].r - length;
}

static const sp_raw_contact unknown = {
    .row = -1, .depth = NAN, .overlap = NAN, .fn = NAN, .ft = {NAN, NAN, NAN}, .kn = NAN, .kt = NAN};

/* ---- cells ----------------------------------------------------------------------------------------------------- */

/* The grains sorted into cells as wide as the largest grain. */
typedef struct lattice {
    sp_packing cell;
    int n[3];
    int32_t *start, *grain; /* cell c holds grain[start[c] .. start[c+1]-1] */
} lattice;

static int cell_along(const sp_work *w, const lattice *l, int32_t i, int a) {
    if (a >= w->dim)
        return 0;
    double s[3];
    sp_packing_fractions(&l->cell, w->grain[i].x, s);
    if (w->periodic[a])
        s[a] -= floor(s[a]);
    const int c = (int)(fmin(fmax(s[a], 0), 1) * l->n[a]);
    return c < l->n[a] ? c : l->n[a] - 1;
}

static int64_t cell_of(const lattice *l, const int c[3]) { return ((int64_t)c[2] * l->n[1] + c[1]) * l->n[0] + c[0]; }

/* Distance between the faces of the box on an axis. */
static double thickness(const sp_work *w, int a) {
    const double *e = w->edge, *t = w->tilt;
    if (a == 0)
        return w->dim == 2   ? e[0] * e[1] / hypot(e[1], t[0])
               : w->dim == 3 ? e[0] * e[1] * e[2] /
                                   sqrt(pow(e[1] * e[2], 2) + pow(t[0] * e[2], 2) + pow(t[0] * t[2] - e[1] * t[1], 2))
                             : e[0];
    return a == 1 && w->dim == 3 ? e[1] * e[2] / hypot(e[2], t[2]) : e[a];
}

static sp_status fill_lattice(const sp_work *w, lattice *l, sp_error *err) {
    double r = 0, most = pow(8.0 * w->n + 64, 1.0 / w->dim);
    for (int32_t k = 0; k < w->n; k++)
        r = fmax(r, w->grain[k].r);
    int64_t cells = 1;
    l->cell = sp_work_cell(w);
    for (int a = 0; a < 3; a++) {
        l->n[a] = a < w->dim ? (int)fmax(1, fmin(floor(thickness(w, a) / (2.0001 * r)), most)) : 1;
        cells *= l->n[a];
    }
    l->start = sp_alloc((size_t)cells + 2, sizeof *l->start);
    l->grain = sp_alloc((size_t)w->n, sizeof *l->grain);
    if (!l->start || !l->grain)
        return sp_fail_memory(err, ((size_t)cells + (size_t)w->n) * sizeof *l->start);
    for (int pass = 0; pass < 2; pass++) {
        for (int32_t k = 0; k < w->n; k++) {
            const int c[3] = {cell_along(w, l, k, 0), cell_along(w, l, k, 1), cell_along(w, l, k, 2)};
            if (pass == 0)
                l->start[cell_of(l, c) + 2]++;
            else
                l->grain[l->start[cell_of(l, c) + 1]++] = k;
        }
        for (int64_t c = 0; pass == 0 && c < cells; c++)
            l->start[c + 1 + 1] += l->start[c + 1];
    }
    return SP_OK;
}

/* The cells along an axis that are next to cell c, each once. */
static int near_along(const sp_work *w, const lattice *l, int c, int a, int out[3]) {
    const int n = l->n[a];
    int count = 0;
    for (int k = c - 1; k <= c + 1; k++) {
        const bool wraps = a < w->dim && w->periodic[a];
        if (!wraps && (k < 0 || k >= n))
            continue;
        const int cell = (k + n) % n;
        bool known = false;
        for (int q = 0; q < count; q++)
            known = known || out[q] == cell;
        if (!known)
            out[count++] = cell;
    }
    return count;
}

/* ---- pairs ----------------------------------------------------------------------------------------------------- */

static bool goes_across(const sp_work *w, int32_t i, int32_t j) {
    const int up = w->dim - 1;
    return w->cut && fabs(w->grain[j].x[up] - w->grain[i].x[up]) > 0.5 * w->edge[up];
}

/* Adds the contacts of a grain in a cell, or only counts them. */
static sp_status touch_cell(sp_work *w, const lattice *l, int32_t i, int64_t cell, int64_t *count, sp_error *err) {
    sp_status status = SP_OK;
    for (int32_t k = l->start[cell]; status == SP_OK && k < l->start[cell + 1]; k++) {
        const int32_t j = l->grain[k];
        if (j <= i)
            continue;
        sp_raw_contact c = unknown;
        c.i = i;
        c.j = j;
        sp_work_geometry(w, &c);
        if (!(c.depth > 0))
            continue;
        if (count)
            *count += !goes_across(w, i, j);
        else if (goes_across(w, i, j))
            w->report.across++;
        else
            status = sp_work_add(w, &c, err);
    }
    return status;
}

static sp_status touch(sp_work *w, int64_t *touching, sp_error *err) {
    lattice l = {0};
    sp_status status = fill_lattice(w, &l, err);
    for (int32_t i = 0; status == SP_OK && i < w->n; i++) {
        int near[3][3], count[3];
        for (int a = 0; a < 3; a++)
            count[a] = near_along(w, &l, cell_along(w, &l, i, a), a, near[a]);
        for (int p = 0; p < count[0]; p++)
            for (int q = 0; q < count[1]; q++)
                for (int r = 0; status == SP_OK && r < count[2]; r++) {
                    const int c[3] = {near[0][p], near[1][q], near[2][r]};
                    status = touch_cell(w, &l, i, cell_of(&l, c), touching, err);
                }
    }
    sp_free(l.start);
    sp_free(l.grain);
    return status;
}

sp_status sp_touch_grains(sp_work *w, sp_error *err) { return touch(w, NULL, err); }

sp_status sp_touch_count(sp_work *w, int64_t *pairs, sp_error *err) {
    *pairs = 0;
    return touch(w, pairs, err);
}

sp_status sp_touch_walls(sp_work *w, sp_error *err) {
    sp_status status = SP_OK;
    for (int side = 0; side < 6; side++)
        for (int32_t i = 0; status == SP_OK && i < w->n && w->has_wall[side]; i++) {
            sp_raw_contact c = unknown;
            c.i = i;
            c.j = SP_BOTTOM - side;
            sp_work_geometry(w, &c);
            if (c.depth > 0)
                status = sp_work_add(w, &c, err);
        }
    return status;
}
