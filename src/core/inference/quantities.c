/* Measures the sound of one packing. */
#include "inference/uncertain.h"

#include "base/base.h"
#include "sensitivity/gradient.h"

#include <math.h>
#include <sonopack/elastic.h>
#include <sonopack/modes.h>
#include <stdio.h>
#include <string.h>

sp_quantities sp_quantities_of(const sp_network *net, const sp_uncertainty_options *opt) {
    static const sp_modulus all[] = {SP_MODULUS_C11, SP_MODULUS_C12, SP_MODULUS_C13, SP_MODULUS_C22,
                                     SP_MODULUS_C23, SP_MODULUS_C33, SP_MODULUS_C44, SP_MODULUS_C55,
                                     SP_MODULUS_C66, SP_MODULUS_CL,  SP_MODULUS_CT};
    sp_quantities q = {.opt = opt, .modes = opt->modes};
    if (sp_network_touches(net, SP_BOTTOM) && sp_network_touches(net, SP_TOP))
        q.fronts = SP_FRONT_MARKS;
    for (int k = 0; k < SP_MODULUS_COUNT && opt->moduli; k++)
        if (sp_modulus_exists(net->dim, all[k]))
            q.modulus[q.moduli++] = all[k];
    q.window = sp_signal_window(net->box[net->dim - 1], net->pressure);
    q.n = q.fronts + q.moduli + q.modes;
    return q;
}

void sp_quantity_name(const sp_quantities *q, int32_t k, char name[24], char unit[40]) {
    static const char *const marks[SP_FRONT_MARKS][2] = {{"t10", "d/sqrt(E* / rho)"},
                                                         {"t_peak", "d/sqrt(E* / rho)"},
                                                         {"peak", "E* d^2"},
                                                         {"width", "d/sqrt(E* / rho)"},
                                                         {"c", "sqrt(E* / rho)"}};
    if (k < q->fronts) {
        snprintf(name, 24, "%s", marks[k][0]);
        snprintf(unit, 40, "%s", marks[k][1]);
    } else if (k < q->fronts + q->moduli) {
        snprintf(name, 24, "%s", sp_modulus_name(q->modulus[k - q->fronts]));
        snprintf(unit, 40, "%s", name[0] == 'C' ? "E*" : "sqrt(E* / rho)");
    } else {
        snprintf(name, 24, "omega_%d", k - q->fronts - q->moduli + 1);
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
    for (int k = 0; k < q->moduli && status == SP_OK; k++)
        value[k] = sp_modulus_value(&m, q->modulus[k]);
    return status;
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
    sp_status status = sp_network_make(p, &q->opt->network, &net, err);
    if (status == SP_OK && q->fronts > 0)
        status = measure_front(q, &net, value, err);
    if (status == SP_OK && q->moduli > 0)
        status = measure_moduli(q, p, &net, value + q->fronts, err);
    if (status == SP_OK && q->modes > 0)
        status = measure_modes(q, &net, value + q->fronts + q->moduli, err);
    *contacts = net.n_springs;
    sp_network_free(&net);
    return status;
}
