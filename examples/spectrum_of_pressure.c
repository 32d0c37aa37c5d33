/* How the frequencies of vibration grow with the pressure: the density of states in a loop over pressures.
 *
 * Hertzian contacts grow stiffer under load, k ~ p^(1/3), so that frequencies grow about as p^(1/6). One packing is
 * compressed further and further. Omega is in sqrt(E* / rho)/d. */
#include <sonopack/sonopack.h>

#include <math.h>
#include <stdio.h>

enum { PRESSURES = 3, BINS = 40 };
static const double pressures[PRESSURES] = {1e-6, 1e-5, 1e-4}; /* [E*] */

/* The packing at a pressure, from the one before; the first from a gas. */
static sp_status compress(const sp_packing *before, double pressure, sp_packing *out, sp_error *err) {
    sp_pack_spec spec = sp_pack_spec_default();
    const sp_pack_hooks hooks = {.from = before};
    spec.pressure = pressure;
    spec.protocol = SP_PROTOCOL_QUICK;
    if (before->n == 0) {
        spec.grains = 100;
        spec.width = 10.0;
        return sp_packing_make(&spec, NULL, NULL, out, err);
    }
    spec.kind = SP_PACK_FILE;
    sp_status status = sp_pack_spec_from(&spec, before, err);
    return status == SP_OK ? sp_packing_make_with(&spec, &hooks, out, err) : status;
}

static sp_status find_spectrum(const sp_packing *p, sp_dos *out, sp_error *err) {
    const sp_network_options options = sp_network_options_default();
    sp_dos_options ask = sp_dos_options_default();
    sp_network net = sp_network_none();
    ask.method = SP_DOS_EXACT; /* every frequency: 100 disks have no more than 300 */
    ask.norm = SP_DOS_ONE;
    ask.bins = BINS;
    sp_status status = sp_network_make(p, &options, &net, err);
    if (status == SP_OK)
        status = sp_dos_make(&net, &ask, out, err);
    sp_network_free(&net);
    return status;
}

/* The frequency that half of the modes lie below, by straight lines between the edges of bins. */
static double median(const sp_dos *d) {
    int k = 0;
    while (k < d->bins - 1 && d->cumulative[k] < 0.5)
        k++;
    const double before = k > 0 ? d->cumulative[k - 1] : 0;
    return d->edge[k] + (d->edge[k + 1] - d->edge[k]) * (0.5 - before) / (d->cumulative[k] - before);
}

int main(void) {
    sp_error err = {0};
    sp_status status = SP_OK;
    sp_dos dos[PRESSURES] = {sp_dos_none(), sp_dos_none(), sp_dos_none()};
    sp_packing packing = sp_packing_none();
    for (int k = 0; k < PRESSURES && status == SP_OK; k++) {
        sp_packing next = sp_packing_none();
        status = compress(&packing, pressures[k], &next, &err);
        if (status == SP_OK && (status = find_spectrum(&next, &dos[k], &err)) == SP_OK)
            printf("p = %.0e E*: half of all frequencies are below %.3f p^(1/6) sqrt(E*/rho)/d\n", pressures[k],
                   median(&dos[k]) / pow(pressures[k], 1.0 / 6.0));
        sp_packing_free(&packing);
        packing = next;
    }
    for (int k = 0; k < PRESSURES; k++)
        sp_dos_free(&dos[k]);
    sp_packing_free(&packing);
    return status == SP_OK ? 0 : (fprintf(stderr, "%s: %s\n", sp_status_name(status), err.text), 1);
}
