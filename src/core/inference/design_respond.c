/* How a packing at rest follows a change of its radii: one solve with K for all grains. */
#include "inference/design.h"

#include "base/base.h"
#include "base/vector.h"
#include "elastic/equilibrium.h"

#include <math.h>
#include <string.h>

/* The top wall carries its load: it follows its contacts, whose stiffnesses add up. */
typedef struct wall {
    double stiffness; /* sum of k_n of its contacts */
    double slope;     /* derivative of Q by its height: its contacts lose overlap, and stiffness with it */
} wall;

static wall top_wall(const sp_packing *p, const sp_network *net, const sp_gradient *g) {
    wall w = {0};
    for (int32_t k = net->n_bulk; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        if (s->j != SP_TOP)
            continue;
        const double by_stiffness = s->kn * g->kn.d[k] + (g->kt.n > 0 ? s->kt * g->kt.d[k] : 0);
        w.stiffness += s->kn;
        w.slope -= by_stiffness / (2 * p->contacts[s->contact].overlap);
    }
    return w;
}

static double along(const sp_network *net, const sp_spring *s, const double *u) {
    double sum = 0;
    for (int a = 0; a < net->dim; a++) {
        const double there = s->j >= 0 ? u[(size_t)s->j * (size_t)net->dof + (size_t)a] : 0;
        sum += s->n[a] * (there - u[(size_t)s->i * (size_t)net->dof + (size_t)a]);
    }
    return sum;
}

static double product(int64_t n, const double *a, const double *b) {
    double sum = 0;
    for (int64_t k = 0; k < n; k++)
        sum += a[k] * b[k];
    return sum;
}

/* A larger radius pushes both grains of each contact apart; weight [dofs] is the change of Q for a unit force. */
static void add_pushes(const sp_network *net, const wall *w, double wall_weight, const double *weight,
                       double *by_radius) {
    for (int32_t k = 0; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        double push = s->kn * along(net, s, weight);
        if (s->j == SP_TOP)
            push += wall_weight * s->kn / w->stiffness;
        by_radius[s->i] += push;
        if (s->j >= 0)
            by_radius[s->j] += push;
    }
}

/* The wall's height h = d.u/k + ... turns K into K - d d^T/k, d: the detector. By Sherman and Morrison two solves with
 * K give one with that. weight enters as K^-1 of the right-hand side, z = K^-1 d. */
static void free_wall(int64_t dofs, double stiffness, const double *d, const double *z, double *weight) {
    const double scale = product(dofs, d, weight) / (stiffness - product(dofs, d, z));
    for (int64_t k = 0; k < dofs; k++)
        weight[k] += scale * z[k];
}

sp_status sp_design_respond(const sp_packing *p, const sp_network *net, const sp_gradient *g, double *by_radius,
                            sp_error *err) {
    const int64_t dofs = sp_network_dofs(net);
    const size_t size = (size_t)dofs;
    sp_equilibrium e = sp_equilibrium_none();
    double *work = sp_alloc(4 * size, sizeof *work), residual;
    double *d = work, *z = work + size, *right = work + 2 * size, *weight = work + 3 * size;
    const wall w = top_wall(p, net, g);
    sp_status status = work ? SP_OK : sp_fail_memory(err, 4 * size * sizeof *work);
    if (status == SP_OK)
        status = sp_network_detector(net, d, err);
    if (status == SP_OK)
        status = sp_equilibrium_make(net, &e, err);
    for (int32_t i = 0; i < net->n && status == SP_OK; i++)
        for (int a = 0; a < net->dim; a++) {
            const size_t k = (size_t)i * (size_t)net->dof + (size_t)a;
            right[k] = g->position.d[3 * (size_t)i + (size_t)a];
        }
    for (size_t k = 0; k < size && status == SP_OK; k++)
        right[k] += w.slope * d[k] / w.stiffness;
    if (status == SP_OK)
        status = sp_equilibrium_solve(&e, d, 0, z, &residual, err);
    if (status == SP_OK)
        status = sp_equilibrium_solve(&e, right, 0, weight, &residual, err);
    if (status == SP_OK) {
        free_wall(dofs, w.stiffness, d, z, weight);
        add_pushes(net, &w, product(dofs, weight, d) + w.slope, weight, by_radius);
    }
    sp_equilibrium_free(&e);
    sp_free(work);
    return status;
}
