/* Loud pulses: the balance of energy and its order in the step, the linear limit and how it is approached, motion back
 * in time, agreement with `dynamics', bad input. */
#include "amplitude/loud_motion.h"
#include "base/base.h"
#include "carried.h"
#include "making.h"
#include "signals.h"

#include <sonopack/amplitude.h>
#include <sonopack/signal.h>

#define DISKS SOURCE_DIR "/packings/reference/packing_N200_p1e-4.txt"

static double *source_of(const sp_network *net) {
    double *a = calloc((size_t)sp_network_dofs(net), sizeof *a);
    assert_ok(sp_network_source(net, SP_SOURCE_IMPULSE, a, &err));
    return a;
}

/* Largest defect of the balance in a run with steps h, and what happened to contacts. */
static double defect_of(const sp_packing *p, double amplitude, double until, int steps, sp_amplitude_front *counts) {
    FREED(sp_network) net = carried_network(p);
    motion s;
    double *a = source_of(&net), worst = 0;
    assert_ok(sp_motion_make(p, &net, SP_MOTION_NEAR, 0, NULL, &s, &err));
    sp_motion_kick(&s, a, true, amplitude);
    for (int k = 0; k < steps; k++) {
        sp_motion_step(&s, until / steps, 0);
        worst = fmax(worst, sp_motion_energy(&s).defect);
    }
    assert_ok(sp_motion_check(&s, amplitude, &err));
    sp_motion_count(&s, counts);
    counts->energy = sp_motion_energy(&s);
    sp_motion_free(&s);
    free(a);
    return worst;
}

/* Halving the step divides the defect by four, in motions that stay linear and in those in which contacts slide, open
 * and close. Without the work of sliding, or that of the forces at rest, the balance is off by as much as they are. */
TEST(test_balance) {
    FREED(sp_packing) flat = reference_packing(DISKS);
    for (int q = 0; q < 3; q++) {
        const double amplitude = (const double[]){1e-5, 0.1, 1}[q];
        sp_amplitude_front c[3];
        double defect[3];
        for (int k = 0; k < 3; k++)
            defect[k] = defect_of(&flat, amplitude, 30, 400 << k, &c[k]);
        assert_true(defect[2] < 1e-4 && defect[2] > 1e-8);
        assert_close(log2(defect[0] / defect[1]), 2, 0.1);
        assert_close(log2(defect[1] / defect[2]), 2, 0.1);
        const sp_amplitude_energy *e = &c[2].energy;
        assert_true(q == 0 ? c[2].slid == 0 && e->slid == 0 : c[2].slid > 10 && e->slid > 0.5 * e->input);
        assert_true(q < 2 || (c[2].opened > 10 && c[2].closed > 10 && c[2].lost > 0));
        assert_true(q == 0 || fabs(e->released) > 1e-2 * e->input);
    }
}

/* Spheres, with torques about three axes, and smooth disks, whose energy is that of springs alone. */
TEST(test_balance_elsewhere) {
    for (int q = 0; q < 2; q++) {
        FREED(sp_packing) p = q == 0 ? carried_packing(3, 3, 0.2, 5) : scattered_packing(2, 5, 0, 3);
        sp_amplitude_front c;
        const double one = defect_of(&p, 0.3, 20, 800, &c), two = defect_of(&p, 0.3, 20, 1600, &c);
        assert_true(two < 1e-3 && two < 0.5 * one);
        assert_true(q == 0 ? c.slid > 0 : c.energy.tangential == 0 && c.energy.slid == 0 && c.energy.released == 0);
    }
}

/* Balls between walls, without friction: with velocities reversed they return to rest, through all contacts that have
 * opened. */
TEST(test_reversal) {
    enum { STEPS = 4000 };
    FREED(sp_packing) p = chain_packing(20, 1e-5);
    FREED(sp_network) net = carried_network(&p);
    double *a = source_of(&net), largest = 0;
    motion s;
    assert_ok(sp_motion_make(&p, &net, SP_MOTION_NEAR, 0, NULL, &s, &err));
    sp_motion_kick(&s, a, true, 5);
    const double v = s.m.v[0];
    sp_amplitude_front c;
    for (int way = 0; way < 2; way++) {
        for (int k = 0; k < STEPS; k++)
            sp_motion_step(&s, 0.01, 0);
        sp_motion_count(&s, &c);
        assert_true(c.opened > 3);
        for (int k = 0; k < 6 * p.n; k++) {
            largest = fmax(largest, fabs(s.m.u[k]));
            s.m.v[k] = -s.m.v[k];
        }
    }
    for (int k = 0; k < p.n; k++) {
        assert_close(s.m.u[6 * k], 0, 1e-9 * largest);
        assert_close(s.m.v[6 * k], k == 0 ? v : 0, 1e-9 * v);
    }
    sp_motion_free(&s);
    free(a);
}

/* With the same steps the force is that of `dynamics', bit for bit. */
TEST(test_same_motion) {
    enum { POINTS = 101 };
    FREED(sp_packing) p = reference_packing(DISKS);
    FREED(sp_network) net = carried_network(&p);
    sp_signal_options o = sp_signal_options_default();
    FREED(sp_signal) signal = sp_signal_none();
    RELEASED double *a = source_of(&net);
    o.method = SP_SIGNAL_DYNAMICS;
    o.amplitude = 0.2;
    o.until = 20;
    o.points = POINTS;
    o.step = 0.1;
    assert_ok(sp_signal_compute(&p, &net, &o, &signal, &err));
    motion s;
    assert_ok(sp_motion_make(&p, &net, SP_MOTION_NEAR, 0, NULL, &s, &err));
    const double factor = sp_motion_kick(&s, a, true, 0.2);
    assert_true(factor == signal.amplitude);
    for (int l = 0; l < POINTS; l++) {
        for (int k = 0; k < (l > 0 ? 2 : 0); k++)
            sp_motion_step(&s, 0.1, 0);
        assert_true(sp_motion_force(&s, 0) / factor == signal.f[l]);
    }
    sp_motion_free(&s);
}

static sp_packing lattice_packing(void) {
    sp_pack_spec spec = sp_pack_spec_default();
    spec.kind = SP_PACK_TRIANGULAR;
    spec.grains = 90;
    spec.width = 6;
    spec.friction = 0;
    return make_packing(&spec);
}

/* The ratios tend to 1. Without friction the distance from it goes as the amplitude: the first term of the law that is
 * not linear. */
TEST(test_linear_limit) {
    SKIP_SANITIZED();
    const double amplitude[] = {1e-8, 1e-3, 1e-2};
    for (int q = 0; q < 3; q++) {
        FREED(sp_packing) p = q == 0 ? reference_packing(DISKS) : q == 1 ? chain_packing(30, 1e-4) : lattice_packing();
        sp_amplitude_options o = sp_amplitude_options_default();
        sp_amplitude_front a[3];
        sp_front linear;
        o.tolerance = q == 0 ? 1e-4 : 1e-6;
        assert_ok(sp_amplitude_pulses(&p, &o, q == 0 ? 1 : 3, amplitude, a, &linear, &err));
        assert_close(a[0].speed.value, 1, a[0].speed.error);
        assert_close(a[0].peak.value, 1, a[0].peak.error);
        assert_close(a[0].width.value, 1, a[0].width.error);
        assert_close(a[0].t10.value, linear.t10, a[0].t10.error);
        assert_true(a[0].speed.error < 1e-3 && a[0].energy.defect <= o.tolerance);
        if (q > 0) {
            const double off = a[1].peak.value - 1, more = a[2].peak.value - 1;
            assert_true(fabs(off) > 3 * a[1].peak.error && a[2].slid == 0 && a[2].opened == 0);
            assert_close(more / off, 10, 1);
        }
    }
}

/* Errors cover what finer steps give. */
TEST(test_errors) {
    const double amplitude[] = {0.01, 0.3, 2};
    FREED(sp_packing) p = reference_packing(DISKS);
    sp_amplitude_options o = sp_amplitude_options_default(), fine = o;
    sp_amplitude_front a[3], b[3];
    fine.tolerance = 3e-6;
    assert_ok(sp_amplitude_pulses(&p, &o, 3, amplitude, a, NULL, &err));
    assert_ok(sp_amplitude_pulses(&p, &fine, 3, amplitude, b, NULL, &err));
    for (int k = 0; k < 3; k++) {
        assert_true(b[k].step < 0.2 * a[k].step);
        assert_close(a[k].speed.value, b[k].speed.value, a[k].speed.error + b[k].speed.error);
        assert_close(a[k].peak.value, b[k].peak.value, a[k].peak.error + b[k].peak.error);
        assert_close(a[k].width.value, b[k].width.value, a[k].width.error + b[k].width.error);
        sp_amplitude_front one; /* does not depend on the amplitudes before it */
        assert_ok(sp_amplitude_pulses(&p, &o, 1, &amplitude[k], &one, NULL, &err));
        assert_true(one.speed.value == a[k].speed.value && one.energy.slid == a[k].energy.slid);
    }
}

TEST(test_bad_input) {
    FREED(sp_packing) p = reference_packing(DISKS);
    sp_amplitude_front a;
    sp_amplitude_options o = sp_amplitude_options_default();
    const double bad[] = {0, -1, 1e-10, 1e7, NAN, INFINITY}, good = 0.01, loud = 1e4;
    for (int k = 0; k < 6; k++)
        assert_fails(sp_amplitude_pulses(&p, &o, 1, &bad[k], &a, NULL, &err), SP_EINVAL, "amplitude");
    assert_fails(sp_amplitude_pulses(&p, &o, 1, &loud, &a, NULL, &err), SP_EFAILED, "amplitude");
    o.tolerance = 0;
    assert_fails(sp_amplitude_pulses(&p, &o, 1, &good, &a, NULL, &err), SP_EINVAL, "tolerance");
    o.tolerance = 1e-3;
    o.until = 5;
    assert_fails(sp_amplitude_pulses(&p, &o, 1, &good, &a, NULL, &err), SP_EREFUSED, "until");
    o.until = NAN;
    assert_fails(sp_amplitude_pulses(&p, &o, 1, &good, &a, NULL, &err), SP_EINVAL, "until");
    o.until = 0;
    EACH_ALLOCATION_FAILS(10, sp_amplitude_pulses(&p, &o, 1, &good, &a, NULL, &err), );
}

RUN_TESTS(NULL, NULL)
