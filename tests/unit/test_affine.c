/* The affine protocol: a homogeneous strain compresses the gas at a fixed inertial number, then the piston takes over.
 */
#include "test.h"

#include <sonopack/packing.h>
#include <string.h>

static sp_pack_spec affine(int dim, int32_t grains) {
    sp_pack_spec spec = sp_pack_spec_default();
    spec.protocol = SP_PROTOCOL_AFFINE;
    spec.dim = dim;
    spec.grains = grains;
    spec.width = 5;
    return spec;
}

static sp_packing make(const sp_pack_spec *spec, sp_pack_watch watch, void *user) {
    sp_packing p = sp_packing_none();
    assert_ok(sp_packing_make(spec, watch, user, &p, &err));
    return p;
}

TEST(test_rest) {
    for (int k = 0; k < 6; k += SANITIZED_STEP(5)) {
        sp_pack_spec spec = affine(k % 2 ? 3 : 2, 80);
        spec.friction = k == 2 || k == 3 ? 0 : 0.5;
        spec.pressure = k < 4 ? 1e-4 : 1e-2;
        if (k == 4) /* a lattice of disks, which all turn in the same sense */
            spec.diameter_min = spec.diameter_max = 1;
        FREED(sp_packing) p = make(&spec, NULL, NULL);
        sp_audit audit;
        char reason[200];
        assert_ok(sp_packing_audit(&p, 1e-4, &audit, &err));
        assert_true(sp_audit_worst(&audit, 1e-3, reason, sizeof reason) < 1e-3);
    }
}

/* Heights as a run goes on, until the piston takes over. */
typedef struct heights {
    double height[2000];
    int count;
} heights;

static bool note(const sp_pack_progress *progress, void *user) {
    heights *h = user;
    assert_true(strcmp(progress->phase, "flight") != 0); /* nothing flies freely */
    if (h->count < 2000)
        h->height[h->count++] = progress->height;
    return true;
}

/* Nothing but the strain moves the walls: the height shrinks steadily down to that of the packing, whereas a piston
 * rebounds. */
TEST(test_no_rebound) {
    sp_pack_spec spec = affine(2, 400);
    heights h = {.count = 0};
    double rise = 0;
    FREED(sp_packing) p = make(&spec, note, &h);
    for (int i = 1; i < h.count; i++)
        rise = fmax(rise, h.height[i] / h.height[i - 1] - 1);
    assert_true(h.count > 3 && h.height[0] > 2 * sp_packing_height(&p));
    assert_true(rise < 0.01);
}

static double steps_of(sp_protocol protocol, int32_t grains) {
    sp_pack_spec spec = affine(2, grains);
    spec.protocol = protocol;
    spec.tolerance = 1e-8;
    FREED(sp_packing) p = make(&spec, NULL, NULL);
    const double steps = (double)p.steps;
    return steps;
}

/* No plug flies and rebounds, which takes the longer the higher the box. */
TEST(test_steps_and_height) {
    SKIP_SANITIZED();
    const double affine_steps = steps_of(SP_PROTOCOL_AFFINE, 600), piston = steps_of(SP_PROTOCOL_DEFAULT, 600);
    print_message("affine: %g steps, piston: %g\n", affine_steps, piston);
    assert_true(affine_steps < 0.5 * piston);
}

/* State that a run saved after 8000 steps, as a copy. */
typedef struct kept {
    unsigned char *bytes;
    size_t size;
    int count;
} kept;

static sp_status keep(const void *state, size_t size, void *user, sp_error *why) {
    kept *k = user;
    (void)why;
    if (++k->count != 2)
        return SP_OK;
    k->bytes = malloc(size);
    assert_non_null(k->bytes);
    memcpy(k->bytes, state, size);
    k->size = size;
    return SP_OK;
}

/* Of a dilute gas a few grains may carry a wall for a moment, which packing.calm = 100 takes for calm. The strain goes
 * on all the same, and a run that is resumed in the middle of it ends in the same packing. */
TEST(test_calm_gas) {
    for (uint64_t seed = 1; seed <= 6; seed += SANITIZED_STEP(5)) {
        sp_pack_spec spec = affine(2, 60);
        spec.friction = 0;
        spec.gas_fraction = 0.01;
        spec.time_step = 0.05;
        spec.calm = 100;
        spec.max_steps = 2000000;
        spec.seed = seed;
        kept k = {.count = 0};
        sp_pack_hooks hooks = {.save = keep, .user = &k};
        FREED(sp_packing) whole = sp_packing_none(), resumed = sp_packing_none();
        assert_ok(sp_packing_make_with(&spec, &hooks, &whole, &err));
        assert_true(k.size > 0);
        hooks = (sp_pack_hooks){.state = k.bytes, .state_size = k.size};
        assert_ok(sp_packing_make_with(&spec, &hooks, &resumed, &err));
        assert_true(sp_packing_hash(&whole) == sp_packing_hash(&resumed));
        free(k.bytes);
    }
}

RUN_TESTS(NULL, NULL)
