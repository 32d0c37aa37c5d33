#include "base/base.h"
#include "reference.h"

#include <sonopack/figure/plot.h>
#include <sonopack/modes.h>
#include <unistd.h>

#if defined(__SANITIZE_ADDRESS__)
/* fontconfig, behind cairo, keeps offsets in place of pointers: the leak checker cannot see that its memory is held. */
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) { return "leak:libfontconfig"; }
#endif

static const char figure[] = "test_plot_spectrum.svg";

static bool drawn(const char *text) {
    static char content[1 << 21];
    FILE *file = fopen(figure, "rb");
    assert_non_null(file);
    content[fread(content, 1, sizeof content - 1, file)] = '\0';
    fclose(file);
    remove(figure);
    return strstr(content, text) != NULL;
}

static sp_table table_of(const char *kind, const char *const *columns, int count) {
    sp_table t = sp_table_none();
    assert_ok(sp_table_add_comment(&t, &err, "spectrum = %s", kind));
    for (int k = 0; k < count; k++)
        assert_ok(sp_table_add_column(&t, columns[k], "", SP_COLUMN_NUMBER, &err));
    return t;
}

static sp_table dos_table(double scale) {
    static const char *const columns[] = {"omega", "low", "high", "density", "smooth", "smooth_err"};
    sp_table t = table_of("dos", columns, 6);
    for (int k = 0; k < 40; k++) {
        const double w = (k + 0.5) / 40, g = scale * w * w * (1 - w);
        assert_ok(sp_table_add_row(&t, &err, w, w - 0.0125, w + 0.0125, g * (k % 2 ? 1.2 : 0.8), g, 0.1 * g));
    }
    return t;
}

static void test_kinds(void **state) {
    (void)state;
    static const char *const columns[] = {"omega", "magnitude", "participation", "sd"};
    const char *const kinds[] = {"transmission", "harmonic", "participation"};
    sp_table one = dos_table(3), two = dos_table(5);
    const sp_plot_table pair[] = {{"first", &one, false}, {"second", &two, false}};
    assert_ok(sp_plot_spectrum(1, pair, figure, &err));
    assert_true(drawn("Density of states"));
    assert_ok(sp_plot_spectrum(2, pair, figure, &err));
    assert_true(drawn("second"));
    for (int k = 0; k < 3; k++) {
        sp_table t = table_of(kinds[k], columns, 4);
        const sp_plot_table shown[] = {{"", &t, false}, {"first", &one, false}};
        for (int l = 1; l < 20; l++)
            assert_ok(sp_table_add_row(&t, &err, 0.1 * l, pow(10, -l), 0.5 / l, l == 3 ? NAN : 0.1 / l));
        assert_ok(sp_plot_spectrum(1, shown, figure, &err));
        assert_true(drawn("<svg"));
        assert_fails(sp_plot_spectrum(2, shown, figure, &err), SP_EINVAL, "dos");
        sp_table_free(&t);
    }
    sp_table_free(&one);
    sp_table_free(&two);
}

/* Means over samples: steps with a band, one or several; known by its columns where the comments are lost. */
static void test_ensembles(void **state) {
    (void)state;
    static const char *const columns[] = {"omega", "low", "high", "density", "density_low", "density_high"};
    sp_table one = table_of("ensemble", columns, 6), bare = sp_table_none(), two = dos_table(3);
    for (int k = 0; k < 6; k++)
        assert_ok(sp_table_add_column(&bare, columns[k], "", SP_COLUMN_NUMBER, &err));
    for (int k = 0; k < 20; k++) {
        const double w = k + 0.5, g = w * (20 - w), off = k == 7 ? NAN : k < 3 ? 2 * g : 0.1 * g;
        assert_ok(sp_table_add_row(&one, &err, w, w - 0.5, w + 0.5, g, g - off, g + off));
        assert_ok(sp_table_add_row(&bare, &err, w, w - 0.5, w + 0.5, g, NAN, NAN));
    }
    const sp_plot_table shown[] = {{"first", &one, false}, {"second", &bare, false}, {"third", &two, false}};
    assert_ok(sp_plot_spectrum(1, shown, figure, &err));
    assert_true(drawn("Density of states"));
    assert_ok(sp_plot_spectrum(2, shown, figure, &err));
    assert_true(drawn("second"));
    assert_fails(sp_plot_spectrum(2, shown + 1, figure, &err), SP_EINVAL, "dos");
    sp_table_free(&one);
    one = table_of("ensemble", columns, 5);
    assert_fails(sp_plot_spectrum(1, shown, figure, &err), SP_EINVAL, "density_high");
    sp_table_free(&one);
    sp_table_free(&bare);
    sp_table_free(&two);
}

static void test_refusals(void **state) {
    (void)state;
    static const char *const columns[] = {"omega", "smooth"};
    sp_table t = table_of("dos", columns, 2), none = sp_table_none();
    const sp_plot_table empty = {NULL, &t, false}, other = {NULL, &none, false};
    assert_fails(sp_plot_spectrum(1, &empty, figure, &err), SP_EREFUSED, "");
    assert_fails(sp_plot_spectrum(1, &other, figure, &err), SP_EINVAL, "");
    assert_fails(sp_plot_spectrum(0, &empty, figure, &err), SP_EINVAL, "1 32");
    assert_fails(sp_plot_spectrum(1, &empty, "test.bmp", &err), SP_EINVAL, "test.bmp");
    assert_fails(sp_plot_dispersion(1, &empty, figure, &err), SP_EINVAL, "polarization");
    sp_table_free(&t);
    assert_true(access(figure, F_OK) != 0);
}

static void test_dispersion(void **state) {
    (void)state;
    sp_table t = sp_table_none();
    const sp_plot_table shown[] = {{"a", &t, false}, {"b", &t, false}, {"c", &t, false}};
    assert_ok(sp_table_add_column(&t, "polarization", "", SP_COLUMN_TEXT, &err));
    assert_ok(sp_table_add_column(&t, "k", "1/d", SP_COLUMN_NUMBER, &err));
    assert_ok(sp_table_add_column(&t, "peak", "", SP_COLUMN_NUMBER, &err));
    assert_ok(sp_table_add_column(&t, "half_width", "", SP_COLUMN_NUMBER, &err));
    for (int k = 1; k < 9; k++) {
        assert_ok(sp_table_add_row(&t, &err, "longitudinal", 0.2 * k, sin(0.1 * k), 0.05));
        assert_ok(sp_table_add_row(&t, &err, "rotational", 0.2 * k, 1.2, k == 2 ? NAN : 0.1));
    }
    assert_ok(sp_plot_dispersion(1, shown, figure, &err));
    assert_true(drawn("rotational"));
    assert_ok(sp_plot_dispersion(2, shown, figure, &err));
    assert_false(drawn("transverse"));
    assert_fails(sp_plot_dispersion(3, shown, figure, &err), SP_EINVAL, "3");
    sp_table_free(&t);
}

static void test_mode(void **state) {
    (void)state;
    sp_packing all[] = {chain_packing(5, 1e-4), scattered_packing(2, 5, 0.5, 1), scattered_packing(2, 5, 0, 1),
                        scattered_packing(3, 2, 0.5, 1)};
    for (int q = 0; q < 4; q++) {
        const sp_network_options no = sp_network_options_default();
        sp_network net = sp_network_none();
        assert_ok(sp_network_make(&all[q], &no, &net, &err));
        double *u = calloc((size_t)sp_network_dofs(&net), sizeof *u);
        for (int64_t k = 0; k < sp_network_dofs(&net); k++)
            u[k] = sin(3.0 * (double)k);
        assert_ok(sp_plot_mode(&all[q], &net, u, 7, 0.25, figure, &err));
        assert_true(drawn("= 0.25"));
        assert_ok(sp_plot_mode(&all[q], &net, u, 7, 0.25, figure, &err));
        assert_true(drawn("\nclockwise\n") == (net.dof > net.dim));
        assert_ok(sp_plot_mode(&all[q], &net, u, 7, 0.25, figure, &err));
        assert_true(drawn("\ngrains at half their size, far ones pale\n") == (net.dim == 3));
        assert_ok(sp_plot_snapshot(&all[q], &net, u, 20, figure, &err));
        assert_true(drawn("\ngrains at half their size, far ones pale\n") == (net.dim == 3));
        memset(u, 0, (size_t)sp_network_dofs(&net) * sizeof *u); /* nothing moves: no arrows, and no trouble */
        assert_ok(sp_plot_mode(&all[q], &net, u, 7, 0.25, figure, &err));
        assert_false(drawn("clockwise"));
        u[0] = NAN;
        assert_fails(sp_plot_mode(&all[q], &net, u, 7, 0.25, figure, &err), SP_EREFUSED, "0");
        assert_fails(sp_plot_snapshot(&all[q], &net, u, 7, figure, &err), SP_EREFUSED, "0");
        free(u);
        sp_network_free(&net);
        sp_packing_free(&all[q]);
    }
}

static void test_no_memory(void **state) {
    (void)state;
    sp_table t = dos_table(1);
    const sp_plot_table shown = {"dos", &t, false};
    sp_status status = SP_ENOMEM;
    for (int64_t count = 0; status != SP_OK && count < 100; count++) {
        sp_error err = {0};
        sp_alloc_fail_after(count);
        status = sp_plot_spectrum(1, &shown, figure, &err);
        sp_alloc_fail_after(-1);
        assert_true(status == SP_OK || err.text[0]);
    }
    assert_int_equal(status, SP_OK);
    remove(figure);
    sp_table_free(&t);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_kinds),      cmocka_unit_test(test_ensembles), cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_dispersion), cmocka_unit_test(test_mode),      cmocka_unit_test(test_no_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
