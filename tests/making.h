#ifndef TEST_MAKING_H
#define TEST_MAKING_H
/* Packings made for tests, and what all of them must have. */
#include "test.h"

#include <sonopack/packing.h>

static inline sp_packing make_packing(const sp_pack_spec *spec) {
    sp_packing p = sp_packing_none();
    assert_ok(sp_packing_make(spec, NULL, NULL, &p, &err));
    return p;
}

static inline sp_pack_spec spheres(int32_t grains, double width, double friction, uint64_t seed) {
    sp_pack_spec spec = sp_pack_spec_default();
    spec.dim = 3;
    spec.grains = grains;
    spec.width = width;
    spec.friction = friction;
    spec.seed = seed;
    return spec;
}

/* mass: by how much the heaviest grains may leave larger forces than those of diameter 1; excess over Coulomb's limit.
 */
static inline void assert_at_rest(const sp_packing *p, double mass, double excess) {
    sp_audit a;
    assert_ok(sp_packing_check(p, &err));
    assert_ok(sp_packing_audit(p, 1e-4, &a, &err));
    assert_true(a.force_residual < 2e-6 * mass);
    assert_true(a.torque_residual < 1e-6 * mass);
    assert_true(a.wall_residual < 1e-5);
    assert_true(a.law_residual < 1e-12);
    assert_true(a.geometry_residual < 1e-9);
    assert_true(a.coulomb_excess < excess);
    assert_int_equal(a.missing, 0);
}

#endif
