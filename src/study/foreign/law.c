/* Completes contacts: overlaps from forces or forces from overlaps, whichever the file gives more exactly, and checks
 * one against the other where both are given. */
#include "base/base.h"
#include "base/vector.h"
#include "foreign/work.h"
#include "packing/contact.h"
#include "packing/geometry.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static double stiffness_of(const sp_work *w, const sp_raw_contact *c, sp_wall wall) {
    const double r = w->grain[c->i].r;
    return c->j < 0 ? contact_wall_stiffness(r, wall) : contact_stiffness(r, w->grain[c->j].r);
}

/* The overlap that the file gives, or that the positions give. */
static double overlap_of(const sp_raw_contact *c) { return isnan(c->overlap) ? c->depth : c->overlap; }

static int by_value(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* ---- forces against overlaps ----------------------------------------------------------------------------------- */

/* Fn over Hertz's law, of contacts whose overlap is known. */
typedef struct comparison {
    size_t count;
    double median, low, high;
    double spread; /* largest deviation from the median, over it */
} comparison;

static comparison compare(const sp_work *w, bool at_walls, sp_wall wall, double *ratio) {
    comparison c = {.median = NAN, .spread = NAN};
    double mean = 0;
    for (int32_t k = 0; k < w->found; k++)
        mean += isnan(w->contact[k].fn) ? 0 : w->contact[k].fn / w->found;
    for (int32_t k = 0; k < w->found; k++) {
        const sp_raw_contact *r = &w->contact[k];
        const double overlap = overlap_of(r);
        if ((r->j < 0) != at_walls || !(r->fn > 0.01 * mean) || isnan(overlap) || fabs(overlap) <= 1000 * w->place)
            continue;
        ratio[c.count++] = overlap > 0 ? r->fn / contact_force(stiffness_of(w, r, wall), overlap) : INFINITY;
    }
    if (c.count == 0)
        return c;
    qsort(ratio, c.count, sizeof *ratio, by_value);
    c.median = ratio[c.count / 2];
    c.low = ratio[0];
    c.high = ratio[c.count - 1];
    c.spread = fmax(c.high / c.median - 1, 1 - c.low / c.median);
    return c;
}

static bool fits(const comparison *c) { return fabs(c->median - 1) <= 1e-3 && c->spread <= 0.02; }

/* Forces and overlaps of grains must follow Hertz's law. */
static sp_status check_grains(sp_work *w, double *ratio, sp_error *err) {
    const comparison c = compare(w, false, w->wall, ratio);
    w->report.hertz = c.median;
    w->report.hertz_spread = c.spread;
    if (c.count == 0 || fits(&c))
        return SP_OK;
    if (c.spread <= 1e-3)
        return sp_fail(
            err, SP_EREFUSED,
            "%s: all normal forces are %.6g times Hertz's at the overlaps; must be 1: E or the unit of forces "
            "is wrong by this factor (--material E=..., --force-unit)",
            w->path, c.median);
    return sp_fail(
        err, SP_EREFUSED,
        "%s: normal forces are %.4g .. %.4g times Hertz's at the overlaps; must be 1: are E, radii and units "
        "right? For another contact law give stiffnesses, --kn or columns kn kt",
        w->path, c.low, c.high);
}

/* ---- walls ----------------------------------------------------------------------------------------------------- */

/* The kind of wall that the program of this form has. */
static sp_wall usual_wall(const sp_work *w) {
    if (w->o->wall >= 0)
        return (sp_wall)w->o->wall;
    if (w->form == SP_FORM_LAMMPS_DATA || w->form == SP_FORM_LAMMPS_DUMP || w->form == SP_FORM_LIGGGHTS)
        return SP_WALL_ELASTIC;
    return w->form == SP_FORM_YADE ? SP_WALL_GRAIN : SP_WALL_RIGID;
}

/* Walls of none of our kinds whose forces follow Hertz's law with another modulus: each contact keeps its stiffness,
 * dF/d(overlap) = 3/2 F/overlap. */
static void keep_stiffness(sp_work *w, double factor) {
    for (int32_t k = 0; k < w->found; k++) {
        sp_raw_contact *c = &w->contact[k];
        if (c->j >= 0 || !(overlap_of(c) > 0) || !(c->fn > 0))
            continue;
        c->overlap = overlap_of(c);
        c->kn = 1.5 * c->fn / c->overlap;
        c->kt = c->kn * contact_eta(w->poisson);
    }
    sp_work_note(
        w,
        "walls: %.6g times as stiff as elastic ones; contacts with them keep this stiffness, so that the packing "
        "is no longer Hertz's (--set wall=elastic makes it so)",
        factor);
}

/* The kind of wall that forces and overlaps fit, if both are known and none is given. */
static sp_status choose_wall(sp_work *w, double *ratio, sp_error *err) {
    w->wall = usual_wall(w);
    comparison c = compare(w, true, w->wall, ratio);
    if (w->o->wall >= 0) {
        for (int32_t k = 0; k < w->found && c.count > 0 && !fits(&c); k++)
            if (w->contact[k].j < 0 && w->contact[k].fn > 0)
                w->contact[k].overlap = contact_overlap(stiffness_of(w, &w->contact[k], w->wall), w->contact[k].fn);
        return SP_OK;
    }
    for (int k = 0; k < 3 && c.count > 0; k++) {
        const comparison one = compare(w, true, (sp_wall)k, ratio);
        if (!fits(&one))
            continue;
        w->wall = (sp_wall)k;
        sp_work_note(w, "walls: %s, by their forces and overlaps", sp_wall_names[k]);
        return SP_OK;
    }
    c = compare(w, true, SP_WALL_ELASTIC, ratio);
    if (c.count > 0 && c.spread > 0.02)
        return sp_fail(
            err, SP_EREFUSED,
            "%s: normal forces of walls are %.4g .. %.4g times Hertz's at the overlaps; must be one number: "
            "--set bottom=PLACE and top=PLACE correct the overlaps, --set wall=KIND takes them from the forces",
            w->path, c.low, c.high);
    if (c.count > 0)
        keep_stiffness(w, c.median);
    else if (w->cell != SP_CELL_PERIODIC)
        sp_work_note(w, "walls: %s (--set wall=rigid|grain|elastic chooses)", sp_wall_names[w->wall]);
    return SP_OK;
}

static double mean_overlap(const sp_work *w) {
    double sum = 0;
    int32_t count = 0;
    for (int32_t k = 0; k < w->found; k++)
        if (overlap_of(&w->contact[k]) > 0) {
            sum += overlap_of(&w->contact[k]);
            count++;
        }
    return count > 0 ? sum / count : NAN;
}

/* How many digits coordinates need for overlaps within a thousandth. */
static sp_status fail_digits(const sp_work *w, double mean, sp_error *err) {
    double largest = 0;
    int digits = 0;
    const sp_place x = sp_role_find((sp_work *)w, &w->grains, "x");
    for (int32_t k = 0; k < w->n; k++)
        for (int a = 0; a < w->dim; a++)
            largest = fmax(largest, fabs(w->grain[k].x[a]));
    digits = (int)ceil(log10(largest / (1e-3 * mean))) + 1;
    return sp_fail(
        err, SP_EREFUSED,
        "%s: positions have %d digits, which makes overlaps of %.3g d wrong by %.3g d; %d digits are needed "
        "(LAMMPS: dump_modify ID format float %%.17g), or contacts with their forces; --set digits=exact if the "
        "numbers are exact",
        w->path, w->grains.digits[x.index], mean, w->place, digits < 17 ? digits : 17);
}

/* ---- springs --------------------------------------------------------------------------------------------------- */

static sp_status complete_spring(sp_work *w, sp_raw_contact *c, sp_error *err) {
    const double own = w->o->kn * w->stiffness;
    c->kn = isnan(c->kn) ? own : c->kn;
    if (!(c->kn > 0))
        return sp_fail(err, SP_EFORMAT,
                       "%s: a contact of grain %lld has the stiffness %g; must be positive: --kn, or a "
                       "column kn",
                       w->path, (long long)w->grain[c->i].id, c->kn);
    if (isnan(c->kt))
        c->kt = c->kn * (isnan(w->o->kt_ratio) ? contact_eta(w->poisson) : w->o->kt_ratio);
    if (isnan(c->fn)) {
        c->overlap = fmax(overlap_of(c), 0);
        c->fn = c->kn * c->overlap;
    } else if (isnan(c->overlap)) {
        c->overlap = c->fn / c->kn;
    }
    return SP_OK;
}

/* ---- all ------------------------------------------------------------------------------------------------------- */

/* Overlaps of contacts with forces follow from these, or from the positions. */
static void complete_hertz(sp_work *w, sp_raw_contact *c, bool from_forces) {
    const double e = stiffness_of(w, c, w->wall), given = overlap_of(c);
    if (c->kn > 0)
        return;
    c->kn = c->kt = 0;
    if (!isnan(c->fn) && (from_forces || !(given > 0)))
        c->overlap = contact_overlap(e, c->fn);
    else
        c->overlap = fmax(given, 0);
    if (isnan(c->fn))
        c->fn = contact_force(e, c->overlap);
}

static void note_wall_forces(sp_work *w) {
    int32_t unknown = 0;
    for (int32_t k = 0; k < w->found; k++)
        unknown += w->contact[k].j < 0 && isnan(w->contact[k].fn);
    if (w->has_forces && unknown > 0)
        sp_work_note(w, "%d forces of walls are not in the file: from the overlaps, without tangential forces",
                     unknown);
}

static sp_status complete_all(sp_work *w, double *ratio, sp_error *err) {
    bool listed = false;
    for (int32_t k = 0; k < w->found; k++) {
        w->springs = w->springs || isfinite(w->contact[k].kn);
        listed = listed || !isnan(w->contact[k].overlap);
    }
    w->springs = w->springs || isfinite(w->o->kn);
    sp_status status = SP_OK;
    w->wall = usual_wall(w);
    if (w->springs) {
        for (int32_t k = 0; status == SP_OK && k < w->found; k++)
            status = complete_spring(w, &w->contact[k], err);
        return status;
    }
    const double mean = mean_overlap(w), noise = listed ? 0 : w->place / mean;
    w->report.overlap_error = noise;
    const bool from_forces = w->has_forces && !(noise <= 1e-6 || noise <= w->force_place);
    if (!w->has_forces && noise > 0.01)
        return fail_digits(w, mean, err);
    if (from_forces)
        sp_work_note(w,
                     "overlaps: from the normal forces by Hertz's law; the digits of the positions give them within "
                     "%.2g only (LAMMPS: dump_modify ID format float %%.17g)",
                     noise);
    if (w->has_forces)
        status = check_grains(w, ratio, err);
    note_wall_forces(w);
    if (status == SP_OK)
        status = choose_wall(w, ratio, err);
    for (int32_t k = 0; status == SP_OK && k < w->found; k++)
        complete_hertz(w, &w->contact[k], from_forces);
    return status;
}

/* The tangential force has no part along n, but for rounding. */
static void clean_tangent(sp_raw_contact *c) {
    for (int a = 0; a < 3; a++)
        c->ft[a] = isnan(c->ft[a]) ? 0 : c->ft[a] + 0.0;
    const double along = dot3(c->ft, c->n);
    for (int a = 0; a < 3 && along != 0; a++)
        c->ft[a] -= along * c->n[a];
}

sp_status sp_law_complete(sp_work *w, sp_error *err) {
    const sp_import_options *o = w->o;
    w->poisson = isfinite(o->poisson) ? o->poisson : o->material.young > 0 ? o->material.poisson : 0;
    if (!isfinite(o->friction))
        return sp_fail_key(
            err, SP_EINVAL, "friction",
            ": no file says it; must be given, --set friction=MU (0: no tangential forces, no rotations)");
    w->friction = o->friction;
    double *ratio = sp_alloc((size_t)w->found, sizeof *ratio);
    sp_status status = ratio ? complete_all(w, ratio, err) : sp_fail_memory(err, (size_t)w->found * 8);
    sp_free(ratio);
    for (int32_t k = 0; status == SP_OK && k < w->found; k++)
        clean_tangent(&w->contact[k]);
    if (status == SP_OK && w->has_ft && !(w->friction > 0))
        sp_work_note(w, "tangential forces are left out, for friction = 0");
    if (status == SP_OK && !w->has_ft && w->friction > 0)
        sp_work_note(w, "tangential forces are not known: 0");
    return status;
}
