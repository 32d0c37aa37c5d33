/* Makes the packing, and says what came out. */
#include "base/base.h"
#include "base/vector.h"
#include "foreign/work.h"
#include "packing/contact.h"
#include "packing/geometry.h"
#include "store/exchange.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

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
        low = sphere ? fmin(low, density) : -INFINITY;
        high = fmax(high, density);
    }
    const double place = 1e-6 + fmin(10 * w->mass_place, 1e-3);
    if (high - low <= place * high && (!(w->o->material.young > 0) || fabs(high - 1) < place))
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

/* Mean of the normal stresses, as sp_packing_audit has it: sum of F.r over the volume and the dimension. */
static double mean_stress(const sp_packing *p) {
    double sum = 0;
    for (int32_t k = 0; k < p->n_contacts; k++) {
        const sp_contact *c = &p->contacts[k];
        sum += c->fn * (p->r[c->i] - c->overlap + (c->j >= 0 ? p->r[c->j] : 0));
    }
    return sum / (p->dim * sp_packing_volume(p));
}

static double weight_of(const sp_packing *p, int32_t i) {
    return p->gravity * (p->mass ? p->mass[i] : grain_mass(p->r[i]));
}

static sp_status fail_pressure(const sp_work *w, sp_error *err) {
    return sp_fail_key(
        err, SP_EINVAL, "pressure",
        ": there is no force on the walls and none between grains (%d contacts); must be given: --set pressure=P",
        w->found);
}

/* The pressure in a periodic cell or a box. */
static sp_status find_mean_pressure(sp_work *w, sp_packing *p, sp_error *err) {
    const double given = w->o->pressure * w->force / (w->scale * w->scale), mean = mean_stress(p);
    char text[2][SP_WORK_TEXT];
    w->report.bottom_pressure = w->report.top_pressure = NAN;
    p->pressure = isfinite(given) ? given : mean;
    if (!(p->pressure > 0))
        return fail_pressure(w, err);
    if (isfinite(given) && fabs(mean / given - 1) > 1e-2)
        sp_work_note(w, "the mean of the normal stresses is %s, not the given %s", sp_work_pressure(w, mean, text[0]),
                     sp_work_pressure(w, given, text[1]));
    return SP_OK;
}

static sp_status find_pressure(sp_work *w, sp_packing *p, sp_error *err) {
    const double area = sp_packing_wall_area(p), given = w->o->pressure * w->force / (w->scale * w->scale);
    double wall[2] = {0, 0}, weight = 0;
    char text[2][SP_WORK_TEXT];
    const int up = w->dim - 1;
    for (int32_t k = 0; k < w->found; k++) {
        const sp_raw_contact *c = &w->contact[k];
        const double f = c->ft[up] - c->fn * c->n[up]; /* upward force on the grain */
        if (c->j < 0)
            wall[c->j == SP_TOP] += c->j == SP_TOP ? -f : f;
    }
    w->report.bottom_pressure = wall[0] > 0 ? wall[0] / area : NAN;
    w->report.top_pressure = wall[1] > 0 ? wall[1] / area : NAN;
    for (int32_t i = 0; i < p->n && p->gravity != 0; i++)
        weight += weight_of(p, i);
    const double low = w->report.bottom_pressure - weight / area, high = w->report.top_pressure;
    const double walls = isfinite(low) && isfinite(high) ? 0.5 * (low + high) : isfinite(low) ? low : high;
    p->pressure = isfinite(given) ? given : isfinite(walls) ? walls : stress(w, p);
    if (!(p->pressure > 0))
        return fail_pressure(w, err);
    if (!isfinite(given) && !isfinite(walls))
        sp_work_note(w, "no contact with a wall: the pressure %s is the stress along %c from the contacts",
                     sp_work_pressure(w, p->pressure, text[0]), "xyz"[w->axis[w->dim - 1]]);
    if (fabs(low / high - 1) > 1e-3)
        sp_work_note(w, "the pressures on the walls differ: %s below, %s above (weight, motion, or contacts missing)",
                     sp_work_pressure(w, low, text[0]), sp_work_pressure(w, high, text[1]));
    if (isfinite(given) && fabs(walls / given - 1) > 1e-2)
        sp_work_note(w, "the pressure on the walls is %s, not the given %s", sp_work_pressure(w, walls, text[0]),
                     sp_work_pressure(w, given, text[1]));
    return SP_OK;
}

/* ---- the packing ----------------------------------------------------------------------------------------------- */

/* The axis on which a grain lies outside of the walls; -1: none. */
static int axis_outside(const sp_work *w, const sp_raw_grain *g) {
    for (int a = w->dim - 1; a >= 0; a--)
        if (!w->periodic[a] && !(g->x[a] >= 0 && g->x[a] <= w->edge[a]))
            return a;
    return -1;
}

/* Says where the walls are taken to be, and whether anything touches them: loose grains have no walls to find. */
static sp_status fail_outside(const sp_work *w, const sp_raw_grain *g, sp_error *err) {
    const int up = axis_outside(w, g);
    const char axis[2] = {"xyz"[w->axis[up]], '\0'};
    const double low = w->low[up] / w->scale, high = (w->low[up] + w->edge[up]) / w->scale;
    const int32_t first = sp_work_wall(w, up, -1);
    const char *const *name = &sp_side_names[-1 - first];
    int32_t outside = 0, touching[2] = {0, 0};
    char rule[400];
    for (int32_t k = 0; k < w->n; k++)
        outside += axis_outside(w, &w->grain[k]) == up;
    for (int32_t k = 0; k < w->found; k++)
        if (w->contact[k].j == first || w->contact[k].j == first - 1)
            touching[w->contact[k].j != first]++;
    snprintf(rule, sizeof rule,
             "between the walls, which are taken to be at %.8g and %.8g. Outside of them are %d of %d grains, and %d "
             "touch the %s wall, %d the %s: %sgive --set %s= and %s=, or --types",
             low, high, outside, w->n, touching[0], name[0], touching[1], name[1],
             touching[0] + touching[1] <= 2 ? "is this packing under pressure? If so, " : "", name[0], name[1]);
    return sp_sheet_fail(&w->grains, g->row, sp_role_find((sp_work *)w, &w->grains, axis).index, rule, err);
}

static sp_status give_grains(const sp_work *w, sp_packing *p, sp_error *err) {
    for (int32_t k = 0; k < w->n; k++) {
        const sp_raw_grain *g = &w->grain[k];
        p->r[k] = g->r;
        for (int a = 0; a < w->dim; a++)
            p->x[3 * (size_t)k + (size_t)a] =
                w->periodic[a] && w->cell == SP_CELL_PISTON ? sp_wrap(g->x[a], w->edge[a]) : g->x[a] + 0.0;
        sp_wrap_grain(p, p->x + 3 * (size_t)k);
        if (axis_outside(w, g) >= 0)
            return fail_outside(w, g, err);
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
        if (w->dim == 2) { /* a vector that our tables give back with all bits */
            const double along = sp_tangent_scalar(c->n, c->ft);
            sp_tangent_vector(c->n, along, c->ft);
        }
        w->report.wall_contacts += r->j < 0;
    }
    w->report.grains = p->n;
    w->report.contacts = p->n_contacts;
    sp_packing_sort(p);
}

static bool is_near(double a, double b) { return fabs(a - b) <= 1e-12 * fabs(b); }

/* Stiffnesses and masses that are those of Hertzian spheres anyway, as in our own CSV, say nothing new. */
static void forget_usual(sp_packing *p) {
    bool spheres = p->mass != NULL, hertz = true;
    for (int32_t i = 0; i < p->n && spheres; i++)
        spheres = is_near(p->mass[i], grain_mass(p->r[i])) && is_near(p->inertia[i], grain_inertia(p->r[i]));
    if (spheres) {
        sp_free(p->mass);
        sp_free(p->inertia);
        p->mass = p->inertia = NULL;
    }
    for (int32_t k = 0; k < p->n_contacts && hertz; k++) {
        const sp_contact *c = &p->contacts[k];
        const double kn = contact_normal_stiffness(contact_stiffness_in(p, c->i, c->j), c->overlap);
        hertz = c->kn > 0 && is_near(c->kn, kn) && (is_near(c->kt, contact_eta(p->poisson) * kn) || !(p->friction > 0));
    }
    for (int32_t k = 0; k < p->n_contacts && hertz; k++)
        p->contacts[k].kn = p->contacts[k].kt = 0;
}

/* Net forces and torques over R of all grains, six numbers each. sign: of tangential forces. */
static void add_forces(const sp_packing *p, double sign, double *net) {
    for (int32_t k = 0; k < p->n_contacts; k++) {
        const sp_contact *c = &p->contacts[k];
        double turn[3];
        cross3(c->n, c->ft, turn);
        for (int a = 0; a < 3; a++) {
            const double f = sign * c->ft[a] - c->fn * c->n[a];
            net[6 * (size_t)c->i + (size_t)a] += f;
            net[6 * (size_t)c->i + 3 + (size_t)a] += turn[a];
            if (c->j < 0)
                continue;
            net[6 * (size_t)c->j + (size_t)a] -= f;
            net[6 * (size_t)c->j + 3 + (size_t)a] += turn[a];
        }
    }
}

/* What is not balanced: the largest net force and torque over R, and the sum of squares of the forces. */
typedef struct imbalance {
    double force, torque, squares;
} imbalance;

static sp_status find_imbalance(const sp_work *w, const sp_packing *p, double sign, const uint8_t *rattler,
                                imbalance *out, sp_error *err) {
    double *net = sp_alloc((size_t)p->n * 6, sizeof *net);
    if (!net)
        return sp_fail_memory(err, (size_t)p->n * 48);
    add_forces(p, sign, net);
    for (int32_t k = 0; k < p->n && p->gravity != 0; k++)
        net[6 * (size_t)k + (size_t)p->dim - 1] -= weight_of(p, k);
    *out = (imbalance){0};
    for (int32_t k = 0; k < p->n; k++) {
        if (rattler[k] || (w->grain[k].boundary && !w->o->walls))
            continue;
        const double force = length3(net + 6 * (size_t)k);
        out->squares += force * force;
        out->force = fmax(out->force, force);
        out->torque = fmax(out->torque, length3(net + 6 * (size_t)k + 3));
    }
    sp_free(net);
    return SP_OK;
}

static sp_status check_balance(sp_work *w, const sp_packing *p, sp_error *err) {
    double mean = 0;
    int32_t rattlers;
    imbalance now, turned;
    uint8_t *rattler = sp_alloc((size_t)p->n, 1);
    if (!rattler)
        return sp_fail_memory(err, (size_t)p->n);
    for (int32_t k = 0; k < p->n_contacts; k++)
        mean += p->contacts[k].fn / p->n_contacts;
    sp_status status = sp_packing_rattlers(p, 1e-4, rattler, NULL, &rattlers, err);
    if (status == SP_OK)
        status = find_imbalance(w, p, 1, rattler, &now, err);
    if (status == SP_OK)
        status = find_imbalance(w, p, -1, rattler, &turned, err);
    sp_free(rattler);
    if (status != SP_OK)
        return status;
    w->report.balance = mean > 0 && rattlers < p->n ? now.force / mean : NAN;
    if (rattlers == p->n)
        sp_work_note(w, "all grains are rattlers: no balance of forces can be told%s",
                     p->friction > 0 ? "" : " (friction = 0)");
    else if (now.force > mean && !w->has_ft && w->friction > 0)
        sp_work_note(w, "forces do not balance, perhaps because the tangential forces are missing");
    else if (now.force > mean)
        sp_work_note(w, "forces do not balance: is the file cut short, or are periods, units or signs wrong?");
    if (turned.squares < 0.25 * now.squares)
        sp_work_note(w,
                     "with the other sign of the tangential forces the grains balance better (%.2g of the mean force): "
                     "--columns ft_x=-COLUMN,... (or ft=-COLUMN) turns them",
                     turned.force / mean);
    else if (now.force < 1e-3 * now.torque)
        sp_work_note(
            w,
            "torques over R balance within %.2g of the mean force only: tangential forces act at the distance R "
            "here, at R - overlap/2 in LAMMPS and LIGGGHTS",
            now.torque / mean);
    return SP_OK;
}

/* ---- remarks --------------------------------------------------------------------------------------------------- */

static void remark_friction(sp_work *w, const sp_packing *p) {
    double excess = 0;
    for (int32_t k = 0; k < p->n_contacts && p->friction > 0; k++) {
        const sp_contact *c = &p->contacts[k];
        if (c->fn > 1e-4 * p->pressure)
            excess = fmax(excess, length3(c->ft) / (p->friction * c->fn));
    }
    if (excess > 1 + 1e-6)
        sp_work_note(w, "a tangential force is %.4g times friction times the normal force: is friction = %g right?",
                     excess, p->friction);
}

static void remark_walls(sp_work *w, const sp_packing *p) {
    for (int side = 0; side < 6; side++) {
        bool any = !sp_packing_has_wall(p, SP_BOTTOM - side) || sp_work_wall_axis(w, SP_BOTTOM - side) >= w->dim;
        for (int32_t k = 0; k < p->n_contacts; k++)
            any = any || p->contacts[k].j == SP_BOTTOM - side;
        const char *name = side == 0 ? "lower" : side == 1 ? "upper" : sp_side_names[side];
        if (!any && w->cut)
            sp_work_note(w, "no grain touches the %s wall", name);
        else if (!any)
            sp_work_note(w, "no grain touches the %s wall; --set %s=PLACE moves it", name, sp_side_names[side]);
    }
}

/* Pairs that overlap by the positions and are not in the list of contacts. */
static sp_status remark_missing(sp_work *w, sp_error *err) {
    int64_t pairs, listed = 0;
    if (!w->contacts.file || !(w->report.overlap_error < 0.01))
        return SP_OK;
    sp_status status = sp_touch_count(w, &pairs, err);
    for (int32_t k = 0; k < w->found; k++)
        listed += w->contact[k].j >= 0 && w->contact[k].depth > 0;
    if (status == SP_OK && pairs - listed > pairs / 10)
        return sp_fail(err, SP_EFORMAT,
                       "%s: lists %lld of the %lld pairs that overlap; must list all: is it cut short, or are the "
                       "periods wrong?",
                       w->contacts.file, (long long)listed, (long long)pairs);
    if (status == SP_OK && pairs > listed)
        sp_work_note(w, "%lld pairs overlap and are not listed as contacts", (long long)(pairs - listed));
    return status;
}

sp_status sp_finish(sp_work *w, sp_packing *out, sp_error *err) {
    sp_packing p = sp_packing_none();
    sp_status status = sp_packing_alloc(&p, w->dim, w->n, w->found, err);
    for (int a = 0; status == SP_OK && a < w->dim; a++)
        p.box[a] = w->edge[a];
    memcpy(p.tilt, w->tilt, sizeof p.tilt);
    p.cell = w->cell;
    p.gravity = w->gravity;
    p.friction = w->friction;
    p.poisson = w->poisson;
    p.wall = w->wall;
    p.material = w->report.material;
    if (status == SP_OK)
        status = give_grains(w, &p, err);
    if (status == SP_OK)
        status = give_masses(w, &p, err);
    if (status == SP_OK) {
        give_contacts(w, &p);
        forget_usual(&p);
        status = p.cell == SP_CELL_PISTON ? find_pressure(w, &p, err) : find_mean_pressure(w, &p, err);
    }
    if (status == SP_OK && sp_packing_check(&p, err) != SP_OK)
        status = sp_fail_prefix(err, "%s", w->path);
    if (status == SP_OK)
        status = check_balance(w, &p, err);
    if (status == SP_OK)
        status = remark_missing(w, err);
    if (status == SP_OK) {
        remark_friction(w, &p);
        remark_walls(w, &p);
        *out = p;
    } else
        sp_packing_free(&p);
    return status;
}
