/* Measures the sound of one packing. */
#include "inference/quantities.h"

#include "base/base.h"

#include <math.h>
#include <sonopack/elastic.h>
#include <sonopack/modes.h>
#include <stdio.h>
#include <string.h>

static const char *const front_names[SP_FRONT_MARKS] = {"t10", "t_peak", "peak", "width", "c"};
static const char *const moduli_plane[] = {"C11", "C12", "C22", "C33", "c_l", "c_t"};
static const char *const moduli_space[] = {"C11", "C12", "C13", "C22", "C23", "C33", "C44", "C55", "C66", "c_l", "c_t"};
enum { MODULI_CHAIN = 2, MODULI_PLANE = 6, MODULI_SPACE = 11 };

static int count_moduli(const sp_quantities *q) {
    if (!q->moduli)
        return 0;
    return q->dim == 1 ? MODULI_CHAIN : q->dim == 2 ? MODULI_PLANE : MODULI_SPACE;
}

sp_quantities sp_quantities_of(const sp_network *net, const sp_uncertainty_options *opt) {
    sp_quantities q = {.opt = opt, .dim = net->dim, .moduli = opt->moduli, .modes = opt->modes};
    q.front = sp_network_touches(net, SP_BOTTOM) && sp_network_touches(net, SP_TOP);
    q.window = sp_signal_window(net->box[net->dim - 1], net->pressure);
    q.n = (q.front ? SP_FRONT_MARKS : 0) + count_moduli(&q) + q.modes;
    return q;
}

static const char *modulus_name(int dim, int k) {
    static const char *const chain[MODULI_CHAIN] = {"C22", "c_l"};
    return dim == 1 ? chain[k] : dim == 2 ? moduli_plane[k] : moduli_space[k];
}

void sp_quantity_name(const sp_quantities *q, int32_t k, char name[24], char unit[40]) {
    static const char *const marks[SP_FRONT_MARKS] = {"d/sqrt(E* / rho)", "d/sqrt(E* / rho)", "E* d^2",
                                                      "d/sqrt(E* / rho)", "sqrt(E* / rho)"};
    const int fronts = q->front ? SP_FRONT_MARKS : 0, moduli = count_moduli(q);
    if (k < fronts) {
        snprintf(name, 24, "%s", front_names[k]);
        snprintf(unit, 40, "%s", marks[k]);
    } else if (k < fronts + moduli) {
        snprintf(name, 24, "%s", modulus_name(q->dim, k - fronts));
        snprintf(unit, 40, "%s", name[0] == 'C' ? "E*" : "sqrt(E* / rho)");
    } else {
        snprintf(name, 24, "omega_%d", k - fronts - moduli + 1);
        snprintf(unit, 40, "sqrt(E* / rho)/d");
    }
}

/* Twice as dense a grid moves t10 by less than 1e-5 of itself: study/ensemble looks for fronts on the same. */
double sp_inference_spacing(double pressure) { return 0.1 * pow(pressure / 1e-4, -1.0 / 6); }

sp_status sp_inference_signal(const sp_network *net, sp_source source, double window, sp_signal *out, sp_error *err) {
    const double points = ceil(window / sp_inference_spacing(net->pressure)) + 1;
    if (!(points < 1e8))
        return sp_fail(err, SP_EINVAL, "a window of %g at pressure %g needs %g points, at most 1e8", window,
                       net->pressure, points);
    sp_signal_options o = sp_signal_options_default();
    o.method = SP_SIGNAL_CHEBYSHEV;
    o.source = source;
    o.until = window;
    o.points = points > 3 ? (int32_t)points : 3;
    return sp_signal_make(net, &o, out, err);
}

static sp_status measure_front(const sp_quantities *q, const sp_network *net, double *value, sp_error *err) {
    const sp_front_options rule = sp_front_options_default();
    sp_signal s = sp_signal_none();
    sp_front f;
    sp_status status = sp_inference_signal(net, q->opt->source, q->window, &s, err);
    if (status == SP_OK)
        status = sp_front_find(s.n, s.t, s.f, &rule, &f, err);
    if (status == SP_OK) {
        const double marks[SP_FRONT_MARKS] = {f.t10, f.t_peak, f.amplitude, f.width, net->box[net->dim - 1] / f.t10};
        memcpy(value, marks, sizeof marks);
    }
    sp_signal_free(&s);
    return status;
}

static sp_status measure_moduli(const sp_quantities *q, const sp_packing *p, const sp_network *net, double *value,
                                sp_error *err) {
    double density;
    sp_moduli m;
    sp_status status = sp_packing_density(p, q->opt->network.threshold, q->opt->margin, &density, err);
    if (status == SP_OK)
        status = sp_moduli_make(net, density, &m, err);
    if (status != SP_OK)
        return status;
    const double chain[MODULI_CHAIN] = {m.c22, m.c_l};
    const double plane[MODULI_PLANE] = {m.c11, m.c12, m.c22, m.c33, m.c_l, m.c_t};
    const double space[MODULI_SPACE] = {m.c11, m.c12, m.c13, m.c22, m.c23, m.c33, m.c44, m.c55, m.c66, m.c_l, m.c_t};
    memcpy(value, q->dim == 1 ? chain : q->dim == 2 ? plane : space, (size_t)count_moduli(q) * sizeof *value);
    return SP_OK;
}

static sp_status measure_modes(const sp_quantities *q, const sp_network *net, double *value, sp_error *err) {
    sp_modes_options o = sp_modes_options_default();
    const sp_modes_range range = sp_modes_range_lowest(q->modes);
    sp_modes m = sp_modes_none();
    /* Samples are computed side by side, and ARPACK allows one search at a time. Lanczos needs a larger space than that
     * of the wanted modes. */
    o.solver = sp_network_dofs(net) < 10 * (int64_t)q->modes + 100 ? SP_SOLVER_DENSE : SP_SOLVER_LANCZOS;
    sp_status status = sp_modes_make(net, &o, &range, &m, err);
    for (int32_t k = 0; k < q->modes && status == SP_OK; k++)
        value[k] = m.omega[k];
    sp_modes_free(&m);
    return status;
}

sp_status sp_quantities_measure(const sp_quantities *q, const sp_packing *p, double *value, int32_t *contacts,
                                sp_error *err) {
    sp_network net = sp_network_none();
    const int fronts = q->front ? SP_FRONT_MARKS : 0;
    sp_status status = sp_network_make(p, &q->opt->network, &net, err);
    if (status == SP_OK && q->front)
        status = measure_front(q, &net, value, err);
    if (status == SP_OK && q->moduli)
        status = measure_moduli(q, p, &net, value + fronts, err);
    if (status == SP_OK && q->modes > 0)
        status = measure_modes(q, &net, value + fronts + count_moduli(q), err);
    *contacts = net.n_springs;
    sp_network_free(&net);
    return status;
}
