/* The linear response of a packing to a change of its pressure. */
#include "sensitivity/gradient.h"

#include "base/base.h"
#include "base/vector.h"
#include "elastic/equilibrium.h"
#include "elastic/strain.h"
#include "network/network_cell.h"
#include "sensitivity/products.h"

#include <math.h>

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

sp_status sp_gradient_compress(const sp_network *net, sp_compression_response *out, sp_error *err) {
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
        *out =
            (sp_compression_response){change, -(end_strain(net) - first_strain(net)) / stress, 1e3 * residual + 1e-12};
    } else {
        sp_free(change);
    }
    sp_free(work);
    sp_equilibrium_free(&e);
    return status;
}
