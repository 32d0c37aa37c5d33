/* Statistics of participation ratios in bins of frequency. */
#include "base/base.h"

#include <math.h>
#include <sonopack/spectrum.h>

/* Running mean and variance (Welford 1962). */
static void add_value(sp_participation_bin *b, double x) {
    if (b->modes == 0) {
        b->least = b->largest = x;
        b->mean = b->sd = 0;
    }
    const double before = x - b->mean;
    b->modes++;
    b->mean += before / (double)b->modes;
    b->sd += before * (x - b->mean);
    b->least = fmin(b->least, x);
    b->largest = fmax(b->largest, x);
}

sp_status sp_participation(const sp_modes *modes, int32_t bins, double until, sp_participation_bin *out,
                           sp_error *err) {
    if (bins < 1)
        return sp_fail(err, SP_EINVAL, "bins = %d, must be 1 or more", bins);
    if (!(until >= 0 && isfinite(until)))
        return sp_fail(err, SP_EINVAL, "until = %g, must be a frequency, or 0 for the largest", until);
    if (!modes->participation)
        return sp_fail(err, SP_EINVAL, "modes have no vectors, which participation ratios need");
    const double last = until > 0 ? until : modes->n > 0 ? modes->omega[modes->n - 1] : 0;
    if (!(last > 0))
        return sp_fail(err, SP_EREFUSED, "there are no vibrations: all frequencies are 0");
    for (int32_t b = 0; b < bins; b++)
        out[b] = (sp_participation_bin){.low = last * b / bins,
                                        .high = b + 1 < bins ? last * (b + 1) / bins : last,
                                        .mean = NAN,
                                        .sd = NAN,
                                        .least = NAN,
                                        .largest = NAN};
    int32_t b = 0;
    for (int64_t k = 0; k < modes->n; k++) { /* frequencies ascend */
        if (!(modes->omega[k] > 0) || modes->omega[k] > last)
            continue;
        while (modes->omega[k] > out[b].high)
            b++;
        add_value(&out[b], modes->participation[k]);
    }
    for (b = 0; b < bins; b++)
        if (out[b].modes > 0)
            out[b].sd = out[b].modes > 1 ? sqrt(out[b].sd / (double)(out[b].modes - 1)) : NAN;
    return SP_OK;
}
