/* Packings under the piston: at rest, sound, and a function of scene and seed alone. Their statistics against the paper
 * are in benchmarks/ (they need many samples). */
#include "making.h"

#include "base/base.h"

#include <sonopack/packing.h>

/* The default tolerance 1e-6 p bounds |F|/(p d^2) of a grain by 1e-6 m: largest m is 0.9. Coulomb holds to rounding:
 * the spring was cut at mu F_n a step ago, and F_n has changed since by the residual motion only. */
static const double MASS = 1, EXCESS = 1e-6;

TEST(test_rest) {
    const double pressure[] = {1e-4, 1e-5, 1e-6}, friction[] = {0.5, 0.1, 0};
    for (int k = 0; k < 9; k++) {
        sp_pack_spec spec = sp_pack_spec_default();
        spec.grains = 120;
        spec.width = 12;
        spec.pressure = pressure[k % 3];
        spec.friction = friction[k / 3];
        spec.poisson = k % 2 ? 0.3 : 0;
        spec.seed = 100 + (uint64_t)k;
        sp_packing p = make_packing(&spec);
        assert_at_rest(&p, MASS, EXCESS);
        double height = sp_packing_height(&p);
        assert_true(height > 8 && height < 11); /* 120 x pi/4 x 1.013/(12 phi), phi from 0.75 to 0.9 */
        sp_packing_free(&p);
    }
}

static bool same(const sp_packing *p, const sp_packing *q) {
    return p->n == q->n && p->n_contacts == q->n_contacts && p->steps == q->steps &&
           memcmp(p->x, q->x, (size_t)p->n * 24) == 0 && memcmp(p->r, q->r, (size_t)p->n * 8) == 0 &&
           memcmp(p->contacts, q->contacts, (size_t)p->n_contacts * sizeof *p->contacts) == 0 &&
           memcmp(p->box, q->box, sizeof p->box) == 0;
}

static bool count_calls(const sp_pack_progress *progress, void *user) {
    assert_true(progress->steps >= 0 && progress->height > 0);
    ++*(int *)user;
    return true;
}

TEST(test_determinism) {
    sp_pack_spec spec = sp_pack_spec_default();
    spec.grains = 80;
    spec.width = 10;
    spec.seed = 5;
    sp_packing p = make_packing(&spec), q = sp_packing_none();
    int calls = 0;
    assert_ok(sp_packing_make(&spec, count_calls, &calls, &q, &err));
    assert_true(calls >= 2 && calls <= 1 + q.steps / 40);
    assert_true(same(&p, &q));
    sp_packing_free(&q);
    spec.seed = 6;
    q = make_packing(&spec);
    assert_false(same(&p, &q));
    sp_packing_free(&q);
    sp_packing_free(&p);
}

static bool stop_soon(const sp_pack_progress *progress, void *user) {
    (void)user;
    return progress->steps < 4000;
}

TEST(test_stops) {
    sp_pack_spec spec = sp_pack_spec_default();
    sp_packing p = sp_packing_none();
    assert_fails(sp_packing_make(&spec, stop_soon, NULL, &p, &err), SP_EINTERRUPTED, "4000");
    spec.grains = 40;
    spec.width = 6;
    spec.max_steps = 2000;
    assert_fails(sp_packing_make(&spec, NULL, NULL, &p, &err), SP_EFAILED, "2000");
    spec.max_steps = 0;
    spec.pressure = 1e-2; /* flattens small grains between large ones */
    spec.grains = 300;
    spec.width = 16;
    spec.diameter_min = 0.02;
    spec.diameter_max = 1.98;
    assert_fails(sp_packing_make(&spec, NULL, NULL, &p, &err), SP_EFAILED,
                 "packing.pressure packing.diameter_min 0.02");
    assert_null(p.x);
}

/* Protocols at the ends of their ranges end in packings like others: a piston lighter than a grain, one that falls for
 * long before it is carried, no phase with global damping, and no such damping in it. */
TEST(test_odd_protocols) {
    sp_pack_spec base = sp_pack_spec_default();
    base.grains = 40;
    base.width = 6;
    enum { PROTOCOLS = 11 };
    sp_pack_spec spec[PROTOCOLS];
    for (int k = 0; k < PROTOCOLS; k++)
        spec[k] = base;
    spec[0].piston_mass = 0.1;
    spec[1].piston_mass = 1e3;
    spec[2].calm = 0;
    spec[3].drag = 0;
    spec[4].gas_fraction = 0.01; /* so far a heavy piston would fall that it strikes too hard */
    spec[4].protocol = SP_PROTOCOL_QUICK;
    spec[5].damping = 2;
    spec[5].time_step = 0.8;
    spec[6].diameter_min = 0.2;
    spec[6].diameter_max = 1.5;
    spec[7].diameter_min = spec[7].diameter_max = 1;
    spec[8].friction = 1e6;
    spec[9].damping = spec[9].calm_damping = 0.001; /* two grains alone swing faster than any in a packing */
    spec[9].friction = 1e6;
    spec[9].time_step = 0.8;
    spec[9].diameter_min = spec[9].diameter_max = 1;
    spec[10].grains = 150; /* the piston would strike too hard */
    spec[10].pressure = 1e-2;
    for (int k = 0; k < PROTOCOLS; k++) {
        print_message("protocol %d\n", k);
        sp_packing p = make_packing(&spec[k]);
        assert_at_rest(&p, MASS, EXCESS);
        sp_packing_free(&p);
    }
}

/* The default protocol is the motion of somfai2005 until the global damping begins (in 3D with the same time step):
 * without it they are the same bits, and with it the same material, in a narrow tall box too, where one that brakes
 * earlier makes another. Now and then a packing rearranges while it comes to rest, in one and not in the other. */
TEST(test_one_material) {
    for (int dim = 2; dim <= 3; dim++) {
        sp_pack_spec one = sp_pack_spec_default();
        one.dim = dim;
        one.width = 5;
        one.grains = dim == 2 ? 120 : 150;
        one.tolerance = 1e-7;
        one.time_step = 0.7;
        int alike = 0;
        for (one.seed = 1; one.seed <= 3; one.seed++) {
            sp_pack_spec other = one;
            other.protocol = SP_PROTOCOL_SOMFAI2005;
            sp_packing p = make_packing(&one), q = make_packing(&other);
            const double ratio = sp_packing_height(&p) / sp_packing_height(&q);
            print_message("%d dimensions: heights %g off, %d and %d contacts\n", dim, ratio - 1, p.n_contacts,
                          q.n_contacts);
            alike += fabs(ratio - 1) < 1e-3 && abs(p.n_contacts - q.n_contacts) <= 0.03 * q.n_contacts;
            sp_packing_free(&p);
            sp_packing_free(&q);
        }
        assert_true(alike >= 2);
        one.calm = 0;
        one.grains = 40;
        one.tolerance = 1e-5;
        sp_pack_spec other = one;
        other.protocol = SP_PROTOCOL_SOMFAI2005;
        sp_packing p = make_packing(&one), q = make_packing(&other);
        assert_true(same(&p, &q));
        sp_packing_free(&p);
        sp_packing_free(&q);
    }
}

TEST(test_few_grains) {
    for (int n = 1; n <= 5; n++) {
        sp_pack_spec spec = sp_pack_spec_default();
        spec.grains = n;
        spec.width = 5;
        spec.seed = (uint64_t)n;
        sp_packing p = make_packing(&spec);
        int32_t rattlers;
        assert_at_rest(&p, MASS, EXCESS);
        assert_ok(sp_packing_rattlers(&p, 1e-4, NULL, NULL, &rattlers, &err));
        assert_true(rattlers < n); /* somebody holds the piston */
        sp_packing_free(&p);
    }
}

RUN_TESTS(NULL, NULL)
