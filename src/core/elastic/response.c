/* The static response of a network, K u = f, to forces, to grains that swell, and to affine strains. */
#include "base/base.h"
#include "base/vector.h"
#include "elastic/equilibrium.h"
#include "elastic/strain.h"
#include "network/rows.h"
#include "packing/contact.h"

#include <math.h>
#include <sonopack/elastic.h>

/* What a load does to a spring before the grains move: the stretch of its rows. */
static void own_stretch(const sp_network *net, const sp_load *load, int32_t k, const sp_rows *rows, double *stretch) {
    const sp_spring *s = &net->springs[k];
    double gap[3] = {0};
    if (load->kind == SP_LOAD_STRAIN)
        sp_strain_displacement(net, load->axis, s->n, net->length[k], gap);
    for (int q = 0; q < rows->count; q++)
        stretch[q] = load->kind == SP_LOAD_STRAIN ? dot3(rows->gap[q], gap) : 0;
    if (load->kind == SP_LOAD_SWELL && (s->i == load->at || s->j == load->at)) /* row 0 is that of the normal */
        stretch[0] -= s->i == load->at ? s->ri : s->rj;
}

/* f = -B^T k (own stretch), and the scale of its terms. */
static double spring_loads(const sp_network *net, const sp_load *load, double *f) {
    double squares = 0, stretch[SP_ROWS_MAX];
    sp_rows rows;
    for (int32_t k = 0; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        sp_network_rows(net, s, &rows);
        own_stretch(net, load, k, &rows, stretch);
        for (int q = 0; q < rows.count; q++) {
            const double force = rows.k[q] * stretch[q];
            squares += force * force;
            for (int a = 0; a < rows.width; a++)
                f[sp_strain_index(net, s, a)] -= force * rows.b[q][a];
        }
    }
    return sqrt(squares);
}

static double mass_along(const sp_network *net, int axis) {
    double all = 0;
    for (int64_t k = axis; k < sp_network_dofs(net); k += net->dof)
        all += net->mass[k];
    return all;
}

/* Where the network as a whole can move, a force is balanced by the opposite one, spread over all masses. */
static double unit_force(const sp_equilibrium *e, const sp_load *load, double *f) {
    const sp_network *net = e->net;
    f[(int64_t)load->at * net->dof + load->axis] = 1;
    if (load->axis >= e->loose)
        return 1;
    const double all = mass_along(net, load->axis);
    for (int64_t k = load->axis; k < sp_network_dofs(net); k += net->dof)
        f[k] -= net->mass[k] / all;
    return 1;
}

/* Forces of 1 that push the two ends of a spring apart. */
static double dipole(const sp_network *net, const sp_load *load, double *f) {
    const sp_spring *s = &net->springs[load->at];
    for (int a = 0; a < net->dim; a++) {
        f[(int64_t)s->i * net->dof + a] -= s->n[a];
        if (s->j >= 0)
            f[(int64_t)s->j * net->dof + a] += s->n[a];
    }
    return 1;
}

static sp_status check_load(const sp_network *net, const sp_load *load, bool grips, sp_error *err) {
    const int32_t most = load->kind == SP_LOAD_DIPOLE ? net->n_springs : net->n;
    if (load->kind == SP_LOAD_STRAIN)
        return !sp_strain_allowed(net, load->axis, grips)
                   ? sp_fail(err, SP_EREFUSED, "walls without friction cannot shear the packing")
                   : sp_strain_check(net, err);
    if (load->at < 0 || load->at >= most)
        return sp_fail(err, SP_EINVAL, "load at %d, must be 0 .. %d", load->at, most - 1);
    if (load->kind == SP_LOAD_FORCE && (load->axis < 0 || load->axis >= net->dim))
        return sp_fail(err, SP_EINVAL, "force along axis %d, must be 0 .. %d", load->axis, net->dim - 1);
    return SP_OK;
}

/* Changes of the forces of all springs: normal ones, positive in compression, and the sizes of tangential ones. */
static void find_forces(const sp_network *net, const sp_load *load, sp_response *r) {
    double stretch[SP_ROWS_MAX];
    sp_rows rows;
    for (int32_t k = 0; k < net->n_springs; k++) {
        double sides = 0, *force = r->force + 3 * (int64_t)k;
        sp_network_rows(net, &net->springs[k], &rows);
        own_stretch(net, load, k, &rows, stretch);
        for (int q = 0; q < rows.count; q++) {
            for (int a = 0; a < rows.width; a++)
                stretch[q] += rows.b[q][a] * r->u[sp_strain_index(net, &net->springs[k], a)];
            if (q > 0)
                sides += rows.k[q] * stretch[q] * rows.k[q] * stretch[q];
            for (int a = 0; a < net->dim; a++)
                force[a] += rows.k[q] * stretch[q] * rows.gap[q][a];
        }
        r->fn[k] = -rows.k[0] * stretch[0];
        r->ft[k] = sqrt(sides);
    }
}

/* The displacement is exact for a load that differs by `error` of it: by the residual, and by the rounding of the
 * residual. */
static double error_of(sp_equilibrium *e, const double *f, double scale, const double *u, double *rest, double *size) {
    const double off = sp_equilibrium_residual(e, f, u, rest), load = sp_norm(sp_network_dofs(e->net), f);
    sp_strain_rounding(e->net, -1, u, size, NULL);
    const double rounding =
        sp_strain_noise(e->net) * (sp_norm(sp_network_dofs(e->net), size) + sqrt((double)e->count) * scale);
    return (off + rounding) / load;
}

/* Of all solutions the one whose mass stays where it is, along axes along which the whole can move. */
static void hold_mass(const sp_equilibrium *e, double *u) {
    const sp_network *net = e->net;
    for (int a = 0; a < e->loose; a++) {
        const double all = mass_along(net, a);
        double moved = 0;
        for (int64_t k = a; k < sp_network_dofs(net); k += net->dof)
            moved += net->mass[k] * u[k];
        for (int64_t k = a; k < sp_network_dofs(net); k += net->dof)
            u[k] -= moved / all;
    }
}

/* The same of the turn about the centre of two rings that let the whole turn. */
static void hold_turn(const sp_network *net, double *u) {
    double turned = 0, inertia = 0;
    for (int32_t k = net->n_bulk; k < net->n_springs; k++)
        if (net->springs[k].kt > 0)
            return;
    for (int pass = 0; pass < 2; pass++)
        for (int32_t i = 0; i < net->n; i++) {
            const double *x = net->x + 3 * (int64_t)i, *mass = net->mass + (int64_t)i * net->dof;
            const double turn[3] = {0.5 * net->box[0] - x[1], x[0] - 0.5 * net->box[0], 1};
            for (int a = 0; a < net->dof; a++) {
                double *to = u + (int64_t)i * net->dof + a;
                *to -= pass == 1 ? turned / inertia * turn[a] : 0;
                turned += pass == 0 ? mass[a] * turn[a] * *to : 0;
                inertia += pass == 0 ? mass[a] * turn[a] * turn[a] : 0;
            }
        }
}

static sp_status respond(sp_equilibrium *e, const sp_load *load, sp_response *r, sp_error *err) {
    const sp_network *net = e->net;
    const int64_t n = sp_network_dofs(net);
    double *work = sp_alloc(3 * (size_t)n, sizeof *work), residual = 0;
    if (!work)
        return sp_fail_memory(err, 3 * (size_t)n * sizeof *work);
    double *f = work, *rest = work + n, *size = work + 2 * n;
    const double scale = load->kind == SP_LOAD_FORCE    ? unit_force(e, load, f)
                         : load->kind == SP_LOAD_DIPOLE ? dipole(net, load, f)
                                                        : spring_loads(net, load, f);
    sp_status status = sp_equilibrium_solve(e, f, scale, r->u, &residual, err);
    if (status == SP_OK && !(residual <= 1e-8 * sp_norm(n, f)) && residual > 1e-14 * scale)
        status = sp_equilibrium_refuse(e, "the response", sp_norm(n, f), f, r->u, err);
    if (status == SP_OK) {
        hold_mass(e, r->u);
        if (net->cell == SP_CELL_RING)
            hold_turn(net, r->u);
        r->work = 0.5 * sp_dot(n, f, r->u);
        r->error = error_of(e, f, scale, r->u, rest, size);
        find_forces(net, load, r);
    }
    sp_free(work);
    return status;
}

/* ---- limits of the contacts -------------------------------------------------------------------------------------- */

/* The root nearest to 0 of a e^2 + 2 b e + c, c < 0, and of the normal force n + e dn: the other sheet of the cone lies
 * behind that, and both forces of a grain with two contacts keep their directions, so that they pass through the tip.
 */
static double nearest_exit(double a, double b, double c, double n, double dn) {
    const double q = -(b + copysign(sqrt(fmax(0, b * b - a * c)), b)), roots[2] = {q / a, c / q};
    double nearest = dn == 0 ? INFINITY : -n / dn;
    for (int k = 0; k < 2; k++)
        if (fabs(roots[k]) < fabs(nearest))
            nearest = roots[k];
    return nearest;
}

void sp_response_limits(const sp_packing *p, const sp_network *net, const sp_response *r, int32_t spring, double *opens,
                        double *slides) {
    const sp_contact *c = &p->contacts[net->springs[spring].contact];
    const double *n = net->springs[spring].n, *force = r->force + 3 * (int64_t)spring,
                 mu = contact_smooth(c) ? 0 : contact_mu(p, c);
    const double dn = r->fn[spring], ft = length3(c->ft);
    double change[3];
    for (int a = 0; a < 3; a++)
        change[a] = force[a] + dn * n[a];
    const double off = (ft - mu * c->fn) * (ft + mu * c->fn);
    *opens = dn == 0 ? INFINITY : -c->fn / dn;
    *slides = mu == 0    ? INFINITY
              : off >= 0 ? 0
                         : nearest_exit(dot3(change, change) - mu * mu * dn * dn,
                                        dot3(c->ft, change) - mu * mu * c->fn * dn, off, c->fn, dn);
}

/* ---- a response -------------------------------------------------------------------------------------------------- */

sp_response sp_response_none(void) { return (sp_response){0}; }

void sp_response_free(sp_response *r) {
    sp_free(r->u); /* all arrays are one block */
    *r = sp_response_none();
}

sp_status sp_response_make(const sp_network *net, const sp_load *load, sp_response *out, sp_error *err) {
    sp_equilibrium e = sp_equilibrium_none();
    sp_response r = {.n = sp_network_dofs(net), .springs = net->n_springs};
    sp_status status = sp_network_need_symmetry(net, "a response", err);
    if (status == SP_OK)
        status = sp_equilibrium_make(net, &e, err);
    if (status == SP_OK)
        status = check_load(net, load, e.grips, err);
    const size_t size = (size_t)r.n + 5 * (size_t)r.springs;
    if (status == SP_OK && !(r.u = sp_alloc(size, sizeof *r.u)))
        status = sp_fail_memory(err, size * sizeof *r.u);
    if (status == SP_OK) {
        r.fn = r.u + r.n;
        r.ft = r.fn + r.springs;
        r.force = r.ft + r.springs;
        status = respond(&e, load, &r, err);
    }
    sp_equilibrium_free(&e);
    if (status == SP_OK)
        *out = r;
    else
        sp_response_free(&r);
    return status;
}
