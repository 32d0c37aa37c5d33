/* Moduli at finite strain: brings a strained packing to equilibrium with its full contact law. */
#include "base/base.h"
#include "base/vector.h"
#include "elastic/moduli.h"
#include "elastic/strain.h"
#include "linalg/krylov.h"
#include "packing/contact.h"
#include "packing/geometry.h"
#include "packing/vibrate.h"

#include <math.h>
#include <string.h>

/* Whether the contact is closed and at Coulomb's limit. */
static bool slides(const vibration *m, const touching *t) { return m->turns && t->kn > 0 && t->held < 1; }

/* Component of a vibration's vectors (0 .. 5: translation, rotation) for degree of freedom d of a grain of the network.
 */
static int component(const sp_network *net, int d) { return d < net->dim || net->dim == 3 ? d : 5; }

/* Change of the tangential force of a contact at Coulomb's limit. Along the force it is the change of the normal force
 * times the friction coefficient, whatever the slip; across it the spring still acts. The first part makes the
 * stiffness nonsymmetric. */
static void limit_friction(const vibration *m, const touching *t, double along, double push[3]) {
    double force[3];
    for (int a = 0; a < 3; a++)
        force[a] = t->ft0[a] + t->ft[a];
    const double size = sp_norm(3, force);
    if (!(size > 0))
        return;
    const double part = sp_dot(3, force, push) / size;
    for (int a = 0; a < 3; a++)
        push[a] = t->held * (push[a] - part * force[a] / size) - m->friction * t->kn * along * force[a] / size;
}

/* Change of the force on i due to the relative displacement and to the rotations times lever arms. */
static void force_change(const vibration *m, const touching *t, const double moved[3], const double turn[3],
                         double push[3]) {
    const double *n = m->straight ? t->n0 : t->n, along = sp_dot(3, moved, n);
    memset(push, 0, 3 * sizeof *push);
    if (m->turns) {
        const double rest = t->overlap > 0 ? contact_normal_stiffness(t->e, t->overlap) : 0;
        const double kt = 0.5 * m->eta * (rest + t->kn);
        double arm[3];
        cross3(turn, n, arm);
        for (int a = 0; a < 3; a++)
            push[a] = kt * (moved[a] - along * n[a] - arm[a]);
    }
    if (slides(m, t))
        limit_friction(m, t, along, push);
    for (int a = 0; a < 3; a++)
        push[a] += t->kn * along * n[a];
}

/* Adds the forces of a contact due to the displacements `in`. */
static void add_contact(const vibration *m, const sp_network *net, const int32_t *row, const touching *t,
                        const double *in, double *out) {
    const int64_t i = (int64_t)(row[t->i] - 1) * net->dof;
    const int64_t j = t->j < 0 ? -1 : (int64_t)(row[t->j] - 1) * net->dof;
    double moved[3] = {0}, turn[3] = {0}, push[3], twist[3];
    for (int d = 0; d < net->dof; d++) {
        const int c = component(net, d);
        const double one = in[i + d], other = j < 0 ? 0 : in[j + d];
        if (c < 3)
            moved[c] = other - one;
        else
            turn[c - 3] = t->arm_i * one + t->arm_j * other;
    }
    force_change(m, t, moved, turn, push);
    cross3(m->straight ? t->n0 : t->n, push, twist);
    for (int d = 0; d < net->dof; d++) {
        const int c = component(net, d);
        out[i + d] -= c < 3 ? push[c] : t->arm_i * twist[c - 3];
        if (j >= 0)
            out[j + d] -= c < 3 ? -push[c] : t->arm_j * twist[c - 3];
    }
}

/* Adds to out the forces of closed contacts due to the displacements `in`; both [dofs]. row: for each grain of the
 * packing its row in the network, from 1. */
static void add_tangent(const vibration *m, const sp_network *net, const int32_t *row, const double *in, double *out) {
    for (int32_t k = 0; k < m->count; k++)
        if (m->touch[k].kn > 0)
            add_contact(m, net, row, &m->touch[k], in, out);
}

/* Residual over the load: goal of Newton's method; goal if it converges slowly; largest value accepted. A single loose
 * grain that is still moving does not affect the stress. */
static const double GOAL = 1e-11, SLOW_GOAL = 1e-9, ACCEPTED = 1e-6;

/* Stiffness given to floppy motions in Newton steps, relative to that of their grains, to limit them. */
static const double FLOPPY = 1e-4;

sp_finite_strain_options sp_finite_strain_options_default(void) {
    return (sp_finite_strain_options){.strain = 1e-6, .turning = true};
}

typedef struct strain_run {
    const sp_packing *p;
    const sp_network *net;
    sp_equilibrium initial;   /* springs at rest */
    sp_equilibrium current;   /* springs of the current contacts, if these differ too much from those at rest */
    sp_equilibrium stiffened; /* springs at rest with stiffened floppy motions, if K is singular */
    sp_network springs;       /* network of `current`; owns its springs and length */
    int32_t *row;             /* [p->n] row of a grain in the network, from 1; 0: rattler */
    vibration m;
    double strain, load; /* extension positive; norm of the forces of the affine strain */
    double kept;         /* fraction of its stiffness that a sliding or open contact keeps in Newton steps */
    double *u, *step, *force, *best, *start; /* [dofs] */
    sp_finite_strain out;
} strain_run;

/* Selects contacts and gaps between grains of the network, and with walls. Weak contacts that are not springs of the
 * network are left out. */
static sp_status choose_contacts(strain_run *r, sp_error *err) {
    const sp_network *net = r->net;
    vibration *m = &r->m;
    uint8_t *spring = sp_alloc((size_t)r->p->n_contacts, 1);
    int32_t kept = 0;
    r->row = sp_alloc((size_t)r->p->n, sizeof *r->row);
    sp_status status = spring && r->row ? SP_OK : sp_fail_memory(err, (size_t)r->p->n_contacts + 4 * (size_t)r->p->n);
    for (int32_t k = 0; k < net->n_springs && status == SP_OK; k++)
        spring[net->springs[k].contact] = 1;
    for (int32_t k = 0; k < net->n && status == SP_OK; k++)
        r->row[net->grain[k]] = k + 1;
    for (int32_t k = 0; k < m->count && status == SP_OK; k++) {
        const touching *t = &m->touch[k];
        if (k < r->p->n_contacts ? spring[k] : r->row[t->i] && (t->j < 0 || r->row[t->j]))
            m->touch[kept++] = *t;
    }
    if (status == SP_OK)
        m->count = kept;
    sp_free(spring);
    return status;
}

static void set_strain(strain_run *r, int strain) {
    for (int32_t k = 0; k < r->m.count; k++) {
        touching *t = &r->m.touch[k];
        double gap[3];
        sp_strain_displacement(r->net, strain, t->n0, t->length, gap);
        for (int a = 0; a < 3; a++)
            t->shift[a] = r->strain * gap[a];
    }
}

/* Forces on the grains at the displacement u; returns their norm. */
static double forces(strain_run *r, const double *u, double *force) {
    const sp_network *net = r->net;
    sp_vibration_rest(&r->m);
    for (int32_t i = 0; i < net->n; i++)
        for (int d = 0; d < net->dof; d++)
            r->m.u[6 * (int64_t)net->grain[i] + component(net, d)] = u[(int64_t)i * net->dof + d];
    sp_vibration_begin(&r->m);
    for (int32_t i = 0; i < net->n; i++)
        for (int d = 0; d < net->dof; d++) {
            const int64_t k = (int64_t)i * net->dof + d;
            force[k] = r->m.a[6 * (int64_t)net->grain[i] + component(net, d)] * net->mass[k];
        }
    return sp_norm(sp_network_dofs(net), force);
}

/* Adds the spring of a contact in its current state. A sliding contact keeps a fraction of its tangential stiffness and
 * an open one a fraction of its whole stiffness, to limit the steps. */
static void add_spring(strain_run *r, int32_t k) {
    const double kept = r->kept;
    sp_network *net = &r->springs;
    const touching *t = &r->m.touch[k];
    const double rest = t->overlap > 0 ? contact_normal_stiffness(t->e, t->overlap) : 0;
    const double tangential = r->m.turns ? 0.5 * r->m.eta * (rest + t->kn) : 0;
    sp_spring s = {.i = r->row[t->i] - 1, .j = t->j < 0 ? t->j : r->row[t->j] - 1, .ri = t->arm_i, .rj = t->arm_j};
    s.kn = fmax(t->kn, kept * rest); /* a contact that barely touches will be stiffer soon */
    s.kt = t->kn > 0 && !slides(&r->m, t) ? tangential : kept * tangential;
    for (int a = 0; a < 3; a++)
        s.n[a] = r->m.straight ? t->n0[a] : t->n[a];
    net->length[net->n_springs] = t->length;
    net->springs[net->n_springs++] = s;
}

static sp_status factor_now(strain_run *r, sp_error *err) {
    sp_equilibrium e = sp_equilibrium_none();
    r->springs.n_springs = 0;
    for (int walls = 0; walls < 2; walls++) {
        for (int32_t k = 0; k < r->m.count; k++)
            if ((r->m.touch[k].j < 0) == walls && (r->m.touch[k].overlap > 0 || r->m.touch[k].kn > 0))
                add_spring(r, k);
        if (!walls)
            r->springs.n_bulk = r->springs.n_springs;
    }
    sp_status status = sp_equilibrium_make(&r->springs, &e, err);
    if (status == SP_OK && e.shift_kind)
        status = sp_equilibrium_shift(&e, SHIFT_DIAGONAL, FLOPPY, err);
    if (status == SP_OK) {
        sp_equilibrium_free(&r->current);
        r->current = e;
        r->out.factors++;
    }
    return status;
}

/* Takes `fraction` times a step, halved as long as the forces grow much; returns their norm. */
static double take_step(strain_run *r, double fraction, double before) {
    const int64_t n = sp_network_dofs(r->net);
    double size;
    for (int64_t k = 0; k < n; k++)
        r->u[k] += fraction * r->step[k];
    size = forces(r, r->u, r->force);
    for (int turn = 0; turn < 6 && !(size < 2 * before); turn++) {
        fraction *= 0.5;
        for (int64_t k = 0; k < n; k++)
            r->u[k] -= fraction * r->step[k];
        size = forces(r, r->u, r->force);
    }
    return size;
}

static sp_equilibrium *initial_factor(strain_run *r) { return r->stiffened.factor ? &r->stiffened : &r->initial; }

static void apply_tangent(void *with, const double *in, double *out) {
    strain_run *r = with;
    const int64_t n = sp_network_dofs(r->net);
    const sp_equilibrium *e = initial_factor(r);
    memset(out, 0, (size_t)n * sizeof *out);
    add_tangent(&r->m, r->net, r->row, in, out);
    for (int64_t k = 0; k < n && e->shift_kind; k++) /* as in the factor */
        out[k] += e->shift * e->k.x[e->k.p[k]] * in[k];
    sp_equilibrium_add_spins(e, 1, in, out);
}

static void precondition(void *with, const double *in, double *out) {
    strain_run *r = with;
    r->out.solves++;
    sp_equilibrium_apply(initial_factor(r), in, out);
}

/* Newton's method with the exact tangent stiffness; keeps the best u in `best`. The tangent differs from the stiffness
 * at rest by a few numbers for each sliding contact, so GMRES needs few steps with the factor at rest as
 * preconditioner. */
static sp_status newton_exact(strain_run *r, double *least, sp_error *err) {
    enum { STEPS_MAX = 40, PATIENCE = 4, SEARCH_MAX = 120 };
    krylov_problem p = {sp_network_dofs(r->net), apply_tangent, precondition, r, 0, SEARCH_MAX};
    const size_t bytes = (size_t)p.n * sizeof *r->u;
    double size = forces(r, r->u, r->force), left;
    int stalled = 0;
    *least = size;
    memcpy(r->best, r->u, bytes);
    for (int step = 0; step < STEPS_MAX && stalled < PATIENCE && size > GOAL * r->load; step++) {
        const double before = size;
        p.goal = 1e-4 * size;
        sp_status status = sp_gmres(&p, r->force, r->step, &left, err);
        if (status != SP_OK)
            return status;
        size = take_step(r, 1, before);
        stalled = size < 0.9 * *least ? 0 : stalled + 1;
        if (size < *least) {
            *least = size;
            memcpy(r->best, r->u, bytes);
        }
        if (!isfinite(size) || (size > 0.5 * before && *least < SLOW_GOAL * r->load))
            break;
    }
    return SP_OK;
}

/* Contacts that alternate between sticking and sliding can make the steps cycle, and a loose grain must travel far
 * until it is held again. After `stalled` steps without progress this tries other step lengths and stiffness
 * fractions. */
static double vary_step(strain_run *r, int stalled) {
    static const double part[] = {3e-2, 3e-3, 3e-4, 3e-5, 1e-1, 1e-2};
    r->kept = part[stalled / 9 % 6];
    return 1.0 / (1 << stalled / 3 % 3);
}

/* Newton's method with symmetric springs, where a sliding or open contact keeps a fraction of its stiffness. It needs
 * more steps but survives many changes of contacts. Continues from `u`; least: smallest residual so far. */
static sp_status newton_symmetric(strain_run *r, double least, sp_error *err) {
    enum { STEPS_MAX = 500, PATIENCE = 20 };
    const int64_t n = sp_network_dofs(r->net);
    sp_equilibrium *factor = &r->initial;
    double size = forces(r, r->u, r->force);
    int stalled = 0;
    if (r->initial.shift_kind) {
        sp_status status = factor_now(r, err);
        if (status != SP_OK)
            return status;
        factor = &r->current;
    }
    for (int step = 0; step < STEPS_MAX && size > GOAL * r->load; step++) {
        const double before = size, fraction = vary_step(r, stalled);
        sp_equilibrium_apply(factor, r->force, r->step);
        r->out.solves++;
        size = take_step(r, fraction, before);
        stalled = size < 0.9 * least ? 0 : stalled + 1;
        if (size < least) {
            least = size;
            memcpy(r->best, r->u, (size_t)n * sizeof *r->u);
        }
        if (!isfinite(size) || (size > 0.3 * before && least < SLOW_GOAL * r->load) ||
            (stalled > PATIENCE && least < ACCEPTED * r->load))
            break;
        if (size > 0.3 * before) {
            const sp_status status = factor_now(r, err);
            if (status == SP_EREFUSED) /* no chain of springs connects the walls any more */
                break;
            if (status != SP_OK)
                return status;
            factor = &r->current;
        }
    }
    return SP_OK;
}

/* Starts from the linear solution. */
static sp_status find_equilibrium(strain_run *r, double *residual, sp_error *err) {
    const size_t bytes = (size_t)sp_network_dofs(r->net) * sizeof *r->u;
    double least = 0;
    memcpy(r->start, r->u, bytes);
    sp_status status = newton_exact(r, &least, err);
    if (status == SP_OK && !(least < ACCEPTED * r->load) && least > 0) {
        memcpy(r->u, r->start, bytes);
        status = newton_symmetric(r, least, err);
    }
    if (status != SP_OK)
        return status;
    *residual = forces(r, r->best, r->force);
    if (*residual > 0) /* a strain that stretches no contact causes no load */
        *residual /= r->load;
    return SP_OK;
}

static void count_contacts(strain_run *r) {
    int32_t sliding = 0, lost = 0, made = 0;
    for (int32_t k = 0; k < r->m.count; k++) {
        const touching *t = &r->m.touch[k];
        sliding += slides(&r->m, t);
        lost += t->overlap > 0 && t->kn == 0;
        made += t->overlap <= 0 && t->kn > 0;
    }
    r->out.sliding = sliding > r->out.sliding ? sliding : r->out.sliding;
    r->out.lost = lost > r->out.lost ? lost : r->out.lost;
    r->out.made = made > r->out.made ? made : r->out.made;
}

/* One column of C: changes of the stress. A stretched contact pulls grain i towards j. */
static void put_stress(const strain_run *r, int strain, sp_stiffness *c) {
    const int strains = sp_strain_count(r->net);
    double sum[STRAINS_3D] = {0};
    for (int32_t k = 0; k < r->m.count; k++) {
        const touching *t = &r->m.touch[k];
        for (int b = 0; b < strains; b++) {
            double gap[3];
            sp_strain_displacement(r->net, b, t->n0, t->length, gap);
            for (int a = 0; a < 3; a++)
                sum[b] += t->force[a] * gap[a];
        }
    }
    for (int b = 0; b < strains; b++)
        if (sp_strain_allowed(r->net, b, r->initial.grips))
            c->c[b][strain] = sum[b] / (r->strain * sp_strain_volume(r->net));
}

/* Whether all contacts that may have closed were watched. */
static bool within_reach(const strain_run *r) {
    double worst = 0, shift = 0;
    for (int32_t i = 0; i < r->net->n; i++)
        worst = fmax(worst, sp_norm(r->net->dim, r->best + (int64_t)i * r->net->dof));
    for (int32_t k = 0; k < r->m.count; k++)
        shift = fmax(shift, fabs(r->strain) * r->m.touch[k].length);
    return 2 * worst + shift <= r->m.reach;
}

/* Below Coulomb's limit at rest and at the limit now. A contact at the limit already at rest slides under any strain of
 * one sign. */
static bool begins_to_slide(const vibration *m, const touching *t) {
    const double *f = t->ft0;
    return slides(m, t) && t->overlap > 0 && sp_norm(3, f) < (1 - 1e-9) * m->friction * t->fn0;
}

/* Reports the grain with the largest residual force. The contact law has no scale of its own except where contacts
 * open, close or begin to slide; a smaller strain changes fewer contacts. */
static sp_status report_failure(strain_run *r, double residual, sp_error *err) {
    int32_t worst = 0, contacts = 0, sliding = 0, changed = 0;
    const int dof = r->net->dof;
    for (int32_t i = 1; i < r->net->n; i++)
        if (sp_norm(dof, r->force + (int64_t)i * dof) > sp_norm(dof, r->force + (int64_t)worst * dof))
            worst = i;
    for (int32_t k = 0; k < r->m.count; k++) {
        const touching *t = &r->m.touch[k];
        const bool own = r->row[t->i] == worst + 1 || (t->j >= 0 && r->row[t->j] == worst + 1);
        contacts += own && t->kn > 0;
        sliding += own && slides(&r->m, t);
        changed += (t->overlap > 0) != (t->kn > 0) || begins_to_slide(&r->m, t);
    }
    return sp_fail(
        err, SP_EREFUSED,
        "strain %g: no equilibrium found, residual %.3g, must be below %g: the packing yields at grain %d, of "
        "whose %d contacts %d slide; %s",
        -r->strain, residual, ACCEPTED, r->net->grain[worst], contacts, sliding,
        changed > 0 ? "contacts open, close or begin to slide, try a smaller strain"
                    : "contacts do not change, so a smaller strain is not likely to help");
}

static sp_status strain_one(strain_run *r, int strain, sp_stiffness *c, sp_error *err) {
    const int64_t n = sp_network_dofs(r->net);
    double residual = 0;
    const double scale = sp_strain_load(r->net, strain, r->force);
    memset(r->u, 0, (size_t)n * sizeof *r->u);
    sp_status status = sp_equilibrium_solve(&r->initial, r->force, scale, r->u, &residual, err);
    if (status != SP_OK)
        return status;
    for (int64_t k = 0; k < n; k++)
        r->u[k] *= r->strain;
    r->load = fabs(r->strain) * scale;
    set_strain(r, strain);
    status = find_equilibrium(r, &residual, err);
    if (status != SP_OK)
        return status;
    if (!(residual < ACCEPTED))
        return report_failure(r, residual, err);
    if (!within_reach(r))
        return sp_fail(err, SP_EREFUSED,
                       "strain %g: grains move farther than the search for contacts reaches, must be smaller",
                       -r->strain);
    r->out.residual = fmax(r->out.residual, residual);
    count_contacts(r);
    put_stress(r, strain, c);
    return SP_OK;
}

static sp_status strain_all(strain_run *r, sp_stiffness *c, sp_error *err) {
    sp_status status = SP_OK;
    for (int a = 0; a < STRAINS_3D; a++)
        for (int b = 0; b < STRAINS_3D; b++)
            c->c[a][b] = c->error[a][b] = NAN;
    for (int a = 0; a < sp_strain_count(r->net) && status == SP_OK; a++)
        if (sp_strain_allowed(r->net, a, r->initial.grips))
            status = strain_one(r, a, c, err);
    return status;
}

static sp_status stiffen_floppy(strain_run *r, sp_error *err) {
    sp_status status = sp_equilibrium_make(r->net, &r->stiffened, err);
    return status == SP_OK ? sp_equilibrium_shift(&r->stiffened, SHIFT_DIAGONAL, FLOPPY, err) : status;
}

static sp_status open_run(strain_run *r, sp_error *err) {
    const size_t n = (size_t)sp_network_dofs(r->net);
    sp_status status = sp_equilibrium_make(r->net, &r->initial, err);
    if (status == SP_OK)
        status = sp_vibration_make(r->p, 0, &r->m, err);
    if (status == SP_OK)
        status = choose_contacts(r, err);
    if (status != SP_OK)
        return status;
    r->springs = *r->net;
    r->springs.springs = NULL;
    r->springs.length = NULL;
    r->springs.carried = NULL; /* these terms of K matter little for Newton steps */
    r->springs.springs = sp_alloc((size_t)r->m.count, sizeof *r->springs.springs);
    r->springs.length = sp_alloc((size_t)r->m.count, sizeof *r->springs.length);
    r->u = sp_alloc(5 * n, sizeof *r->u);
    if (!r->springs.springs || !r->springs.length || !r->u)
        return sp_fail_memory(err, 5 * n * sizeof *r->u);
    r->step = r->u + n;
    r->force = r->u + 2 * n;
    r->best = r->u + 3 * n;
    r->start = r->u + 4 * n;
    return r->initial.shift_kind ? stiffen_floppy(r, err) : SP_OK;
}

sp_status sp_moduli_finite_strain(const sp_packing *p, const sp_network *net, double phi3s,
                                  const sp_finite_strain_options *opt, sp_finite_strain *out, sp_error *err) {
    if (!(fabs(opt->strain) >= 1e-12 && fabs(opt->strain) <= 0.01))
        return sp_fail(err, SP_EINVAL, "strain %g, its magnitude must be 1e-12 .. 0.01", opt->strain);
    if (net->n_all != p->n)
        return sp_fail(err, SP_EINVAL, "network of a packing of %d grains, must be that of this packing, of %d",
                       net->n_all, p->n);
    strain_run r = {.p = p, .net = net, .strain = -opt->strain};
    sp_stiffness c = {0};
    sp_status status = sp_cell_need_flat(net->cell, "an imposed strain", err);
    if (status == SP_OK)
        status = open_run(&r, err);
    r.m.straight = !opt->turning;
    if (status == SP_OK)
        status = strain_all(&r, &c, err);
    if (status == SP_OK) {
        c.residual = r.out.residual;
        sp_moduli_from_stiffness(net, phi3s, &c, &r.out.moduli);
        *out = r.out;
    }
    sp_free(r.springs.springs);
    sp_free(r.springs.length);
    sp_free(r.row);
    sp_free(r.u);
    sp_vibration_free(&r.m);
    sp_equilibrium_free(&r.current);
    sp_equilibrium_free(&r.stiffened);
    sp_equilibrium_free(&r.initial);
    return status;
}
