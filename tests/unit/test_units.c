/* Units: texts, factors, quantities, and tables in SI. */
#include "test.h"

#include "base/base.h"

#include <sonopack/units.h>

/* All values differ, so that no wrong power hides. */
static const sp_material glass = {70e9, 0.22, 2500, 1e-3}, odd = {3e9, 0.4, 1230, 0.037};

static double modulus(const sp_material *m) { return m->young / (1 - m->poisson * m->poisson); }

/* ---- factors ---------------------------------------------------------------------------------------------------- */

/* Powers of m, kg and s, with which a unit is a number of SI base units. */
TEST(every_unit_of_tables_and_files) {
    for (int k = 0; k < 2; k++) {
        const sp_material *m = k == 0 ? &glass : &odd;
        const double e = modulus(m), rho = m->density, d = m->diameter, c = sqrt(e / rho), mass = rho * d * d * d;
        const struct {
            const char *unit, *si;
            double factor;
        } units[] = {{"d", "mm", d * 1e3},
                     {"1/d", "1/mm", 1e-3 / d},
                     {"E*", "kPa", e / 1e3},
                     {"E* d^2", "N", e * d * d},
                     {"E* d", "N/m", e * d},
                     {"sqrt(E* / rho)", "m/s", c},
                     {"d/sqrt(E* / rho)", "us", d / c * 1e6},
                     {"d / sqrt(E* / rho)", "us", d / c * 1e6},
                     {"sqrt(E* / rho)/d", "rad/s", c / d},
                     {"sqrt(E* / rho) / d", "rad/s", c / d},
                     {"E* / (rho d)", "m/s^2", e / rho / d},
                     {"E* / (rho d^2)", "rad^2/s^2", e / rho / (d * d)},
                     {"modes d/sqrt(E* / rho)", "modes us", d / c * 1e6},
                     {"E* d^3/sqrt(E* / rho)", "N us", e * d * d * (d / c) * 1e6},
                     {"E* d^2/sqrt(E* / rho)", "N s/m", e * d * d / c},
                     {"d sqrt(E* / rho)", "m^2/s", d * c},
                     {"rho d^3", "mg", mass * 1e6},
                     {"rho d^5", "mg mm^2", mass * d * d * 1e12},
                     {"rho d", "mg/mm^2", rho * d},
                     {"1/sqrt(rho d^3)", "1/sqrt(mg)", 1e-3 / sqrt(mass)},
                     {"1/sqrt(rho d^5)", "1/(sqrt(mg) mm)", 1e-6 / sqrt(mass) / d},
                     {"d sqrt(rho d^3)", "mm sqrt(mg)", d * sqrt(mass) * 1e6},
                     {"E* d/sqrt(rho d^3)", "N/(m sqrt(mg))", e * d / sqrt(mass) * 1e-3}};
        for (size_t i = 0; i < sizeof units / sizeof *units; i++) {
            char si[SP_UNIT_TEXT];
            double factor;
            assert_true(sp_unit_is_ours(units[i].unit));
            assert_ok(sp_unit_to_si(units[i].unit, m, &factor, si, &err));
            assert_string_equal(si, units[i].si);
            assert_close(factor / units[i].factor, 1, 1e-15);
            assert_false(sp_unit_is_ours(si));
        }
    }
}

TEST(what_is_no_unit_of_ours) {
    static const char *const others[] = {"",        "%",     "s",      "mm",      "rad", "modes/grain",
                                         "l/c",     "K l",   "1/tap",  "cm",      "1",   "p d^2",
                                         "max |F|", "E* d^", "E* d^0", "sqrt(E*", "E*)", "d d^99"};
    char si[SP_UNIT_TEXT];
    double factor;
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
        assert_false(sp_unit_is_ours(others[i]));
        assert_int_equal(sp_unit_to_si(others[i], &glass, &factor, si, NULL), SP_EINVAL);
    }
    assert_int_equal(sp_unit_to_si("d", &(sp_material){0}, &factor, si, NULL), SP_EINVAL);
    assert_true(sp_unit_is_ours("E* d^8")); /* of no dimension that a table has */
    assert_int_equal(sp_unit_to_si("E* d^8", &glass, &factor, si, NULL), SP_EINVAL);
}

/* ---- quantities ------------------------------------------------------------------------------------------------- */

static double read(const char *text, const char *unit, const sp_material *m) {
    double value = NAN;
    assert_ok(sp_quantity_read(text, unit, m, &value, &err));
    return value;
}

TEST(quantities) {
    const double e = modulus(&glass), time = 1e-3 / sqrt(e / 2500);
    static const char *const same[] = {"100 kPa",  "100kPa",    "0.1 MPa",     "1e5 Pa",         "1 bar",
                                       "1e-4 GPa", "1e5 N/m^2", "100 mN/mm^2", "1e5 kg/(m s^2)", "1E5 Pa"};
    for (size_t i = 0; i < sizeof same / sizeof *same; i++)
        assert_close(read(same[i], "E*", &glass) / (1e5 / e), 1, 5e-16);
    assert_true(read("20 mm", "d", &glass) == 20);
    assert_true(read("3 cm", "d", &glass) == 30);
    assert_close(read("50 us", "d/sqrt(E* / rho)", &glass) / (50e-6 / time), 1, 5e-16);
    assert_close(read("1e5 rad/s", "sqrt(E* / rho)/d", &glass) / (1e5 * time), 1, 5e-16);
    assert_close(read("1e5 1/s", "sqrt(E* / rho)/d", &glass) / (1e5 * time), 1, 5e-16);
    /* our own units need no material, nor do those of SI among each other */
    assert_true(read("1e-4 E*", "E*", NULL) == 1e-4);
    assert_true(read("24 d", "d", &(sp_material){0}) == 24);
    assert_true(read("70 GPa", "Pa", NULL) == 70e9);
    assert_true(read("2.5 g/cm^3", "kg/m^3", NULL) == 2500);
    assert_true(read("1 mm", "m", NULL) == 1e-3);
}

TEST(refused_quantities) {
    static const char *const wrong[] = {"",          "kPa",      "100",     "100 kpa", "100 m",
                                        "100 kPa m", "1e999 Pa", "nan Pa",  "inf Pa",  "100 Pa^",
                                        "100 Pa^0",  "100 Pa/",  "100 (Pa", "100 Pa)", "100 Hz",
                                        "1,5 Pa",    "100 EPa",  "0x1 Pa",  "100\tPa", "100 sqrt(sqrt(Pa^2))^3x"};
    double value = 7;
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_int_equal(sp_quantity_read(wrong[i], "E*", &glass, &value, NULL), SP_EINVAL);
    assert_true(value == 7);
    assert_int_equal(sp_quantity_read("100 kPa", "E*", NULL, &value, NULL), SP_EINVAL);
    assert_int_equal(sp_quantity_read("100 kPa", "p d^2", &glass, &value, NULL), SP_EINVAL);
    assert_int_equal(sp_quantity_read("1 mm", "", &glass, &value, NULL), SP_EINVAL);
    char deep[200] = "1 ";
    memset(deep + 2, '(', 150);
    assert_int_equal(sp_quantity_read(deep, "E*", &glass, &value, NULL), SP_EINVAL);
}

/* ---- tables ----------------------------------------------------------------------------------------------------- */

static sp_table example(void) {
    sp_table t = sp_table_none();
    assert_ok(sp_table_add_column(&t, "n", "", SP_COLUMN_INTEGER, &err));
    assert_ok(sp_table_add_column(&t, "t", "d/sqrt(E* / rho)", SP_COLUMN_NUMBER, &err));
    assert_ok(sp_table_add_column(&t, "F", "E* d^2", SP_COLUMN_NUMBER, &err));
    assert_ok(sp_table_add_column(&t, "seconds", "s", SP_COLUMN_NUMBER, &err));
    static const char *const comments[] = {"height = 24.5",
                                           "pressure = 1e-4, grains = 30, width = 8, friction = 0.5",
                                           "complete = 0.25:inf",
                                           "error = 1e-9",
                                           "F = from part:1:2.5:normal to plane:3:shear, error 1e-9",
                                           "F = from disc:1:2:3:normal to part:1:2:shear, error 1e-9",
                                           "packing.history = [0.001, 1e-05]",
                                           "p = 0.0001: grains 20 and 40, heights 8 and nan",
                                           "a remark with 3 d",
                                           "height = high"};
    for (size_t i = 0; i < sizeof comments / sizeof *comments; i++)
        assert_ok(sp_table_add_comment(&t, &err, "%s", comments[i]));
    assert_ok(sp_table_add_row(&t, &err, (int64_t)1, 2.0, 1e-9, 3.0));
    assert_ok(sp_table_add_row(&t, &err, (int64_t)2, NAN, -INFINITY, 4.0));
    return t;
}

TEST(a_table) {
    /* E* = 1 GPa, c = 1000 m/s, d = 500 mm: a time is 500 us, a force 2.5e8 N, a frequency 2000 rad/s */
    const sp_material plain = {1e9, 0, 1000, 0.5};
    FREED(sp_table) t = example();
    assert_ok(sp_table_to_si(&t, &plain, &err));
    static const char *const comments[] = {
        "height = 12250 mm",
        "pressure = 100 kPa, grains = 30, width = 4000 mm, friction = 0.5",
        "complete = 500 rad/s:inf rad/s",
        "error = 0.25 N",
        "F = from part:500mm:1250mm:normal to plane:1500mm:shear, error 0.25 N",
        "F = from disc:500mm:1000mm:1500mm:normal to part:500mm:1000mm:shear, error 0.25 N",
        "packing.history = [1000, 10] kPa",
        "p = 100 kPa: grains 20 and 40, heights 4000 mm and nan mm",
        "a remark with 3 d",
        "height = high",
        "material = E=1000000000,nu=0,rho=1000,d=0.5"};
    assert_int_equal(t.comments, sizeof comments / sizeof *comments);
    for (int i = 0; i < t.comments; i++)
        assert_string_equal(t.comment[i], comments[i]);
    double height;
    assert_true(sp_table_get_number(&t, "height", &height) && height == 12250);
    assert_string_equal(t.column[1].unit, "us");
    assert_string_equal(t.column[2].unit, "N");
    assert_string_equal(t.column[3].unit, "s");
    assert_close(sp_table_number(&t, 0, 1), 1000, 0);
    assert_close(sp_table_number(&t, 0, 2), 0.25, 0);
    assert_true(isnan(sp_table_number(&t, 1, 1)) && isinf(sp_table_number(&t, 1, 2)));
    assert_true(sp_table_number(&t, 0, 3) == 3);
    /* what is in SI stays as it is */
    char *before = sp_table_text(&t, SP_TSV);
    assert_ok(sp_table_to_si(&t, &plain, &err));
    char *after = sp_table_text(&t, SP_TSV);
    assert_string_equal(before, after);
    sp_free(before);
    sp_free(after);
}

TEST(a_table_that_cannot_be_converted) {
    sp_table t = example();
    char *before = sp_table_text(&t, SP_TSV);
    assert_int_equal(sp_table_to_si(&t, &(sp_material){0}, NULL), SP_EINVAL);
    char *after = sp_table_text(&t, SP_TSV);
    assert_string_equal(before, after);
    sp_free(before);
    sp_free(after);
    sp_table_free(&t);
    t = sp_table_none();
    assert_ok(sp_table_add_column(&t, "n", "d", SP_COLUMN_INTEGER, &err));
    assert_int_equal(sp_table_to_si(&t, &glass, NULL), SP_EINVAL);
    sp_table_free(&t);
}

TEST(without_memory) {
    sp_table t = example();
    EACH_ALLOCATION_FAILS(3, sp_table_to_si(&t, &glass, &err), sp_table_free(&t), t = example());
    sp_table_free(&t);
}

RUN_TESTS(NULL, NULL)
