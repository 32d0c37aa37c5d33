/* The way of the data through the public headers alone: a chain, its network, the signal, the front. */
#include <math.h>
#include <sonopack/sonopack.h>
#include <stdio.h>

static sp_status chain_front(sp_front *front, double *arrival, sp_error *err) {
    sp_pack_spec spec = sp_pack_spec_default();
    spec.kind = SP_PACK_CHAIN;
    spec.dim = 1;
    spec.grains = 100;
    spec.pressure = 1e-4;
    spec.diameter_min = spec.diameter_max = 1.0;

    sp_packing packing = sp_packing_none();
    sp_network net = sp_network_none();
    sp_signal signal = sp_signal_none();
    sp_network_options options = sp_network_options_default();
    sp_status status = sp_packing_make(&spec, NULL, NULL, &packing, err);
    if (status == SP_OK)
        status = sp_network_make(&packing, &options, &net, err);
    if (status == SP_OK) {
        /* sound crosses one grain in sqrt(m/K) (Somfai et al. 2005, Eq. (C3)) */
        *arrival = 100.0 * sqrt(net.mass[50] / net.springs[50].kn);
        sp_signal_options ask = sp_signal_options_default();
        ask.until = 2.0 * *arrival;
        ask.points = 4000;
        status = sp_signal_make(&net, &ask, &signal, err);
    }
    if (status == SP_OK) {
        sp_front_options rule = sp_front_options_default();
        status = sp_front_find(signal.n, signal.t, signal.f, &rule, front, err);
    }
    sp_signal_free(&signal);
    sp_network_free(&net);
    sp_packing_free(&packing);
    return status;
}

int main(void) {
    sp_error err = {0};
    sp_front front = {0};
    double arrival = 0;
    if (chain_front(&front, &arrival, &err) != SP_OK) {
        fprintf(stderr, "%s\n", err.text);
        return 1;
    }
    printf("sonopack %s: t10 %.6g, peak %.6g, sound arrives at %.6g\n", SONOPACK_VERSION, front.t10, front.t_peak,
           arrival);
    /* the Airy front: 10% before the sound, the peak after it, both within a few widths N^(1/3) of one grain */
    double width = arrival / 100.0 * cbrt(100.0);
    return front.t10 < front.t_peak && fabs(front.t_peak - arrival) < 2.0 * width ? 0 : 1;
}
