/* Steps too long for the stiffest grains: these get more inertia, and drag spares grains that gain speed
 * (packing/inertia.h). */
#include "test.h"

#include "packing/dynamics.h"
#include "packing/inertia.h"
#include "packing/prepare.h"

static const double OVERLAP = 0.01, DRAG = 0.1, DT = 0.01;

/* Two equal grains in one contact, at rest, far from both walls. */
static dynamics make_pair(int dim, double friction, bool long_steps) {
    sp_pack_spec spec = sp_pack_spec_default();
    spec.dim = dim;
    spec.grains = 2;
    spec.width = 8;
    spec.friction = friction;
    spec = sp_pack_spec_resolve(&spec);
    spec.time_step = long_steps ? 2 : 0.5;
    const double r[2] = {0.5, 0.5}, x[6] = {3, 4, 4, 4 - OVERLAP, 4, 4};
    dynamics d;
    assert_ok(sp_dynamics_make(&spec, r, x, 8, &d, &err));
    assert_true(d.long_steps == long_steps);
    d.pressure = 0;
    return d;
}

/* Largest speed after some steps of `length` over the pair's rate; the grains roll on each other at first. */
static double speed_after(int dim, double friction, bool long_steps, double length) {
    dynamics d = make_pair(dim, friction, long_steps);
    dynamics_grain(&d, 0)[d.at.w + d.dim - 2] = dynamics_grain(&d, 1)[d.at.w + d.dim - 2] = friction > 0 ? 1e-3 : 0;
    assert_ok(sp_neighbours_refresh(&d, &err));
    sp_dynamics_forces(&d, 0);
    sp_dynamics_advance(&d, 0);
    const double dt = length / d.rate;
    double fastest = 0;
    for (int step = 0; step < 40; step++) {
        assert_ok(sp_neighbours_refresh(&d, &err));
        sp_dynamics_forces(&d, dt);
        sp_dynamics_advance(&d, dt);
        for (int i = 0; i < 2; i++)
            fastest = fmax(fastest, fabs(dynamics_grain(&d, i)[d.at.w + d.dim - 2]));
        fastest = fmax(fastest, d.v_max);
    }
    sp_dynamics_free(&d);
    return fastest;
}

/* A contact cannot drive its grains faster than its energy allows, in steps up to 1.5 over their rate. With their own
 * inertia the rotation grows: the coupled mode of a single contact has a viscous rate of 14 zeta. */
TEST(test_stiff_grains_are_stable) {
    const double energy = 0.4 * 0.5 * pow(OVERLAP, 2.5), m = 3.14159265358979 / 6; /* of the overlap, below this */
    const double bound = sqrt(2 * energy / m) + 2e-3;
    for (int dim = 2; dim <= 3; dim++)
        for (double length = 0.3; length < 1.6; length *= 1.5)
            for (int rough = 0; rough < 2; rough++)
                assert_true(speed_after(dim, rough ? 1e6 : 0, true, length) < bound);
    assert_true(speed_after(2, 1e6, false, 1) > bound);
    assert_true(speed_after(3, 1e6, false, 1) > bound);
}

/* Short steps leave every grain as it is, long ones divide both accelerations by the same factor. */
TEST(test_factor) {
    for (int dim = 2; dim <= 3; dim++)
        for (int rough = 0; rough < 2; rough++) {
            assert_true(inertia_factor(0.8, 0.1, 0.2, dim, rough) == 1);
            assert_true(inertia_factor(0.8, 1, 0.2, dim, rough) > 1.5);
            assert_true(inertia_factor(0.8, 1, 1, dim, rough) > inertia_factor(0.8, 1, 0.2, dim, rough));
        }
}

/* Velocity along x after one step with drag, of the left grain, which its neighbour pushes to the left. */
static double pushed(int dim, double v, bool long_steps, double *kick) {
    dynamics d = make_pair(dim, 0, long_steps);
    double *g = dynamics_grain(&d, 0), force[3], turn[3];
    g[d.at.v] = dynamics_grain(&d, 1)[d.at.v] = v; /* together, so that contact viscosity does not act */
    d.drag = DRAG;
    assert_ok(sp_neighbours_refresh(&d, &err));
    sp_dynamics_forces(&d, DT);
    sp_dynamics_force_on(&d, 0, force, turn);
    assert_true(force[0] < 0);
    *kick = DT * g[d.at.inv_m] * force[0];
    sp_dynamics_advance(&d, DT);
    const double after = g[d.at.v];
    sp_dynamics_free(&d);
    return after;
}

TEST(test_drag_spares_what_gains_speed) {
    const double v = 1e-3, keep = 1 - DRAG * DT;
    for (int dim = 2; dim <= 3; dim++) {
        double kick, now = pushed(dim, -v, true, &kick);
        assert_true(fabs(now - (-v + kick)) < 1e-15);
        now = pushed(dim, v, true, &kick);
        assert_true(fabs(now - (keep * v + kick)) < 1e-15);
        now = pushed(dim, -v, false, &kick);
        assert_true(fabs(now - (-keep * v + kick)) < 1e-15);
    }
}

/* The default protocol takes long steps in 3D, and packings come to rest in the longest that a scene may ask for. */
TEST(test_packings_at_rest) {
    for (int dim = 2; dim <= 3; dim++)
        for (int rough = 0; rough < 2; rough++) {
            sp_pack_spec spec = sp_pack_spec_default();
            spec.dim = dim;
            spec.grains = 60;
            spec.width = 5;
            spec.friction = rough ? 0.5 : 0;
            assert_true((sp_pack_spec_resolve(&spec).time_step > SP_LONG_STEP) == (dim == 3));
            spec.time_step = 4;
            sp_packing p = sp_packing_none();
            assert_ok(sp_packing_make(&spec, NULL, NULL, &p, &err));
            sp_audit audit;
            assert_ok(sp_packing_audit(&p, 1e-4, &audit, &err));
            assert_true(p.residual < 1e-10 && audit.wall_residual < 1e-5);
            sp_packing_free(&p);
        }
}

RUN_TESTS(NULL, NULL)
