/* Tables as text and back. */
#include "test_store_fixture.h"

#include <locale.h>

static sp_table example(void) {
    sp_table t = sp_table_none();
    assert_ok(sp_table_add_column(&t, "file", "", SP_COLUMN_TEXT, &err));
    assert_ok(sp_table_add_column(&t, "p", "E*", SP_COLUMN_NUMBER, &err));
    assert_ok(sp_table_add_column(&t, "n", "", SP_COLUMN_INTEGER, &err));
    assert_ok(sp_table_add_column(&t, "c_l", "sqrt(E* / rho)", SP_COLUMN_NUMBER, &err));
    assert_ok(sp_table_add_comment(&t, &err, "pressure = %g", 1e-4));
    assert_ok(sp_table_add_row(&t, &err, "a b.h5", 0.1, (int64_t)-7, NAN));
    assert_ok(sp_table_add_row(&t, &err, "#tab\tline\nback\\slash,\"q\"", 1.0 / 3, INT64_MAX, -INFINITY));
    assert_ok(sp_table_add_row(&t, &err, "\xc3\xa9\xff", 5e-324, (int64_t)0, 1.7976931348623157e308));
    return t;
}

static void assert_text(const sp_table *t, sp_table_format format, const char *expected) {
    char *text = sp_table_text(t, format);
    assert_non_null(text);
    assert_string_equal(text, expected);
    sp_free(text);
}

TEST_IN_FOLDER(texts) {
    FREED(sp_table) t = example();
    assert_text(&t, SP_TSV,
                "# pressure = 0.0001\n# units: p [E*] c_l [sqrt(E* / rho)]\nfile\tp\tn\tc_l\n"
                "a b.h5\t0.1\t-7\tnan\n"
                "\\#tab\\tline\\nback\\\\slash,\"q\"\t0.3333333333333333\t9223372036854775807\t-inf\n"
                "\xc3\xa9\xff\t4.94065645841247e-324\t0\t1.7976931348623157e+308\n");
    assert_text(&t, SP_CSV,
                "file,p,n,c_l\n"
                "a b.h5,0.1,-7,nan\n"
                "\"#tab\tline\nback\\slash,\"\"q\"\"\",0.3333333333333333,9223372036854775807,-inf\n"
                "\xc3\xa9\xff,4.94065645841247e-324,0,1.7976931348623157e+308\n");
    assert_text(&t, SP_JSON,
                "{\"comments\":[\"pressure = 0.0001\"],\n\"columns\":[\"file\",\"p\",\"n\",\"c_l\"],\n"
                "\"units\":[\"\",\"E*\",\"\",\"sqrt(E* / rho)\"],\n\"rows\":[\n"
                "[\"a b.h5\",0.1,-7,null],\n"
                "[\"#tab\\u0009line\\u000aback\\\\slash,\\\"q\\\"\",0.3333333333333333,9223372036854775807,null],\n"
                "[\"\xc3\xa9\\ufffd\",4.94065645841247e-324,0,1.7976931348623157e+308]]}\n");
    sp_table empty = sp_table_none();
    assert_text(&empty, SP_JSON, "{\"comments\":[],\n\"columns\":[],\n\"units\":[],\n\"rows\":[]}\n");
}

/* Two digits of an error, which say how many its value has: 3 where it is 24.7(1.3); six at
 * most, and where no error is known. Texts stand at the left; characters count, not bytes. */
TEST_IN_FOLDER(aligned) {
    static const struct {
        const char *file;
        double c, error;
        int64_t n;
    } row[] = {{"a\tb", 0.26612345, 0.0043, 7},
               {"\xc3\xa9", 24.7182818, 1.26, -12345},
               {"", 0.25, 0.001, 0},
               {"big", 123456.789, 1234, 1},
               {"small", 1.23456789e-9, 5e-9, 2},
               {"known", 3.14159265358979, 1e-12, 3},
               {"none", 1.0 / 3, NAN, 4},
               {"not", -NAN, 0, 5}};
    const struct {
        int digits;
        const char *text;
    } each[] = {{SP_DIGITS_OF_ERRORS, "# p = 0.1\n# units: c [m/s]\n"
                                      "file           c    c_err       n\n"
                                      "a\\tb      0.2661   0.0043       7\n"
                                      "\xc3\xa9           24.7      1.3  -12345\n"
                                      "          0.2500    0.001       0\n"
                                      "big    1.235e+05  1.2e+03       1\n"
                                      "small    1.2e-09    5e-09       2\n"
                                      "known    3.14159    1e-12       3\n"
                                      "none    0.333333      nan       4\n"
                                      "not          nan        0       5\n"},
                {3, "# p = 0.1\n# units: c [m/s]\n"
                    "file          c     c_err       n\n"
                    "a\\tb      0.266    0.0043       7\n"
                    "\xc3\xa9          24.7      1.26  -12345\n"
                    "           0.25     0.001       0\n"
                    "big    1.23e+05  1.23e+03       1\n"
                    "small  1.23e-09     5e-09       2\n"
                    "known      3.14     1e-12       3\n"
                    "none      0.333       nan       4\n"
                    "not         nan         0       5\n"},
                {SP_DIGITS_ALL, "# p = 0.1\n# units: c [m/s]\n"
                                "file                    c   c_err       n\n"
                                "a\\tb           0.26612345  0.0043       7\n"
                                "\xc3\xa9              24.7182818    1.26  -12345\n"
                                "                     0.25   0.001       0\n"
                                "big            123456.789    1234       1\n"
                                "small      1.23456789e-09   5e-09       2\n"
                                "known    3.14159265358979   1e-12       3\n"
                                "none   0.3333333333333333     nan       4\n"
                                "not                   nan       0       5\n"}};
    FREED(sp_table) t = sp_table_none();
    assert_ok(sp_table_add_column(&t, "file", "", SP_COLUMN_TEXT, &err));
    assert_ok(sp_table_add_column(&t, "c", "m/s", SP_COLUMN_NUMBER, &err));
    assert_ok(sp_table_add_column(&t, "c_err", "", SP_COLUMN_NUMBER, &err));
    assert_ok(sp_table_add_column(&t, "n", "", SP_COLUMN_INTEGER, &err));
    assert_ok(sp_table_add_comment(&t, &err, "p = 0.1"));
    for (size_t k = 0; k < sizeof row / sizeof *row; k++)
        assert_ok(sp_table_add_row(&t, &err, row[k].file, row[k].c, row[k].error, row[k].n));
    for (size_t k = 0; k < sizeof each / sizeof *each; k++) {
        char *text = sp_table_aligned(&t, each[k].digits);
        assert_string_equal(text, each[k].text);
        sp_free(text);
    }
}

TEST_IN_FOLDER(tsv_round_trip) {
    FREED(sp_table) t = example(), back = sp_table_none();
    char *text = sp_table_text(&t, SP_TSV);
    const char *path = fixture_path(folder, "t.tsv");
    assert_ok(sp_text_save(path, text, strlen(text), &err));
    assert_ok(sp_table_read(path, &back, &err));
    assert_int_equal(back.columns, 4);
    assert_int_equal(back.rows, 3);
    assert_string_equal(back.column[3].unit, "sqrt(E* / rho)");
    assert_string_equal(back.column[0].unit, "");
    assert_string_equal(sp_table_get_text(&back, "pressure"), "0.0001");
    for (int64_t row = 0; row < 3; row++) {
        assert_string_equal(back.cells[row * 4].text, t.cells[row * 4].text);
        for (int c = 1; c < 4; c++) {
            double a = sp_table_number(&t, row, c), b = sp_table_number(&back, row, c);
            assert_true(a == b || (isnan(a) && isnan(b)));
        }
    }
    sp_free(text);
}

static sp_status read_text(const char *text, sp_table *t, sp_error *err) {
    const char *path = fixture_path(folder, "t.tsv");
    fixture_write(path, text);
    return sp_table_read(path, t, err);
}

TEST_IN_FOLDER(lenient_reading) {
    sp_table t;
    /* plain columns at any blanks, CRLF, blank lines, no newline at the end, a byte order mark */
    assert_ok(read_text("\xef\xbb\xbf# a comment\r\n\r\n 0  1.5\t\t-2e3\r\n   \n1\t2 3", &t, &err));
    assert_int_equal(t.columns, 3);
    assert_int_equal(t.rows, 2);
    assert_string_equal(t.column[2].name, "c3");
    assert_string_equal(t.comment[0], "a comment");
    assert_true(sp_table_number(&t, 0, 2) == -2e3 && sp_table_number(&t, 1, 2) == 3);
    sp_table_free(&t);
    /* a header at blanks; one column is text because one cell is no number */
    assert_ok(read_text("t F who\n0 1 2\n1 nan x\n", &t, &err));
    assert_int_equal(t.column[1].kind, SP_COLUMN_NUMBER);
    assert_int_equal(t.column[2].kind, SP_COLUMN_TEXT);
    assert_true(isnan(sp_table_number(&t, 1, 1)));
    assert_string_equal(t.cells[2].text, "2");
    sp_table_free(&t);
    /* cells with blanks and empty cells between tabs */
    assert_ok(read_text("file\tnote\nmy file.h5\t\nb\tfine\n", &t, &err));
    assert_string_equal(t.cells[0].text, "my file.h5");
    assert_string_equal(t.cells[1].text, "");
    sp_table_free(&t);
    /* a header and no rows */
    assert_ok(read_text("t\tF\n", &t, &err));
    assert_true(t.columns == 2 && t.rows == 0);
    sp_table_free(&t);
}

TEST_IN_FOLDER(reference_signal_reads) {
    FREED(sp_table) t;
    assert_ok(sp_table_read(SOURCE_DIR "/packings/reference/signal_N200_p1e-4.txt", &t, &err));
    assert_true(t.columns == 3 && t.rows > 100 && t.comments >= 3);
    assert_true(sp_table_number(&t, 0, 0) == 0);
}

TEST_IN_FOLDER(refusals) {
    sp_table t;
    assert_fails(read_text("", &t, &err), SP_EFORMAT, "t.tsv");
    assert_fails(read_text("# only a comment\n", &t, &err), SP_EFORMAT, "t.tsv");
    assert_fails(read_text("1 2\n\n3 4 5\n", &t, &err), SP_EFORMAT, "t.tsv:3 3 2");
    assert_fails(read_text("a\tb\n1\n", &t, &err), SP_EFORMAT, "t.tsv:2 1");
    assert_fails(sp_table_read(fixture_path(folder, "nowhere"), &t, &err), SP_EIO, "nowhere No such file");
    assert_fails(sp_table_read(folder, &t, &err), SP_EIO, "Is a directory");
    assert_fails(sp_table_read("/dev/zero", &t, &err), SP_EFORMAT, "/dev/zero");
    char name[64];
    memset(name, 'n', sizeof name);
    name[63] = '\0';
    assert_fails(read_text(name, &t, &err), SP_EFORMAT, "1");
    const size_t length = 70000;
    RELEASED char *line = malloc(length + 1);
    memset(line, '1', length);
    line[length] = '\0';
    assert_fails(read_text(line, &t, &err), SP_EFORMAT, "t.tsv:1 70000");
    for (size_t k = 0; k < 2050; k++)
        line[k] = k % 2 ? ' ' : '1';
    line[2050] = '\0';
    assert_fails(read_text(line, &t, &err), SP_EFORMAT, "t.tsv:1 1024");
    for (size_t k = 0; k < 10000; k++)
        memcpy(line + 2 * k, "#\n", 2);
    line[20000] = '\0';
    assert_fails(read_text(line, &t, &err), SP_EFORMAT, "t.tsv:4097 4096 lines");
}

/* Arbitrary bytes: an error or a table, nothing else. */
TEST_IN_FOLDER(noise_is_survived) {
    static const char letters[] = "0123456789.-+eE \t\n\r#\\abnif[]:=,\"";
    uint64_t random = 2024;
    for (int k = 0; k < 3000; k++) {
        char text[200];
        size_t length = fixture_next(&random) % sizeof text;
        for (size_t c = 0; c < length; c++)
            text[c] = letters[fixture_next(&random) % (sizeof letters - 1)];
        text[length ? length - 1 : 0] = '\0';
        sp_table t;
        sp_error err = {0};
        sp_status status = read_text(text, &t, &err);
        if (status == SP_OK)
            sp_table_free(&t);
        else
            assert_true(status == SP_EFORMAT && *err.text);
    }
}

TEST_IN_FOLDER(lack_of_memory) {
    FREED(sp_table) t = example(), back;
    char *text = sp_table_text(&t, SP_TSV);
    const char *path = fixture_path(folder, "t.tsv");
    assert_ok(sp_text_save(path, text, strlen(text), &err));
    sp_free(text);
    for (int format = SP_TSV; format <= SP_JSON; format++) {
        sp_alloc_fail_after(0);
        assert_null(sp_table_text(&t, (sp_table_format)format));
        sp_alloc_fail_after(-1);
    }
    text = NULL;
    for (int64_t k = 0; !text; k++) { /* half a text is none */
        sp_alloc_fail_after(k);
        text = sp_table_aligned(&t, SP_DIGITS_ALL);
        sp_alloc_fail_after(-1);
    }
    assert_int_equal(text[strlen(text) - 1], '\n');
    sp_free(text);
    sp_status status = SP_ENOMEM;
    for (int64_t k = 0; status != SP_OK; k++) {
        sp_alloc_fail_after(k);
        status = sp_table_read(path, &back, NULL);
        sp_alloc_fail_after(-1);
        assert_true(status == SP_OK || status == SP_ENOMEM);
    }
}

/* The program around us may have set a locale with a decimal comma. */
TEST_IN_FOLDER(decimal_comma) {
    if (!setlocale(LC_ALL, "de_DE.UTF-8") && !setlocale(LC_ALL, "fr_FR.UTF-8"))
        skip(); /* none is installed */
    FREED(sp_table) t = example(), back;
    char *text = sp_table_text(&t, SP_TSV);
    assert_non_null(strstr(text, "0.1"));
    assert_ok(read_text("1.5 2.5\n", &back, &err));
    assert_true(sp_table_number(&back, 0, 0) == 1.5);
    setlocale(LC_ALL, "C");
    sp_free(text);
}

/* As many columns as one likes (up to what a file may have), rows of numbers at once. */
TEST_IN_FOLDER(many_columns) {
    enum { MANY = 1000 };
    sp_table t = sp_table_none(), back;
    double row[MANY];
    for (int c = 0; c < MANY; c++) {
        char name[16];
        snprintf(name, sizeof name, "F%d", c);
        assert_ok(sp_table_add_column(&t, name, "d", SP_COLUMN_NUMBER, &err));
    }
    for (int k = 0; k < 70; k++) {
        for (int c = 0; c < MANY; c++)
            row[c] = c + k / 64.0;
        assert_ok(sp_table_add_numbers(&t, row, &err));
    }
    assert_fails(sp_table_add_column(&t, "late", "", SP_COLUMN_NUMBER, &err), SP_EINVAL, "late");
    char *text = sp_table_text(&t, SP_TSV);
    assert_non_null(text);
    assert_ok(read_text(text, &back, &err));
    assert_int_equal(back.columns, MANY);
    assert_int_equal(back.rows, 70);
    assert_string_equal(back.column[999].name, "F999");
    assert_true(sp_table_number(&back, 69, 999) == 999 + 69 / 64.0);
    sp_table_free(&back);
    back = example();
    assert_fails(sp_table_add_numbers(&back, row, &err), SP_EINVAL, "file");
    sp_free(text);
    sp_table_free(&t);
    sp_table_free(&back);
}

/* Each setter writes its comment line, and reading the file finds the same value. */
TEST_IN_FOLDER(metadata) {
    FREED(sp_table) t = example(), back;
    double value = 0;
    assert_ok(sp_table_set_number(&t, "third", 1.0 / 3, 0, &err));
    assert_ok(sp_table_set_number(&t, "rounded", 1.0 / 3, 3, &err));
    assert_ok(sp_table_set_number(&t, "unknown", NAN, 3, &err));
    assert_ok(sp_table_set_integer(&t, "samples", 12, &err));
    assert_ok(sp_table_set_text(&t, "method", "event driven", &err));
    assert_fails(sp_table_set_integer(&t, "samples", 13, &err), SP_EINVAL, "samples");
    assert_fails(sp_table_set_number(&t, "digits", 1, 18, &err), SP_EINVAL, "18 digits");
    assert_string_equal(t.comment[2], "rounded = 0.333");
    char *text = sp_table_text(&t, SP_TSV);
    assert_ok(read_text(text, &back, &err));
    for (int k = 0; k < t.values; k++) {
        assert_string_equal(back.value[k].key, t.value[k].key);
        assert_string_equal(back.value[k].text, t.value[k].text);
        assert_int_equal(back.value[k].kind, t.value[k].kind);
    }
    assert_int_equal(back.values, 6);
    assert_true(sp_table_get_number(&back, "third", &value) && value == 1.0 / 3);
    assert_true(sp_table_get_number(&back, "samples", &value) && value == 12);
    assert_false(sp_table_get_number(&back, "unknown", &value));
    assert_false(sp_table_get_number(&back, "method", &value));
    assert_false(sp_table_get_number(&back, "absent", &value));
    assert_true(value == 12);
    assert_string_equal(sp_table_get_text(&back, "method"), "event driven");
    assert_null(sp_table_get_text(&back, "absent"));
    sp_free(text);
}

/* Lines that people or earlier versions wrote. */
TEST_IN_FOLDER(metadata_of_lines) {
    FREED(sp_table) t;
    double value = 0;
    assert_ok(read_text("# pressure = 0.25, grains = 1024, friction = 0.5\n"
                        "# packing.seed=7 \n"
                        "# gamma(p=1e-06, width=24) = 0.125, error 0.01\n"
                        "# means with their interval at level 0.95, by a rule\n"
                        "# a sentence\n#\n"
                        "x\n1\n",
                        &t, &err));
    assert_int_equal(t.values, 6);
    assert_true(sp_table_get_number(&t, "pressure", &value) && value == 0.25);
    assert_true(sp_table_get_number(&t, "grains", &value) && value == 1024);
    assert_string_equal(sp_table_get_text(&t, "friction"), "0.5");
    assert_string_equal(sp_table_get_text(&t, "packing.seed"), "7");
    assert_true(sp_table_get_number(&t, "gamma(p=1e-06, width=24)", &value) && value == 0.125);
    assert_string_equal(sp_table_get_text(&t, "gamma(p=1e-06, width=24)"), "0.125, error 0.01");
    assert_true(sp_table_get_number(&t, "interval_level", &value) && value == 0.95);
}

RUN_TESTS(NULL, NULL)
