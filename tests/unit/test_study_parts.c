/* Parts of a sample that a scene describes, and that are made again when it describes them otherwise: fronts at planes,
 * the signal; and probes and frequencies. */
#include "base/base.h"
#include "ensemble/sample.h"
#include "test.h"

#include <sonopack/modes.h>
#include <sonopack/study/study.h>

static const char text[] = "packing = { width = 8; grains = 120; tolerance = 1e-7; protocol = \"quick\"; };"
                           "signal = { planes = [0.5, 3, 7.5, 12, 100]; points = 51; until = 30; };"
                           "study = { want = [\"planes\"]; };";

static sp_scene parse(const char *set) {
    char value[200];
    char *sets[] = {value};
    sp_scene scene;
    snprintf(value, sizeof value, "%s", set ? set : "");
    assert_ok(sp_scene_parse(text, "test", set ? 1 : 0, sets, &scene, &err));
    return scene;
}

/* A packing that all tests share. */
static sp_packing packing;

static int make(void **state) {
    (void)state;
    FREED(sp_scene) scene = parse(NULL);
    sp_error err = {0};
    packing = sp_packing_none();
    const sp_status status = sp_packing_make(&scene.pack, NULL, NULL, &packing, &err);
    return status != SP_OK;
}

static int release(void **state) {
    (void)state;
    sp_packing_free(&packing);
    return 0;
}

/* ---- planes ------------------------------------------------------------------------------------------------------ */

/* Each plane by itself: its own signal, up to the end of its own window. */
TEST(planes_one_by_one) {
    FREED(sp_scene) scene = parse(NULL);
    sp_sample s = {0};
    assert_ok(sp_sample_make(&scene, SP_WANT_PLANES, &packing, &s, NULL, &err));
    assert_int_equal(s.have, SP_WANT_PLANES); /* no other part */
    assert_int_equal(s.planes, 3);            /* 0.5 is nearer to a wall than a diameter, 100 above the box */
    const double height = sp_packing_height(&packing);
    assert_true(height > 13.5 && height < 17);
    FREED(sp_network) net = sp_network_none();
    assert_ok(sp_network_make(&packing, &scene.network, &net, &err));
    for (int k = 0; k < 3; k++) {
        const double plane[3] = {3, 7.5, 12};
        assert_true(s.plane[k] == plane[k]);
        sp_place at = {.kind = SP_PLACE_PLANE, .height = plane[k]};
        sp_signal_options o = sp_signal_options_default();
        FREED(sp_signal) signal = sp_signal_none();
        o.method = SP_SIGNAL_DENSE;
        o.until = 8 * plane[k] + 40;
        o.points = (int32_t)(10 * o.until) + 1;
        o.detectors = 1;
        o.to = &at;
        assert_ok(sp_signal_make(&net, &o, &signal, &err));
        sp_front_options rule = sp_front_options_default();
        sp_front alone;
        assert_ok(sp_front_find(signal.n, signal.t, signal.f, &rule, &alone, &err));
        /* the grids differ: marks to 2e-4, as on the default grid against a finer one */
        assert_relative(s.plane_front[k].t10, alone.t10, 2e-4);
        assert_relative(s.plane_front[k].t_peak, alone.t_peak, 2e-4);
        assert_relative(s.plane_front[k].t_zero, alone.t_zero, 2e-4);
        assert_relative(s.plane_front[k].amplitude, alone.amplitude, 2e-4);
        assert_true(k == 0 || s.plane_front[k].t10 > s.plane_front[k - 1].t10);
    }
}

TEST(other_planes_are_made_anew) {
    FREED(sp_scene) scene = parse(NULL), other = parse("signal.planes=3,5"),
                    outside = parse("signal.planes=0.5,3,7.5,12");
    sp_sample s = {0};
    assert_ok(sp_sample_make(&scene, SP_WANT_PLANES, &packing, &s, NULL, &err));
    assert_int_equal(sp_sample_parts(&scene, &s), SP_WANT_PLANES);
    assert_int_equal(sp_sample_parts(&outside, &s), SP_WANT_PLANES); /* they differ in what is not inside */
    assert_int_equal(sp_sample_parts(&other, &s), 0);
    const sp_front low = s.plane_front[0];
    s.plane_front[1].t10 = 777; /* kept when nothing is to be made */
    assert_ok(sp_sample_make(&scene, SP_WANT_PLANES, &packing, &s, NULL, &err));
    assert_true(s.plane_front[1].t10 == 777);
    assert_ok(sp_sample_make(&other, SP_WANT_PLANES, &packing, &s, NULL, &err));
    assert_int_equal(s.planes, 2);
    assert_true(s.plane[1] == 5 && s.plane_front[1].t10 != 777);
    assert_relative(s.plane_front[0].t10, low.t10, 1e-9); /* in whatever company */
}

TEST(planes_without_fronts) {
    sp_scene scene = parse("signal.planes=500,600");
    sp_sample s = {0};
    assert_ok(sp_sample_make(&scene, SP_WANT_PLANES, &packing, &s, NULL, &err)); /* none inside: nothing to find */
    assert_true(s.planes == 0 && s.have == SP_WANT_PLANES && !s.failed);
    sp_scene_free(&scene);
    scene = parse(NULL);
    scene.network.threshold = 50; /* no network */
    s = (sp_sample){0};
    assert_fails(sp_sample_make(&scene, SP_WANT_PLANES, &packing, &s, NULL, &err), SP_EREFUSED, "no");
    assert_true(s.failed && s.have == 0 && s.planes == 0);
    sp_scene_free(&scene);
}

/* ---- the signal -------------------------------------------------------------------------------------------------- */

TEST(another_signal_is_made_anew) {
    FREED(sp_scene) scene = parse(NULL);
    sp_sample s = {0};
    FREED(sp_sample_arrays) arrays = sp_sample_arrays_none();
    assert_ok(sp_sample_make(&scene, SP_WANT_SIGNAL, &packing, &s, &arrays, &err));
    assert_true(s.signal.points == 51 && s.signal.until == 30 && s.signal.tolerance == 1e-10);
    static const struct {
        const char *set;
        bool fits;
    } other[] = {{"signal.points=52", false},    {"signal.until=31", false},        {"signal.tolerance=1e-9", false},
                 {"signal.method=dense", false}, {"signal.method=dynamics", false}, {"signal.method=chebyshev", true},
                 {"study.samples=3", true},      {"signal.until=30.0", true}};
    for (size_t k = 0; k < sizeof other / sizeof *other; k++) {
        FREED(sp_scene) changed = parse(other[k].set);
        if ((sp_sample_parts(&changed, &s) == SP_WANT_SIGNAL) != other[k].fits)
            fail_msg("%s", other[k].set);
    }
    s.signal.tolerance = NAN; /* of a file that does not say */
    assert_int_equal(sp_sample_parts(&scene, &s), SP_WANT_SIGNAL);
    FREED(sp_scene) longer = parse("signal.points=77");
    assert_ok(sp_sample_make(&longer, SP_WANT_SIGNAL, &packing, &s, &arrays, &err));
    assert_true(arrays.signal.n == 77 && s.signal.points == 77);
    /* until = 0: the window of the packing's own height */
    FREED(sp_scene) whole = parse("signal.until=0");
    assert_ok(sp_sample_make(&whole, SP_WANT_SIGNAL, &packing, &s, &arrays, &err));
    assert_relative(s.signal.until, 8 * sp_packing_height(&packing) + 40, 1e-12);
    assert_int_equal(sp_sample_parts(&whole, &s), SP_WANT_SIGNAL);
}

/* ---- the spectrum ------------------------------------------------------------------------------------------------ */

/* The frequencies are those of the dense solver, but for the rattlers' zero modes; nothing else is made. */
TEST(every_frequency) {
    FREED(sp_scene) scene = parse(NULL);
    sp_sample s = {0};
    sp_sample_arrays arrays = sp_sample_arrays_none();
    FREED(sp_network) net = sp_network_none();
    sp_modes modes = sp_modes_none();
    const sp_modes_options options = {.vectors = false};
    assert_ok(sp_sample_make(&scene, SP_WANT_SPECTRUM, &packing, &s, &arrays, &err));
    assert_int_equal(s.have, SP_WANT_SPECTRUM);
    assert_int_equal(arrays.signal.n, 0);
    assert_ok(sp_network_make(&packing, &scene.network, &net, &err));
    assert_ok(sp_modes_dense(&net, &options, &modes, &err));
    assert_true(net.rattlers > 0 && modes.n_rattler > 0);
    assert_true(s.spectrum.carrying == net.n && s.spectrum.dof == 3 && s.spectrum.zero_modes == 0);
    assert_int_equal(arrays.modes, 3 * net.n);
    assert_int_equal(arrays.modes, modes.n - modes.n_rattler);
    for (int64_t k = 0; k < arrays.modes; k++)
        assert_true(arrays.omega[k] == modes.omega[modes.n_rattler + k] && arrays.omega[k] > 0);
    assert_true(s.spectrum.omega_max == arrays.omega[arrays.modes - 1]);
    sp_modes_free(&modes);
    /* they are there whatever the scene says of signals and planes, and are not made a second time */
    FREED(sp_scene) other = parse("signal.until=31");
    assert_int_equal(sp_sample_parts(&other, &s), SP_WANT_SPECTRUM);
    sp_sample_arrays_free(&arrays);
    assert_ok(sp_sample_make(&other, SP_WANT_SPECTRUM | SP_WANT_STATICS, &packing, &s, &arrays, &err));
    assert_int_equal(s.have, SP_WANT_SPECTRUM | SP_WANT_STATICS);
    assert_true(arrays.modes == 0 && !arrays.omega && s.spectrum.carrying > 0);
    /* nowhere to put them */
    s = (sp_sample){0};
    assert_ok(sp_sample_make(&scene, SP_WANT_SPECTRUM | SP_WANT_STATICS, &packing, &s, NULL, &err));
    assert_int_equal(s.have, SP_WANT_STATICS);
}

TEST(no_frequency) {
    FREED(sp_scene) scene = parse(NULL);
    scene.network.threshold = 50; /* no network */
    scene.want = SP_WANT_SPECTRUM | SP_WANT_STATICS;
    sp_sample s = {0};
    sp_sample_arrays arrays = sp_sample_arrays_none();
    assert_fails(sp_sample_make(&scene, scene.want, &packing, &s, &arrays, &err), SP_EREFUSED, "no");
    assert_true(s.failed && s.have == SP_WANT_STATICS && arrays.modes == 0 && !arrays.omega);
    /* it is known that they cannot be made */
    s.failed = false;
    assert_int_equal(sp_sample_stored(&scene, &s), SP_STORED_NOT);
    s.lacks = SP_WANT_SPECTRUM;
    assert_int_equal(sp_sample_stored(&scene, &s), SP_STORED_FAILED);
    s.have |= SP_WANT_SPECTRUM;
    assert_int_equal(sp_sample_stored(&scene, &s), SP_STORED_ALL);
}

/* ---- probes ------------------------------------------------------------------------------------------------------ */

TEST(probes_beside_moduli) {
    FREED(sp_scene) scene = parse(NULL);
    sp_sample both = {0}, one = {0};
    assert_ok(sp_sample_make(&scene, SP_WANT_PROBES | SP_WANT_MODULI, &packing, &both, NULL, &err));
    assert_int_equal(both.have, SP_WANT_PROBES | SP_WANT_MODULI | SP_WANT_STATICS);
    assert_ok(sp_sample_make(&scene, SP_WANT_MODULI, &packing, &one, NULL, &err));
    assert_int_equal(one.have, SP_WANT_MODULI | SP_WANT_STATICS);
    assert_relative(both.moduli.c22, one.moduli.c22, 1e-9); /* both are exact to their residuals */
    assert_relative(both.moduli.c_t, one.moduli.c_t, 1e-9);
    assert_ok(sp_sample_make(&scene, SP_WANT_PROBES, &packing, &one, NULL, &err));
    assert_int_equal(one.have, both.have);
    FREED(sp_network) net = sp_network_none();
    assert_ok(sp_network_make(&packing, &scene.network, &net, &err));
    const sp_probe probe[SP_PROBES] = {
        {SP_PROBE_SINE, 1}, {SP_PROBE_SINE, 2}, {SP_PROBE_LINES, 1}, {SP_PROBE_LINES, 3}};
    sp_probe_moduli alone[SP_PROBES];
    assert_ok(sp_moduli_probe(&net, both.statics.phi3s, SP_PROBES, probe, NULL, alone, &err));
    for (int k = 0; k < SP_PROBES; k++) {
        assert_relative(both.probe[k].along, alone[k].along, 1e-9);
        assert_relative(both.probe[k].shear, alone[k].shear, 1e-9);
        assert_relative(one.probe[k].along, alone[k].along, 1e-9);
        assert_true(alone[k].along > 0 && alone[k].shear > 0);
    }
}

TEST(wants_and_parts) {
    assert_int_equal(sp_want_parts(SP_WANT_SCALING), SP_WANT_CTOF);
    assert_int_equal(sp_want_parts(SP_WANT_SCALING | SP_WANT_PLANES), SP_WANT_CTOF | SP_WANT_PLANES);
    assert_int_equal(sp_want_parts(SP_WANT_MODULI), SP_WANT_MODULI);
    assert_int_equal(sp_want_parts(SP_WANT_SPECTRUM | SP_WANT_SCALING), SP_WANT_SPECTRUM | SP_WANT_CTOF);
    FREED(sp_scene) scene = parse(NULL);
    sp_sample s = {0};
    assert_ok(sp_sample_make(&scene, SP_WANT_SCALING, &packing, &s, NULL, &err));
    assert_int_equal(s.have, SP_WANT_CTOF);
}

TEST(lack_of_memory) {
    FREED(sp_scene) scene = parse(NULL);
    sp_status status = SP_ENOMEM;
    for (int64_t k = 0; status != SP_OK; k += 1 + k / 8) {
        sp_sample s = {0};
        FREED(sp_sample_arrays) arrays = sp_sample_arrays_none();
        sp_error err = {0};
        sp_alloc_fail_after(k);
        status =
            sp_sample_make(&scene, SP_WANT_PLANES | SP_WANT_PROBES | SP_WANT_SPECTRUM, &packing, &s, &arrays, &err);
        sp_alloc_fail_after(-1);
        assert_true(status == SP_OK || (status == SP_ENOMEM && !s.failed));
        assert_true(k < 20000);
    }
}

RUN_TESTS(make, release)
