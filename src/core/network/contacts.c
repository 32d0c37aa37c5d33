/* Creates the network of a packing from its contacts. */
#include "network/contacts.h"
#include "base/base.h"
#include "base/vector.h"
#include "network/bound.h"
#include "packing/contact.h"
#include "packing/geometry.h"

#include <math.h>
#include <sonopack/network.h>
#include <string.h>

static sp_status make_grains(const sp_packing *p, const uint8_t *rattler, int32_t *row, sp_network *net,
                             sp_error *err) {
    const size_t n = (size_t)net->n, dof = (size_t)net->dof;
    net->grain = sp_alloc(n, sizeof *net->grain);
    net->mass = sp_alloc(n * dof, sizeof *net->mass);
    net->x = sp_alloc(3 * n, sizeof *net->x);
    net->r = sp_alloc(n, sizeof *net->r);
    if (!net->grain || !net->mass || !net->x || !net->r)
        return sp_fail_memory(err, n * (dof + 5) * sizeof(double));
    int32_t k = 0;
    for (int32_t i = 0; i < p->n; i++) {
        row[i] = rattler[i] ? -1 : k;
        if (rattler[i])
            continue;
        const double mass = p->mass ? p->mass[i] : grain_mass(p->r[i]);
        const double inertia = p->mass ? p->inertia[i] : grain_inertia(p->r[i]);
        if (!isnormal(mass) || (net->dof > net->dim && !isnormal(inertia)))
            return sp_fail(err, SP_EFORMAT,
                           "grain %d: r = %g, mass or moment of inertia is beyond the range of numbers", i, p->r[i]);
        net->grain[k] = i;
        net->r[k] = p->r[i];
        for (size_t a = 0; a < 3; a++)
            net->x[3 * (size_t)k + a] = p->x[3 * (size_t)i + a];
        for (size_t a = 0; a < dof; a++)
            net->mass[(size_t)k * dof + a] = a < (size_t)net->dim ? mass : inertia;
        k++;
    }
    return SP_OK;
}

/* Whether a contact is within 1% of the Coulomb limit; contacts that slid last are a little below it. */
static bool slides(const sp_packing *p, const sp_contact *c) {
    return length3(c->ft) >= contact_mu(p, c) * c->fn * (1 - 1e-2);
}

/* What the slip at the edge of a contact leaves of its tangential stiffness. */
static double slip_factor(const sp_packing *p, const sp_network_options *opt, const sp_contact *c) {
    if (opt->tangential == SP_SPRINGS_CONSTANT)
        return 1;
    const double q = fmin(1, length3(c->ft) / (contact_mu(p, c) * c->fn));
    return cbrt(opt->tangential == SP_SPRINGS_LOADING ? 1 - q : 0.5 * (1 - q));
}

/* Stiffnesses by (A1), (A2), (A4), or the contact's own. A wall has no lever arm. */
static sp_status make_spring(const sp_packing *p, const sp_network_options *opt, int32_t contact, const int32_t *row,
                             sp_network *net, sp_error *err) {
    const sp_contact *c = &p->contacts[contact];
    const bool wall = c->j < 0;
    const double ri = p->r[c->i], rj = wall ? 0 : p->r[c->j];
    const double length = ri + rj - c->overlap, kn = contact_kn(p, c);
    if (!(length > 0 && kn > 0 && isfinite(kn)))
        return sp_fail(err, SP_EFORMAT,
                       "contact %d: overlap = %g, must be above 0 and below %g where a force is carried", contact,
                       c->overlap, ri + rj);
    sp_spring *s = &net->springs[net->n_springs];
    net->length[net->n_springs++] = length;
    *s = (sp_spring){.i = row[c->i], .j = wall ? c->j : row[c->j], .contact = contact, .kn = kn, .ri = ri, .rj = rj};
    for (int a = 0; a < net->dim; a++)
        s->n[a] = c->n[a];
    if (net->dof > net->dim && !(opt->sliding_free && slides(p, c)))
        s->kt = (c->kn > 0 ? c->kt : contact_eta(p->poisson) * kn) * slip_factor(p, opt, c);
    return SP_OK;
}

static sp_status make_springs(const sp_packing *p, const sp_network_options *opt, const uint8_t *carrying,
                              const int32_t *row, sp_network *net, sp_error *err) {
    size_t count = 0;
    for (int32_t c = 0; c < p->n_contacts; c++)
        count += carrying[c];
    net->springs = sp_alloc(count, sizeof *net->springs);
    net->length = sp_alloc(count, sizeof *net->length);
    if (!net->springs || !net->length)
        return sp_fail_memory(err, count * (sizeof *net->springs + sizeof *net->length));
    sp_status status = SP_OK;
    for (int walls = 0; walls < 2; walls++) {
        for (int32_t c = 0; c < p->n_contacts && status == SP_OK; c++)
            if (carrying[c] && (p->contacts[c].j < 0) == walls)
                status = make_spring(p, opt, c, row, net, err);
        if (!walls)
            net->n_bulk = net->n_springs;
    }
    return status;
}

/* The normal of a spring turns by the transverse displacement over this radius: the distance of the grains; at a flat
 * wall, whose normal is fixed, infinity; at a ring the distance of the grain from its centre, about which the inner one
 * turns the normal as a fixed grain would, and the outer one, which is hollow, the other way: negative. */
static double radius_of(const sp_packing *p, const sp_network *net, int32_t k) {
    const sp_spring *s = &net->springs[k];
    if (s->j >= 0)
        return net->length[k];
    if (p->cell != SP_CELL_RING)
        return INFINITY;
    const double level = sp_ring_level(p->box, net->x + 3 * (int64_t)s->i);
    return -sp_packing_wall_side(s->j) * (level + 0.5 * p->box[0] - p->box[1]);
}

/* Keeps the tangential forces if any is not 0. They are projected again, because a text file has few digits. */
static sp_status make_carried(const sp_packing *p, sp_network *net, sp_error *err) {
    bool any = false;
    net->carried = sp_alloc((size_t)net->n_springs, sizeof *net->carried);
    if (!net->carried)
        return sp_fail_memory(err, (size_t)net->n_springs * sizeof *net->carried);
    for (int32_t k = 0; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        const double *ft = p->contacts[s->contact].ft;
        sp_carried *held = &net->carried[k];
        held->turn = 1 / radius_of(p, net, k);
        const double off = dot3(ft, s->n);
        for (int a = 0; a < net->dim; a++) {
            held->ft[a] = ft[a] - off * s->n[a];
            any = any || held->ft[a] != 0;
        }
    }
    if (!any) {
        sp_free(net->carried);
        net->carried = NULL;
    }
    net->prestress = net->prestress || any;
    return SP_OK;
}

/* The forces at rest of a network without any. */
static sp_status make_forces(const sp_packing *p, sp_network *net, sp_error *err) {
    const int32_t turning = p->cell == SP_CELL_RING ? net->n_springs : net->n_bulk;
    for (int32_t k = 0; k < turning && net->dim > 1; k++) {
        net->springs[k].kp = -p->contacts[net->springs[k].contact].fn / radius_of(p, net, k);
        net->prestress = true;
    }
    return net->dof > net->dim ? make_carried(p, net, err) : SP_OK;
}

sp_status sp_network_prestress(const sp_packing *p, const sp_network *net, sp_network *out, sp_error *err) {
    const size_t springs = (size_t)net->n_springs * sizeof *net->springs;
    sp_network loaded = *net;
    loaded.springs = sp_alloc((size_t)net->n_springs, sizeof *loaded.springs);
    if (!loaded.springs)
        return sp_fail_memory(err, springs);
    memcpy(loaded.springs, net->springs, springs);
    sp_status status = make_forces(p, &loaded, err);
    if (status == SP_OK)
        status = sp_network_find_bounds(&loaded, err);
    if (status == SP_OK)
        *out = loaded;
    else
        sp_network_release_prestress(&loaded);
    return status;
}

void sp_network_release_prestress(sp_network *net) {
    sp_free(net->springs);
    sp_free(net->carried);
    *net = sp_network_none();
}

static int degrees_of_freedom(const sp_packing *p) {
    if (p->dim == 1 || !(p->friction > 0))
        return p->dim;
    return p->dim == 2 ? 3 : 6;
}

static sp_status check_tangential(const sp_packing *p, const sp_network_options *opt, sp_error *err) {
    if (opt->tangential != SP_SPRINGS_LOADING && opt->tangential != SP_SPRINGS_LOWEST)
        return sp_fail(err, SP_EINVAL, "tangential stiffness %d, must be constant, loading or lowest",
                       (int)opt->tangential);
    return sp_packing_need_law(p, "tangential stiffness by loading history", err);
}

sp_status sp_network_make(const sp_packing *p, const sp_network_options *opt, sp_network *out, sp_error *err) {
    sp_network net = sp_network_none();
    uint8_t *rattler = NULL, *carrying = NULL;
    int32_t *row = NULL;
    sp_status status;
    if (!(opt->threshold >= 0 && isfinite(opt->threshold)))
        return sp_fail(err, SP_EINVAL, "threshold = %g, must be a fraction of the pressure, 0 or more", opt->threshold);
    if (p->dim < 1 || p->dim > 3)
        return sp_fail(err, SP_EINVAL, "packing of dimension %d, must be 1, 2 or 3", p->dim);
    if (opt->tangential != SP_SPRINGS_CONSTANT) {
        status = check_tangential(p, opt, err);
        if (status != SP_OK)
            return status;
    }
    rattler = sp_alloc((size_t)p->n, 1);
    carrying = sp_alloc((size_t)p->n_contacts, 1);
    row = sp_alloc((size_t)p->n, sizeof *row);
    if (!rattler || !carrying || !row) {
        status = sp_fail_memory(err, 5 * (size_t)p->n + (size_t)p->n_contacts);
        goto out;
    }
    status = sp_packing_rattlers(p, opt->threshold, rattler, carrying, &net.rattlers, err);
    if (status != SP_OK)
        goto out;
    net.dim = p->dim;
    net.dof = degrees_of_freedom(p);
    net.n_all = p->n;
    net.n = p->n - net.rattlers;
    net.pressure = p->pressure;
    net.cell = p->cell;
    for (int a = 0; a < 3; a++) {
        net.box[a] = p->box[a];
        net.tilt[a] = p->tilt[a];
    }
    if (net.n == 0) {
        status = sp_fail(err, SP_EREFUSED, "no grain carries: all %d are rattlers above %g p", p->n, opt->threshold);
        goto out;
    }
    status = make_grains(p, rattler, row, &net, err);
    if (status == SP_OK)
        status = make_springs(p, opt, carrying, row, &net, err);
    if (status == SP_OK && opt->prestress)
        status = make_forces(p, &net, err);
    if (status == SP_OK)
        status = sp_network_find_bounds(&net, err);
out:
    sp_free(row);
    sp_free(carrying);
    sp_free(rattler);
    if (status == SP_OK)
        *out = net;
    else
        sp_network_free(&net);
    return status;
}
