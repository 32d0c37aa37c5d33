/* The cost model and the remaining times, on compressions whose clock is their steps: no test waits for a clock. */
#include "base/base.h"
#include "cost/remaining.h"

#include "test.h"

#include <math.h>
#include <sonopack/cost.h>
#include <sonopack/study/forecast.h>
#include <string.h>

typedef struct recorded {
    sp_remaining left;
    double first, last, at_third, steps_at_third, total; /* said, in steps */
    double expected;
    int grown, said;
    double fraction;
    bool fraction_fell;
} recorded;

static bool watch(const sp_pack_progress *p, void *user) {
    recorded *r = user;
    const double steps = (double)p->steps;
    const sp_time_left left = sp_remaining_next(&r->left, steps, steps);
    assert_true(left.low <= left.high && left.low >= 0);
    r->grown += r->said > 0 && left.high > r->last;
    r->last = left.high;
    if (r->said++ == 0)
        r->first = left.high;
    if (steps <= r->expected / 3) {
        r->at_third = 0.5 * (left.low + left.high);
        r->steps_at_third = steps;
    }
    const double fraction = sp_remaining_fraction(&r->left, steps);
    r->fraction_fell |= fraction < r->fraction || fraction >= 1;
    r->fraction = fraction;
    return true;
}

static sp_pack_spec small(int dim, double pressure, double friction, sp_protocol protocol) {
    sp_pack_spec s = sp_pack_spec_default();
    s.dim = dim;
    s.grains = dim == 3 ? 160 : 150;
    s.width = dim == 3 ? 5 : 12;
    s.pressure = pressure;
    s.friction = friction;
    s.protocol = protocol;
    return s;
}

static recorded record(const sp_pack_spec *spec) {
    const sp_machine machine = sp_machine_reference();
    const sp_packing_forecast f = sp_packing_expect(spec, 1, &machine);
    recorded r = {.expected = f.steps, .left = sp_remaining_begin(f.steps, 0, 1)};
    FREED(sp_packing) p = sp_packing_none();
    assert_ok(sp_packing_make(spec, watch, &r, &p, &err));
    r.total = (double)p.steps;
    return r;
}

/* Unlike compressions: what is said never grows, is right within 2 at a third, and is small at the end: the third of
 * them all where a third more steps were expected. */
TEST(test_remaining_never_grows) {
    const sp_pack_spec specs[] = {small(2, 1e-4, 0.5, SP_PROTOCOL_DEFAULT), small(2, 1e-6, 0.5, SP_PROTOCOL_DEFAULT),
                                  small(2, 1e-3, 0, SP_PROTOCOL_DEFAULT), small(3, 1e-4, 0.5, SP_PROTOCOL_DEFAULT)};
    for (size_t k = 0; k < sizeof specs / sizeof *specs; k++) {
        const recorded r = record(&specs[k]);
        const double right = r.total - r.steps_at_third;
        assert_true(r.said > 3 && r.grown == 0 && !r.fraction_fell);
        assert_true(r.at_third > right / 2 && r.at_third < 2 * right);
        assert_true(r.last < 0.4 * r.total && r.last > 0);
    }
}

static sp_pack_spec in_cell(sp_cell cell, int dim, double pressure, double friction, sp_protocol protocol) {
    sp_pack_spec s = small(dim, pressure, friction, protocol);
    s.cell = cell;
    s.width = sp_pack_spec_default().width; /* equal edges */
    return s;
}

static sp_pack_spec tall(void) {
    sp_pack_spec s = small(3, 1e-6, 0.5, SP_PROTOCOL_AFFINE);
    s.grains = 551; /* 20 d high */
    return s;
}

/* The steps that are expected are those that are taken, within 2. A cell at 1e-3 takes a fifth of those of a piston, an
 * affine compression a third: their own laws are what is tested. */
TEST(test_steps) {
    SKIP_SANITIZED();
    const sp_pack_spec specs[] = {small(2, 1e-5, 0.3, SP_PROTOCOL_DEFAULT),
                                  small(2, 1e-4, 0.5, SP_PROTOCOL_QUICK),
                                  small(3, 1e-3, 0, SP_PROTOCOL_DEFAULT),
                                  small(2, 1e-4, 0.5, SP_PROTOCOL_AFFINE),
                                  small(3, 1e-4, 0, SP_PROTOCOL_AFFINE),
                                  tall(),
                                  in_cell(SP_CELL_PERIODIC, 2, 1e-3, 0.5, SP_PROTOCOL_DEFAULT),
                                  in_cell(SP_CELL_PERIODIC, 2, 1e-6, 0, SP_PROTOCOL_AFFINE),
                                  in_cell(SP_CELL_PERIODIC, 3, 1e-4, 0.5, SP_PROTOCOL_DEFAULT),
                                  in_cell(SP_CELL_BOX, 2, 1e-3, 0, SP_PROTOCOL_QUICK),
                                  in_cell(SP_CELL_BOX, 3, 1e-3, 0.5, SP_PROTOCOL_DEFAULT)};
    for (size_t k = 0; k < sizeof specs / sizeof *specs; k++) {
        const recorded r = record(&specs[k]);
        assert_true(r.expected > r.total / 2 && r.expected < 2 * r.total);
    }
}

/* A clock ten times slower than expected, and work of three times the expected amount. */
TEST(test_surprises) {
    sp_remaining r = sp_remaining_begin(100, 0, 0.1);
    double before = INFINITY;
    for (int k = 1; k <= 300; k++) {
        const sp_time_left left = sp_remaining_next(&r, k, k);
        assert_true(left.high <= before && left.high > 0);
        before = left.high;
    }
    assert_true(before < 30);
    r = sp_remaining_begin(100, 40, 1); /* resumed */
    const sp_time_left left = sp_remaining_next(&r, 0, 40);
    assert_true(fabs(left.high - 60) < 1e-9 && left.low < left.high);
    assert_true(fabs(sp_remaining_fraction(&r, 40) - 0.4) < 1e-12);
}

/* Costs grow with the size, and follow the machine. */
TEST(test_laws) {
    const sp_machine one = sp_machine_reference();
    sp_machine slow = one;
    for (int k = 0; k < SP_KERNELS; k++)
        slow.slower[k] = 3;
    sp_pack_spec spec = sp_pack_spec_default();
    const sp_packing_forecast packing = sp_packing_expect(&spec, 1, &one);
    assert_true(fabs(packing.height - 24.7) < 0.7); /* measured: 24.65 to 25.0 */
    assert_true(fabs(sp_packing_expect(&spec, 1, &slow).cost.cpu / packing.cost.cpu - 3) < 1e-9);
    spec.grains = 1200;
    assert_true(sp_packing_expect(&spec, 1, &one).cost.cpu > 2.5 * packing.cost.cpu);
    sp_pack_spec remembers = spec;
    remembers.tangential = SP_TANGENTIAL_HISTORY;
    assert_true(sp_packing_expect(&remembers, 1, &one).cost.cpu > 4 * sp_packing_expect(&spec, 1, &one).cost.cpu);
    assert_true(sp_packing_expect(&remembers, 1, &one).cost.memory > sp_packing_expect(&spec, 1, &one).cost.memory);
    spec.grains = 600;
    const sp_network_size net = sp_network_size_expect(&spec, &packing);
    assert_true(fabs(net.dofs / 1659 - 1) < 0.1 && fabs(net.omega / 1.375 - 1) < 0.1);
    const sp_modes_options vectors = {.vectors = true};
    const sp_modes_range few = sp_modes_range_lowest(20), all = sp_modes_range_all();
    assert_true(sp_cost_modes(&net, &vectors, &few, 20, &one).cpu <
                0.1 * sp_cost_modes(&net, &vectors, &all, net.dofs, &one).cpu);
    sp_signal_options o = sp_signal_options_default();
    sp_signal_method method;
    double products;
    o.method = SP_SIGNAL_VERLET;
    assert_true(isnan(sp_cost_signal(&net, &o, &one, &method, &products).cpu));
    o.method = SP_SIGNAL_AUTO;
    assert_true(sp_cost_signal(&net, &o, &one, &method, &products).cpu > 0);
    assert_int_equal(method, SP_SIGNAL_CHEBYSHEV);
}

/* Every compression has a law, and the memory that is foretold is that by which one is refused. */
TEST(test_every_compression) {
    const sp_machine one = sp_machine_reference();
    for (int k = 0; k < 48; k++) {
        sp_pack_spec spec = small(2 + k % 2, 1e-4, k / 2 % 2 ? 0.5 : 0, (sp_protocol)(k / 4 % 4));
        spec.cell = (sp_cell)(k / 16);
        const sp_packing_forecast f = sp_packing_expect(&spec, 1, &one);
        assert_true(f.steps > 100 && f.steps < 1e6 && f.cost.cpu > 0);
        assert_true(f.cost.memory > 200.0 * spec.grains && f.cost.memory < 2e4 * spec.grains);
        spec.grains = 100000000;
        spec.width = spec.dim == 3 ? 464 : 10000;
        const double have = sp_memory_limit(), need = sp_packing_expect(&spec, 1, &one).cost.memory;
        sp_packing p = sp_packing_none();
        if (need > have)
            assert_fails(sp_packing_make(&spec, NULL, NULL, &p, &err), SP_ENOMEM, "packing.grains");
    }
}

/* The kernels do their work; how fast is not asked. */
TEST(test_machine) {
    sp_machine m;
    assert_ok(sp_machine_measure((1U << SP_KERNELS) - 1, &m, &err));
    for (int k = 0; k < SP_KERNELS; k++)
        assert_true(m.slower[k] > 0 && isfinite(m.slower[k]));
}

static sp_stored every_third(void *user, const sp_scene *scene, const char *name) {
    int *asked = user;
    (void)scene, (void)name;
    return (*asked)++ % 3 == 0 ? SP_STORED_ALL : SP_STORED_NOT;
}

/* Samples are counted, and only the missing ones cost. */
TEST(test_study) {
    const sp_machine one = sp_machine_reference();
    const sp_study_options o = {.jobs = 1, .shard = 1, .shards = 1, .threads = 1};
    FREED(sp_scene) scene;
    sp_forecast none, some;
    int asked = 0;
    const sp_study_sink sink = {.user = &asked, .has = every_third};
    char samples[] = "study.samples=6", want[] = "study.want=[\"moduli\"]", sweep[] = "packing.pressure=[1e-5, 1e-4]",
         *override[] = {samples, want, sweep};
    assert_ok(sp_scene_parse("packing = { };", "test", 3, override, &scene, &err));
    assert_ok(sp_study_expect(&scene, &o, NULL, NULL, NULL, &one, &none, &err));
    assert_ok(sp_study_expect(&scene, &o, &sink, NULL, NULL, &one, &some, &err));
    assert_int_equal(none.samples, 12);
    assert_int_equal(none.part[0].count, 12);
    assert_int_equal(some.stored, 4);
    assert_int_equal(some.part[0].count, 8);
    assert_true(some.part[0].cost.cpu < none.part[0].cost.cpu && some.part[0].bytes < none.part[0].bytes);
}

RUN_TESTS(NULL, NULL)
