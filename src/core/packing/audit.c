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

/* Overlap from the positions, and the largest deviation of the stored normal from theirs. */
static double true_overlap(const sp_packing *p, const sp_contact *c, double *turn) {
    double d[3] = {0, 0, 0}, r2 = 0;
    *turn = 0;
    if (c->j >= 0)
        sp_packing_separation(p, c->i, c->j, d);
    else
        d[sp_packing_wall_axis(p, c->j)] = sp_packing_wall_side(c->j) * sp_packing_wall_distance(p, c->i, c->j);
    for (int a = 0; a < 3; a++)
        r2 += d[a] * d[a];
    for (int a = 0; a < 3; a++)
        *turn = fmax(*turn, fabs(d[a] / sqrt(r2) - c->n[a]));
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
        double ft = length3(k->ft);
        a->geometry_residual = fmax(a->geometry_residual, fmax(turn, fabs(overlap - k->overlap) / deepest));
        a->law_residual = fmax(a->law_residual, fabs(hertz - k->fn) / fmax(k->fn, small));
        a->coulomb_excess = fmax(a->coulomb_excess, (ft - p->friction * k->fn) / fmax(p->friction * k->fn, small));
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
    for (int a = 0; a < 3 && p->cell == SP_CELL_BOX; a++)
        worst = fmax(worst, fabs(s->push[a] - (a == p->dim - 1 ? grains : 0)) / load);
    return worst;
}

static sp_status audit_balance(const sp_packing *p, const uint8_t *rattler, double unit, sp_audit *a, sp_error *err) {
    sums s = {.trace = 0};
    double *force = sp_alloc((size_t)p->n * 6, sizeof *force);
    if (!force)
        return sp_fail_memory(err, (size_t)p->n * 6 * sizeof *force);
    sum_on_grains(p, force, &s);
    for (size_t i = 0; i < (size_t)p->n; i++) {
        if (rattler[i])
            continue;
        a->force_residual = fmax(a->force_residual, length3(force + 6 * i) / unit);
        a->torque_residual = fmax(a->torque_residual, length3(force + 6 * i + 3) / unit);
    }
    a->wall_residual = wall_residual(p, &s);
    sp_free(force);
    return SP_OK;
}

/* ---- pairs that overlap but are not listed ------------------------------------------------------------------ */

typedef struct search {
    const sp_packing *p;
    double slack;
    int32_t missing;
} search;

static sp_status check_listed(int32_t i, int32_t j, void *user, sp_error *err) {
    search *s = user;
    double d[3];
    (void)err;
    if (j < 0)
        return SP_OK;
    sp_packing_separation(s->p, i, j, d);
    s->missing += length3(d) < s->p->r[i] + s->p->r[j] - s->slack && !sp_packing_has_contact(s->p, i, j);
    return SP_OK;
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
    status = audit_balance(p, rattler, unit, &a, err);
    search missing = {.p = p, .slack = 1e-6 * deepest + 1e-12 * diameter};
    if (status == SP_OK)
        status = sp_packing_sweep(p, 0, check_listed, &missing, err);
    a.missing = missing.missing;
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
    {offsetof(sp_audit, wall_residual), "the pressure in the grains is not that of the packing"},
};

double sp_audit_worst(const sp_audit *audit, double tolerance, char *reason, size_t size) {
    double largest = 0;
    *reason = '\0';
    sp_locale locale = sp_locale_enter(); /* the reason gets into tables */
    if (audit->missing > 0)
        snprintf(reason, size, "%d pairs overlap that are not listed as contacts: must be 0", audit->missing);
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
