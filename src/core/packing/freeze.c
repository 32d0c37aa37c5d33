/* Extracts the packing from the final state of a compression. */
#include "base/vector.h"
#include "packing/compression.h"
#include "packing/contact.h"
#include "packing/deform.h"
#include "packing/geometry.h"

#include <math.h>
#include <string.h>

/* The tangential forces are those of the last evaluation, before the last step. Makes them tangential to the stored
 * normal and limits them by Coulomb's law at the stored overlap. */
static void finish_contact(const dynamics *d, sp_contact *c) {
    double along = 0, square = 0;
    for (int a = 0; a < 3; a++)
        along += c->ft[a] * c->n[a];
    for (int a = 0; a < 3; a++) {
        c->ft[a] -= d->dim == 3 ? along * c->n[a] : 0;
        square += c->ft[a] * c->ft[a];
    }
    const double size = sqrt(square), limit = d->law.friction * c->fn;
    for (int a = 0; a < 3; a++)
        c->ft[a] = (size > limit ? c->ft[a] * (limit / size) : c->ft[a]) + 0.0; /* no negative zero */
}

/* Adds pair k of the list as a contact, from the lower to the higher index, if it is closed. */
static void add_pair(const compression *run, const pair_list *list, int32_t k, sp_packing *p, int32_t *count) {
    const dynamics *d = &run->d;
    const int32_t one = run->id[list->i[k]], two = run->id[list->j[k]], i = one < two ? one : two,
                  j = one < two ? two : one;
    double n[3], t[3] = {0, 0, 0};
    sp_packing_separation(p, i, j, n);
    const double r = length3(n), overlap = p->r[i] + p->r[j] - r, flip = one < two ? 1 : -1;
    if (!(overlap > 0))
        return;
    for (int a = 0; a < d->dim; a++)
        n[a] /= r;
    if (d->dim == 2) { /* the scalar along (-ny, nx) does not depend on the order of i and j */
        t[0] = -list->ft[k] * n[1];
        t[1] = list->ft[k] * n[0];
    } else {
        for (int a = 0; a < 3; a++)
            t[a] = flip * list->ft[k + (int64_t)a * list->capacity];
    }
    sp_contact *c = &p->contacts[(*count)++];
    *c = (sp_contact){.i = i, .j = j, .overlap = overlap, .n = {n[0], n[1], n[2]}, .ft = {t[0], t[1], t[2]}};
    c->fn = contact_force(contact_stiffness(p->r[i], p->r[j]), overlap);
    finish_contact(d, c);
}

static void add_wall(const compression *run, int side, int32_t at, sp_packing *p, int32_t *count) {
    const dynamics *d = &run->d;
    const int32_t i = run->id[at];
    const wall_frame frame = dynamics_wall(d, side);
    const double *ft = d->wall_ft[side] + (int64_t)(d->dim - 1) * at;
    double overlap = p->r[i] - sp_packing_wall_distance(p, i, -1 - side);
    if (!(overlap > 0))
        return;
    sp_contact c = {.i = i, .j = -1 - side, .overlap = overlap};
    c.fn = contact_force(contact_wall_stiffness(p->r[i], p->wall), overlap);
    c.n[frame.axis] = frame.sign;
    for (int a = 0; a < d->dim - 1; a++)
        c.ft[frame.along[a]] = ft[a];
    finish_contact(d, &c);
    p->contacts[(*count)++] = c;
}

/* The tilts may have grown beyond half of the edges since the lists were built. */
static void set_cell(const dynamics *d, sp_packing *p) {
    dynamics now = *d;
    sp_deform_reduce(&now);
    const sp_packing cell = sp_dynamics_cell(&now);
    p->cell = cell.cell;
    memcpy(p->box, cell.box, sizeof cell.box);
    memcpy(p->tilt, cell.tilt, sizeof cell.tilt);
}

sp_status sp_compression_freeze(const compression *run, sp_packing *out, sp_error *err) {
    const dynamics *d = &run->d;
    const sp_pack_spec *spec = run->spec;
    const pair_list *list = dynamics_pairs(d);
    sp_packing p = sp_packing_none();
    int32_t walls = 0;
    for (int side = 0; side < d->walls; side++)
        walls += d->wall[side].n;
    sp_status status = sp_packing_alloc(&p, d->dim, d->n, list->n + walls, err);
    if (status != SP_OK)
        return status;
    set_cell(d, &p);
    p.gravity = spec->gravity;
    p.pressure = spec->pressure;
    p.friction = spec->friction;
    p.poisson = spec->poisson;
    p.seed = spec->seed;
    p.steps = run->steps;
    p.residual = run->residual;
    for (int32_t at = 0; at < d->n; at++) {
        const double *g = dynamics_grain(d, at);
        double *x = p.x + 3 * (size_t)run->id[at];
        p.r[run->id[at]] = g[d->at.r];
        for (int a = 0; a < d->dim; a++)
            x[a] = g[a];
        if (p.cell == SP_CELL_PERIODIC)
            sp_packing_wrap(&p, x);
        for (int a = 0; a < d->dim - 1 && p.cell == SP_CELL_PISTON; a++) {
            x[a] -= d->period[a] * floor(x[a] / d->period[a]);
            x[a] = x[a] < d->period[a] ? x[a] : 0;
        }
    }
    int32_t count = 0;
    for (int32_t k = 0; k < list->n; k++)
        add_pair(run, list, k, &p, &count);
    for (int side = 0; side < d->walls; side++)
        for (int32_t k = 0; k < d->wall[side].n; k++)
            add_wall(run, side, d->wall[side].i[k], &p, &count);
    p.n_contacts = count;
    sp_packing_sort(&p);
    *out = p;
    return SP_OK;
}
