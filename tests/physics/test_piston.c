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
        FREED(sp_packing) p = make_packing(&spec);
        assert_at_rest(&p, MASS, EXCESS);
        double height = sp_packing_height(&p);
        assert_true(height > 8 && height < 11); /* 120 x pi/4 x 1.013/(12 phi), phi from 0.75 to 0.9 */
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
        FREED(sp_packing) p = make_packing(&spec[k]);
        assert_at_rest(&p, MASS, EXCESS);
    }
}

/* The default protocol is somfai2005 with dashpots that lag: without the lag, and in its steps, they are the same bits.
 */
TEST(test_default_without_lag) {
    for (int dim = 2; dim <= 3; dim++) {
        sp_pack_spec one = sp_pack_spec_default();
        one.dim = dim;
        one.width = 5;
        one.grains = 40;
        one.tolerance = 1e-7;
        sp_pack_spec other = one;
        one.lag = 0;
        one.time_step = 0.7;
        other.protocol = SP_PROTOCOL_SOMFAI2005;
        FREED(sp_packing) p = make_packing(&one), q = make_packing(&other);
        assert_true(same(&p, &q));
    }
}

/* With the lag they are the same material: heights and contacts agree within three standard errors, in narrow tall
 * boxes, where a protocol that brakes earlier makes another. */
TEST(test_one_material) {
    enum { SEEDS = 8 };
    for (int dim = 2; dim <= 3; dim++) {
        double sum[2][2] = {{0}}, square[2][2] = {{0}};
        for (int k = 0; k < 2 * SEEDS; k++) {
            sp_pack_spec spec = sp_pack_spec_default();
            spec.dim = dim;
            spec.width = 5;
            spec.grains = dim == 2 ? 120 : 150;
            spec.tolerance = 1e-7;
            spec.seed = (uint64_t)k;
            spec.protocol = k % 2 ? SP_PROTOCOL_SOMFAI2005 : SP_PROTOCOL_DEFAULT;
            FREED(sp_packing) p = make_packing(&spec);
            const double value[2] = {sp_packing_height(&p), p.n_contacts};
            for (int q = 0; q < 2; q++) {
                sum[k % 2][q] += value[q];
                square[k % 2][q] += value[q] * value[q];
            }
        }
        for (int q = 0; q < 2; q++) {
            double variance = 0;
            for (int protocol = 0; protocol < 2; protocol++) {
                sum[protocol][q] /= SEEDS;
                variance += (square[protocol][q] / SEEDS - sum[protocol][q] * sum[protocol][q]) / (SEEDS - 1);
            }
            const double apart = (sum[0][q] - sum[1][q]) / sqrt(variance);
            print_message("%d dimensions, %s: %g and %g, %.1f standard errors apart\n", dim, q ? "contacts" : "height",
                          sum[0][q], sum[1][q], apart);
            assert_true(fabs(apart) < 3);
        }
    }
}

TEST(test_few_grains) {
    for (int n = 1; n <= 5; n++) {
        sp_pack_spec spec = sp_pack_spec_default();
        spec.grains = n;
        spec.width = 5;
        spec.seed = (uint64_t)n;
        FREED(sp_packing) p = make_packing(&spec);
        int32_t rattlers;
        assert_at_rest(&p, MASS, EXCESS);
        assert_ok(sp_packing_rattlers(&p, 1e-4, NULL, NULL, &rattlers, &err));
        assert_true(rattlers < n); /* somebody holds the piston */
    }
}

RUN_TESTS(NULL, NULL)
