/* Figures of the tapped column: what they say, that they stay small, and what they refuse. */
#include "base/base.h"
#include "figure/tapped_view.h"
#include "reference.h"

#include <math.h>
#include <sonopack/figure/figure.h>
#include <sonopack/figure/plot.h>
#include <unistd.h>

#if defined(__SANITIZE_ADDRESS__)
/* fontconfig, behind cairo, keeps offsets in place of pointers: the leak checker cannot see that its memory is held. */
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) { return "leak:libfontconfig"; }
const char *__lsan_default_options(void);
const char *__lsan_default_options(void) { return "print_suppressions=0"; }
#endif

static char folder[] = "/tmp/sonopack-column-XXXXXX", svg[64], png[64];

static int setup(void **state) {
    (void)state;
    if (!mkdtemp(folder))
        return 1;
    snprintf(svg, sizeof svg, "%s/a.svg", folder);
    snprintf(png, sizeof png, "%s/a.png", folder);
    return 0;
}

static int teardown(void **state) {
    (void)state;
    remove(svg);
    remove(png);
    return rmdir(folder);
}

static char *read_figure(size_t *size) {
    enum { MOST = 16000000 };
    FILE *file = fopen(svg, "rb");
    assert_non_null(file);
    char *text = calloc(1, MOST + 1);
    assert_non_null(text);
    *size = fread(text, 1, MOST, file);
    assert_true(*size > 0 && *size < MOST);
    fclose(file);
    remove(svg);
    return text;
}

static void says_not(const char *const *words) {
    size_t size;
    char *text = read_figure(&size);
    for (; *words; words++)
        if (strstr(text, *words))
            fail_msg("%s in %.900s", *words, text);
    free(text);
}

/* All texts of the figure, a line each. */
static void says(const char *const *words) {
    size_t size;
    char *text = read_figure(&size);
    for (; *words; words++)
        if (!strstr(text, *words))
            fail_msg("no %s in %.900s", *words, text);
    assert_null(strstr(text, " nan")); /* no place on the canvas; an image in base64 has no blanks */
    free(text);
}

typedef struct cells {
    const char *names; /* "t [s] y0 [cm] ...": a unit belongs to the name before it */
    int64_t rows;
    double (*cell)(int64_t row, int column);
} cells;

static sp_table table_of(cells from) {
    sp_table t = sp_table_none();
    char copy[512], *rest = copy;
    double row[64];
    snprintf(copy, sizeof copy, "%s", from.names);
    for (char *name; (name = strsep(&rest, " ")) != NULL;) {
        char *unit = strchr(name, '[');
        if (unit) {
            *unit++ = '\0';
            unit[strlen(unit) - 1] = '\0';
        }
        assert_ok(sp_table_add_column(&t, name, unit ? unit : "", SP_COLUMN_NUMBER, &err));
    }
    for (int64_t k = 0; k < from.rows; k++) {
        for (int c = 0; c < t.columns; c++)
            row[c] = from.cell(k, c);
        assert_ok(sp_table_add_numbers(&t, row, &err));
    }
    return t;
}

static sp_status plot(int tables, const sp_table *t, const sp_plot_column_options *o, const char *path, sp_error *err) {
    sp_plot_table shown[8] = {
        {"first", &t[0], false}, {"second", &t[tables > 1], false}, {"third", &t[tables > 2 ? 2 : 0], false}};
    for (int k = 3; k < 8; k++)
        shown[k] = shown[0];
    return sp_plot_column(tables, shown, o, path, err);
}

static void refuses(int tables, const sp_table *t, const sp_plot_column_options *o, sp_status status,
                    const char *reason) {
    sp_error err = {0};
    assert_int_equal(plot(tables, t, o, svg, &err), status);
    if (!test_names(err.text, reason))
        fail_msg("%s: not named in \"%s\"", reason, err.text);
    assert_int_equal(access(svg, F_OK), -1);
}

/* A time each hundredth, a floor that taps, and particles two apart that swing. */
static double swing(int64_t row, int column) {
    const double t = 0.01 * (double)row, phase = fmod(t, 1);
    if (column == 0)
        return t;
    if (column == 1)
        return phase < 0.1 ? sin(31.4159 * phase) : 0;
    return 2 * column - 3 + 0.8 * exp(-3 * phase) * sin(9 * phase);
}

#define FIVE "t[s] y0[cm] y1[cm] y2[cm] y3[cm] y4[cm] y5[cm]"
#define NINE FIVE " y6[cm] y7[cm] y8[cm] y9[cm]"

static void test_trajectory(void **state) {
    (void)state;
    sp_table t = table_of((cells){FIVE, 250, swing}), many = table_of((cells){NINE, 250, swing});
    assert_ok(sp_table_add_comment(&t, &err, "period = 1"));
    assert_ok(plot(1, &t, NULL, svg, &err));
    says((const char *[]){"\ny_1\n", "\ny_5\n", "\nfloor y_0\n", "\nt  [s]\n", "\ny  [cm]\n", NULL});
    assert_ok(plot(1, &many, NULL, svg, &err));
    says((const char *[]){"\ny_1 \xe2\x80\xa6 y_9\n", "\nfloor y_0\n", NULL});
    /* a gap is left open, but not all may be gaps, and times must rise */
    t.cells[7 * 100 + 3].number = NAN;
    assert_ok(plot(1, &t, NULL, svg, &err));
    remove(svg);
    t.cells[7 * 100].number = 0.5;
    refuses(1, &t, NULL, SP_EREFUSED, "101 0.5 0.99");
    t.cells[7 * 100].number = NAN;
    refuses(1, &t, NULL, SP_EREFUSED, "101 nan");
    for (int64_t k = 0; k < many.rows; k++)
        for (int c = 1; c < many.columns; c++)
            many.cells[k * many.columns + c].number = NAN;
    refuses(1, &many, NULL, SP_EREFUSED, "");
    sp_table_free(&t);
    sp_table_free(&many);
}

/* A long run is thinned: its figure is no larger than a short one's by more than what the lines can show. */
static void test_long_trajectory(void **state) {
    (void)state;
    size_t size;
    sp_table t = table_of((cells){FIVE, 200000, swing});
    assert_ok(plot(1, &t, NULL, svg, &err));
    free(read_figure(&size));
    assert_true(size < 4000000);
    sp_table_free(&t);
}

/* Panels are called by their models, and by their files where these are the same. */
static void test_surfaces(void **state) {
    (void)state;
    const sp_plot_column_options alone = {.surface = true};
    sp_table t[3] = {table_of((cells){FIVE, 120, swing}), table_of((cells){FIVE, 120, swing}),
                     table_of((cells){FIVE, 90, swing})};
    assert_ok(plot(1, t, &alone, svg, &err));
    says((const char *[]){"\nt  [s]\n", "\ny  [cm]\n", "\nparticle\n", "\ny(t) \xe2\x88\x92 y(0)  [cm]\n", NULL});
    assert_ok(plot(2, t, NULL, svg, &err));
    says((const char *[]){"\n(a)  first\n", "\n(b)  second\n", NULL});
    assert_ok(sp_table_add_comment(&t[0], &err, "model = lattice"));
    assert_ok(sp_table_add_comment(&t[1], &err, "model = longwave"));
    assert_ok(sp_table_add_comment(&t[2], &err, "model = bsr"));
    assert_ok(plot(3, t, NULL, svg, &err));
    says((const char *[]){"\n(a)  lattice\n", "\n(b)  long wave\n", "\n(c)  BSR\n", NULL});
    assert_ok(plot(3, t, NULL, png, &err));
    sp_table one = table_of((cells){"t y0 y1", 10, swing}), words = sp_table_none();
    refuses(1, &one, &alone, SP_EINVAL, "");
    assert_ok(sp_table_add_column(&words, "t", "", SP_COLUMN_TEXT, &err));
    refuses(1, &words, NULL, SP_EINVAL, "t");
    refuses(7, t, NULL, SP_EINVAL, "7");
    for (int k = 0; k < 3; k++)
        sp_table_free(&t[k]);
    sp_table_free(&one);
    sp_table_free(&words);
}

/* Both scales darken all the way from one end to the other, so that they read in grey, and the sides of the signed one
 * differ in colour. */
static void test_colours(void **state) {
    (void)state;
    double before = 2;
    for (int k = 0; k <= 20; k++) {
        const colour c = sp_scene3_colour(k / 20.0);
        const double light = 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b;
        assert_true(light < before); /* reads in grey, too */
        before = light;
    }
    before = 2;
    for (int k = 0; k <= 40; k++) {
        const double part = 1 - k / 20.0;
        const colour c = sp_scene3_signed_colour(part);
        const double light = 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b;
        assert_true(light < before);
        assert_true(k == 20 || (part > 0 ? c.r > c.b : c.b > c.r));
        before = light;
    }
}

static double strobe(int64_t row, int column) {
    return column == 0   ? (double)row + 1
           : column == 1 ? (double)row + 0.99
           : column == 5 ? 0.65
                         : column + 0.1 * (double)row;
}

static void test_strobe(void **state) {
    (void)state;
    sp_table t = table_of((cells){"tap t[s] y1[cm] y2[cm] y3[cm] density[g/cm]", 20, strobe});
    assert_ok(plot(1, &t, NULL, svg, &err));
    says((const char *[]){"\ndensity  [g/cm]\n", "\ntap\n", "\ny \xe2\x88\x92 y(tap 1)  [cm]\n", "\ny_3\n", "\n(b)\n",
                          NULL});
    /* of a few taps only whole ones have ticks */
    for (int64_t few = 2; few <= 6; few++) {
        char last[16];
        sp_table some = table_of((cells){"tap t[s] y1[cm] y2[cm] y3[cm] density[g/cm]", few, strobe});
        snprintf(last, sizeof last, "\n%d\n", (int)few);
        assert_ok(plot(1, &some, NULL, svg, &err));
        says((const char *[]){"\n1\n", few == 6 ? "\n5\n" : last, NULL});
        assert_ok(plot(1, &some, NULL, svg, &err));
        says_not((const char *[]){"\n1.5\n", "\n2.5\n", "\n1.2\n", "\n2.0\n", NULL});
        sp_table_free(&some);
    }
    sp_table one = table_of((cells){"tap t y1 density", 1, strobe});
    refuses(1, &one, NULL, SP_EREFUSED, "");
    sp_table_free(&t);
    sp_table_free(&one);
}

static double exponent(int64_t row, int column) {
    return column == 0 ? 1 + 0.01 * (double)row : row % 7 == 0 ? -INFINITY : sin(0.1 * (double)row);
}
static double branch(int64_t row, int column) {
    return column == 0 ? 1 + 0.01 * (double)(row / 10) : column == 1 ? (double)(row % 10) : sin((double)row * column);
}
#define BRANCHES "parameter[cm] tap y1[cm] y2[cm]"

static void test_diagrams(void **state) {
    (void)state;
    const sp_plot_column_options second = {.column = "y2"}, third = {.column = "y3"};
    sp_table t[2] = {table_of((cells){BRANCHES, 1000, branch}),
                     table_of((cells){"parameter[cm] lambda", 100, exponent})};
    assert_ok(plot(1, &t[1], NULL, svg, &err));
    says((const char *[]){"\nparameter  [cm]\n", "\n\xce\xbb\n", NULL});
    assert_ok(sp_table_add_comment(&t[0], &err, "parameter = amplitude"));
    assert_ok(plot(1, t, NULL, svg, &err));
    says((const char *[]){"\na  [cm]\n", "\ny_1 after a tap  [cm]\n", NULL});
    assert_ok(plot(2, t, &second, svg, &err));
    says((const char *[]){"\ny_2 after a tap  [cm]\n", "\n(a)\n", "\n(b)\n", "\n\xce\xbb\n", NULL});
    refuses(1, t, &third, SP_EINVAL, "y1 y2");
    refuses(1, &t[1], &second, SP_EINVAL, "bifurcation");
    assert_ok(sp_table_add_comment(&t[1], &err,
                                   "warning: ordering (1) violated at 3 of 100 points, first at amplitude = 1.2: "
                                   "centres passed each other"));
    assert_ok(plot(1, &t[1], NULL, svg, &err));
    says((const char *[]){"\norder (1) violated at 3 of 100 points\n", NULL});
    assert_ok(plot(2, t, NULL, svg, &err));
    says((const char *[]){"\n(b): order (1) violated at 3 of 100 points\n", NULL});
    assert_ok(sp_table_add_comment(&t[1], &err, "parameter = period"));
    refuses(2, t, NULL, SP_EINVAL, "amplitude");
    const sp_table twice[2] = {t[1], t[1]};
    refuses(2, twice, NULL, SP_EINVAL, "1 2");
    const sp_table thrice[3] = {t[0], t[1], t[0]};
    refuses(3, thrice, NULL, SP_EINVAL, "1 bifurcation 3 bifurcation");
    for (int64_t k = 0; k < 100; k++)
        t[1].cells[2 * k + 1].number = -INFINITY;
    refuses(1, &t[1], NULL, SP_EREFUSED, "");
    for (int k = 0; k < 2; k++)
        sp_table_free(&t[k]);
    sp_table same = table_of((cells){BRANCHES, 10, branch});
    refuses(1, &same, NULL, SP_EREFUSED, "");
    sp_table_free(&same);
}

/* A million dots are an image: no more than the pixels of the frame hold, here less than 6 MB. */
static void test_million(void **state) {
    (void)state;
    size_t size;
    sp_table t = table_of((cells){"parameter tap y1", 1000000, branch});
    assert_ok(plot(1, &t, NULL, svg, &err));
    free(read_figure(&size));
    assert_true(size > 20000 && size < 6000000);
    sp_table_free(&t);
}

static double difference(int64_t row, int column) {
    return column == 0 ? 0.01 * (double)row : 0.01 * (double)row * pow(column, column > 2 ? 4 : 1);
}

/* Far apart, they stand on a logarithmic axis. */
static void test_compare(void **state) {
    (void)state;
    sp_table t = table_of((cells){"t[s] mean_longwave[cm] max_longwave[cm] mean_bsr[cm] max_bsr[cm]", 100, difference});
    assert_ok(plot(1, &t, NULL, svg, &err));
    says((const char *[]){"\nlong wave, mean\n", "\nBSR, largest\n", "\ndifference from the lattice  [cm]\n",
                          "\n10^\xe2\x88\x92"
                          "1\n",
                          NULL});
    sp_table one = table_of((cells){"t mean_bsr", 10, difference});
    assert_ok(plot(1, &one, NULL, svg, &err));
    says((const char *[]){"\nBSR, mean\n", NULL});
    sp_table_free(&t);
    sp_table_free(&one);
}

static double dense(int64_t row, int column) {
    return column == 0 ? 0.01 * (double)row : column < 4 ? 2 * column + sin(0.1 * (double)row) : 1.0 / column;
}

static void test_density(void **state) {
    (void)state;
    sp_table t = table_of((cells){"t[s] y1[cm] y2[cm] y3[cm] rho1[g/cm] rho2[g/cm] rho3[g/cm]", 301, dense});
    assert_ok(sp_table_add_comment(&t, &err, "period = 1"));
    assert_ok(plot(1, &t, NULL, svg, &err));
    says((const char *[]){"\nt = 0 s\n", "\ntap 1, t = 0.99 s\n", "\ntap 3, t = 2.99 s\n", "\nheight y  [cm]\n",
                          "\nparticle 3\n", "\ndensity \xcf\x81  [g/cm]\n", NULL});
    assert_ok(plot(1, &t, &(sp_plot_column_options){.surface = true}, svg, &err));
    says((const char *[]){"\ndensity \xcf\x81  [g/cm]\n", "\nparticle\n", NULL});
    /* of many taps the first and the last are among those shown */
    sp_table many = table_of((cells){"t[s] y1[cm] y2[cm] y3[cm] rho1[g/cm] rho2[g/cm] rho3[g/cm]", 4101, dense});
    assert_ok(sp_table_add_comment(&many, &err, "period = 1"));
    assert_ok(plot(1, &many, NULL, svg, &err));
    says(
        (const char *[]){"\nt = 0 s\n", "\ntap 1, t = 0.99 s\n", "\ntap 11, t = 11 s\n", "\ntap 41, t = 41 s\n", NULL});
    sp_table_free(&many);
    sp_table path = table_of((cells){FIVE, 301, swing}), bad = table_of((cells){"t y1 y2 rho1", 9, dense});
    const sp_table both[2] = {t, path};
    refuses(2, both, NULL, SP_EINVAL, "");
    refuses(1, &bad, NULL, SP_EINVAL, "2 y1 y2 1 rho1");
    sp_table_free(&t);
    sp_table_free(&path);
    sp_table_free(&bad);
}

static double energy(int64_t row, int column) {
    return column == 0 ? (double)row + 1 : column == 5 && row == 2 ? NAN : 7000 + 10 * (double)column + (double)row;
}

static void test_energy(void **state) {
    (void)state;
    sp_table t =
        table_of((cells){"tap work[erg] dissipated[erg] energy[erg] residual rest[s] separation[cm]", 4, energy});
    assert_ok(plot(1, &t, NULL, svg, &err));
    says((const char *[]){"\nwork of the floor\n", "\ndissipated\n", "\nenergy  [erg]\n", "\nat rest after  [s]\n",
                          "\nwork \xe2\x88\x92 dissipated  [erg]\n", "\n(d)\n", NULL});
    sp_table least = table_of((cells){"tap work dissipated", 1, energy}),
             bad = table_of((cells){"tap work", 4, energy});
    assert_ok(plot(1, &least, NULL, svg, &err));
    says((const char *[]){"\ntap\n", NULL});
    refuses(1, &bad, NULL, SP_EINVAL, "dissipated");
    sp_table_free(&t);
    sp_table_free(&least);
    sp_table_free(&bad);
}

static void test_others(void **state) {
    (void)state;
    sp_table other = table_of((cells){"p c_tof", 3, swing}), gap = table_of((cells){"t y0 y2", 3, swing});
    sp_table empty = table_of((cells){FIVE, 0, swing}), t = table_of((cells){FIVE, 9, swing});
    refuses(1, &other, NULL, SP_EINVAL, "");
    refuses(1, &gap, NULL, SP_EINVAL, "y1");
    refuses(1, &empty, NULL, SP_EREFUSED, "");
    const sp_table both[2] = {t, other};
    refuses(2, both, NULL, SP_EINVAL, "2");
    assert_int_equal(plot(1, &t, NULL, "a.gif", NULL), SP_EINVAL);
    sp_table_free(&other);
    sp_table_free(&gap);
    sp_table_free(&empty);
    sp_table_free(&t);
}

/* A lack of memory at any point is reported, and leaves no file. */
static void test_memory(void **state) {
    (void)state;
    sp_table t[2] = {table_of((cells){FIVE, 60, swing}), table_of((cells){BRANCHES, 100, branch})};
    for (int which = 0; which < 3; which++) {
        const sp_plot_column_options o = {.surface = which == 1};
        sp_status status = SP_ENOMEM;
        for (int64_t k = 0; status != SP_OK; k++) {
            assert_true(k < 200);
            sp_alloc_fail_after(k);
            status = plot(1, &t[which / 2], &o, svg, NULL);
            sp_alloc_fail_after(-1);
            assert_true(status == SP_OK || status == SP_ENOMEM);
            assert_int_equal(access(svg, F_OK), status == SP_OK ? 0 : -1);
        }
        remove(svg);
    }
    for (int k = 0; k < 2; k++)
        sp_table_free(&t[k]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_trajectory), cmocka_unit_test(test_long_trajectory), cmocka_unit_test(test_surfaces),
        cmocka_unit_test(test_colours),    cmocka_unit_test(test_strobe),          cmocka_unit_test(test_diagrams),
        cmocka_unit_test(test_million),    cmocka_unit_test(test_compare),         cmocka_unit_test(test_density),
        cmocka_unit_test(test_energy),     cmocka_unit_test(test_others),          cmocka_unit_test(test_memory)};
    return cmocka_run_group_tests(tests, setup, teardown);
}
