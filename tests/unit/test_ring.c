/* Packings between two rings, in closed form: grains that stand apart between both rings are pairs of springs. */
#include "base/base.h"
#include "packing/bulk.h"
#include "reference.h"

#include <sonopack/elastic.h>

enum { GRAINS = 12 };
static const double RADIUS = 0.5, OVERLAP = 1e-3, FORCE = 1e-4, KN = 0.3;

/* Grains on a circle of this radius, with a force and a spring at each ring. */
static sp_packing between(double circle, double friction) {
    sp_packing p = sp_packing_none();
    assert_ok(sp_packing_alloc(&p, 2, GRAINS, 2 * GRAINS, &err));
    const double outer = circle + RADIUS - OVERLAP;
    p.cell = SP_CELL_RING;
    p.box[0] = 2 * outer;
    p.box[1] = 2 * (RADIUS - OVERLAP);
    p.pressure = GRAINS * FORCE / (2 * M_PI * outer);
    p.friction = friction;
    for (int32_t i = 0; i < GRAINS; i++) {
        const double angle = 2 * M_PI * i / GRAINS + 0.1, n[2] = {cos(angle), sin(angle)};
        p.r[i] = RADIUS;
        for (int a = 0; a < 2; a++)
            p.x[3 * i + a] = outer + circle * n[a];
        for (int32_t side = 0; side < 2; side++)
            p.contacts[side * GRAINS + i] = (sp_contact){.i = i,
                                                         .j = side ? SP_TOP : SP_BOTTOM,
                                                         .n = {side ? n[0] : -n[0], side ? n[1] : -n[1]},
                                                         .overlap = OVERLAP,
                                                         .fn = FORCE,
                                                         .kn = KN,
                                                         .kt = friction > 0 ? KN : 0};
    }
    assert_ok(sp_packing_check(&p, &err));
    return p;
}

/* The forces over the circumferences; the mean radial stress balances them, and none acts along circles. */
TEST(stresses) {
    for (double circle = 3; circle < 100; circle *= 5) {
        FREED(sp_packing) p = between(circle, 0.5);
        const double b = 0.5 * p.box[0], a = b - p.box[1];
        sp_ring_statics s;
        assert_ok(sp_ring_statics_make(&p, 1e-4, &s, &err));
        assert_relative(s.p_inner, GRAINS * FORCE / (2 * M_PI * a), 1e-12);
        assert_relative(s.p_outer, GRAINS * FORCE / (2 * M_PI * b), 1e-12);
        assert_relative(0.5 * s.s_rr * (b * b - a * a), s.p_outer * b * b - s.p_inner * a * a, 1e-12);
        assert_true(fabs(s.s_tt) + fabs(s.s_rt) + fabs(s.t_inner) + fabs(s.t_outer) < 1e-15 * circle);
        assert_fails(sp_ring_statics_make(&p, NAN, &s, &err), SP_EINVAL, "threshold");
        p.cell = SP_CELL_BOX;
        assert_fails(sp_ring_statics_make(&p, 1e-4, &s, &err), SP_EREFUSED, "must be a ring");
    }
}

/* Each grain is two springs in a row; the grains roll, so that the inner ring turns freely. */
TEST(moduli) {
    FREED(sp_packing) p = between(4, 0.5);
    const double b = 0.5 * p.box[0], a = b - p.box[1], share = b * b / (a * a) - 1;
    const double inner = GRAINS * KN / (4 * M_PI), outer = inner * a / b, shear = 0.5 * (inner - outer);
    const sp_network_options options = sp_network_options_default();
    FREED(sp_network) net = sp_network_none();
    sp_ring_moduli m;
    assert_ok(sp_network_make(&p, &options, &net, &err));
    assert_ok(sp_ring_moduli_make(&net, &m, &err));
    assert_relative(m.p_inner, inner, 1e-12);
    assert_relative(m.p_outer, outer, 1e-12);
    assert_true(fabs(m.shear - shear) <= m.error_shear + 1e-15 && m.error_shear < 1e-12);
    assert_true(fabs(m.bulk - (0.5 * share * outer - shear)) <= m.error_bulk + 1e-15 && m.error_bulk < 1e-12);
    assert_true(m.torque == 0 && isnan(m.shear_turn));
    net.cell = SP_CELL_BOX;
    assert_fails(sp_ring_moduli_make(&net, &m, &err), SP_EREFUSED, "must be a ring");
}

/* Discs: whole ones, the circle alone, none, a lens of equal circles; half of one on the edge of a wide circle. */
TEST(parts_in_circles) {
    assert_relative(sp_disc_in_circle(1, 0.5, 2), 1.0, 1e-15);
    assert_relative(sp_disc_in_circle(0, 2, 1), 0.25, 1e-15);
    assert_true(sp_disc_in_circle(3, 0.5, 2) == 0 && sp_disc_in_circle(1, 0.5, 0) == 0);
    assert_relative(sp_disc_in_circle(1, 1, 1), 2.0 / 3 - sqrt(3) / (2 * M_PI), 1e-14);
    for (double wide = 1e2; wide < 1e9; wide *= 10)
        assert_close(sp_disc_in_circle(wide, 0.5, wide), 0.5, 0.5 / wide);
}

RUN_TESTS(NULL, NULL)
