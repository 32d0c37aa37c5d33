/* Files of other programs: numbers as strtod reads them, cells and lines, keys, contacts against all pairs, and every
 * allocation that can fail. */
#include "test.h"

#include "base/base.h"
#include "foreign/forms.h"
#include "foreign/sheet.h"

#include <math.h>
#include <sonopack/study/import.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char folder[] = "/tmp/sonopack-import-XXXXXX";

static const char *in_folder(const char *name) {
    static char path[200];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static void write_text(const char *name, const char *text) {
    FILE *file = fopen(in_folder(name), "w");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

/* ---- numbers --------------------------------------------------------------------------------------------------- */

static double parse_one(const char *text, int *digits) {
    sp_number_sheet s = {.file = "x", .separator = ' ', .columns = 1, .name = {"a"}};
    assert_int_equal(sp_sheet_row(&s, text, strlen(text), 1, NULL), SP_OK);
    const double value = sp_sheet_value(&s, 0, 0);
    *digits = s.digits[0];
    sp_free(s.value);
    sp_free(s.line);
    sp_free(s.number);
    return value;
}

/* Every text of a number has the bits that strtod gives. */
static void test_numbers(void **state) {
    (void)state;
    static const char *const forms[] = {"%.17g", "%.16e", "%.6g", "%.3f", "%.15g", "%+.8E"};
    unsigned seed = 20260101;
    printf("seed %u\n", seed);
    for (int k = 0; k < 60000; k++) {
        char text[400];
        int digits;
        const double scale = pow(10, (double)(rand_r(&seed) % 80) - 40);
        const double value = (rand_r(&seed) / (double)RAND_MAX - 0.5) * scale;
        snprintf(text, sizeof text, forms[k % 6], value);
        const double expected = strtod(text, NULL), found = parse_one(text, &digits);
        if (memcmp(&expected, &found, sizeof found) != 0)
            fail_msg("'%s' read as %.17g", text, found);
    }
}

static void test_words(void **state) {
    (void)state;
    static const struct {
        const char *text;
        double value;
        int digits;
    } cases[] = {{"0.001230", 0.00123, 4}, {"-12.50", -12.5, 4},
                 {"1e5", 1e5, 1},          {"1.", 1, 1},
                 {".5", 0.5, 1},           {"0", 0, 0},
                 {"-0.0", -0.0, 0},        {"123456789012345678", 123456789012345678.0, 18},
                 {"1e-320", 1e-320, 1},    {"5E+2", 500, 1},
                 {"0.1e1", 1, 1}};
    static const char *const wrong[] = {"nan", "inf", "1e", "1e+", "0x10", "1.2.3", "--1", "1e999", "one", "1,5", "."};
    int digits;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        const double found = parse_one(cases[k].text, &digits);
        assert_memory_equal(&found, &cases[k].value, sizeof found);
        assert_int_equal(digits, cases[k].digits);
    }
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++)
        assert_true(isnan(parse_one(wrong[k], &digits)));
}

static void test_cells(void **state) {
    (void)state;
    const char *line = " 1.5 , two,\"three 3\" ,,5", *from = line;
    static const char *const cells[] = {"1.5", "two", "three 3", "", "5"};
    char word[SP_SHEET_NAME];
    for (int k = 0; k < 5; k++) {
        assert_true(sp_next_cell(&from, line + strlen(line), ',', word));
        assert_string_equal(word, cells[k]);
    }
    assert_false(sp_next_cell(&from, line + strlen(line), ',', word));
    char text[] = "a\r\n\n  \nb";
    sp_cursor at = {.next = text, .end = text + strlen(text)};
    size_t length;
    assert_ptr_equal(sp_cursor_words(&at, &length), text);
    assert_int_equal(length, 1);
    assert_ptr_equal(sp_cursor_words(&at, &length), text + strlen(text) - 1);
    assert_int_equal(at.number, 4);
    assert_null(sp_cursor_words(&at, &length));
}

/* ---- keys ------------------------------------------------------------------------------------------------------ */

static void test_keys(void **state) {
    (void)state;
    sp_import_options o = sp_import_options_default();
    static const char *const right[] = {"width=4",     "packing.friction=0.3", "up=x",      "sides=open",
                                        "across=drop", "dimension=3",          "bottom=-2", "wall=grain",
                                        "first_id=5",  "digits=exact"};
    static const char *const wrong[] = {"width=-1",     "width=nan",   "width",       "up=w",
                                        "sides=closed", "across=keep", "wall=wood",   "wide=4",
                                        "poisson=1",    "dimension=1", "first_id=-2", "friction="};
    for (size_t k = 0; k < sizeof right / sizeof *right; k++)
        assert_int_equal(sp_import_set(&o, right[k], NULL), SP_OK);
    assert_true(o.width == 4 && o.friction == 0.3 && o.up == 0 && o.open && o.cut && o.dim == 3 && o.bottom == -2);
    assert_true(o.wall == SP_WALL_GRAIN && o.first_id == 5 && o.exact);
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++)
        assert_int_equal(sp_import_set(&o, wrong[k], NULL), SP_EINVAL);
}

/* ---- contacts -------------------------------------------------------------------------------------------------- */

/* All pairs of a random packing that overlap are found, through the sides too, whatever the sizes. */
static void test_all_pairs(void **state) {
    (void)state;
    enum { N = 300 };
    static double x[N][3], r[N];
    unsigned seed = 7;
    printf("seed %u\n", seed);
    FILE *file = fopen(in_folder("gas.csv"), "w");
    fprintf(file, "id,x,y,z,radius\n");
    for (int i = 0; i < N; i++) {
        for (int a = 0; a < 3; a++)
            x[i][a] = (a == 2 ? 1 + 5 * (rand_r(&seed) / (RAND_MAX + 1.0)) : 5 * (rand_r(&seed) / (RAND_MAX + 1.0)));
        r[i] = i % 20 == 0 ? 1 : 0.1 + 0.4 * (rand_r(&seed) / (double)RAND_MAX);
        fprintf(file, "%d,%.17g,%.17g,%.17g,%.17g\n", i, x[i][0], x[i][1], x[i][2], r[i]);
    }
    fclose(file);
    int expected = 0;
    for (int i = 0; i < N; i++)
        for (int j = 0; j < i; j++) {
            double d2 = 0;
            for (int a = 0; a < 3; a++) {
                double d = fabs(x[i][a] - x[j][a]);
                d = a < 2 && d > 2.5 ? 5 - d : d;
                d2 += d * d;
            }
            expected += sqrt(d2) < r[i] + r[j];
        }
    sp_import_options o = sp_import_options_default();
    o.width = o.depth = 5;
    o.friction = 0;
    o.contacts = "overlap";
    o.walls = "none";
    sp_packing p;
    sp_import_report report;
    sp_error err = {0};
    if (sp_import(in_folder("gas.csv"), &o, &p, &report, &err) != SP_OK)
        fail_msg("%s", err.text);
    assert_int_equal(p.n_contacts, expected);
    assert_int_equal(report.wall_contacts, 0);
    sp_packing_free(&p);
}

/* ---- memory ---------------------------------------------------------------------------------------------------- */

/* Whichever allocation fails, the import says so, frees all that it has, and gives no packing. */
static void test_memory(void **state) {
    (void)state;
    sp_import_options o = sp_import_options_default();
    o.contacts = SOURCE_DIR "/tests/foreign/samples/lammps/layer_contacts.dump";
    o.types = "1";
    o.friction = 0.5;
    int failures = 0;
    for (int64_t k = 0;; k++) {
        sp_packing p = sp_packing_none();
        sp_error err = {0};
        sp_alloc_fail_after(k);
        const sp_status status =
            sp_import(SOURCE_DIR "/tests/foreign/samples/lammps/layer_grains.dump", &o, &p, NULL, &err);
        sp_alloc_fail_after(-1);
        if (status == SP_OK) {
            assert_int_equal(p.n, 72);
            sp_packing_free(&p);
            break;
        }
        if (status != SP_ENOMEM)
            fail_msg("allocation %d: %s", (int)k, err.text);
        assert_null(p.x);
        failures++;
    }
    assert_true(failures > 15);
}

static int make_folder(void **state) {
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state) {
    (void)state;
    unlink(in_folder("gas.csv"));
    unlink(in_folder("a"));
    return rmdir(folder);
}

static void test_forms(void **state) {
    (void)state;
    static const struct {
        const char *text;
        sp_form form;
    } cases[] = {{"ITEM: TIMESTEP\n0\n", SP_FORM_LAMMPS_DUMP},
                 {"LAMMPS data\n\n5 atoms\n", SP_FORM_LAMMPS_DATA},
                 {"# a comment\n5 atoms\n", SP_FORM_LAMMPS_DATA},
                 {"#format x_y_z_r\n1 2 3 4\n", SP_FORM_YADE},
                 {"2 0 0 0 0 1 1 1\n1 2 3 0 0 0 1 0 0 0 0 0 0 0\n", SP_FORM_MERCURY},
                 {"2\nLattice=\"1 0 0 0 1 0 0 0 1\"\n", SP_FORM_XYZ},
                 {"frame,id,x,y,radius,boundary\n1,1,2,3,4,0\n", SP_FORM_PHOTOELASTIC},
                 {"id,x,y,radius\n", SP_FORM_CSV},
                 {"id x y radius\n", SP_FORM_CSV},
                 {"# packing: N\nN 5 Lx 4 p 1 mu 0\n", SP_FORM_OURS},
                 {"hello world\n", SP_FORM_AUTO},
                 {"", SP_FORM_AUTO}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        sp_form form;
        write_text("a", cases[k].text);
        assert_int_equal(sp_form_of_file(in_folder("a"), &form, NULL), SP_OK);
        if (form != cases[k].form)
            fail_msg("'%s' taken for form %d", cases[k].text, (int)form);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_numbers), cmocka_unit_test(test_words),     cmocka_unit_test(test_cells),
        cmocka_unit_test(test_keys),    cmocka_unit_test(test_all_pairs), cmocka_unit_test(test_memory),
        cmocka_unit_test(test_forms),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
