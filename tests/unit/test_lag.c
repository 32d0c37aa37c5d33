/* Dashpots that feel averaged velocities (dynamics.lag), the step that they allow, and drag that spares loose grains.
 */
#include "test.h"

#include "packing/contact.h"
#include "packing/dynamics.h"
#include "packing/prepare.h"

static const double OVERLAP = 0.01, DRAG = 0.1, DT = 0.01, LAG = 0.6, ZETA = 0.8;

static sp_pack_spec pair_spec(int dim, double friction, double lag) {
    sp_pack_spec spec = sp_pack_spec_default();
    spec.dim = dim;
    spec.grains = 2;
    spec.width = 8;
    spec.friction = friction;
    spec.lag = lag;
    spec.damping = ZETA;
    return sp_pack_spec_resolve(&spec);
}

/* Two equal grains, the second to the right, at rest and far from both walls. A gap of below 0 is an overlap. */
static dynamics make_pair(const sp_pack_spec *spec, double gap) {
    const double r[2] = {0.5, 0.5}, x[6] = {3, 4, 4, 4 + gap, 4, 4};
    dynamics d;
    assert_ok(sp_dynamics_make(spec, r, x, 8, &d, &err));
    d.pressure = 0;
    return d;
}

/* Force along x on the left grain while the right one moves to the left at v, not limited by the sign of forces. */
static double force_at(dynamics *d, double v) {
    double force[3], turn[3];
    dynamics_grain(d, 1)[d->at.v] = -v;
    assert_ok(sp_neighbours_refresh(d, &err));
    sp_dynamics_forces(d, 0);
    sp_dynamics_force_on(d, 0, force, turn);
    return force[0];
}

/* What remains of the force without the elastic part, over the dashpot's constant. */
static double felt(dynamics *d, double v) {
    const double e = contact_stiffness(0.5, 0.5), kn = contact_normal_stiffness(e, OVERLAP);
    const double c = 2 * ZETA * sqrt(0.5 * grain_mass(0.5) * kn);
    return (-force_at(d, v) - contact_force(e, OVERLAP)) / c;
}

/* Disks that nearly form a lattice have no lag unless it is asked for. */
TEST(test_lattice) {
    static const sp_protocol all[] = {SP_PROTOCOL_DEFAULT, SP_PROTOCOL_AFFINE};
    for (int k = 0; k < 2; k++)
        for (int dim = 2; dim <= 3; dim++) {
            sp_pack_spec spec = sp_pack_spec_default();
            spec.dim = dim;
            spec.protocol = all[k];
            assert_true(sp_pack_spec_resolve(&spec).lag == 0.6);
            spec.diameter_min = 0.9995;
            spec.diameter_max = 1.0005;
            assert_true(sp_pack_spec_resolve(&spec).lag == (dim == 2 ? 0 : 0.6));
            spec.lag = 0.3;
            assert_true(sp_pack_spec_resolve(&spec).lag == 0.3);
        }
}

/* An open contact leaves nothing behind: the average begins where the contact closes. */
TEST(test_average) {
    for (int dim = 2; dim <= 3; dim++)
        for (int kind = 0; kind < (dim == 2 ? 3 : 2); kind++) {
            sp_pack_spec spec = pair_spec(dim, kind > 0 ? 0.5 : 0, LAG);
            if (kind == 2)
                spec.tangential = SP_TANGENTIAL_HISTORY;
            dynamics d = make_pair(&spec, 1e-4);
            assert_true(force_at(&d, 5e-3) == 0);
            dynamics_grain(&d, 1)[0] -= OVERLAP + 1e-4;
            assert_close(felt(&d, 1e-3), 1e-3 + LAG * (5e-3 - 1e-3), 1e-14);
            assert_close(felt(&d, 1e-3), 1e-3 + LAG * LAG * (5e-3 - 1e-3), 1e-14);
            d.outer_travel = INFINITY; /* it outlasts new lists */
            assert_close(felt(&d, 2e-3), 2e-3 + LAG * (-1e-3 + LAG * LAG * (5e-3 - 1e-3)), 1e-14);
            sp_dynamics_free(&d);
        }
}

/* Along the contact, with the spring released: steps of length 0 do not stretch it. */
TEST(test_average_along_a_contact) {
    for (int dim = 2; dim <= 3; dim++) {
        const sp_pack_spec spec = pair_spec(dim, 1e6, LAG);
        dynamics d = make_pair(&spec, -OVERLAP);
        double force[2][3], turn[3];
        for (int k = 0; k < 2; k++) {
            dynamics_grain(&d, 1)[d.at.v + dim - 1] = k == 0 ? 3e-3 : 1e-3;
            assert_ok(sp_neighbours_refresh(&d, &err));
            sp_dynamics_forces(&d, 0);
            sp_dynamics_force_on(&d, 0, force[k], turn);
        }
        /* the first step averages with the rest in which the contact was made */
        assert_close(force[1][dim - 1] / force[0][dim - 1],
                     (1e-3 + LAG * ((1 - LAG) * 3e-3 - 1e-3)) / ((1 - LAG) * 3e-3), 1e-12);
        sp_dynamics_free(&d);
    }
}

/* Grains at a wall feel the same average: bottom, with the wall's own friction. */
TEST(test_average_at_a_wall) {
    for (int dim = 2; dim <= 3; dim++) {
        const sp_pack_spec spec = pair_spec(dim, 0.5, LAG);
        dynamics d = make_pair(&spec, 1);
        double *g = dynamics_grain(&d, 0), force[3], turn[3];
        const double kn = contact_normal_stiffness(sqrt(0.5), OVERLAP), c = 2 * ZETA * sqrt(grain_mass(0.5) * kn);
        double average = 0;
        g[dim - 1] = 0.5 - OVERLAP;
        d.outer_travel = INFINITY;
        for (int k = 0; k < 3; k++) {
            g[d.at.v + dim - 1] = -1e-3 * (k + 1);
            average = k == 0 ? 1e-3 * (1 - LAG) : 1e-3 * (k + 1) + LAG * (average - 1e-3 * (k + 1));
            assert_ok(sp_neighbours_refresh(&d, &err));
            sp_dynamics_forces(&d, 0);
            sp_dynamics_force_on(&d, 0, force, turn);
            assert_close(force[dim - 1], contact_force(sqrt(0.5), OVERLAP) + c * average, 1e-14);
        }
        sp_dynamics_free(&d);
    }
}

/* Largest speed after some steps of `length` over the pair's rate; the grains roll on each other at first. */
static double speed_after(int dim, double friction, double length) {
    const sp_pack_spec spec = pair_spec(dim, friction, LAG);
    dynamics d = make_pair(&spec, -OVERLAP);
    dynamics_grain(&d, 0)[d.at.w + d.dim - 2] = dynamics_grain(&d, 1)[d.at.w + d.dim - 2] = friction > 0 ? 1e-3 : 0;
    assert_ok(sp_neighbours_refresh(&d, &err));
    sp_dynamics_forces(&d, 0);
    sp_dynamics_advance(&d, 0);
    const double dt = length / d.rate;
    double fastest = 0;
    for (int step = 0; step < 100; step++) {
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

/* A contact cannot drive its grains faster than its energy allows in steps of up to 0.83 over the rate, those of the
 * default protocol. The rate that counts is more than twice that of the contact: its rotation would grow. */
TEST(test_pairs_are_stable) {
    const double energy = 0.4 * 0.5 * pow(OVERLAP, 2.5), m = grain_mass(0.5);
    const double bound = sqrt(2 * energy / m) + 2e-3;
    for (int dim = 2; dim <= 3; dim++) {
        for (double length = 0.2; length < 0.84; length += 0.09)
            for (int rough = 0; rough < 2; rough++)
                assert_true(speed_after(dim, rough ? 1e6 : 0, length) < bound);
        assert_true(speed_after(dim, 1e6, 2.4 * 0.83) > bound);
    }
}

/* Velocity along x after one step with drag, of the left grain, which its neighbour pushes to the left. */
static double pushed(int dim, double v, bool sparing, double *kick) {
    const sp_pack_spec spec = pair_spec(dim, 0, LAG);
    dynamics d = make_pair(&spec, -OVERLAP);
    double *g = dynamics_grain(&d, 0), force[3], turn[3];
    g[d.at.v] = dynamics_grain(&d, 1)[d.at.v] = v; /* together, so that contact viscosity does not act */
    d.drag = DRAG;
    d.sparing = sparing;
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

/* Packings come to rest in the longest step that a scene may ask for, or the run says why not. */
TEST(test_packings_at_rest) {
    for (int dim = 2; dim <= 3; dim++)
        for (int rough = 0; rough < 2; rough++) {
            sp_pack_spec spec = sp_pack_spec_default();
            spec.dim = dim;
            spec.grains = 60;
            spec.width = 5;
            spec.friction = rough ? 0.5 : 0;
            spec.time_step = 0.8;
            FREED(sp_packing) p = sp_packing_none();
            assert_ok(sp_packing_make(&spec, NULL, NULL, &p, &err));
            sp_audit audit;
            assert_ok(sp_packing_audit(&p, 1e-4, &audit, &err));
            assert_true(p.residual < 1e-10 && audit.wall_residual < 1e-5);
        }
}

RUN_TESTS(NULL, NULL)
