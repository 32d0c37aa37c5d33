/* From grains to the speed of sound by time of flight, all in memory.
 *
 * Two packings of unlike height are made under the same pressure and knocked at their bottom walls. The difference of
 * their heights over the difference of their arrival times is the speed of the first front: what happens at the walls
 * delays both signals alike, and drops out. One height over one time would count it.
 *
 * Lengths are in mean grain diameters d, pressures in E*, the modified Young modulus of a grain, times in d/sqrt(E* /
 * rho). For glass (E* = 70 GPa, rho = 2500 kg/m^3) sqrt(E* / rho) is 5.3 km/s, and 1e-4 E* is 7 MPa. */
#include <sonopack/sonopack.h>

#include <stdio.h>

static const double pressure = 1e-4, glass = 5290.0; /* E*; m/s */

/* A packing of so many grains. The time step, the damping and so on follow from the protocol. */
static sp_status make(int32_t grains, uint64_t seed, sp_packing *out, sp_error *err) {
    sp_pack_spec spec = sp_pack_spec_default();
    spec.grains = grains;
    spec.width = 10.0;
    spec.pressure = pressure;
    spec.protocol = SP_PROTOCOL_QUICK;
    spec.seed = seed;
    return sp_packing_make(&spec, NULL, NULL, out, err);
}

/* The force on the top wall after a knock, and its first front. */
static sp_status listen(const sp_packing *p, sp_front *front, sp_error *err) {
    const sp_network_options network_options = sp_network_options_default();
    sp_signal_options signal_options = sp_signal_options_default();
    sp_front_options front_options = sp_front_options_default();
    sp_network net = sp_network_none();
    sp_signal signal = sp_signal_none();
    signal_options.until = sp_signal_window(sp_packing_height(p), p->pressure);
    signal_options.points = 2000;
    sp_status status = sp_network_make(p, &network_options, &net, err);
    if (status == SP_OK)
        status = sp_signal_make(&net, &signal_options, &signal, err);
    if (status == SP_OK)
        status = sp_front_find(signal.n, signal.t, signal.f, &front_options, front, err);
    sp_signal_free(&signal); /* also right for what was never made */
    sp_network_free(&net);
    return status;
}

static sp_status arrival(int32_t grains, double *height, double *time, sp_error *err) {
    sp_packing packing = sp_packing_none();
    sp_front front;
    sp_status status = make(grains, 1, &packing, err);
    if (status == SP_OK)
        status = listen(&packing, &front, err);
    if (status == SP_OK) {
        *height = sp_packing_height(&packing);
        *time = front.t10;
        printf("%4d grains: height %6.2f d, the front arrives at t = %6.1f d/sqrt(E*/rho)\n", (int)grains, *height,
               *time);
    }
    sp_packing_free(&packing);
    return status;
}

int main(void) {
    sp_error err = {0};
    double height[2], time[2];
    for (int k = 0; k < 2; k++) {
        if (arrival(k == 0 ? 80 : 240, &height[k], &time[k], &err) != SP_OK) {
            fprintf(stderr, "%s: %s\n", sp_status_name(err.status), err.text);
            return 1;
        }
    }
    const double speed = (height[1] - height[0]) / (time[1] - time[0]);
    printf("speed of the front: %.4f sqrt(E*/rho), %.0f m/s in glass at %.0f MPa\n", speed, speed * glass,
           pressure * 70e3);
    return 0;
}
