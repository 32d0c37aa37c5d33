/* Displacements of all grains after the pulse. */
#include "base/base.h"
#include "signals.h"

#include <sonopack/modes.h>

static double largest_of(int64_t n, const double *u) {
    double largest = 0;
    for (int64_t k = 0; k < n; k++)
        largest = fmax(largest, fabs(u[k]));
    return largest;
}

/* u(t) = sum_n e_n (e_n . a) sin(w_n t)/w_n over all modes of the dense solver; zero modes drift: (e . a) t. */
static void by_modes(const sp_network *net, sp_source source, const sp_place *from, double t, double *u) {
    const int64_t n = sp_network_dofs(net);
    const sp_modes_options o = sp_modes_options_default();
    const sp_modes_range all = sp_modes_range_all();
    const sp_place wall = sp_place_wall();
    FREED(sp_modes) m = sp_modes_none();
    RELEASED double *a = calloc((size_t)n, sizeof *a);
    assert_non_null(a);
    assert_ok(sp_network_source_at(net, source, from ? from : &wall, a, &err));
    assert_ok(sp_modes_make(net, &o, &all, &m, &err));
    for (int64_t k = 0; k < n; k++)
        u[k] = 0;
    const bool moves = source != SP_SOURCE_DISPLACEMENT;
    for (int64_t q = m.n_rattler; q < m.n; q++) {
        const double *e = m.vectors + (q - m.n_rattler) * n, w = m.omega[q];
        double part = 0;
        for (int64_t k = 0; k < n; k++)
            part += e[k] * a[k] * (moves ? 1 / sqrt(net->mass[k]) : sqrt(net->mass[k]));
        part *= moves ? (w > 0 ? sin(w * t) / w : t) : cos(w * t);
        for (int64_t k = 0; k < n; k++)
            u[k] += part * e[k] / sqrt(net->mass[k]);
    }
}

static void compare(const sp_packing *p, const sp_place *from) {
    static const double t[] = {40, 0, 7.5, 160};
    static const sp_source sources[] = {SP_SOURCE_IMPULSE, SP_SOURCE_VELOCITY, SP_SOURCE_DISPLACEMENT};
    FREED(sp_network) net = network_of(p, false);
    const int64_t n = sp_network_dofs(&net);
    double *u = calloc(4 * (size_t)n, sizeof *u), *v = calloc((size_t)n, sizeof *v), errors[4];
    assert_true(u && v);
    for (int s = 0; s < 3; s++) {
        const sp_field_options spec = {.source = sources[s], .from = from, .times = 4, .t = t};
        assert_ok(sp_signal_field(&net, &spec, u, errors, &err));
        for (int l = 0; l < 4; l++) {
            by_modes(&net, sources[s], from, t[l], v);
            double off = 0;
            for (int64_t k = 0; k < n; k++)
                off = fmax(off, fabs(u[l * n + k] - v[k]));
            const double largest = fmax(largest_of(n, v), largest_of(n, u + l * n));
            /* what the dense solver leaves: 1e-11 of the largest; the bound is far below 1e-10 of it */
            assert_true(off <= 1e-10 * largest);
            if (t[l] > 0 || sources[s] == SP_SOURCE_DISPLACEMENT)
                assert_true(errors[l] > 0 && errors[l] < 1e-10 * largest);
            else
                assert_close(largest, 0, 0);
        }
    }
    free(u);
    free(v);
}

TEST(test_modes_agree) {
    FREED(sp_packing) p = reference_packing(SOURCE_DIR "/packings/reference/packing_N200_p1e-4.txt");
    compare(&p, NULL);
    const sp_place part = {.kind = SP_PLACE_PART, .shear = true, .from = 2, .to = 12};
    compare(&p, &part);
    sp_packing_free(&p);
    p = chain_packing(40, 1e-4);
    compare(&p, NULL);
    sp_packing_free(&p);
    p = scattered_packing(3, 3, 0.5, 7);
    compare(&p, NULL);
}

TEST(test_refusals) {
    FREED(sp_packing) p = chain_packing(10, 1e-4);
    FREED(sp_network) net = network_of(&p, false);
    double u[10];
    static const double bad[] = {-1, NAN, INFINITY}, late = 1e12, good = 3;
    for (int k = 0; k < 3; k++) {
        const sp_field_options spec = {.times = 1, .t = &bad[k]};
        assert_fails(sp_signal_field(&net, &spec, u, NULL, &err), SP_EINVAL, "1");
    }
    sp_field_options spec = {.times = 0, .t = &good};
    assert_fails(sp_signal_field(&net, &spec, u, NULL, &err), SP_EINVAL, "0");
    spec = (sp_field_options){.times = 1, .t = &late};
    assert_fails(sp_signal_field(&net, &spec, u, NULL, &err), SP_EREFUSED, "1e+12 20000000");
    const sp_place nowhere = {.kind = SP_PLACE_PLANE, .height = -3};
    spec = (sp_field_options){.times = 1, .t = &good, .from = &nowhere};
    assert_int_not_equal(sp_signal_field(&net, &spec, u, NULL, NULL), SP_OK);
    spec.from = NULL;
    EACH_ALLOCATION_FAILS(8, sp_signal_field(&net, &spec, u, NULL, &err), );
}

RUN_TESTS(NULL, NULL)
