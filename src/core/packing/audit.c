/* Checks the physics of a packing, from positions, radii and the contact law alone. */
#include "base/base.h"
#include "base/text.h"
#include "base/vector.h"
#include "packing/contact.h"
#include "packing/geometry.h"

#include <math.h>
#include <sonopack/packing.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

static void wall_vector(const sp_packing *p, const sp_contact *c, double d[3]) {
    const double distance = sp_packing_wall_distance(p, c->i, c->j);
    sp_packing_wall_normal(p, c->i, c->j, d);
    for (int a = 0; a < 3; a++)
        d[a] *= distance;
}

/* Overlap from the positions, and the largest deviation of the stored normal from theirs. */
static double true_overlap(const sp_packing *p, const sp_contact *c, double *turn) {
    double d[3] = {0, 0, 0}, r2 = 0;
    *turn = 0;
    if (c->j >= 0)
        sp_packing_separation(p, c->i, c->j, d);
    else
        wall_vector(p, c, d);
    for (int a = 0; a < 3; a++)
        r2 += d[a] * d[a];
    for (int a = 0; a < 3 && r2 > 0; a++)
        *turn = fmax(*turn, fabs(d[a] / sqrt(r2) - c->n[a]));
    if (!(r2 > 0)) /* centres that coincide have no normal */
        *turn = 1;
    return p->r[c->i] + (c->j >= 0 ? p->r[c->j] : 0) - sqrt(r2);
}

/* Errors of each contact by itself. */
static void audit_contacts(const sp_packing *p, double small, sp_audit *a) {
    double deepest = 0;
    for (int32_t c = 0; c < p->n_contacts; c++)
        deepest = fmax(deepest, p->contacts[c].overlap);
    for (int32_t c = 0; c < p->n_contacts; c++) {
        const sp_contact *k = &p->contacts[c];
        double turn, overlap = true_overlap(p, k, &turn);
        double hertz = k->kn > 0 ? k->fn : contact_force(contact_stiffness_in(p, k->i, k->j), k->overlap);
        double ft = length3(k->ft), limit = contact_mu(p, k) * k->fn;
        a->geometry_residual = fmax(a->geometry_residual, fmax(turn, fabs(overlap - k->overlap) / deepest));
        a->law_residual = fmax(a->law_residual, fabs(hertz - k->fn) / fmax(k->fn, small));
        a->coulomb_excess = fmax(a->coulomb_excess, (ft - limit) / fmax(limit, small));
    }
}

/* Sums over all contacts: on each wall, of all walls on the grains, and of force times branch vector. */
typedef struct sums {
    double wall[6], push[3], trace;
} sums;

static double weight(const sp_packing *p, int32_t i) {
    return p->gravity * (p->mass ? p->mass[i] : grain_mass(p->r[i]));
}

/* force[6 i ..]: net force on grain i, then the sum of n x ft, which is the net torque over R. */
static void sum_on_grains(const sp_packing *p, double *force, sums *s) {
    for (int32_t i = 0; i < p->n && p->gravity != 0; i++)
        force[6 * (size_t)i + (size_t)p->dim - 1] = -weight(p, i);
    for (int32_t c = 0; c < p->n_contacts; c++) {
        const sp_contact *k = &p->contacts[c];
        double turn[3];
        cross3(k->n, k->ft, turn);
        for (int a = 0; a < 3; a++) {
            const double f = k->ft[a] - k->fn * k->n[a];
            force[6 * (size_t)k->i + (size_t)a] += f;
            force[6 * (size_t)k->i + 3 + (size_t)a] += turn[a];
            if (k->j < 0)
                s->push[a] += f;
            if (k->j >= 0) {
                force[6 * (size_t)k->j + (size_t)a] -= f;
                force[6 * (size_t)k->j + 3 + (size_t)a] += turn[a];
            }
        }
        if (k->j < 0)
            s->wall[-1 - k->j] += k->fn;
        s->trace += k->fn * (p->r[k->i] - k->overlap + (k->j >= 0 ? p->r[k->j] : 0));
    }
}

/* Walls under a piston: each carries the pressure, and the bottom the weight of the grains too. Other cells: the mean
 * pressure in the grains, and the balance of all walls: friction at one pair of them bears on the other too. */
static double wall_residual(const sp_packing *p, const sums *s) {
    const double load = p->pressure * sp_packing_wall_area(p);
    double grains = 0;
    for (int32_t i = 0; i < p->n && p->gravity != 0; i++)
        grains += weight(p, i);
    if (p->cell == SP_CELL_PISTON)
        return fmax(fabs(s->wall[1] / load - 1), fabs((s->wall[0] - grains) / load - 1));
    double worst = fabs(s->trace / (p->dim * p->pressure * sp_packing_volume(p)) - 1);
    for (int a = 0; a < 3 && p->cell >= SP_CELL_BOX; a++)
        worst = fmax(worst, fabs(s->push[a] - (a == p->dim - 1 ? grains : 0)) / load);
    return worst;
}

/* A rattler may press on others like any grain, and has to be in balance then. What is left of it may be as large as a
 * contact that does not count as carrying. As all contacts push, a group of grains in balance reaches from wall to
 * wall, or around a periodic cell. */
static sp_status audit_balance(const sp_packing *p, const uint8_t *rattler, double threshold, double unit, sp_audit *a,
                               sp_error *err) {
    sums s = {.trace = 0};
    double *force = sp_alloc((size_t)p->n * 6, sizeof *force);
    if (!force)
        return sp_fail_memory(err, (size_t)p->n * 6 * sizeof *force);
    sum_on_grains(p, force, &s);
    for (size_t i = 0; i < (size_t)p->n; i++) {
        const double slack = rattler[i] ? threshold * p->pressure / unit : 0, r = p->r[i],
                     mass = p->mass ? p->mass[i] : grain_mass(r);
        const double spin = r * r / (p->inertia ? p->inertia[i] : grain_inertia(r));
        const double linear = length3(force + 6 * i) / mass, turning = length3(force + 6 * i + 3) * spin;
        a->acceleration = fmax(a->acceleration, fmax(linear, turning));
        if (p->mass)
            a->inertia_excess = fmax(a->inertia_excess, 1 / (spin * mass) - 1);
        a->force_residual = fmax(a->force_residual, length3(force + 6 * i) / unit - slack);
        a->torque_residual = fmax(a->torque_residual, length3(force + 6 * i + 3) / unit - slack);
    }
    a->wall_residual = wall_residual(p, &s);
    sp_free(force);
    return SP_OK;
}

/* ---- what overlaps but is not listed -------------------------------------------------------------------------- */

typedef struct search {
    const sp_packing *p;
    double slack;
    bool narrow; /* a grain may touch more than one image of another, or of itself */
    int32_t missing;
} search;

/* Whether some period is shorter than two of the largest grains side by side. */
static bool is_narrow(const sp_packing *p) {
    double largest = 0, shortest = INFINITY;
    for (int32_t i = 0; i < p->n; i++)
        largest = fmax(largest, p->r[i]);
    for (int a = 0; a < p->dim; a++)
        if (sp_packing_periodic(p, a))
            shortest = fmin(shortest, p->box[a]);
    return shortest < 4 * largest;
}

/* How many images of a grain at d are closer than reach. The lattice vectors are nearly reduced (tilts are at most half
 * of the edges), so that few multiples of each do. */
static int images_within(const sp_packing *p, const double d[3], double reach, bool narrow) {
    int most[3], found = 0;
    for (int a = 0; a < 3; a++)
        most[a] = narrow && sp_packing_periodic(p, a) ? 3 : 0;
    for (int u = -most[0]; u <= most[0]; u++)
        for (int v = -most[1]; v <= most[1]; v++)
            for (int w = -most[2]; w <= most[2]; w++) {
                const double e[3] = {d[0] + u * p->box[0] + v * p->tilt[0] + w * p->tilt[1],
                                     d[1] + v * p->box[1] + w * p->tilt[2], d[2] + w * p->box[2]};
                found += length3(e) < reach;
            }
    return found;
}

static sp_status check_listed(int32_t i, int32_t j, void *user, sp_error *err) {
    search *s = user;
    const sp_packing *p = s->p;
    double d[3];
    int overlapping;
    (void)err;
    if (j >= 0) {
        sp_packing_separation(p, i, j, d);
        overlapping = images_within(p, d, p->r[i] + p->r[j] - s->slack, s->narrow);
    } else {
        overlapping = sp_packing_wall_distance(p, i, j) < p->r[i] - s->slack;
    }
    if (overlapping > 0) /* a contact stands for one image */
        s->missing += overlapping - sp_packing_has_contact(p, i, j);
    return SP_OK;
}

/* Counts what overlaps beyond rounding and is not listed: pairs, grains and walls, second images, and images of a grain
 * itself, which cannot be listed. */
static sp_status audit_missing(const sp_packing *p, double slack, int32_t *out, sp_error *err) {
    static const double here[3] = {0, 0, 0};
    search s = {.p = p, .slack = slack, .narrow = is_narrow(p)};
    for (int32_t i = 0; i < p->n && s.narrow; i++)
        s.missing += images_within(p, here, 2 * p->r[i] - slack, true) > 1;
    sp_status status = sp_packing_sweep(p, 0, check_listed, &s, err);
    *out = s.missing;
    return status;
}

sp_status sp_packing_audit(const sp_packing *p, double threshold, sp_audit *out, sp_error *err) {
    sp_audit a = {0};
    double diameter = 0, deepest = 0;
    for (int32_t i = 0; i < p->n; i++)
        diameter += 2 * p->r[i] / p->n;
    for (int32_t c = 0; c < p->n_contacts; c++)
        deepest = fmax(deepest, p->contacts[c].overlap);
    const double unit = p->pressure * diameter * diameter;
    uint8_t *rattler = sp_alloc((size_t)p->n, 1), *carrying = sp_alloc((size_t)p->n_contacts, 1);
    sp_status status = rattler && carrying ? SP_OK : sp_fail_memory(err, (size_t)p->n + (size_t)p->n_contacts);
    if (status == SP_OK)
        status = sp_packing_rattlers(p, threshold, rattler, carrying, &a.rattlers, err);
    if (status != SP_OK)
        goto out;
    for (int32_t c = 0; c < p->n_contacts; c++)
        a.carrying += carrying[c];
    audit_contacts(p, threshold * unit, &a);
    status = audit_balance(p, rattler, threshold, unit, &a, err);
    if (status == SP_OK)
        status = audit_missing(p, 1e-6 * deepest + 1e-12 * diameter, &a.missing, err);
    if (status == SP_OK)
        *out = a;
out:
    sp_free(carrying);
    sp_free(rattler);
    return status;
}

/* ---- verdict -------------------------------------------------------------------------------------------------- */

/* The relative errors of an audit, in the order of reporting. */
static const struct measure {
    size_t offset;
    const char *fault;
} measures[] = {
    {offsetof(sp_audit, geometry_residual), "overlaps do not follow from the positions"},
    {offsetof(sp_audit, law_residual), "normal forces do not follow from the overlaps (Hertz)"},
    {offsetof(sp_audit, force_residual), "forces on a grain do not balance"},
    {offsetof(sp_audit, torque_residual), "torques on a grain do not balance"},
    {offsetof(sp_audit, coulomb_excess), "a tangential force is above friction times the normal force"},
    {offsetof(sp_audit, inertia_excess), "a moment of inertia is above mass times squared radius"},
    {offsetof(sp_audit, wall_residual), "the pressure in the grains is not that of the packing"},
};

double sp_audit_worst(const sp_audit *audit, double tolerance, char *reason, size_t size) {
    double largest = 0;
    *reason = '\0';
    sp_locale locale = sp_locale_enter(); /* the reason gets into tables */
    if (audit->missing > 0)
        snprintf(reason, size, "%d overlaps of grains, walls or images are not listed as contacts: must be 0",
                 audit->missing);
    for (size_t k = 0; k < sizeof measures / sizeof *measures; k++) {
        double value;
        memcpy(&value, (const char *)audit + measures[k].offset, sizeof value);
        if (!(value <= largest))
            largest = isnan(largest) ? largest : value;
        if (!(value <= tolerance) && *reason == '\0')
            snprintf(reason, size, "%s: relative error %.3g, must be at most %.3g", measures[k].fault, value,
                     tolerance);
    }
    sp_locale_leave(&locale);
    return largest;
}
