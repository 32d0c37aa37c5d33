/* Figures of curves in panels. */
#include "base/base.h"
#include "test.h"

#include <cairo/cairo.h>
#include <sonopack/figure/figure.h>
#include <unistd.h>

#if defined(__SANITIZE_ADDRESS__)
/* fontconfig, behind cairo, keeps offsets in place of pointers: the leak checker cannot see that its memory is held. */
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) { return "leak:libfontconfig"; }
const char *__lsan_default_options(void);
const char *__lsan_default_options(void) { return "print_suppressions=0"; }
#endif

static char folder[] = "/tmp/sonopack-sheet-XXXXXX", png[64], svg[64];

static int setup(void **state) {
    (void)state;
    if (!mkdtemp(folder))
        return 1;
    snprintf(png, sizeof png, "%s/a.png", folder);
    snprintf(svg, sizeof svg, "%s/a.svg", folder);
    return 0;
}

static int teardown(void **state) {
    (void)state;
    remove(png);
    remove(svg);
    return rmdir(folder);
}

/* ---- pictures --------------------------------------------------------------------------------------------------- */

typedef struct picture {
    cairo_surface_t *surface;
    int width, height;
} picture;

static picture draw(const sp_sheet *s) {
    sp_error err = {0};
    if (sp_plot_sheet(s, png, &err) != SP_OK)
        fail_msg("%s", err.text);
    picture p = {.surface = cairo_image_surface_create_from_png(png)};
    assert_int_equal(cairo_surface_status(p.surface), CAIRO_STATUS_SUCCESS);
    p.width = cairo_image_surface_get_width(p.surface);
    p.height = cairo_image_surface_get_height(p.surface);
    return p;
}

static uint32_t pixel(const picture *p, int x, int y) {
    uint32_t value;
    memcpy(&value, cairo_image_surface_get_data(p->surface) + y * cairo_image_surface_get_stride(p->surface) + 4 * x,
           4);
    return value & 0xffffff;
}

static int count(const picture *p, uint32_t colour) {
    int n = 0;
    for (int y = 0; y < p->height; y++)
        for (int x = 0; x < p->width; x++)
            n += pixel(p, x, y) == colour;
    return n;
}

static int64_t ink_of(const sp_sheet *s, uint32_t colour) {
    picture p = draw(s);
    const int n = count(&p, colour);
    cairo_surface_destroy(p.surface);
    return n;
}

static char *text_of(const sp_sheet *s) {
    sp_error err = {0};
    if (sp_plot_sheet(s, svg, &err) != SP_OK)
        fail_msg("%s", err.text);
    FILE *file = fopen(svg, "rb");
    assert_non_null(file);
    fseek(file, 0, SEEK_END);
    const size_t size = (size_t)ftell(file);
    rewind(file);
    char *text = calloc(size + 1, 1);
    assert_non_null(text);
    assert_int_equal(fread(text, 1, size, file), size);
    fclose(file);
    return text;
}

#define BLUE      0x0072b2
#define VERMILION 0xd55e00
#define GREEN     0x009e73

static sp_sheet one(const sp_panel *p) { return (sp_sheet){.title = "test", .rows = 1, .columns = 1, .panel = p}; }

/* ---- what is drawn ---------------------------------------------------------------------------------------------- */

/* With limits 0 to 1 given, marks at 0.25, 0.5 and 0.75 are evenly spaced, on both kinds of axes, and what lies
 * outside of the limits is not drawn. */
TEST(test_points_are_in_place) {
    for (int log = 0; log < 2; log++) {
        double x[5] = {.25, .5, .75, 1.5, .5}, y[5] = {.25, .5, .75, .5, -2};
        if (log)
            for (int k = 0; k < 5; k++) {
                x[k] = pow(10, x[k]);
                y[k] = pow(10, y[k]);
            }
        const double low = log ? 1 : 0, high = log ? 10 : 1;
        const sp_curve c = {.n = 5, .x = x, .y = y, .ink = 1, .dash = SP_DASH_NONE, .mark = SP_MARK_SQUARE};
        const sp_panel p = {.x = {"x", log, low, high}, .y = {"y", log, low, high}, .curves = 1, .curve = &c};
        const sp_sheet s = one(&p);
        picture a = draw(&s);
        double sum[3][3] = {{0}};
        int at[2] = {a.width, 0};
        for (int i = 0; i < a.width; i++)
            for (int j = 0; j < a.height; j++)
                if (pixel(&a, i, j) == BLUE) {
                    at[0] = i < at[0] ? i : at[0];
                    at[1] = i > at[1] ? i : at[1];
                }
        for (int i = 0; i < a.width; i++)
            for (int j = 0; j < a.height; j++)
                if (pixel(&a, i, j) == BLUE) {
                    const int k = (i - at[0]) * 3 / (at[1] - at[0] + 1);
                    sum[k][0] += i;
                    sum[k][1] += j;
                    sum[k][2]++;
                }
        for (int k = 0; k < 3; k++) {
            assert_true(sum[k][2] > 200 && sum[k][2] < 600); /* one mark of about 4.3 pt, at 300 dpi 18 pixels */
            sum[k][0] /= sum[k][2];
            sum[k][1] /= sum[k][2];
        }
        assert_close(sum[1][0] - sum[0][0], sum[2][0] - sum[1][0], 1);
        assert_close(sum[0][1] - sum[1][1], sum[1][1] - sum[2][1], 1);
        assert_true(sum[1][0] - sum[0][0] > 150 && sum[0][1] - sum[1][1] > 100);
        cairo_surface_destroy(a.surface);
    }
}

/* A line that leaves the limits ends at the frame: the ink of one ten times as long is the same. */
TEST(test_lines_are_clipped) {
    double x[2] = {0, 1}, y[2] = {.5, .5};
    const sp_curve c = {.n = 2, .x = x, .y = y, .ink = 1};
    const sp_panel p = {.x = {"x", false, 0, 1}, .y = {"y", false, 0, 1}, .curves = 1, .curve = &c};
    const sp_sheet s = one(&p);
    const int64_t ink = ink_of(&s, BLUE);
    x[0] = -5;
    x[1] = 5;
    assert_true(ink > 800);
    assert_int_equal(ink_of(&s, BLUE), ink);
    y[0] = y[1] = 7;
    assert_int_equal(ink_of(&s, BLUE), 0);
}

/* Steps of heights 1 and 3 over x = 0, 1, 2: the upper line lies at three times the height of the lower. */
TEST(test_steps) {
    const double x[3] = {0, 1, 2}, y[3] = {1, 3, 99};
    const sp_curve c = {.n = 3, .x = x, .y = y, .ink = 2, .steps = true};
    const sp_panel p = {.x = {"x", false, 0, 2}, .y = {"y", false, 0, 4}, .curves = 1, .curve = &c};
    const sp_sheet s = one(&p);
    picture a = draw(&s);
    int row[4] = {0}; /* pixels in quarters of the height that the steps span */
    int low = a.height, high = 0, left = a.width, right = 0;
    for (int i = 0; i < a.width; i++)
        for (int j = 0; j < a.height; j++)
            if (pixel(&a, i, j) == VERMILION) {
                low = j < low ? j : low;
                high = j > high ? j : high;
                left = i < left ? i : left;
                right = i > right ? i : right;
            }
    for (int i = left; i <= right; i++) {
        row[0] += pixel(&a, i, high - 1) == VERMILION;
        row[1] += pixel(&a, i, low + 1) == VERMILION;
        row[2] += pixel(&a, i, (low + high) / 2) == VERMILION;
    }
    assert_close(row[0], (right - left) / 2.0, 6);
    assert_close(row[1], (right - left) / 2.0, 6);
    assert_true(row[2] > 0 && row[2] < 8);
    cairo_surface_destroy(a.surface);
}

/* A gap is left open, a hollow mark has less ink than a full one, an error bar more, a band is lighter. */
TEST(test_gaps_marks_bars_bands) {
    double x[5] = {0, 1, 2, 3, 4}, y[5] = {1, 1, 1, 1, 1}, e[5] = {.2, .2, .2, .2, .2};
    const double lower[5] = {.5, .5, .5, .5, .5}, upper[5] = {1.5, 1.5, 1.5, 1.5, 1.5};
    sp_curve c = {.n = 5, .x = x, .y = y, .ink = 3};
    const sp_panel p = {.x = {"x", false, 0, 4}, .y = {"y", false, 0, 2}, .curves = 1, .curve = &c};
    const sp_sheet s = one(&p);
    const int64_t line = ink_of(&s, GREEN);
    y[2] = NAN;
    assert_close((double)ink_of(&s, GREEN), 0.5 * (double)line, 0.03 * (double)line);
    y[2] = INFINITY;
    assert_close((double)ink_of(&s, GREEN), 0.5 * (double)line, 0.03 * (double)line);
    y[2] = 1;
    c.mark = SP_MARK_CIRCLE;
    c.dash = SP_DASH_NONE;
    const int64_t full = ink_of(&s, GREEN);
    c.open = true;
    const int64_t open = ink_of(&s, GREEN);
    assert_true(open > 0 && open < full / 2);
    c.error = e;
    assert_true(ink_of(&s, GREEN) > open + 5 * 60); /* bars of 0.2 of 2 are some 100 pixels long */
    e[1] = NAN;                                     /* no bar there */
    assert_true(ink_of(&s, GREEN) > open);
    c = (sp_curve){.n = 5, .x = x, .y = y, .ink = 3, .dash = SP_DASH_NONE, .lower = lower, .upper = upper};
    assert_int_equal(ink_of(&s, GREEN), 0);
    picture a = draw(&s);
    int light = 0;
    for (int i = 0; i < a.width; i++)
        for (int j = 0; j < a.height; j++) /* 0.22 of the ink on white: 199, 234, 224 */
            light += abs((int)(pixel(&a, i, j) >> 16) - 199) < 3 && abs((int)(pixel(&a, i, j) & 0xff) - 224) < 3;
    assert_true(light > 100000);
    cairo_surface_destroy(a.surface);
}

/* ---- places ----------------------------------------------------------------------------------------------------- */

/* A curve through all corners of given limits leaves the legend no room within the frame: it goes above, and the
 * whole curve is still seen. An automatic axis makes room by growing. */
TEST(test_legend_hides_nothing) {
    enum { N = 4000 };
    double x[N], y[N];
    for (int k = 0; k < N; k++) {
        x[k] = (double)k / (N - 1);
        y[k] = 0.5 + 0.5 * sin(300 * x[k]);
    }
    for (int automatic = 0; automatic < 2; automatic++) {
        sp_curve c = {.n = N, .x = x, .y = y, .ink = 1, .width = 0.5};
        const sp_panel p = {
            .x = {"x", false, 0, 1}, .y = {"y", false, 0, automatic ? NAN : 1}, .tag = "(a)", .curves = 1, .curve = &c};
        const sp_sheet s = one(&p);
        picture a = draw(&s);
        c.label = "a wave";
        picture b = draw(&s);
        /* between a legend in the upper right corner and one above the middle of the frame: the curve alone */
        int top[2] = {a.height, a.height}, bottom[2] = {0, 0};
        for (int i = (int)(0.6 * a.width); i < 0.8 * a.width; i++)
            for (int j = 0; j < a.height; j++) {
                if (pixel(&a, i, j) == BLUE) {
                    top[0] = j < top[0] ? j : top[0];
                    bottom[0] = j > bottom[0] ? j : bottom[0];
                }
                if (pixel(&b, i, j) == BLUE) {
                    top[1] = j < top[1] ? j : top[1];
                    bottom[1] = j > bottom[1] ? j : bottom[1];
                }
            }
        assert_true(top[1] > top[0] + (automatic ? 4 : 25)); /* it has a little room above as it is */
        assert_close(bottom[1], bottom[0], 3);
        cairo_surface_destroy(a.surface);
        cairo_surface_destroy(b.surface);
    }
}

TEST(test_texts) {
    const double x[3] = {1, 2, 3}, y[3] = {1e-5, 2e-5, 3e-5};
    const sp_curve c = {.label = "|c|_{tof}", .n = 3, .x = x, .y = y, .ink = 1};
    const sp_panel inset = {.x = {"inner", true, NAN, NAN}, .y = {"depth", true, NAN, NAN}, .curves = 1, .curve = &c};
    const sp_panel p[2] = {{.tag = "(a)",
                            .x = {"|t|", .log = false},
                            .y = {.label = "|F|  [|E|* |d|^{2}]"},
                            .curves = 1,
                            .curve = &c,
                            .inset = &inset},
                           {.tag = "(b)", .x = {.label = NULL}, .y = {.label = "|A|"}, .curves = 1, .curve = &c}};
    const sp_sheet s = {.title = "a <title>", .rows = 2, .columns = 1, .panel = p};
    char *text = text_of(&s);
    static const char *const words[] = {"<title>a &lt;title&gt;</title>",
                                        "\n(a)\n",
                                        "\n(b)\n",
                                        "\ninner\n",
                                        "\ndepth\n",
                                        "\nc_tof\n",
                                        "\nF  [10^\xe2\x88\x92"
                                        "5 E* d^2]\n",
                                        "\nA  [10^\xe2\x88\x92"
                                        "5]\n"};
    for (size_t k = 0; k < sizeof words / sizeof *words; k++)
        if (!strstr(text, words[k]))
            fail_msg("no %s in %.900s", words[k], text);
    char *again = text_of(&s);
    assert_string_equal(text, again);
    free(text);
    free(again);
    picture a = draw(&s);
    assert_int_equal(a.width, 1016); /* 8.6 cm */
    assert_close(a.height, 2 * 0.75 * 1016, 1);
    cairo_surface_destroy(a.surface);
}

/* ---- odd and hostile -------------------------------------------------------------------------------------------- */

/* Nothing here may fail, hang, or draw outside of memory. */
TEST(test_odd_values) {
    static const double odd[][2] = {{1e308, -1e308},   {5e-324, 1e-323}, {1, 1},         {0, 0},
                                    {1e9, 1e9 + 1e-6}, {-3, NAN},        {1e-300, 1e300}};
    for (size_t k = 0; k < sizeof odd / sizeof *odd; k++)
        for (int log = 0; log < 2; log++) {
            if (log && !(odd[k][0] > 0 && odd[k][1] > 0))
                continue;
            const sp_curve c[2] = {{.label = "odd", .n = 2, .x = odd[k], .y = odd[k], .mark = SP_MARK_DIAMOND},
                                   {.label = "empty", .n = 0, .dash = SP_DASH_DASH_DOT, .ink = -1}};
            const sp_panel inset = {.x = {"x", .log = log}, .y = {"y", .log = log}, .curves = 2, .curve = c};
            const sp_panel p = {.x = {"x", .log = log},
                                .y = {"y", .log = log},
                                .curves = 2,
                                .curve = c,
                                .zero_line = true,
                                .inset = &inset};
            const sp_sheet s = one(&p);
            picture a = draw(&s);
            cairo_surface_destroy(a.surface);
        }
    /* one point, and limits of which it lies outside */
    const double v = 3;
    const sp_curve c = {.n = 1, .x = &v, .y = &v, .mark = SP_MARK_CIRCLE, .steps = true};
    const sp_panel p[4] = {{.x = {"x", false, 5, NAN}, .y = {"y", false, 0, 1}, .curves = 1, .curve = &c},
                           {.x = {"x", true, NAN, 9}, .y = {"y", true, NAN, 1}, .curves = 1, .curve = &c},
                           {.x = {NULL, true, 1, 10}, .y = {NULL, true, 1, 1e300}},
                           {.x = {"", false, -1e300, 1e300}, .y = {"", false, 1, 1 + 1e-12}}};
    const sp_sheet s = {.rows = 2, .columns = 2, .panel = p};
    sp_error err = {0};
    assert_int_equal(sp_plot_sheet(&s, png, &err), SP_EREFUSED); /* the only point is no step */
    /* values so far outside of the limits that their places overflow */
    const double x[3] = {1, 2, 3}, huge[3] = {1e300, -1e308, 1e-310}, bars[3] = {1e300, 1e308, 1e307};
    for (int power = -300; power <= 0; power += 10) {
        const sp_curve wild = {.label = "wild", .n = 3, .x = x, .y = huge, .error = bars, .mark = SP_MARK_CIRCLE};
        const sp_panel view = {.y = {"y", false, 0, pow(10, power)}, .curves = 1, .curve = &wild};
        const sp_sheet flat = one(&view);
        picture b = draw(&flat);
        cairo_surface_destroy(b.surface);
    }
    /* limits at the end of the range of numbers, and all points beyond them */
    const double some[2] = {1, 2};
    const sp_curve plain = {.n = 2, .x = some, .y = some};
    for (int log = 0; log < 2; log++) {
        const sp_panel far[2] = {
            {.x = {"x", log, 1.7e308, NAN}, .y = {"y", log, 1, 2}, .curves = 1, .curve = &plain},
            {.x = {"x", log, NAN, log ? 5e-324 : -1.7e308}, .y = {"y", log, 1, 2}, .curves = 1, .curve = &plain}};
        const sp_sheet ends = {.rows = 1, .columns = 2, .panel = far};
        picture b = draw(&ends);
        cairo_surface_destroy(b.surface);
    }
    const double two[2] = {3, 3};
    sp_curve pair = {.n = 2, .x = two, .y = two, .mark = SP_MARK_CIRCLE};
    sp_panel q[4];
    memcpy(q, p, sizeof p);
    q[0].curve = q[1].curve = &pair;
    const sp_sheet t = {.rows = 2, .columns = 2, .panel = q};
    picture a = draw(&t);
    cairo_surface_destroy(a.surface);
}

TEST(test_refusals) {
    const double x[3] = {1, 2, 3}, y[3] = {1, -2, 3}, e[3] = {.1, -.1, .1}, none[3] = {NAN, NAN, NAN};
    const sp_curve good = {.label = "good", .n = 3, .x = x, .y = x};
    const struct {
        sp_curve c;
        sp_axis x, y;
        sp_status status;
        const char *says;
    } cases[] = {{{.label = "g", .n = 3, .x = x, .y = y}, {0}, {.log = true}, SP_EREFUSED, "2 2 y -2"},
                 {{.n = 3, .x = y, .y = x}, {.log = true}, {0}, SP_EREFUSED, "2 2 x -2"},
                 {{.n = 3, .x = x, .y = x, .error = e}, {0}, {0}, SP_EREFUSED, "2 2 -0.1"},
                 {{.n = 3, .x = x}, {0}, {0}, SP_EINVAL, "2 3 points x y"},
                 {{.n = -1}, {0}, {0}, SP_EINVAL, "2 -1 points"},
                 {{.n = 3, .x = x, .y = x, .lower = x}, {0}, {0}, SP_EINVAL, "2"},
                 {{.n = 3, .x = x, .y = x, .ink = 7}, {0}, {0}, SP_EINVAL, "ink 7"},
                 {{.n = 3, .x = x, .y = x, .width = NAN}, {0}, {0}, SP_EINVAL, "width nan"},
                 {{.n = 3, .x = x, .y = x}, {NULL, false, 2, 1}, {0}, SP_EINVAL, "2 1 x"},
                 {{.n = 3, .x = x, .y = x}, {0}, {NULL, true, -1, 1}, SP_EINVAL, "-1 1 y"},
                 {{.n = 3, .x = x, .y = x}, {0}, {NULL, false, 0, INFINITY}, SP_EINVAL, "0 inf y"}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        const sp_curve c[2] = {good, cases[k].c};
        const sp_panel p = {.tag = "(q)", .x = cases[k].x, .y = cases[k].y, .curves = 2, .curve = c};
        const sp_sheet s = one(&p);
        sp_error why = {0};
        const sp_status status = sp_plot_sheet(&s, png, &why);
        if (status != cases[k].status || !test_names(why.text, cases[k].says))
            fail_msg("case %zu: %d %s", k, (int)status, why.text);
    }
    const sp_curve empty = {.n = 3, .x = x, .y = none};
    const sp_panel inset = {.curves = 1, .curve = &good, .inset = &inset};
    const sp_panel p[4] = {
        {.curves = 1, .curve = &empty}, {.curves = 2}, {.curves = 1, .curve = &good, .inset = &inset}};
    sp_sheet s = one(&p[0]);
    assert_fails(sp_plot_sheet(&s, png, &err), SP_EREFUSED, "1");
    s.panel = &p[1];
    assert_fails(sp_plot_sheet(&s, png, &err), SP_EINVAL, "2 NULL");
    s.panel = &p[2];
    assert_fails(sp_plot_sheet(&s, png, &err), SP_EINVAL, "");
    s.panel = NULL;
    assert_fails(sp_plot_sheet(&s, png, &err), SP_EINVAL, "NULL");
    s.panel = p;
    s.rows = 0;
    assert_fails(sp_plot_sheet(&s, png, &err), SP_EINVAL, "0");
    s.rows = 1;
    s.width = -1;
    assert_fails(sp_plot_sheet(&s, png, &err), SP_EINVAL, "width -1");
    s.width = 10;
    assert_fails(sp_plot_sheet(&s, png, &err), SP_EINVAL, "10");
    s.width = 100;
    const sp_panel small = {.curves = 1, .curve = &good, .inset = &p[2]}, flat = {.curves = 1, .curve = &good};
    const sp_panel tiny = {.curves = 1, .curve = &good, .inset = &flat};
    s.panel = &tiny;
    assert_fails(sp_plot_sheet(&s, png, &err), SP_EINVAL, "");
    s.panel = &small;
    s.width = 0;
    assert_fails(sp_plot_sheet(&s, "a.bmp", &err), SP_EINVAL, ".png .svg .pdf");
    assert_fails(sp_plot_sheet(&s, NULL, &err), SP_EINVAL, "");
}

TEST(test_memory) {
    const double x[3] = {1, 2, 3};
    const sp_curve c = {.label = "c", .n = 3, .x = x, .y = x};
    const sp_panel inset = {.curves = 1, .curve = &c}, p = {.curves = 1, .curve = &c, .inset = &inset};
    const sp_sheet s = one(&p);
    int64_t k = 0;
    for (;; k++) {
        sp_error err = {0};
        sp_alloc_fail_after(k);
        const sp_status status = sp_plot_sheet(&s, svg, &err);
        sp_alloc_fail_after(-1);
        if (status == SP_OK)
            break;
        assert_int_equal(status, SP_ENOMEM);
    }
    assert_true(k > 10);
}

RUN_TESTS(setup, teardown)
