/* Turns the units of the file into d, E* and rho; and estimates what the digits of the positions are worth. */
#include "base/base.h"
#include "foreign/work.h"

#include <math.h>

static double mean_diameter(const sp_work *w) {
    double sum = 0;
    for (int32_t k = 0; k < w->n; k++)
        sum += 2 * w->grain[k].r;
    return sum / w->n;
}

static sp_status check_diameter(const sp_work *w, double mean, sp_error *err) {
    if (mean >= 0.2 && mean <= 5)
        return SP_OK;
    if (!(w->o->material.young > 0))
        return sp_fail(err, SP_EINVAL,
                       "%s: the mean diameter is %.4g; must be 0.2 .. 5, since lengths are in mean diameters, or the "
                       "file's units must be given: --material E=...,nu=...,rho=... for metres, pascals and kg/m^3",
                       w->path, mean);
    return sp_fail(err, SP_EINVAL,
                   "%s: the mean diameter is %.4g times the material's d = %g; must be 0.2 .. 5: give no d for the "
                   "file's mean, or correct --length-unit",
                   w->path, mean, w->o->material.diameter);
}

/* The error of an overlap from the rounding of two positions and two radii, evenly distributed. All coordinates are
 * written with as many digits as the longest of them. */
static double digits_error(sp_work *w) {
    static const char *const name[3] = {"x", "y", "z"};
    const sp_number_sheet *s = &w->grains;
    sp_place at[3];
    int digits = 0;
    double place = 0;
    for (int a = 0; a < w->dim; a++) {
        at[a] = sp_role_find(w, s, name[w->axis[a]]);
        digits = s->digits[at[a].index] > digits ? s->digits[at[a].index] : digits;
    }
    for (int a = 0; a < w->dim; a++) {
        double largest = 0;
        for (int32_t k = 0; k < w->n; k++)
            largest = fmax(largest, fabs(sp_sheet_value(s, w->grain[k].row, at[a].index)));
        const bool fraction = s->name[at[a].index][1] == 's'; /* of the box */
        const double unit = fraction ? s->high[w->axis[a]] - s->low[w->axis[a]] : 1;
        place = fmax(place, unit * sp_digits_place(digits, largest));
    }
    return 0.6 * place;
}

sp_status sp_scale_grains(sp_work *w, sp_error *err) {
    const sp_import_options *o = w->o;
    const bool si = o->material.young > 0;
    const double mean = mean_diameter(w);
    sp_material *m = &w->report.material;
    *m = o->material;
    w->report.mean_diameter = mean;
    if (si && !(m->diameter > 0))
        m->diameter = mean * o->length_unit;
    const double d = si ? m->diameter : 1, modulus = si ? sp_material_modulus(m) : 1, rho = si ? m->density : 1;
    w->scale = o->length_unit / d;
    w->force = o->force_unit / (modulus * d * d);
    w->stiffness = 1 / (modulus * d);
    w->place = o->exact ? 0 : digits_error(w) * w->scale;
    const double mass = o->mass_unit / (rho * d * d * d);
    w->gravity = isfinite(o->gravity) ? o->gravity * w->force / mass : 0;
    for (int32_t k = 0; k < w->n; k++) {
        sp_raw_grain *g = &w->grain[k];
        for (int a = 0; a < 3; a++)
            g->x[a] *= w->scale;
        g->r *= w->scale;
        g->mass *= mass;
        g->inertia *= mass * w->scale * w->scale;
        if (isfinite(o->thickness)) {
            g->mass = 3.14159265358979323846 * g->r * g->r * (o->thickness / d);
            g->inertia = 0.5 * g->mass * g->r * g->r;
        }
    }
    return check_diameter(w, mean * w->scale, err);
}
