/* Memory, structure check and contact order of packings; what completes contacts; grains that do not carry force. */
#include "base/base.h"
#include "packing/contact.h"
#include "packing/geometry.h"

#include <math.h>
#include <sonopack/packing.h>
#include <stdlib.h>
#include <string.h>

sp_packing sp_packing_none(void) {
    return (sp_packing){
        .residual = NAN, .seconds = NAN, .box = {1, 1, 1}, .frame = NAN, .strain = {NAN, NAN, NAN, NAN, NAN, NAN}};
}

void sp_packing_free(sp_packing *p) {
    sp_free(p->x);
    sp_free(p->r);
    sp_free(p->mass);
    sp_free(p->inertia);
    sp_free(p->species);
    sp_free(p->contacts);
    sp_free(p->scene);
    *p = sp_packing_none();
}

sp_status sp_packing_alloc(sp_packing *p, int dim, int32_t n, int32_t n_contacts, sp_error *err) {
    if (dim < 1 || dim > 3 || n < 0 || n_contacts < 0)
        return sp_fail(err, SP_EINVAL, "packing of %d grains, %d contacts in %d dimensions: must be >= 0 and 1..3", n,
                       n_contacts, dim);
    sp_packing q = sp_packing_none();
    q.dim = dim;
    q.n = n;
    q.n_contacts = n_contacts;
    q.x = sp_alloc((size_t)n * 3, sizeof *q.x);
    q.r = sp_alloc((size_t)n, sizeof *q.r);
    q.contacts = sp_alloc((size_t)n_contacts, sizeof *q.contacts);
    if (!q.x || !q.r || !q.contacts) {
        sp_packing_free(&q);
        return sp_fail_memory(err, (size_t)n * 32 + (size_t)n_contacts * sizeof *q.contacts);
    }
    *p = q;
    return SP_OK;
}

sp_status sp_packing_alloc_masses(sp_packing *p, sp_error *err) {
    const size_t n = (size_t)p->n;
    p->mass = sp_alloc(n, sizeof *p->mass);
    p->inertia = sp_alloc(n, sizeof *p->inertia);
    if (!p->mass || !p->inertia) {
        sp_free(p->mass);
        sp_free(p->inertia);
        p->mass = p->inertia = NULL;
        return sp_fail_memory(err, 2 * n * sizeof *p->mass);
    }
    for (size_t i = 0; i < n; i++) {
        p->mass[i] = grain_mass(p->r[i]);
        p->inertia[i] = grain_inertia(p->r[i]);
    }
    return SP_OK;
}

sp_status sp_packing_alloc_species(sp_packing *p, sp_error *err) {
    p->species = sp_alloc((size_t)p->n, sizeof *p->species);
    return p->species ? SP_OK : sp_fail_memory(err, (size_t)p->n * sizeof *p->species);
}

bool sp_packing_has_stiffnesses(const sp_packing *p) {
    for (int32_t c = 0; c < p->n_contacts; c++)
        if (p->contacts[c].kn > 0)
            return true;
    return false;
}

bool sp_packing_hertzian(const sp_packing *p) { return p->mass == NULL && !sp_packing_has_stiffnesses(p); }

sp_status sp_packing_need_law(const sp_packing *p, const char *what, sp_error *err) {
    if (sp_packing_hertzian(p))
        return SP_OK;
    return sp_fail(
        err, SP_EREFUSED,
        "%s needs the contact law: must be spheres of unit density in Hertz-Mindlin contact, and this packing has %s",
        what, p->mass ? "masses of its own" : "contacts whose stiffness is given");
}

/* ---- structure ------------------------------------------------------------------------------------------------- */

/* Two grains may touch only once, so a periodic cell is wider than a grain and its two neighbours' halves. */
static sp_status check_cell(const sp_packing *p, sp_error *err) {
    static const int along[3] = {0, 0, 1}, of[3] = {1, 2, 2};
    if (p->cell < SP_CELL_PISTON || p->cell > SP_CELL_RING)
        return sp_fail(err, SP_EFORMAT, "cell %d: must be 0 (piston), 1 (periodic), 2 (box) or 3 (ring)", (int)p->cell);
    if (p->cell == SP_CELL_RING && !(p->dim == 2 && p->box[1] < 0.5 * p->box[0] && p->gravity == 0))
        return sp_fail(
            err, SP_EFORMAT,
            "ring: dimension %d, %g between walls of which the outer has the diameter %g, gravity %g: must be "
            "2, less than half of the diameter, and 0",
            p->dim, p->box[1], p->box[0], p->gravity);
    for (int k = 0; k < 3; k++) {
        const bool tilted = p->cell == SP_CELL_PERIODIC && of[k] < p->dim;
        if (!(fabs(p->tilt[k]) <= (tilted ? 0.5 * p->box[along[k]] * (1 + 1e-12) : 0)))
            return sp_fail(err, SP_EFORMAT, "tilt %d is %g: must be %s", k, p->tilt[k],
                           tilted ? "at most half of the edge along it" : "0 in this cell");
    }
    if (!isfinite(p->gravity))
        return sp_fail(err, SP_EFORMAT, "gravity %g: must be finite", p->gravity);
    return SP_OK;
}

static sp_status check_series(const sp_packing *p, sp_error *err) {
    bool infinite = isinf(p->frame);
    for (int k = 0; k < SP_SERIES_STRAINS; k++)
        infinite = infinite || isinf(p->strain[k]);
    return infinite ? sp_fail(err, SP_EFORMAT, "frame %g, or a strain since the first: must be finite", p->frame)
                    : SP_OK;
}

static sp_status check_globals(const sp_packing *p, sp_error *err) {
    if (p->dim < 1 || p->dim > 3)
        return sp_fail(err, SP_EFORMAT, "dimension %d: must be 1, 2 or 3", p->dim);
    if (p->n < 1)
        return sp_fail(err, SP_EFORMAT, "%d grains: must be at least 1", p->n);
    if (p->n_contacts < 0)
        return sp_fail(err, SP_EFORMAT, "%d contacts: must be >= 0", p->n_contacts);
    for (int k = 0; k < 3; k++)
        if (!(p->box[k] > 0) || !isfinite(p->box[k]))
            return sp_fail(err, SP_EFORMAT, "box edge %d is %g: must be positive and finite", k, p->box[k]);
    if (!(p->pressure > 0) || !isfinite(p->pressure))
        return sp_fail(err, SP_EFORMAT, "pressure %g: must be positive and finite", p->pressure);
    if (!(p->friction >= 0) || !isfinite(p->friction))
        return sp_fail(err, SP_EFORMAT, "friction %g: must be >= 0 and finite", p->friction);
    if (!(p->poisson >= 0 && p->poisson <= 0.5))
        return sp_fail(err, SP_EFORMAT, "Poisson ratio %g: must be in 0..0.5", p->poisson);
    if (p->wall != SP_WALL_RIGID && p->wall != SP_WALL_GRAIN && p->wall != SP_WALL_ELASTIC)
        return sp_fail(err, SP_EFORMAT, "wall kind %d: must be 0 (rigid), 1 (grain) or 2 (elastic)", (int)p->wall);
    if (!p->mass != !p->inertia)
        return sp_fail(err, SP_EFORMAT, "masses and moments of inertia: must be given both, or neither");
    sp_status status = check_cell(p, err);
    if (status == SP_OK)
        status = check_series(p, err);
    return status == SP_OK && p->material.young != 0 ? sp_material_check(&p->material, err) : status;
}

static sp_status check_grains(const sp_packing *p, sp_error *err) {
    for (int32_t i = 0; i < p->n; i++) {
        if (!(p->r[i] > 0) || !isfinite(p->r[i]))
            return sp_fail(err, SP_EFORMAT, "grain %d: radius %g must be positive and finite", i, p->r[i]);
        if (p->mass && !(p->mass[i] > 0 && isfinite(p->mass[i]) && p->inertia[i] > 0 && isfinite(p->inertia[i])))
            return sp_fail(err, SP_EFORMAT, "grain %d: mass %g and moment of inertia %g must be positive and finite", i,
                           p->mass[i], p->inertia[i]);
        if (p->species && p->species[i] < 0)
            return sp_fail(err, SP_EFORMAT, "grain %d: species %d must be >= 0", i, p->species[i]);
        if (p->r[i] > sp_packing_height(p))
            return sp_fail(err, SP_EFORMAT, "grain %d: radius %g must be below the height %g", i, p->r[i],
                           sp_packing_height(p));
        double s[3] = {0, 0, 0};
        if (p->cell == SP_CELL_PERIODIC)
            sp_packing_fractions(p, p->x + 3 * (int64_t)i, s);
        const double level = p->cell == SP_CELL_RING ? sp_ring_level(p->box, p->x + 3 * (int64_t)i) : 0;
        if (!(level >= 0 && level <= p->box[p->dim - 1]))
            return sp_fail(err, SP_EFORMAT, "grain %d: %.17g from the inner ring, must be 0 .. %.17g", i, level,
                           p->box[1]);
        for (int k = 0; k < p->dim && p->cell != SP_CELL_RING; k++) {
            const double x = p->x[3 * (int64_t)i + k];
            if (p->cell != SP_CELL_PERIODIC && !(x >= 0 && x <= p->box[k]))
                return sp_fail(err, SP_EFORMAT, "grain %d: coordinate %d is %.17g, outside the box 0..%.17g", i, k, x,
                               p->box[k]);
            if (!(s[k] >= -1e-12 && s[k] <= 1 + 1e-12)) /* rounding */
                return sp_fail(err, SP_EFORMAT,
                               "grain %d: coordinate %d is %.17g, outside the cell: %.17g lattice vectors", i, k, x,
                               s[k]);
        }
    }
    return SP_OK;
}

/* Hertz's law gives at most 4/3 of the squared radii at the deepest overlap. Other laws may give more, but far larger
 * values are not forces in units of E* d^2. */
static const double FORCE_MAX = 1e6;

static sp_status check_contact(const sp_packing *p, int32_t c, sp_error *err) {
    const sp_contact *k = &p->contacts[c];
    if (k->i < 0 || k->i >= p->n || k->j < SP_BACK || k->j >= p->n || (k->j >= 0 && k->j <= k->i))
        return sp_fail(err, SP_EFORMAT,
                       "contact %d: grains %d and %d; must be 0 <= i < j < %d, or j a wall, %d (bottom) .. %d (back)",
                       c, k->i, k->j, p->n, SP_BOTTOM, SP_BACK);
    if (k->j < 0 && !sp_packing_has_wall(p, k->j))
        return sp_fail(err, SP_EFORMAT, "contact %d: grain %d touches wall %d, which this cell does not have", c, k->i,
                       k->j);
    double length2 = 0, ft2 = 0, along = 0;
    for (int a = 0; a < 3; a++) {
        length2 += k->n[a] * k->n[a];
        ft2 += k->ft[a] * k->ft[a];
        along += k->ft[a] * k->n[a];
        if (a >= p->dim && (k->n[a] != 0 || k->ft[a] != 0))
            return sp_fail(err, SP_EFORMAT, "contact %d: component %d of n or ft is not 0 in %d dimensions", c, a,
                           p->dim);
    }
    if (!(fabs(length2 - 1.0) <= 1e-9))
        return sp_fail(err, SP_EFORMAT, "contact %d: the normal's length is %.12g, must be 1", c, sqrt(length2));
    if (!isfinite(k->overlap) || !(k->overlap >= 0))
        return sp_fail(err, SP_EFORMAT, "contact %d: overlap %g must be >= 0 and finite", c, k->overlap);
    if (!isfinite(k->fn) || !(k->fn >= 0))
        return sp_fail(err, SP_EFORMAT, "contact %d: normal force %g must be >= 0 and finite", c, k->fn);
    if (!isfinite(ft2) || !(fabs(along) <= 1e-6 * sqrt(ft2)))
        return sp_fail(err, SP_EFORMAT, "contact %d: the tangential force must be finite and normal to n", c);
    if (!(k->kn >= 0 && k->kt >= 0) || !isfinite(k->kn) || !isfinite(k->kt) || (k->kt > 0 && !(k->kn > 0)))
        return sp_fail(err, SP_EFORMAT,
                       "contact %d: stiffnesses kn %g and kt %g must be finite and >= 0, and kn above 0 where kt is", c,
                       k->kn, k->kt);
    if (!(k->mu >= 0 && isfinite(k->mu)))
        return sp_fail(err, SP_EFORMAT, "contact %d: friction %g must be finite and >= 0", c, k->mu);
    double reach = k->j >= 0 ? p->r[k->i] + p->r[k->j] : p->r[k->i];
    if (!(k->overlap < reach))
        return sp_fail(err, SP_EFORMAT, "contact %d: overlap %g is not below the radii %g", c, k->overlap, reach);
    if (!(k->fn <= FORCE_MAX * reach * reach))
        return sp_fail(err, SP_EFORMAT, "contact %d: normal force %g must be below %g E* d^2 between radii of %g", c,
                       k->fn, FORCE_MAX * reach * reach, reach);
    return SP_OK;
}

/* Pairs by (i, j), then the walls from SP_BOTTOM to SP_BACK. */
static int compare_contacts(const void *a, const void *b) {
    const sp_contact *p = a, *q = b;
    int wall_p = p->j < 0 ? -p->j : 0, wall_q = q->j < 0 ? -q->j : 0;
    if (wall_p != wall_q)
        return wall_p - wall_q;
    if (p->i != q->i)
        return p->i < q->i ? -1 : 1;
    return (p->j > q->j) - (p->j < q->j);
}

bool sp_packing_has_contact(const sp_packing *p, int32_t i, int32_t j) {
    const sp_contact key = {.i = i, .j = j};
    return p->n_contacts > 0 && bsearch(&key, p->contacts, (size_t)p->n_contacts, sizeof key, compare_contacts) != NULL;
}

static sp_status check_contacts(const sp_packing *p, sp_error *err) {
    for (int32_t c = 0; c < p->n_contacts; c++) {
        sp_status status = check_contact(p, c, err);
        if (status != SP_OK)
            return status;
    }
    for (int32_t c = 1; c < p->n_contacts; c++) {
        const sp_contact *b = &p->contacts[c];
        int order = compare_contacts(b - 1, b);
        if (order == 0)
            return sp_fail(err, SP_EFORMAT, "contact %d: grains %d and %d touch twice", c, b->i, b->j);
        if (order > 0)
            return sp_fail(
                err, SP_EFORMAT,
                "contact %d is out of order: pairs by (i, j), then bottom wall, then top wall, then the sides", c);
    }
    return SP_OK;
}

void sp_packing_sort(sp_packing *p) {
    if (p->n_contacts > 0)
        qsort(p->contacts, (size_t)p->n_contacts, sizeof *p->contacts, compare_contacts);
}

sp_status sp_packing_check(const sp_packing *p, sp_error *err) {
    sp_status status = check_globals(p, err);
    if (status == SP_OK)
        status = check_grains(p, err);
    if (status == SP_OK)
        status = check_contacts(p, err);
    return status;
}

/* ---- what is not known of contacts ------------------------------------------------------------------------------- */

static sp_status complete(const sp_packing *p, int32_t index, sp_contact *c, sp_error *err) {
    if (c->i < 0 || c->i >= p->n || c->j < SP_BACK || c->j >= p->n)
        return sp_fail(err, SP_EINVAL, "contact %d joins %d and %d: must be grains 0 .. %d, or a grain and a wall",
                       index, c->i, c->j, p->n - 1);
    if (c->overlap < 0 || c->fn < 0 || (isnan(c->overlap) && isnan(c->fn)))
        return sp_fail(err, SP_EINVAL, "contact %d has overlap %g, fn %g: must be >= 0, and one of them known", index,
                       c->overlap, c->fn);
    const double e = contact_stiffness_in(p, c->i, c->j);
    const bool spring = c->kn > 0;
    if (isnan(c->overlap))
        c->overlap = spring ? c->fn / c->kn : contact_overlap(e, c->fn);
    else if (isnan(c->fn))
        c->fn = spring ? c->kn * c->overlap : contact_force(e, c->overlap);
    if (isnan(c->kt))
        c->kt = spring ? contact_eta(p->poisson) * c->kn : 0;
    return SP_OK;
}

sp_status sp_packing_complete(sp_packing *p, sp_error *err) {
    sp_status status = SP_OK;
    for (int32_t k = 0; k < p->n_contacts && status == SP_OK; k++)
        status = complete(p, k, &p->contacts[k], err);
    return status;
}

/* ---- rattlers ---------------------------------------------------------------------------------------------------- */

/* Contacts needed to carry force: 2 with friction or in 1D, dim + 1 without friction; with a weight dim, on which a
 * grain rests. */
static int32_t contacts_needed(const sp_packing *p) {
    return p->dim == 1 || p->friction > 0 ? 2 : p->dim + (p->gravity > 0 ? 0 : 1);
}

/* Lists the carrying contacts of each grain i at list[start[i] .. start[i+1]-1]. */
static void list_contacts(const sp_packing *p, const uint8_t *carrying, int32_t *start, int32_t *list) {
    for (int32_t c = 0; c < p->n_contacts; c++) {
        if (!carrying[c])
            continue;
        start[p->contacts[c].i + 1]++;
        if (p->contacts[c].j >= 0)
            start[p->contacts[c].j + 1]++;
    }
    for (int32_t i = 0; i < p->n; i++)
        start[i + 1] += start[i];
    for (int32_t c = p->n_contacts - 1; c >= 0; c--) {
        if (!carrying[c])
            continue;
        list[--start[p->contacts[c].i + 1]] = c;
        if (p->contacts[c].j >= 0)
            list[--start[p->contacts[c].j + 1]] = c;
    }
    /* filling has moved each start[i+1] back to the start of row i */
    memmove(start, start + 1, (size_t)p->n * sizeof *start);
}

sp_status sp_packing_rattlers(const sp_packing *p, double threshold, uint8_t *rattler, uint8_t *carrying,
                              int32_t *n_rattlers, sp_error *err) {
    if (isnan(threshold))
        return sp_fail_key(err, SP_EINVAL, "threshold", " = nan: must be a number");
    size_t n = (size_t)p->n, contacts = (size_t)p->n_contacts;
    sp_status status = SP_OK;
    uint8_t *out = sp_alloc(n, 1), *carries = sp_alloc(contacts, 1);
    int32_t *start = sp_alloc(n + 2, sizeof *start), *list = sp_alloc(2 * contacts, sizeof *list);
    int32_t *count = sp_alloc(n, sizeof *count), *queue = sp_alloc(n, sizeof *queue);
    if (!out || !carries || !start || !list || !count || !queue) {
        status = sp_fail_memory(err, n * 14 + contacts * 9);
        goto out;
    }
    const int32_t needed = contacts_needed(p);
    int32_t queued = 0, total = 0, ends = 0;
    for (int32_t c = 0; c < p->n_contacts; c++) {
        carries[c] = p->contacts[c].fn > threshold * p->pressure;
        ends += carries[c] ? (p->contacts[c].j >= 0 ? 2 : 1) : 0;
    }
    list_contacts(p, carries, start, list);
    start[p->n] = ends;
    for (int32_t i = 0; i < p->n; i++) {
        count[i] = start[i + 1] - start[i];
        if (count[i] < needed) {
            out[i] = 1;
            queue[queued++] = i;
        }
    }
    for (; total < queued; total++) { /* removing a grain may leave its neighbours with too few contacts */
        int32_t i = queue[total];
        for (int32_t k = start[i]; k < start[i + 1]; k++) {
            const sp_contact *contact = &p->contacts[list[k]];
            if (!carries[list[k]])
                continue;
            carries[list[k]] = 0;
            int32_t other = contact->i == i ? contact->j : contact->i;
            if (other >= 0 && --count[other] < needed && !out[other]) {
                out[other] = 1;
                queue[queued++] = other;
            }
        }
    }
    if (rattler)
        memcpy(rattler, out, n);
    if (carrying)
        memcpy(carrying, carries, contacts);
    if (n_rattlers)
        *n_rattlers = total;
out:
    sp_free(queue);
    sp_free(count);
    sp_free(list);
    sp_free(start);
    sp_free(carries);
    sp_free(out);
    return status;
}
