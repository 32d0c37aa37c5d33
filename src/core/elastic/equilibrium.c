/* Factors the stiffness of a network between fixed walls, or in a periodic cell. */
#include "elastic/equilibrium.h"

#include "base/base.h"
#include "base/vector.h"
#include "network/spins.h"
#include "packing/geometry.h"

#include <math.h>
#include <string.h>

sp_equilibrium sp_equilibrium_none(void) { return (sp_equilibrium){0}; }

void sp_equilibrium_free(sp_equilibrium *e) {
    sp_ldl_free(e->factor);
    sp_sparse_free(&e->k);
    sp_free(e->free_dofs);
    sp_free(e->spin);
    sp_free(e->work);
    *e = sp_equilibrium_none();
}

/* A wall's springs: their number and their total tangential stiffness. */
typedef struct wall_support {
    int32_t springs;
    double tangential;
} wall_support;

static wall_support support_of(const sp_network *net, int32_t wall) {
    wall_support h = {0, 0};
    for (int32_t k = net->n_bulk; k < net->n_springs; k++)
        if (net->springs[k].j == wall) {
            h.springs++;
            h.tangential += net->springs[k].kt;
        }
    return h;
}

/* Refuses a network in which no chain of springs connects the walls: it carries no stress. Marks grains reached from
 * the bottom until there are no more. Sweeps run in both directions, so that long chains take few sweeps. */
static sp_status check_connected(const sp_network *net, sp_error *err) {
    uint8_t *reached = sp_alloc((size_t)net->n, 1);
    bool more = true, top = false;
    if (!reached)
        return sp_fail_memory(err, (size_t)net->n);
    while (more && !top) {
        more = false;
        for (int32_t pass = 0; pass < 2 * net->n_springs; pass++) {
            const sp_spring *s = &net->springs[pass < net->n_springs ? pass : 2 * net->n_springs - 1 - pass];
            if (s->kn == 0 || s->j < SP_TOP) /* walls at the sides lead nowhere */
                continue;
            if (s->j == SP_TOP) {
                top = top || reached[s->i];
            } else if (s->j == SP_BOTTOM) {
                more = more || !reached[s->i];
                reached[s->i] = 1;
            } else if (reached[s->i] != reached[s->j]) {
                reached[s->i] = reached[s->j] = 1;
                more = true;
            }
        }
    }
    sp_free(reached);
    return top ? SP_OK : sp_fail(err, SP_EREFUSED, "no chain of springs leads from wall to wall");
}

static sp_status check_network(const sp_network *net, sp_error *err) {
    if (net->cell == SP_CELL_PERIODIC)
        return SP_OK;
    const int32_t bottom = support_of(net, SP_BOTTOM).springs, top = support_of(net, SP_TOP).springs;
    if (bottom == 0 || top == 0)
        return sp_fail(err, SP_EREFUSED, "moduli need carrying contacts at both walls, there are %d and %d", bottom,
                       top);
    return check_connected(net, err);
}

static double *diagonal(const sp_sparse *k, int64_t c) { return &k->x[k->p[c]]; }

static double largest_diagonal(const sp_sparse *k) {
    double largest = 0;
    for (int64_t c = 0; c < k->n; c++)
        largest = fmax(largest, *diagonal(k, c));
    return largest;
}

/* Fixes degrees of freedom that no strain can move, which changes no force: rotations without any tangential spring,
 * and the position of the network, at its first grain, sideways between walls without friction, along all axes without
 * walls. */
static void fix_free_motions(const sp_equilibrium *e, sp_sparse *k) {
    const sp_network *net = e->net;
    const double largest = largest_diagonal(k);
    for (int64_t c = 0; c < k->n; c++) {
        const int64_t d = sp_equilibrium_dof(e, c);
        if (d % net->dof >= net->dim && *diagonal(k, c) == 0)
            *diagonal(k, c) = largest;
    }
    for (int a = 0; a < e->loose && !e->free_dofs; a++)
        *diagonal(k, a) += largest;
}

/* The smallest fraction of the diagonal that is added to a singular matrix: small enough for GMRES to end after one or
 * two steps, unless there are motions nearly as soft as this. */
static const double SHIFT_SMALLEST = 1e-9;

static void shift_diagonal(const sp_equilibrium *e, sp_sparse *k) {
    const double largest = largest_diagonal(k);
    for (int64_t c = 0; c < k->n; c++) {
        const double mass = e->net->mass[sp_equilibrium_dof(e, c)];
        double *x = diagonal(k, c);
        if (e->shift_kind == SHIFT_DIAGONAL)
            *x += e->shift * (*x > 0 ? *x : largest);
        else if (e->shift_kind == SHIFT_MASS)
            *x += e->shift * mass;
        *x += e->lift * mass;
    }
}

static void hold_spins(const sp_equilibrium *e, sp_sparse *k) {
    for (int32_t s = 0; s < e->spins; s++) {
        const equilibrium_spin *spin = &e->spin[s];
        for (int a = 0; a < spin->width; a++)
            for (int b = a; b < spin->width; b++)
                k->x[k->p[spin->column + a] + b - a] += spin->push[a] * spin->push[b];
    }
}

/* SP_EREFUSED if a matrix is singular or indefinite in double precision. Scaling rows and columns does not change what
 * is refused. The factor must not be used then. */
static sp_status factor_positive(sp_ldl *f, const sp_sparse *a, sp_error *err) {
    sp_status status = sp_ldl_set(f, a, err);
    if (status == SP_OK)
        status = sp_ldl_factor(f, 0, err);
    if (status != SP_OK)
        return status;
    if (sp_ldl_negative(f) > 0)
        return sp_fail(err, SP_EREFUSED, "the matrix is not positive definite (%lld of %lld pivots are negative)",
                       (long long)sp_ldl_negative(f), (long long)a->n);
    const double ratio = sp_ldl_least_ratio(f, a);
    if (!(ratio > 1e-13))
        return sp_fail(err, SP_EREFUSED,
                       "the matrix is singular (a pivot is %.2g of its diagonal entry, must be above 1e-13)", ratio);
    return SP_OK;
}

/* Factors the symmetric part of K with fixed motions, held spins and shift. */
static sp_status factorize(sp_equilibrium *e, sp_error *err) {
    const size_t entries = (size_t)e->k.p[e->k.n];
    sp_sparse k = e->k;
    sp_status status = SP_OK;
    k.x = sp_alloc(entries, sizeof *k.x);
    if (!k.x)
        return sp_fail_memory(err, entries * sizeof *k.x);
    memcpy(k.x, e->k.x, entries * sizeof *k.x);
    fix_free_motions(e, &k);
    shift_diagonal(e, &k);
    hold_spins(e, &k);
    if (!e->factor)
        status = sp_ldl_make(&k, e->net, &e->factor, err);
    if (status == SP_OK)
        status = factor_positive(e->factor, &k, err);
    sp_free(k.x);
    return status;
}

/* Factors with the shift that is set. The eigenvalues of a nonsymmetric A are within `skew` of those of its symmetric
 * part. If that has none below -skew, the network is not obviously unstable. */
static sp_status factorize_shifted(sp_equilibrium *e, sp_error *err) {
    e->lift = 0;
    sp_status status = factorize(e, err);
    if (status == SP_EREFUSED && e->net->carried) {
        e->lift = sp_network_skew(e->net);
        status = factorize(e, err);
    }
    if (status == SP_EREFUSED && e->net->prestress)
        sp_fail_prefix(err, "the network is unstable under its prestress");
    return status;
}

void sp_equilibrium_apply(const sp_equilibrium *e, const double *b, double *x) { sp_ldl_solve_one(e->factor, b, x); }

/* push = D motion/sqrt(motion . D motion); weight: [width], D. Where prestress makes that stiffness negative nothing is
 * added, and the factorization finds the instability. */
static void set_push(const double *weight, equilibrium_spin *spin) {
    double stiffness = 0;
    for (int a = 0; a < spin->width; a++) {
        spin->push[a] = weight[a] * spin->motion[a];
        stiffness += spin->push[a] * spin->motion[a];
    }
    for (int a = 0; a < spin->width; a++)
        spin->push[a] = stiffness > 0 ? spin->push[a] / sqrt(stiffness) : 0;
}

/* The unit rotation about an axis through a contact point `at` moves the centre by at x axis. */
static void set_motion(const double at[3], const double axis[3], double motion[6]) {
    for (int a = 0; a < 3; a++) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        motion[a] = at[b] * axis[c] - at[c] * axis[b];
        motion[3 + a] = axis[a];
    }
}

/* The free rotation of grain i, whose columns begin at c and end before `end`. A fixed centre must be on the axis. The
 * spring that holds it is about as stiff as the others of the sphere. It resists the rotation about the axis alone: no
 * other, so that the sphere does not spin as it rolls, and no translation, since nothing resists one of the whole in a
 * periodic cell. */
static bool set_spin(const sp_equilibrium *e, int32_t i, const sp_spin *of, int64_t c, int64_t end,
                     equilibrium_spin *out) {
    double axis[3], motion[6], weight[6] = {0}, stiffness = 0;
    if (!sp_spin_axis(of, axis))
        return false;
    set_motion(of->at[0], axis, motion);
    const bool whole = end - c == 6;
    const bool turns = end - c >= 3 && sp_equilibrium_dof(e, end - 3) == 6 * (int64_t)i + 3;
    if (!whole && !(turns && sp_norm(3, motion) < 1e-6 * sp_norm(3, of->at[0])))
        return false;
    *out = (equilibrium_spin){.column = whole ? c : end - 3, .width = whole ? 6 : 3};
    memcpy(out->motion, motion + 6 - out->width, (size_t)out->width * sizeof *motion);
    for (int64_t d = end - 3; d < end; d++)
        stiffness += *diagonal(&e->k, d) / 3;
    for (int a = out->width - 3; a < out->width; a++)
        weight[a] = stiffness;
    set_push(weight, out);
    return true;
}

static void list_spins(sp_equilibrium *e, const sp_spin *spin) {
    int64_t c = 0;
    for (int32_t i = 0; i < e->net->n; i++) {
        int64_t end = c;
        while (end < e->count && sp_equilibrium_dof(e, end) < 6 * (int64_t)(i + 1))
            end++;
        e->spins += set_spin(e, i, &spin[i], c, end, &e->spin[e->spins]);
        c = end;
    }
}

/* Holds free rotations if K is not symmetric. *singular: whether others are left. A sphere with two contacts spins
 * about the line through them; one with a single contact has more free rotations. */
static sp_status find_spins(sp_equilibrium *e, bool *singular, sp_error *err) {
    const sp_network *net = e->net;
    sp_spin *spin;
    *singular = false;
    sp_status status = sp_spins_make(net, &spin, err);
    for (int32_t i = 0; i < net->n && status == SP_OK && spin; i++)
        *singular = *singular || spin[i].springs < 3;
    if (*singular && net->carried) {
        *singular = false;
        e->spin = sp_alloc((size_t)net->n, sizeof *e->spin);
        if (e->spin)
            list_spins(e, spin);
        else
            status = sp_fail_memory(err, (size_t)net->n * sizeof *e->spin);
    }
    sp_free(spin);
    return status;
}

/* Factors K itself if it is regular, else with a shift. */
static sp_status factorize_or_shift(sp_equilibrium *e, sp_error *err) {
    bool singular;
    sp_status status = find_spins(e, &singular, err);
    if (status == SP_OK && !singular)
        status = factorize(e, err);
    if ((status == SP_OK && singular) || status == SP_EREFUSED) {
        e->shift_kind = SHIFT_DIAGONAL;
        e->shift = SHIFT_SMALLEST;
        status = factorize_shifted(e, err);
    }
    return status;
}

static sp_status allocate(sp_equilibrium *e, sp_error *err) {
    const size_t size = 2 * (size_t)sp_network_dofs(e->net) + 5 * (size_t)e->count;
    e->work = sp_alloc(size, sizeof *e->work);
    return e->work ? SP_OK : sp_fail_memory(err, size * sizeof *e->work);
}

sp_status sp_equilibrium_make(const sp_network *net, sp_equilibrium *out, sp_error *err) {
    sp_equilibrium e = {.net = net, .count = sp_network_dofs(net)};
    sp_status status = check_network(net, err);
    if (status != SP_OK)
        return status;
    const double bottom = support_of(net, SP_BOTTOM).tangential, top = support_of(net, SP_TOP).tangential;
    const bool piston = net->cell == SP_CELL_PISTON;
    e.slips = piston && net->dim > 1 && bottom == 0 && top == 0;
    e.grips = !piston || (bottom > 0 && top > 0);
    e.loose = net->cell == SP_CELL_PERIODIC ? net->dim : e.slips ? net->dim - 1 : 0;
    status = sp_network_assemble(net, &e.k, err);
    if (status == SP_OK)
        status = allocate(&e, err);
    if (status == SP_OK)
        status = factorize_or_shift(&e, err);
    if (status == SP_OK)
        *out = e;
    else
        sp_equilibrium_free(&e);
    return status;
}

/* The largest ratio of a diagonal entry to its mass. */
static double fastest(const sp_equilibrium *e) {
    double most = 0;
    for (int64_t c = 0; c < e->k.n; c++)
        most = fmax(most, *diagonal(&e->k, c) / e->net->mass[sp_equilibrium_dof(e, c)]);
    return most;
}

sp_status sp_equilibrium_shift(sp_equilibrium *e, equilibrium_shift kind, double fraction, sp_error *err) {
    e->shift_kind = kind;
    e->shift = fmax(fraction, SHIFT_SMALLEST) * (kind == SHIFT_MASS ? fastest(e) : 1);
    return factorize_shifted(e, err);
}

sp_status sp_equilibrium_weigh_spins(sp_equilibrium *e, sp_error *err) {
    const double scale = fastest(e);
    for (int32_t s = 0; s < e->spins; s++) {
        double weight[6];
        for (int a = 0; a < e->spin[s].width; a++)
            weight[a] = scale * e->net->mass[sp_equilibrium_dof(e, e->spin[s].column + a)];
        set_push(weight, &e->spin[s]);
    }
    e->weighed = true;
    return factorize_shifted(e, err);
}

/* Extracts the rows and columns of K that are not fixed. */
static sp_status extract_free(const sp_sparse *k, const uint8_t *fixed, sp_equilibrium *e, sp_error *err) {
    const size_t n = (size_t)k->n, entries = (size_t)k->p[k->n];
    int64_t *to = sp_alloc(n, sizeof *to), at = 0;
    e->free_dofs = sp_alloc(n, sizeof *e->free_dofs);
    e->k.p = sp_alloc(n + 1, sizeof *e->k.p);
    e->k.i = sp_alloc(entries, sizeof *e->k.i);
    e->k.x = sp_alloc(entries, sizeof *e->k.x);
    if (!to || !e->free_dofs || !e->k.p || !e->k.i || !e->k.x) {
        sp_free(to);
        return sp_fail_memory(err, 24 * n + 16 * entries);
    }
    for (int64_t c = 0; c < k->n; c++)
        if (!fixed[c]) {
            to[c] = e->count;
            e->free_dofs[e->count++] = c;
        }
    for (int64_t c = 0; c < e->count; c++) {
        const int64_t column = e->free_dofs[c];
        for (int64_t q = k->p[column]; q < k->p[column + 1]; q++)
            if (!fixed[k->i[q]]) {
                e->k.i[at] = to[k->i[q]];
                e->k.x[at++] = k->x[q];
            }
        e->k.p[c + 1] = at;
    }
    e->k.n = e->count;
    sp_free(to);
    return SP_OK;
}

sp_status sp_equilibrium_restrict(const sp_equilibrium *whole, const uint8_t *fixed, sp_equilibrium *out,
                                  sp_error *err) {
    sp_equilibrium e = {.net = whole->net, .slips = whole->slips, .grips = whole->grips, .loose = whole->loose};
    sp_status status = extract_free(&whole->k, fixed, &e, err);
    if (status == SP_OK)
        status = allocate(&e, err);
    if (status == SP_OK && e.count > 0)
        status = factorize_or_shift(&e, err);
    if (status == SP_OK)
        *out = e;
    else
        sp_equilibrium_free(&e);
    return status;
}
