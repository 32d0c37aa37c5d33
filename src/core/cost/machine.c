/* How fast this machine is: small pieces of real work, the same every time, against their times on the machine on which
 * the laws were fitted. */
#include <sonopack/cost.h>

#include "base/base.h"

#include <math.h>
#include <sonopack/elastic.h>
#include <stdlib.h>

enum { RUNS = 3 };

/* Median milliseconds on the machine of the laws. */
static const double reference[SP_KERNELS] = {
    [SP_KERNEL_STEP] = 1.74, [SP_KERNEL_PRODUCT] = 1.75, [SP_KERNEL_DENSE] = 6.05, [SP_KERNEL_SPARSE] = 3.66};

/* What the kernels work on. */
typedef struct samples {
    sp_pack_spec uneven; /* a lattice that is compressed */
    sp_network large, small;
} samples;

sp_machine sp_machine_reference(void) {
    sp_machine m;
    for (int k = 0; k < SP_KERNELS; k++)
        m.slower[k] = 1;
    return m;
}

static sp_status make_lattice(int32_t grains, double width, sp_network *out, sp_error *err) {
    const sp_network_options options = sp_network_options_default();
    sp_pack_spec spec = sp_pack_spec_default();
    sp_packing p = sp_packing_none();
    spec.kind = SP_PACK_TRIANGULAR;
    spec.grains = grains;
    spec.width = width;
    sp_status status = sp_packing_make(&spec, NULL, NULL, &p, err);
    if (status == SP_OK)
        status = sp_network_make(&p, &options, out, err);
    sp_packing_free(&p);
    return status;
}

static sp_status make_samples(samples *s, sp_error *err) {
    *s = (samples){.uneven = sp_pack_spec_default(), .large = sp_network_none(), .small = sp_network_none()};
    s->uneven.kind = SP_PACK_TRIANGULAR;
    s->uneven.grains = 300;
    s->uneven.width = 20;
    s->uneven.diameter_min = 0.99;
    s->uneven.diameter_max = 1.01;
    s->uneven.max_steps = 400;
    sp_status status = make_lattice(400, 20, &s->large, err);
    return status == SP_OK ? make_lattice(80, 8, &s->small, err) : status;
}

/* 400 steps, which do not suffice: that is no failure here. */
static sp_status take_steps(const samples *s, sp_error *err) {
    sp_packing p = sp_packing_none();
    sp_status status = sp_packing_make(&s->uneven, NULL, NULL, &p, err);
    sp_packing_free(&p);
    return status == SP_EFAILED ? SP_OK : status;
}

static sp_status multiply(const samples *s, sp_error *err) {
    sp_signal_options o = sp_signal_options_default();
    sp_signal signal = sp_signal_none();
    o.method = SP_SIGNAL_CHEBYSHEV;
    o.until = 1000;
    o.points = 2;
    sp_status status = sp_signal_make(&s->large, &o, &signal, err);
    sp_signal_free(&signal);
    return status;
}

static sp_status find_modes(const samples *s, sp_error *err) {
    const sp_modes_options o = sp_modes_options_default();
    sp_modes modes = sp_modes_none();
    sp_status status = sp_modes_dense(&s->small, &o, &modes, err);
    sp_modes_free(&modes);
    return status;
}

static sp_status factor(const samples *s, sp_error *err) {
    sp_moduli moduli;
    return sp_moduli_make(&s->large, 1, &moduli, err);
}

static int ascending(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Median of some runs, after one that fills the caches and loads the library. */
static sp_status measure(sp_status (*kernel)(const samples *s, sp_error *err), const samples *s, double *ms,
                         sp_error *err) {
    double took[RUNS];
    sp_status status = kernel(s, err);
    for (int k = 0; k < RUNS && status == SP_OK; k++) {
        const double begun = sp_clock_cpu();
        status = kernel(s, err);
        took[k] = 1e3 * (sp_clock_cpu() - begun);
    }
    if (status != SP_OK)
        return status;
    qsort(took, RUNS, sizeof *took, ascending);
    *ms = took[RUNS / 2];
    return SP_OK;
}

sp_status sp_machine_measure(unsigned kernels, sp_machine *out, sp_error *err) {
    static sp_status (*const kernel[SP_KERNELS])(const samples *, sp_error *) = {[SP_KERNEL_STEP] = take_steps,
                                                                                 [SP_KERNEL_PRODUCT] = multiply,
                                                                                 [SP_KERNEL_DENSE] = find_modes,
                                                                                 [SP_KERNEL_SPARSE] = factor};
    samples s;
    sp_machine m = sp_machine_reference();
    double sum = 0;
    int count = 0;
    sp_status status = make_samples(&s, err);
    for (int k = 0; k < SP_KERNELS && status == SP_OK; k++) {
        double ms;
        if (!(kernels >> k & 1))
            continue;
        status = measure(kernel[k], &s, &ms, err);
        if (status != SP_OK)
            break;
        m.slower[k] = ms / reference[k];
        sum += log(m.slower[k]);
        count++;
    }
    for (int k = 0; k < SP_KERNELS && count > 0; k++)
        if (!(kernels >> k & 1))
            m.slower[k] = exp(sum / count);
    sp_network_free(&s.large);
    sp_network_free(&s.small);
    if (status == SP_OK)
        *out = m;
    return status;
}
