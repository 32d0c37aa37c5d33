/* Makes the packing, and says what came out. */
#include "base/base.h"
#include "base/vector.h"
#include "foreign/work.h"
#include "packing/contact.h"

#include <math.h>
#include <string.h>

static double into(double x, double period) {
    if (x >= 0 && x < period)
        return x + 0.0;
    double inside = fmod(x, period);
    if (inside < 0)
        inside += period;
    return inside < period ? inside + 0.0 : 0.0;
}

/* ---- masses ---------------------------------------------------------------------------------------------------- */

/* Masses of spheres of one density are left out: that density is the unit. */
static sp_status give_masses(const sp_work *w, sp_packing *p, sp_error *err) {
    double low = INFINITY, high = 0;
    for (int32_t k = 0; k < w->n; k++) {
        const sp_raw_grain *g = &w->grain[k];
        if (!isfinite(g->mass))
            return SP_OK;
        const double density = g->mass / grain_mass(g->r);
        const bool sphere = isnan(g->inertia) || fabs(g->inertia / (0.4 * g->mass * g->r * g->r) - 1) < 1e-6;
        low = sphere ? fmin(low, density) : 0;
        high = fmax(high, density);
    }
    const bool one = high - low <= 1e-6 * high;
    if (one && (!(w->o->material.young > 0) || fabs(high - 1) < 1e-6))
        return SP_OK;
    sp_status status = sp_packing_alloc_masses(p, err);
    for (int32_t k = 0; status == SP_OK && k < w->n; k++) {
        const sp_raw_grain *g = &w->grain[k];
        p->mass[k] = g->mass;
        p->inertia[k] = isnan(g->inertia) ? 0.4 * g->mass * g->r * g->r : g->inertia;
    }
    return status;
}

/* ---- pressure -------------------------------------------------------------------------------------------------- */

/* Mean normal stress along the axis up: sum of forces times branches over the volume. */
static double stress(const sp_work *w, const sp_packing *p) {
    const int up = w->dim - 1;
    double sum = 0;
    for (int32_t k = 0; k < w->found; k++) {
        const sp_raw_contact *c = &w->contact[k];
        double d[3] = {0, 0, 0};
        if (c->j >= 0)
            sp_work_separation(w, c->i, c->j, d);
        else
            d[up] = c->n[up] * w->grain[c->i].r;
        sum += (c->fn * c->n[up] - c->ft[up]) * d[up];
    }
    return sum / (sp_packing_wall_area(p) * sp_packing_height(p));
}

static sp_status find_pressure(sp_work *w, sp_packing *p, sp_error *err) {
    const double area = sp_packing_wall_area(p), given = w->o->pressure * w->force / (w->scale * w->scale);
    double wall[2] = {0, 0};
    const int up = w->dim - 1;
    for (int32_t k = 0; k < w->found; k++) {
        const sp_raw_contact *c = &w->contact[k];
        const double f = c->ft[up] - c->fn * c->n[up]; /* upward force on the grain */
        if (c->j < 0)
            wall[c->j == SP_TOP] += c->j == SP_TOP ? -f : f;
    }
    w->report.bottom_pressure = wall[0] > 0 ? wall[0] / area : NAN;
    w->report.top_pressure = wall[1] > 0 ? wall[1] / area : NAN;
    const double low = w->report.bottom_pressure, high = w->report.top_pressure;
    const double walls = isfinite(low) && isfinite(high) ? 0.5 * (low + high) : isfinite(low) ? low : high;
    p->pressure = isfinite(given) ? given : isfinite(walls) ? walls : stress(w, p);
    if (!(p->pressure > 0))
        return sp_fail_key(
            err, SP_EINVAL, "pressure",
            ": there is no force on the walls and none between grains (%d contacts); must be given: --set "
            "pressure=P",
            w->found);
    if (!isfinite(given) && !isfinite(walls))
        sp_work_note(w, "no contact with a wall: the pressure %.6g is the stress along %c from the contacts",
                     p->pressure, "xyz"[w->axis[w->dim - 1]]);
    if (fabs(low / high - 1) > 1e-3)
        sp_work_note(w,
                     "the pressures on the walls differ: %.6g below, %.6g above (weight, motion, or contacts missing)",
                     low, high);
    if (isfinite(given) && fabs(walls / given - 1) > 1e-2)
        sp_work_note(w, "the pressure on the walls is %.6g, not the given %.6g", walls, given);
    return SP_OK;
}

/* ---- the packing ----------------------------------------------------------------------------------------------- */

static sp_status give_grains(const sp_work *w, sp_packing *p, sp_error *err) {
    const int up = w->dim - 1;
    for (int32_t k = 0; k < w->n; k++) {
        const sp_raw_grain *g = &w->grain[k];
        p->r[k] = g->r;
        for (int a = 0; a < w->dim; a++)
            p->x[3 * (size_t)k + (size_t)a] = a < up || w->periodic[up] ? into(g->x[a], w->edge[a]) : g->x[a] + 0.0;
        if (!(g->x[up] >= 0 && g->x[up] <= w->edge[up]) && !w->periodic[up])
            return sp_sheet_fail(
                &w->grains, g->row,
                sp_role_find((sp_work *)w, &w->grains, "id").index >= 0
                    ? sp_role_find((sp_work *)w, &w->grains, "id").index
                    : 0,
                "between the walls: its centre is outside of them; give --set bottom=, top=, or --types", err);
    }
    return SP_OK;
}

static void give_contacts(sp_work *w, sp_packing *p) {
    for (int32_t k = 0; k < w->found; k++) {
        const sp_raw_contact *r = &w->contact[k];
        sp_contact *c = &p->contacts[k];
        *c = (sp_contact){.i = r->i, .j = r->j, .overlap = r->overlap, .fn = r->fn, .kn = r->kn, .kt = r->kt};
        for (int a = 0; a < 3; a++) {
            c->n[a] = r->n[a] + 0.0;
            c->ft[a] = w->friction > 0 ? r->ft[a] + 0.0 : 0;
        }
        w->report.wall_contacts += r->j < 0;
    }
    w->report.grains = p->n;
    w->report.contacts = p->n_contacts;
    sp_packing_sort(p);
}

/* Sums the squares of the net forces on grains that carry force, and finds the largest. sign: of tangential forces. */
static sp_status net_forces(const sp_work *w, const sp_packing *p, double sign, double *squares, double *largest,
                            sp_error *err) {
    double *net = sp_alloc((size_t)p->n * 3, sizeof *net);
    uint8_t *rattler = sp_alloc((size_t)p->n, 1);
    int32_t rattlers;
    sp_status status = net && rattler ? sp_packing_rattlers(p, 1e-4, rattler, NULL, &rattlers, err)
                                      : sp_fail_memory(err, (size_t)p->n * 25);
    *squares = *largest = 0;
    for (int32_t k = 0; status == SP_OK && k < p->n_contacts; k++) {
        const sp_contact *c = &p->contacts[k];
        for (int a = 0; a < 3; a++) {
            const double f = sign * c->ft[a] - c->fn * c->n[a];
            net[3 * (size_t)c->i + (size_t)a] += f;
            if (c->j >= 0)
                net[3 * (size_t)c->j + (size_t)a] -= f;
        }
    }
    for (int32_t k = 0; status == SP_OK && k < p->n; k++) {
        const double length = length3(net + 3 * (size_t)k);
        if (rattler[k] || (w->grain[k].boundary && !w->o->walls))
            continue;
        *squares += length * length;
        *largest = fmax(*largest, length);
    }
    sp_free(net);
    sp_free(rattler);
    return status;
}

static sp_status check_balance(sp_work *w, const sp_packing *p, sp_error *err) {
    double mean = 0, squares, turned, largest, other;
    for (int32_t k = 0; k < p->n_contacts; k++)
        mean += p->contacts[k].fn / p->n_contacts;
    sp_status status = net_forces(w, p, 1, &squares, &largest, err);
    if (status == SP_OK)
        status = net_forces(w, p, -1, &turned, &other, err);
    w->report.balance = mean > 0 ? largest / mean : NAN;
    if (status == SP_OK && turned < 0.25 * squares)
        sp_work_note(w,
                     "with the other sign of the tangential forces the grains balance better (%.2g of the mean force): "
                     "--columns ft_x=-COLUMN,... (or ft=-COLUMN) turns them",
                     other / mean);
    return status;
}

static sp_status audit(sp_work *w, const sp_packing *p, sp_error *err) {
    sp_audit a;
    sp_status status = sp_packing_audit(p, 1e-4, &a, err);
    if (status != SP_OK)
        return status;
    if (a.missing > 0 && w->report.overlap_error < 0.01)
        sp_work_note(w, "%d pairs overlap and are not listed as contacts", a.missing);
    if (a.coulomb_excess > 1e-6 && p->friction > 0)
        sp_work_note(w, "a tangential force is %.4g times friction times the normal force: is friction = %g right?",
                     1 + a.coulomb_excess, p->friction);
    if (a.force_residual < 1e-3 * a.torque_residual)
        sp_work_note(w,
                     "torques balance within %.2g p d^3 only, forces within %.2g p d^2: tangential forces act at the "
                     "distance R here, at R - overlap/2 in LAMMPS and LIGGGHTS",
                     a.torque_residual, a.force_residual);
    for (int side = 0; side < 2; side++) {
        bool any = false;
        for (int32_t k = 0; k < p->n_contacts; k++)
            any = any || p->contacts[k].j == SP_BOTTOM - side;
        if (!any)
            sp_work_note(w, "no grain touches the %s wall%s", side ? "upper" : "lower",
                         w->periodic[w->dim - 1] ? ""
                         : side                  ? "; --set top=PLACE moves it"
                                                 : "; --set bottom=PLACE moves it");
    }
    return SP_OK;
}

sp_status sp_finish(sp_work *w, sp_packing *out, sp_error *err) {
    sp_packing p = sp_packing_none();
    sp_status status = sp_packing_alloc(&p, w->dim, w->n, w->found, err);
    for (int a = 0; status == SP_OK && a < w->dim; a++)
        p.box[a] = w->edge[a];
    p.friction = w->friction;
    p.poisson = w->poisson;
    p.wall = w->wall;
    p.material = w->report.material;
    if (status == SP_OK)
        status = give_grains(w, &p, err);
    if (status == SP_OK)
        status = give_masses(w, &p, err);
    if (status == SP_OK)
        give_contacts(w, &p);
    if (status == SP_OK)
        status = find_pressure(w, &p, err);
    if (status == SP_OK && sp_packing_check(&p, err) != SP_OK)
        status = sp_fail_prefix(err, "%s", w->path);
    if (status == SP_OK)
        status = check_balance(w, &p, err);
    if (status == SP_OK)
        status = audit(w, &p, err);
    if (status == SP_OK)
        *out = p;
    else
        sp_packing_free(&p);
    return status;
}
