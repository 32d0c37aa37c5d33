/* Gradients from products: stiffnesses, masses, geometry and pressure, and the check by Euler's theorem. */
#include "sensitivity/gradient.h"
#include "base/base.h"
#include "base/vector.h"
#include "elastic/equilibrium.h"
#include "elastic/strain.h"
#include "network/contacts.h"
#include "network/network_cell.h"
#include "packing/contact.h"
#include "packing/geometry.h"
#include "sensitivity/products.h"

#include <float.h>
#include <math.h>

static void partials_free(sp_partials *p) {
    sp_free(p->d);
    sp_free(p->error);
    *p = (sp_partials){0};
}

static sp_status partials_make(int64_t n, sp_partials *out, sp_error *err) {
    sp_partials p = {n, sp_alloc((size_t)n, sizeof *p.d), sp_alloc((size_t)n, sizeof *p.error)};
    *out = p;
    return p.d && p.error ? SP_OK : sp_fail_memory(err, 2 * (size_t)n * sizeof *p.d);
}

/* ---- what the contact law makes of radii and positions ----------------------------------------------------------- */

/* How the stiffnesses of a spring change with the overlap (at fixed radii), and with each radius at fixed overlap. */
typedef struct law_slopes {
    double kn, kt, kp;   /* with the overlap */
    double kn_radius[2]; /* with the radii of i and j, at fixed overlap */
    double kt_radius[2], kp_radius[2];
    double length_kp; /* of k_p = -F_n/length with the length, at a fixed force */
} law_slopes;

/* d ln e/dr of e = E12 sqrt(R12) with the radius r and the other one; other <= 0: a wall, where e is as sqrt(r). */
static double stiffness_slope(double r, double other) { return other > 0 ? 0.5 * other / (r * (r + other)) : 0.5 / r; }

static law_slopes law_of(const sp_network *net, const sp_packing *p, int32_t k) {
    const sp_spring *s = &net->springs[k];
    const sp_contact *c = &p->contacts[s->contact];
    const bool own = c->kn > 0, turns = s->kp != 0;
    const double ratio = s->kt / s->kn, r[2] = {p->r[c->i], c->j < 0 ? 0 : p->r[c->j]};
    law_slopes d = {0};
    if (!own) {
        d.kn = 0.5 * s->kn / c->overlap;
        d.kt = ratio * d.kn;
    }
    for (int end = 0; end < (c->j < 0 ? 1 : 2); end++) {
        const double slope = own ? 0 : stiffness_slope(r[end], r[1 - end]);
        d.kn_radius[end] = slope * s->kn;
        d.kt_radius[end] = slope * s->kt;
        d.kp_radius[end] = turns ? slope * s->kp : 0;
    }
    if (turns) {
        d.kp = -s->kn / net->length[k];
        d.length_kp = -s->kp / net->length[k];
    }
    return d;
}

static sp_status need_overlaps(const sp_network *net, const sp_packing *p, sp_error *err) {
    for (int32_t k = 0; k < net->n_springs; k++) {
        const int32_t at = net->springs[k].contact;
        if (at >= p->n_contacts)
            return sp_fail(err, SP_EINVAL, "contact %d of %d: the network is not that of this packing", at,
                           p->n_contacts);
        if (!(p->contacts[at].kn > 0) && !(p->contacts[at].overlap > 0))
            return sp_fail(err, SP_EREFUSED, "contact %d has the overlap %g: its stiffness has no derivative there", at,
                           p->contacts[at].overlap);
    }
    return SP_OK;
}

/* Error of a derivative by an overlap, from those by k_n and k_t. That by k_p is as the one by k_t at most: it has no
 * lever arms. */
static double error_of(const sp_products *p, int32_t k, double kn, double kt, double kp) {
    const double *e = p->error + 2 * (int64_t)k;
    return fabs(kn) * e[0] + (fabs(kt) + fabs(kp)) * (e[1] > e[0] ? e[1] : e[0]);
}

/* The separation is the length times the normal. A wall's normal is fixed. */
static void separate(const sp_products *p, const sp_packing *packing, int32_t k, double out[3], double *error) {
    const sp_network *net = p->net;
    const sp_spring *s = &net->springs[k];
    const law_slopes d = law_of(net, packing, k);
    const sp_stiffness_partials q = sp_products_stiffness(p, k);
    const double length = net->length[k];
    const double along = -(d.kn * q.kn + d.kt * q.kt + d.kp * q.kp) + d.length_kp * q.kp;
    const double *pull = p->pull + 3 * (int64_t)k, pulled = dot3(pull, s->n);
    double turn[3] = {0, 0, 0};
    if (s->j >= 0)
        sp_products_turn(p, k, turn);
    const double off = dot3(turn, s->n);
    for (int a = 0; a < 3; a++)
        out[a] = along * s->n[a] + (turn[a] - off * s->n[a]) / length + (s->j < 0 ? pulled * s->n[a] : pull[a]);
    const double stiff = 2 * (s->kn + s->kt + fabs(s->kp)) / length;
    *error = error_of(p, k, fabs(d.kn) + stiff, fabs(d.kt) + stiff, fabs(d.kp) + fabs(d.length_kp) + stiff);
}

/* Derivatives by the separation of the centres of each spring, [springs][3], and bounds of their errors, [springs]. */
static sp_status separations(const sp_products *p, const sp_packing *packing, double **separation, double **error,
                             sp_error *err) {
    const size_t springs = (size_t)p->net->n_springs;
    sp_status status = need_overlaps(p->net, packing, err);
    if (status != SP_OK)
        return status;
    *separation = sp_alloc(springs, 3 * sizeof **separation);
    *error = sp_alloc(springs, sizeof **error);
    if (!*separation || !*error)
        return sp_fail_memory(err, 4 * springs * sizeof(double));
    for (int32_t k = 0; k < p->net->n_springs; k++)
        separate(p, packing, k, *separation + 3 * (int64_t)k, *error + k);
    return SP_OK;
}

/* The mass of a sphere of unit density is as r^3. With masses of their own nothing of it changes: moments of inertia as
 * r^2, with rotations times the radius as displacements. */
static void add_mass(const sp_products *p, const sp_packing *packing, int32_t grain, sp_partials *out) {
    if (packing->mass)
        return;
    out->d[grain] += 3 * p->mass[grain] / p->net->r[grain];
    out->error[grain] += 3 * p->mass_error[grain] / p->net->r[grain];
}

/* Derivatives by the radii at fixed centres. */
static sp_status set_radii(const sp_products *p, const sp_packing *packing, sp_partials *out, sp_error *err) {
    const sp_network *net = p->net;
    sp_status status = need_overlaps(net, packing, err);
    if (status == SP_OK)
        status = partials_make(net->n, out, err);
    if (status != SP_OK)
        return status;
    for (int32_t k = 0; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        const law_slopes d = law_of(net, packing, k);
        const sp_stiffness_partials q = sp_products_stiffness(p, k);
        for (int end = 0; end < (s->j < 0 ? 1 : 2); end++) {
            const int32_t grain = end == 0 ? s->i : s->j;
            const double kn = d.kn + d.kn_radius[end], kt = d.kt + d.kt_radius[end], kp = d.kp + d.kp_radius[end];
            out->d[grain] += kn * q.kn + kt * q.kt + kp * q.kp;
            out->error[grain] += error_of(p, k, kn, kt, kp);
        }
    }
    for (int32_t k = 0; k < net->n; k++)
        add_mass(p, packing, k, out);
    return SP_OK;
}

/* ---- the linear response to a change of pressure ----------------------------------------------------------------- */

/* The linear response of the packing to its pressure. */
typedef struct compression {
    double *separation; /* [springs][3] change of the separations */
    double volume;      /* change of ln V */
    double error;       /* relative */
} compression;

/* The strains that the pressure imposes: under the piston the one from wall to wall, in other cells all uniaxial
 * strains alike, so that the cell keeps its shape. Moduli are for extension. */
static int first_strain(const sp_network *net) {
    if (net->dim == 1)
        return STRAIN_22;
    return net->cell == SP_CELL_PISTON ? net->dim - 1 : 0;
}

static int end_strain(const sp_network *net) { return net->dim == 1 ? STRAIN_22 + 1 : net->dim; }

/* The displacement of the grains in addition to the sum of the strains, and the mean normal stress. */
static sp_status respond(sp_equilibrium *e, double *f, double *one, double *u, double *stress, double *relative,
                         sp_error *err) {
    const sp_network *net = e->net;
    const int64_t n = sp_network_dofs(net);
    const int first = first_strain(net), end = end_strain(net);
    *stress = *relative = 0;
    for (int a = first; a < end; a++) {
        sp_stiffness s = {0};
        double residual = 0;
        const double scale = sp_strain_load(net, a, f);
        sp_status status = sp_equilibrium_solve(e, f, scale, one, &residual, err);
        if (status != SP_OK)
            return status;
        const double load = fmax(sp_norm(n, f), 1e-6 * scale);
        if (load > 0 && !(residual < 1e-8 * load))
            return sp_equilibrium_refuse(e, "pressure", load, f, one, err);
        sp_strain_stresses(net, a, one, &s);
        for (int b = first; b < end; b++)
            *stress += s.c[b][a] / (end - first);
        *relative = fmax(*relative, load > 0 ? residual / load : 0);
        for (int64_t k = 0; k < n; k++)
            u[k] += one[k];
    }
    return SP_OK;
}

/* A unit of pressure compresses by 1 over the modulus: the separations change by -(strain + u)/modulus. */
static void set_change(const sp_network *net, const double *u, double modulus, double *change) {
    for (int32_t k = 0; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        double local[SP_LOCAL_MAX] = {0}, strain[3], *to = change + 3 * (int64_t)k;
        sp_products_local(net, s, u, local);
        for (int a = 0; a < net->dim; a++)
            to[a] = -local[a] / modulus;
        for (int b = first_strain(net); b < end_strain(net); b++) {
            sp_strain_displacement(net, b, s->n, net->length[k], strain);
            for (int a = 0; a < 3; a++)
                to[a] -= strain[a] / modulus;
        }
    }
}

static sp_status respond_to_pressure(const sp_network *net, compression *out, sp_error *err) {
    const size_t n = (size_t)sp_network_dofs(net);
    sp_equilibrium e = sp_equilibrium_none();
    double *work = sp_alloc(3 * n, sizeof *work), *change = sp_alloc((size_t)net->n_springs, 3 * sizeof *change),
           stress;
    double residual;
    sp_status status = work && change ? SP_OK : sp_fail_memory(err, 3 * n * sizeof *work);
    if (status == SP_OK)
        status = sp_equilibrium_make(net, &e, err);
    if (status == SP_OK)
        status = respond(&e, work, work + n, work + 2 * n, &stress, &residual, err);
    if (status == SP_OK && !(stress > 0))
        status = sp_fail(err, SP_EREFUSED, "the modulus of the compression is %.3g, must be above 0", stress);
    if (status == SP_OK) {
        set_change(net, work + 2 * n, stress, change);
        *out = (compression){change, -(end_strain(net) - first_strain(net)) / stress, 1e3 * residual + 1e-12};
    } else {
        sp_free(change);
    }
    sp_free(work);
    sp_equilibrium_free(&e);
    return status;
}

/* The packing moves with its forces at rest, also where the network of the quantity leaves them out. */
static sp_status compress(const sp_network *net, const sp_packing *packing, compression *out, sp_error *err) {
    sp_network loaded = sp_network_none();
    if (net->prestress)
        return respond_to_pressure(net, out, err);
    sp_status status = sp_network_prestress(packing, net, &loaded, err);
    if (status == SP_OK)
        status = respond_to_pressure(&loaded, out, err);
    sp_network_release_prestress(&loaded);
    return status;
}

/* ---- gradients --------------------------------------------------------------------------------------------------- */

static const unsigned GEOMETRY = SP_BY_RADIUS | SP_BY_POSITION | SP_BY_PRESSURE;
static const unsigned ALL = 2 * SP_BY_PRESSURE - 1;

sp_gradient sp_gradient_none(void) { return (sp_gradient){.homogeneity = NAN, .homogeneity_size = NAN}; }

void sp_gradient_free(sp_gradient *g) {
    sp_partials *all[] = {&g->kn, &g->kt, &g->mass, &g->radius, &g->position, &g->pressure};
    for (size_t k = 0; k < sizeof all / sizeof *all; k++)
        partials_free(all[k]);
    *g = sp_gradient_none();
}

sp_status sp_gradient_check(const sp_network *net, unsigned parameters, const sp_packing *packing, sp_error *err) {
    if (parameters == 0 || parameters & ~ALL)
        return sp_fail(err, SP_EINVAL, "parameters %u, must be a sum of 1 .. %u", parameters, (unsigned)SP_BY_PRESSURE);
    if ((parameters & GEOMETRY) && !packing)
        return sp_fail(err, SP_EINVAL, "radii, positions and the pressure need the packing of the network");
    if ((parameters & GEOMETRY) && net->cell == SP_CELL_RING)
        return sp_cell_need_flat(net->cell, "a derivative by radii, positions or the pressure", err);
    return sp_network_need_symmetry(net, "a sensitivity", err);
}

/* With prestress the products of transverse displacements are needed too. */
bool sp_gradient_whole(const sp_network *net, unsigned parameters) {
    return (parameters & GEOMETRY) || (net->prestress && (parameters & (SP_BY_KN | SP_BY_KT)));
}

bool sp_gradient_masses(unsigned parameters) { return parameters & (SP_BY_MASS | SP_BY_RADIUS); }

/* The derivatives by k_n and k_t, and Euler's sum over k_n, k_t and k_p. */
static sp_status set_stiffnesses(const sp_products *p, unsigned parameters, double law, sp_gradient *g, sp_error *err) {
    const sp_network *net = p->net;
    const bool normal = parameters & SP_BY_KN, tangential = (parameters & SP_BY_KT) && net->dof > net->dim;
    sp_status status = normal ? partials_make(net->n_springs, &g->kn, err) : SP_OK;
    if (status == SP_OK && tangential)
        status = partials_make(net->n_springs, &g->kt, err);
    if (status != SP_OK)
        return status;
    double sum = 0, size = 0;
    for (int32_t k = 0; k < net->n_springs; k++) {
        const sp_stiffness_partials d = sp_products_stiffness(p, k);
        const sp_spring *s = &net->springs[k];
        sum += s->kn * d.kn + s->kt * d.kt + s->kp * d.kp;
        size += fabs(s->kn * d.kn) + fabs(s->kt * d.kt) + fabs(s->kp * d.kp);
        if (normal) {
            g->kn.d[k] = d.kn;
            g->kn.error[k] = p->error[2 * (int64_t)k];
        }
        if (tangential) {
            g->kt.d[k] = d.kt;
            g->kt.error[k] = p->error[2 * (int64_t)k + 1];
        }
    }
    if (normal && (tangential || net->dof == net->dim)) {
        g->homogeneity = sum - law;
        g->homogeneity_size = size + fabs(law);
    }
    return SP_OK;
}

static sp_status set_masses(const sp_products *p, sp_gradient *g, sp_error *err) {
    const sp_network *net = p->net;
    sp_status status = partials_make(net->n, &g->mass, err);
    for (int32_t k = 0; k < net->n && status == SP_OK; k++) {
        const double mass = net->mass[(int64_t)k * net->dof];
        g->mass.d[k] = p->mass[k] / mass;
        g->mass.error[k] = p->mass_error[k] / mass;
    }
    return status;
}

static sp_status set_positions(const sp_products *p, const double *separation, const double *error, sp_gradient *g,
                               sp_error *err) {
    const sp_network *net = p->net;
    sp_status status = partials_make(3 * (int64_t)net->n, &g->position, err);
    for (int32_t k = 0; k < net->n_springs && status == SP_OK; k++)
        for (int a = 0; a < net->dim; a++) {
            const sp_spring *s = &net->springs[k];
            const int64_t i = 3 * (int64_t)s->i + a, j = 3 * (int64_t)s->j + a;
            g->position.d[i] -= separation[3 * (int64_t)k + a];
            g->position.error[i] += error[k];
            if (s->j >= 0) {
                g->position.d[j] += separation[3 * (int64_t)k + a];
                g->position.error[j] += error[k];
            }
        }
    return status;
}

static sp_status set_pressure(const sp_products *p, const sp_packing *packing, const double *separation,
                              const double *error, sp_gradient *g, sp_error *err) {
    const int64_t n = 3 * (int64_t)p->net->n_springs;
    compression r = {0};
    double size = 0;
    sp_status status = partials_make(1, &g->pressure, err);
    if (status == SP_OK)
        status = compress(p->net, packing, &r, err);
    for (int64_t k = 0; k < n && status == SP_OK; k++) {
        g->pressure.d[0] += separation[k] * r.separation[k];
        g->pressure.error[0] += error[k / 3] * fabs(r.separation[k]);
        size += fabs(separation[k] * r.separation[k]);
    }
    if (status == SP_OK) {
        g->pressure.d[0] += p->by_volume * r.volume;
        g->pressure.error[0] += r.error * (size + fabs(p->by_volume * r.volume));
    }
    sp_free(r.separation);
    return status;
}

static sp_status set_geometry(const sp_products *p, unsigned parameters, const sp_packing *packing, sp_gradient *g,
                              sp_error *err) {
    double *separation = NULL, *error = NULL;
    sp_status status = SP_OK;
    if (parameters & (SP_BY_POSITION | SP_BY_PRESSURE))
        status = separations(p, packing, &separation, &error, err);
    if (status == SP_OK && separation && (parameters & SP_BY_POSITION))
        status = set_positions(p, separation, error, g, err);
    if (status == SP_OK && separation && (parameters & SP_BY_PRESSURE))
        status = set_pressure(p, packing, separation, error, g, err);
    if (status == SP_OK && (parameters & SP_BY_RADIUS))
        status = set_radii(p, packing, &g->radius, err);
    sp_free(separation);
    sp_free(error);
    return status;
}

sp_status sp_gradient_make(const sp_products *p, unsigned parameters, const sp_packing *packing, double law,
                           sp_gradient *out, sp_error *err) {
    sp_gradient g = sp_gradient_none();
    sp_status status = set_stiffnesses(p, parameters, law, &g, err);
    if (status == SP_OK && (parameters & SP_BY_MASS))
        status = set_masses(p, &g, err);
    if (status == SP_OK && (parameters & GEOMETRY))
        status = set_geometry(p, parameters, packing, &g, err);
    if (status == SP_OK)
        *out = g;
    else
        sp_gradient_free(&g);
    return status;
}
