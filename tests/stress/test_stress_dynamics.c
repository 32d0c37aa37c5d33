/* Signals of the nonlinear motion of small packings. Their error is an estimate, the change from steps twice as long:
 * how often it holds against steps of an eighth of the length. */
#include "stress/networks.h"
#include "stress/record.h"

#include <sonopack/signal.h>

typedef struct trial {
    double pressure, friction, amplitude, damping;
    uint64_t seed;
} trial;

typedef struct count {
    int tried, held;
    double worst; /* largest ratio of true to estimated error */
} count;

static sp_status make_signal(const sp_packing *p, const sp_network *net, const trial *t, double step, sp_signal *out,
                             sp_error *err) {
    sp_signal_options o = sp_signal_options_default();
    o.method = SP_SIGNAL_DYNAMICS;
    o.until = sp_signal_window(sp_packing_height(p), p->pressure);
    o.points = 61;
    o.tolerance = 1e-3;
    o.amplitude = t->amplitude;
    o.damping = t->damping;
    o.step = step;
    return sp_signal_compute(p, net, &o, out, err);
}

static void run(stress_record *r, const trial *t, count *c) {
    FREED(sp_packing) p = stress_piston(t->pressure, t->friction, t->seed);
    sp_network_options how = sp_network_options_default();
    FREED(sp_network) net = sp_network_none();
    FREED(sp_signal) s = sp_signal_none(), fine = sp_signal_none();
    char network[64], what[64];
    how.prestress = true;
    assert_ok(sp_network_make(&p, &how, &net, &err));
    snprintf(network, sizeof network, "p = %g, friction %g, packing %d", t->pressure, t->friction, (int)t->seed);
    snprintf(what, sizeof what, "amplitude %g, damping %g", t->amplitude, t->damping);
    sp_error reason = {0};
    sp_status status = make_signal(&p, &net, t, 0, &s, &reason);
    if (status == SP_OK)
        status = make_signal(&p, &net, t, s.step / 8, &fine, &reason);
    if (status == SP_OK) {
        double error = 0, scale = 0;
        for (int32_t l = 0; l < s.n; l++) {
            error = fmax(error, fabs(s.f[l] - fine.f[l]));
            scale = fmax(scale, fabs(fine.f[l]));
        }
        c->tried++;
        c->held += error <= s.error;
        c->worst = fmax(c->worst, error / s.error);
        stress_agree(r, network, "dynamics", what, error, 2 * s.error, scale); /* what an estimate may be off by */
    } else if (status == SP_EFAILED && t->amplitude > 0.1)                     /* a grain has left its neighbours */
        r->refused++;
    else
        stress_refuse(r, network, "dynamics", what, status, &reason);
}

TEST(test_packings) {
    static const double pressures[] = {1e-6, 1e-4, 1e-2}, frictions[] = {0, 0.5}, amplitudes[] = {1e-4, 0.03, 0.5},
                        dampings[] = {0, 0.1};
    stress_record r = stress_open();
    count c = {0};
    for (uint64_t k = 0; k < 36; k++) {
        const trial t = {pressures[k % 3], frictions[k / 3 % 2], amplitudes[k / 6 % 3], dampings[k / 18 % 2],
                         1 + k % 2};
        run(&r, &t, &c);
    }
    stress_close(&r);
    print_message("the estimate holds in %d of %d signals; the true error is up to %.3g of it\n", c.held, c.tried,
                  c.worst);
    assert_true(c.tried > 30);
    assert_true(c.held >= 0.95 * c.tried);
    assert_int_equal(r.wrong, 0);
}

RUN_TESTS(NULL, NULL)
