/* What LAMMPS is given and what its log says: numbers of the input script against the contact law, the gas against the
 * spec, versions, and the end of a log that is still written. */
#include "test.h"

#include "base/base.h"
#include "foreign/engine.h"
#include "packing/contact.h"
#include "packing/prepare.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static char folder[] = "/tmp/sonopack-engine-XXXXXX";

static sp_pack_spec small_spec(int dim) {
    sp_pack_spec s = sp_pack_spec_default();
    s.dim = dim;
    s.grains = dim == 2 ? 40 : 60;
    s.width = dim == 2 ? 6 : 5;
    s.pressure = 1e-4;
    s.seed = 5;
    return s;
}

/* noinline: gcc 12 takes the text for a local variable's otherwise */
__attribute__((noinline)) static char *read_file(sp_engine_file file) {
    char path[SP_PATH_MAX], *text = NULL;
    size_t size;
    assert_int_equal(sp_engine_path(folder, file, path, NULL), SP_OK);
    assert_int_equal(sp_file_read_text(path, &text, &size, NULL), SP_OK);
    return text;
}

static void write_file(sp_engine_file file, const char *text) {
    char path[SP_PATH_MAX];
    assert_int_equal(sp_engine_path(folder, file, path, NULL), SP_OK);
    assert_int_equal(sp_file_write(path, text, strlen(text), NULL), SP_OK);
}

/* LAMMPS: F = kn sqrt(R n) n, c = alpha(e) sqrt(m kn sqrt(R n)), k_t = kt sqrt(R n). */
static double alpha_of(double e) {
    const double c[] = {1.2728, -4.2783, 11.087, -22.348, 27.467, -18.022, 4.8218};
    double sum = 0;
    for (int k = 0; k < 7; k++)
        sum += c[k] * pow(e, k);
    return sum;
}

static void test_law(void **state) {
    (void)state;
    const double r1 = 0.4, r2 = 0.6, n = 1e-3, m = 0.2, reduced = r1 * r2 / (r1 + r2), root = sqrt(reduced * n);
    sp_pack_spec s = small_spec(2);
    s.poisson = 0.3;
    const double zetas[] = {0.01, 0.3, 0.8, 2};
    for (int k = 0; k < 4; k++) {
        s.damping = zetas[k];
        const sp_engine_deck d = sp_engine_plan(&s, 20);
        const double e = contact_stiffness(r1, r2), kn = contact_normal_stiffness(e, n);
        assert_relative(d.kn * root * n, contact_force(e, n), 1e-14);
        assert_relative(d.kt * root, contact_eta(0.3) * kn, 1e-14);
        assert_relative(alpha_of(d.restitution) * sqrt(m * d.kn * root), 2 * zetas[k] * sqrt(m * kn), 1e-9);
        assert_true(d.free_viscosity);
        assert_relative(d.weak_damping * alpha_of(d.weak_restitution) * sqrt(m * d.weak_kn * root),
                        2 * zetas[k] * sqrt(m * contact_eta(0.3) * kn), 1e-9);
        assert_true(d.weak_kn < 1e-7 * d.kn && d.restitution >= 0);
        /* at a wall all springs are doubled */
        assert_relative(2 * d.kn * sqrt(r1 * n) * n, contact_force(contact_wall_stiffness(r1, SP_WALL_RIGID), n),
                        1e-14);
    }
    s.viscous_limit = 1;
    assert_false(sp_engine_plan(&s, 20).free_viscosity);
    s.friction = 0;
    assert_true(sp_engine_plan(&s, 20).kt == 0 && sp_engine_plan(&s, 20).tangential_damping == 0);
}

static void test_plan(void **state) {
    (void)state;
    sp_pack_spec s = small_spec(3);
    const sp_engine_deck d = sp_engine_plan(&s, 20);
    assert_relative(d.piston_mass, 12.5 * 25, 1e-14);
    assert_relative(d.calm, 1e-6, 1e-14);
    assert_relative(d.pressure, 1e-4, 0);
    s.pressure = 5e-3; /* the rest of it is put on in sonopack */
    assert_close(sp_engine_pressure(&s), 1e-3, 1e-14);
    s.pressure = 1e-4;
    s.time_step = 0.35;
    assert_relative(sp_engine_plan(&s, 20).step, d.step / 2, 1e-12);
    assert_true(sp_engine_plan(&s, 200).step < sp_engine_plan(&s, 20).step); /* a piston that falls further */
}

/* The gas is the one that sonopack begins with, digit by digit. */
static void test_gas(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        const sp_pack_spec given = small_spec(dim), s = sp_pack_spec_resolve(&given);
        double r[60], x[180] = {0}, height;
        sp_radii_draw(&s, r);
        assert_int_equal(sp_gas_make(&s, r, x, &height, NULL), SP_OK);
        assert_int_equal(sp_engine_write(&given, folder, NULL), SP_OK);
        char *text = read_file(SP_ENGINE_GAS);
        const char *at = strstr(text, "\n1 1 ");
        assert_non_null(at);
        at++;
        for (int i = 0; i < s.grains; i++, at = strchr(at, '\n') + 1) {
            double row[7];
            assert_int_equal(
                sscanf(at, "%lf %lf %lf %lf %lf %lf %lf", row, row + 1, row + 2, row + 3, row + 4, row + 5, row + 6),
                7);
            assert_true(row[0] == i + 1 && row[1] == 1 && row[2] == 2 * r[i] && row[3] == 1);
            assert_true(row[4] == x[3 * i] && row[5] == x[3 * i + 1] && row[6] == x[3 * i + 2]);
        }
        double id, type, diameter, density, place[3];
        assert_int_equal(
            sscanf(at, "%lf %lf %lf %lf %lf %lf %lf", &id, &type, &diameter, &density, place, place + 1, place + 2), 7);
        assert_true(id == s.grains + 1 && type == 2 && place[dim - 1] == height);
        assert_relative(density * grain_mass(0.5 * diameter), 12.5 * s.width * (dim == 3 ? s.depth : 1), 1e-12);
        sp_free(text);
    }
}

static void test_deck(void **state) {
    (void)state;
    const char *const always[] = {"newton      off", "lost error", "p13 p14 p15", "velocity    all set 0 0 0"};
    sp_pack_spec s = small_spec(3);
    assert_int_equal(sp_engine_write(&s, folder, NULL), SP_OK);
    char *text = read_file(SP_ENGINE_INPUT);
    for (int k = 0; k < 4; k++)
        assert_non_null(strstr(text, always[k]));
    assert_non_null(strstr(text, "boundary    p p f"));
    sp_free(text);
    s = small_spec(2);
    s.friction = 0;
    assert_int_equal(sp_engine_write(&s, folder, NULL), SP_OK);
    text = read_file(SP_ENGINE_INPUT);
    assert_null(strstr(text, "hybrid"));
    assert_null(strstr(text, "mindlin"));
    assert_non_null(strstr(text, "enforce2d"));
    sp_free(text);
    s.kind = SP_PACK_CHAIN;
    sp_error err = {0};
    assert_int_equal(sp_engine_write(&s, folder, &err), SP_EINVAL);
}

static void test_log(void **state) {
    (void)state;
    sp_engine_log log;
    write_file(SP_ENGINE_LOG,
               "LAMMPS (29 Sep 2021 - Update 2)\nStep v_largest v_top\n 1000 1e-3 12.5\n 2000 5e-4 11\n 30");
    write_file(SP_ENGINE_WORDS, "x\nERROR on proc 1: Lost atoms\nLast command: run\n");
    sp_engine_read_log(folder, &log);
    assert_string_equal(log.version, "29 Sep 2021 - Update 2");
    assert_string_equal(log.fault, "ERROR on proc 1: Lost atoms");
    assert_int_equal(log.steps, 2000);
    assert_close(log.height, 11, 0);
    write_file(SP_ENGINE_LOG, "");
    write_file(SP_ENGINE_WORDS, "");
    sp_engine_read_log(folder, &log);
    assert_true(log.steps == -1 && log.version[0] == '\0' && log.fault[0] == '\0' && isnan(log.height));
    assert_int_equal(sp_engine_date("29 Sep 2021 - Update 2"), 20210929);
    assert_int_equal(sp_engine_date("2 Aug 2023"), 20230802);
    assert_int_equal(sp_engine_date("nonsense"), 0);
    assert_int_equal(sp_engine_date("1 anF 2023"), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_law), cmocka_unit_test(test_plan),
                                       cmocka_unit_test(test_gas), cmocka_unit_test(test_deck),
                                       cmocka_unit_test(test_log)};
    if (!mkdtemp(folder))
        return 1;
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    for (int k = 0; k < SP_ENGINE_FILES; k++) {
        char path[SP_PATH_MAX];
        if (sp_engine_path(folder, (sp_engine_file)k, path, NULL) == SP_OK)
            unlink(path);
    }
    rmdir(folder);
    return failed;
}
