/* Mindlin's law of one contact: closed forms at a constant normal force, memory of loops, and packings made with it. */
#include "test.h"

#include "base/base.h"
#include "packing/mindlin.h"

#include <sonopack/network.h>
#include <sonopack/packing.h>
#include <string.h>

static const double MU_F = 0.7, K = 1.3; /* limit and stiffness of full stick */

/* Displacement on first loading to F_t, Mindlin and Deresiewicz (1953). */
static double virgin(double force) { return 1.5 * MU_F / K * (1 - pow(1 - force / MU_F, 2.0 / 3)); }

/* Displacement on unloading from top to F_t, and on reloading from -top: the same curve turned by half a turn. */
static double unloading(double top, double force) { return virgin(top) - 2 * virgin(0.5 * (top - force)); }
static double reloading(double top, double force) { return -unloading(top, -force); }

typedef struct contact {
    double past[MINDLIN_NUMBERS], force, s;
} contact;

static void slip_to(contact *c, double s, int steps) {
    const double from = c->s;
    for (int k = 1; k <= steps; k++) {
        const double next = from + (s - from) * k / steps;
        c->force = sp_mindlin_slip(c->past, 1, c->force, MU_F, K, next - c->s);
        c->s = next;
    }
}

/* Around a loop between +-top: every point lies on the closed curves, whatever the length of the steps. */
TEST(test_loop) {
    const double tops[] = {0.05, 0.3, 0.6, 0.699};
    for (int q = 0; q < 4; q++)
        for (int steps = 1; steps <= 40; steps *= 6) {
            const double top = tops[q], far = virgin(top);
            contact c = {{0}, 0, 0};
            for (int k = 1; k <= 10; k++) {
                slip_to(&c, far * k / 10, steps);
                assert_close(virgin(c.force), c.s, 1e-13);
            }
            for (int turn = 0; turn < 3; turn++) {
                for (int k = 1; k <= 10; k++) {
                    slip_to(&c, far * (1 - 0.2 * k), steps);
                    assert_close(unloading(top, c.force), c.s, 1e-13);
                }
                assert_close(c.force, -top, 1e-13);
                for (int k = 1; k <= 10; k++) {
                    slip_to(&c, far * (-1 + 0.2 * k), steps);
                    assert_close(reloading(top, c.force), c.s, 1e-13);
                }
            }
            slip_to(&c, 0.5 * (far + virgin(MU_F)), 1); /* the loop is closed: first loading goes on */
            assert_close(virgin(c.force), c.s, 1e-13);
        }
}

/* Energy lost in a loop: (36/5) (mu F)^2/k (1 - (1 - x)^(5/3) - 5/6 x (1 + (1 - x)^(2/3))), x = top/(mu F). */
TEST(test_energy) {
    enum { STEPS = 20000 };
    const double top = 0.5, far = virgin(top), x = top / MU_F;
    const double exact = 7.2 * MU_F * MU_F / K * (1 - pow(1 - x, 5.0 / 3) - 5.0 / 6 * x * (1 + pow(1 - x, 2.0 / 3)));
    contact c = {{0}, 0, 0};
    double work = 0;
    slip_to(&c, far, 1);
    for (int k = 0; k < 2 * STEPS; k++) {
        const double before = c.force, ds = (k < STEPS ? -2 : 2) * far / STEPS;
        slip_to(&c, c.s + ds, 1);
        work += 0.5 * (before + c.force) * ds;
    }
    assert_close(work, exact, 1e-6 * exact);
    assert_true(exact > 0.01 * MU_F * far);
}

/* A small loop within a large one is closed and forgotten; a reversal has the stiffness of full stick. */
TEST(test_memory) {
    const double top = 0.6, far = virgin(top);
    contact c = {{0}, 0, 0}, small;
    slip_to(&c, far, 3);
    slip_to(&c, 0.2 * far, 3);
    small = c;
    slip_to(&small, small.s + 1e-9, 1);
    assert_close((small.force - c.force) / 1e-9, K, 1e-3 * K);
    slip_to(&small, 0.5 * far, 4); /* there and back, with a smaller loop inside */
    slip_to(&small, 0.4 * far, 2);
    slip_to(&small, 0.45 * far, 2);
    slip_to(&small, 0.2 * far, 5);
    assert_close(small.force, c.force, 1e-13);
    slip_to(&small, -0.3 * far, 2);
    assert_close(unloading(top, small.force), small.s, 1e-13);
    assert_true(fabs(small.past[0]) == 2);
}

/* Coulomb's limit is reached, and never passed. */
TEST(test_limit) {
    contact c = {{0}, 0, 0};
    slip_to(&c, virgin(MU_F), 7);
    assert_close(c.force, MU_F, 1e-13);
    slip_to(&c, 5, 7);
    assert_true(c.force == MU_F);
    slip_to(&c, 5 - 2 * virgin(MU_F), 7);
    assert_close(c.force, -MU_F, 1e-12);
    /* a smaller normal force: the force is cut */
    const double force = sp_mindlin_slip(c.past, 1, c.force, 0.5 * MU_F, K, -1e-12);
    assert_close(force, -0.5 * MU_F, 1e-12);
    assert_true(sp_mindlin_slip(c.past, 1, force, 0, K, 1) == 0 && c.past[0] == 0);
}

/* Any sequence of slips and normal forces keeps the force within the limit, and its slope between 0 and k. */
TEST(test_random) {
    unsigned seed = 3;
    double past[3 * MINDLIN_NUMBERS] = {0}, force = 0;
    for (int k = 0; k < 200000; k++) {
        const double limit = MU_F * (0.2 + rand_r(&seed) / (double)RAND_MAX);
        const double slip = (rand_r(&seed) / (double)RAND_MAX - 0.5) * (k % 7 ? 0.1 : 2);
        const double cut = fmax(-limit, fmin(limit, force));
        const double after = sp_mindlin_slip(past, 3, force, limit, K, slip);
        const double slope = (after - cut) / slip;
        if (!(fabs(after) <= limit && slope >= -1e-9 && slope <= K * (1 + 1e-9)))
            fail_msg("step %d: force %g limit %g slope %g", k, after, limit, slope);
        force = after;
    }
}

static sp_pack_spec history_spec(bool reference) {
    sp_pack_spec s = sp_pack_spec_default();
    s.grains = 40;
    s.width = 6;
    s.tolerance = 1e-8;
    s.tangential = SP_TANGENTIAL_HISTORY;
    s.reference = reference;
    return s;
}

/* Packings come to rest with it, by both paths, and hold Coulomb's condition; they are not those without. */
TEST(test_packings) {
    sp_packing p[3];
    for (int k = 0; k < 3; k++) {
        sp_pack_spec s = history_spec(k == 1);
        if (k == 2)
            s.tangential = SP_TANGENTIAL_CONSTANT;
        assert_ok(sp_packing_make(&s, NULL, NULL, &p[k], &err));
        assert_true(p[k].residual <= 1e-8);
        for (int32_t c = 0; c < p[k].n_contacts; c++) {
            const sp_contact *q = &p[k].contacts[c];
            assert_true(hypot(q->ft[0], q->ft[1]) <= 0.5 * q->fn * (1 + 1e-12));
        }
    }
    assert_true(sp_packing_hash(&p[0]) != sp_packing_hash(&p[2]));
    for (int k = 0; k < 3; k++)
        sp_packing_free(&p[k]);
}

typedef struct kept {
    void *bytes;
    size_t size;
    int count, wanted;
} kept;

static sp_status keep(const void *state, size_t size, void *user, sp_error *err) {
    kept *k = user;
    (void)err;
    if (k->count++ != k->wanted)
        return SP_OK;
    k->bytes = malloc(size);
    memcpy(k->bytes, state, size);
    k->size = size;
    return SP_OK;
}

/* A run that is resumed from a saved state ends with the same bits: the state has the memory of the contacts. */
TEST(test_state) {
    const sp_pack_spec s = history_spec(false);
    kept k = {.wanted = 1};
    FREED(sp_packing) whole = sp_packing_none(), resumed = sp_packing_none();
    sp_pack_hooks hooks = {.save = keep, .user = &k};
    assert_ok(sp_packing_make_with(&s, &hooks, &whole, &err));
    assert_non_null(k.bytes);
    hooks = (sp_pack_hooks){.state = k.bytes, .state_size = k.size};
    assert_ok(sp_packing_make_with(&s, &hooks, &resumed, &err));
    assert_true(sp_packing_hash(&whole) == sp_packing_hash(&resumed));
    sp_pack_spec other = s;
    other.tangential = SP_TANGENTIAL_CONSTANT;
    assert_int_equal(sp_pack_state_check(&other, k.bytes, k.size, NULL, NULL), SP_EFORMAT);
    free(k.bytes);
}

/* The springs of the three kinds of networks, and that they bound each other. */
TEST(test_networks) {
    sp_pack_spec s = history_spec(false);
    FREED(sp_packing) p = sp_packing_none();
    sp_network net[3];
    assert_ok(sp_packing_make(&s, NULL, NULL, &p, &err));
    for (int k = 0; k < 3; k++) {
        sp_network_options o = sp_network_options_default();
        o.tangential = (sp_springs)k;
        assert_ok(sp_network_make(&p, &o, &net[k], &err));
    }
    for (int32_t c = 0; c < net[0].n_springs; c++) {
        const sp_contact *q = &p.contacts[net[0].springs[c].contact];
        const double left = 1 - hypot(q->ft[0], q->ft[1]) / (0.5 * q->fn);
        assert_close(net[0].springs[c].kt, net[0].springs[c].kn, 1e-15);
        assert_close(pow(net[1].springs[c].kt / net[0].springs[c].kt, 3), left, 1e-12);
        assert_close(pow(net[2].springs[c].kt / net[0].springs[c].kt, 3), 0.5 * left, 1e-12);
    }
    for (int k = 0; k < 3; k++)
        sp_network_free(&net[k]);
}

TEST(test_refusals) {
    sp_pack_spec s = history_spec(false);
    sp_error why = {0};
    s.dim = 3;
    s.width = 5;
    assert_int_equal(sp_pack_spec_check(&s, &why), SP_EINVAL);
    assert_string_equal(why.key, "packing.tangential");
    s = history_spec(false);
    s.tangential = (sp_tangential)2;
    assert_int_equal(sp_pack_spec_check(&s, &why), SP_EINVAL);
    assert_string_equal(why.key, "packing.tangential");
}

RUN_TESTS(NULL, NULL)
