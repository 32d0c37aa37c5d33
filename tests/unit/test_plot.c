#include "base/base.h"
#include "figure/markup.h"
#include "test.h"

#include <cairo/cairo.h>
#include <dirent.h>
#include <locale.h>
#include <sonopack/figure/plot.h>
#include <sonopack/study/store.h>
#include <stdbool.h>
#include <sys/stat.h>
#include <unistd.h>

#if defined(__SANITIZE_ADDRESS__)
/* fontconfig, behind cairo, keeps offsets in place of pointers: the leak checker cannot see that its memory is held. */
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) { return "leak:libfontconfig"; }
const char *__lsan_default_options(void);
const char *__lsan_default_options(void) { return "print_suppressions=0"; }
#endif

static char folder[] = "/tmp/sonopack-plot-XXXXXX";

/* A path in the test's folder, of a few that live at the same time. */
static const char *in_folder(const char *name) {
    static char path[4][256];
    static int turn;
    turn = (turn + 1) % 4;
    snprintf(path[turn], sizeof path[turn], "%s/%s", folder, name);
    return path[turn];
}

static int files_in_folder(void) {
    int count = 0;
    DIR *dir = opendir(folder);
    assert_non_null(dir);
    for (const struct dirent *entry; (entry = readdir(dir)) != NULL;)
        count += strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0;
    closedir(dir);
    return count;
}

static char *read_file(const char *path, size_t *size) {
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    fseek(file, 0, SEEK_END);
    *size = (size_t)ftell(file);
    rewind(file);
    char *data = malloc(*size + 1);
    assert_non_null(data);
    assert_int_equal(fread(data, 1, *size, file), *size);
    data[*size] = '\0';
    fclose(file);
    return data;
}

static int setup(void **state) {
    (void)state;
    return mkdtemp(folder) ? 0 : 1;
}

static int clear(void **state) {
    (void)state;
    DIR *dir = opendir(folder);
    for (const struct dirent *entry; (entry = readdir(dir)) != NULL;)
        if (entry->d_name[0] != '.' || strlen(entry->d_name) > 2)
            remove(in_folder(entry->d_name));
    closedir(dir);
    return 0;
}

static int teardown(void **state) {
    clear(state);
    return rmdir(folder);
}

/* ---- pictures --------------------------------------------------------------------------------------------------- */

typedef struct picture {
    cairo_surface_t *surface;
    const unsigned char *data;
    int width, height, stride;
} picture;

static picture open_picture(const char *path) {
    picture p = {.surface = cairo_image_surface_create_from_png(path)};
    assert_int_equal(cairo_surface_status(p.surface), CAIRO_STATUS_SUCCESS);
    p.data = cairo_image_surface_get_data(p.surface);
    p.width = cairo_image_surface_get_width(p.surface);
    p.height = cairo_image_surface_get_height(p.surface);
    p.stride = cairo_image_surface_get_stride(p.surface);
    return p;
}

/* 0xRRGGBB; white outside. */
static uint32_t pixel(const picture *p, int x, int y) {
    uint32_t value;
    if (x < 0 || y < 0 || x >= p->width || y >= p->height)
        return 0xffffff;
    memcpy(&value, p->data + y * p->stride + 4 * x, 4);
    return value & 0xffffff;
}

/* Centre of the next blob of at least `least` pixels of one colour from *at on in the order of rows; pixels within
 * `reach` of its first belong to it. False behind the last. */
static bool next_blob(const picture *p, uint32_t colour, int least, int reach, bool *seen, int *at, double centre[2]) {
    for (; *at < p->width * p->height; ++*at) {
        const int x0 = *at % p->width, y0 = *at / p->width;
        if (seen[*at] || pixel(p, x0, y0) != colour)
            continue;
        double sum[2] = {0, 0};
        int count = 0;
        for (int y = y0; y <= y0 + reach; y++)
            for (int x = x0 - reach; x <= x0 + reach; x++)
                if (pixel(p, x, y) == colour) {
                    seen[y * p->width + x] = true;
                    sum[0] += x;
                    sum[1] += y;
                    count++;
                }
        if (count >= least) {
            centre[0] = sum[0] / count;
            centre[1] = sum[1] / count;
            return true;
        }
    }
    return false;
}

/* The frame: the first and the last row and column that are dark over more than 0.7 of the picture. */
typedef struct frame {
    int left, right, top, bottom;
} frame;

static frame find_frame(const picture *p) {
    frame f = {-1, -1, -1, -1};
    for (int x = 0; x < p->width; x++) {
        int dark = 0;
        for (int y = 0; y < p->height; y++)
            dark += pixel(p, x, y) == 0;
        if (dark > 0.7 * p->height) {
            f.left = f.left < 0 ? x : f.left;
            f.right = x;
        }
    }
    for (int y = 0; y < p->height; y++) {
        int dark = 0;
        for (int x = 0; x < p->width; x++)
            dark += pixel(p, x, y) == 0;
        if (dark > 0.7 * p->width) {
            f.top = f.top < 0 ? y : f.top;
            f.bottom = y;
        }
    }
    assert_true(f.left >= 0 && f.right > f.left && f.bottom > f.top);
    return f;
}

/* ---- tables ----------------------------------------------------------------------------------------------------- */

enum { COLUMNS = 5 };
static const double reference[4][COLUMNS] = {{1e-4, .266, .004, .189, .0905},
                                             {1e-5, .175, .003, .121, .0487},
                                             {1e-6, .123, .002, .0811, .0308},
                                             {1e-7, .0849, .0011, .0539, .0185}};

static sp_table table_of(int rows, const double (*value)[COLUMNS]) {
    static const char *const name[] = {"p", "c_tof", "c_tof_err", "c_l", "c_t"};
    sp_table t = sp_table_none();
    for (int c = 0; c < COLUMNS; c++)
        sp_table_add_column(&t, name[c], "", SP_COLUMN_NUMBER, NULL);
    for (int r = 0; r < rows; r++)
        sp_table_add_row(&t, NULL, value[r][0], value[r][1], value[r][2], value[r][3], value[r][4]);
    return t;
}

static sp_status plot_rows(int rows, const double (*value)[COLUMNS], const char *path, sp_error *err) {
    sp_table t = table_of(rows, value);
    sp_table_add_comment(&t, NULL, "dimension = 2, friction = 0.5");
    sp_status status = sp_plot_ctof(&t, path, err);
    sp_table_free(&t);
    return status;
}

/* The filled circles of c_tof lie where a doubly logarithmic map puts them: two of the four fix the map. */
static void test_points_are_where_the_data_are(void **state) {
    (void)state;
    assert_ok(plot_rows(4, reference, in_folder("ctof.png"), &err));
    picture p = open_picture(in_folder("ctof.png"));
    assert_int_equal(p.width, 1016); /* 8.6 cm at 300 dpi */
    bool *seen = calloc((size_t)(p.width * p.height), 1);
    double centre[8][2];
    int at = 0, blobs = 0;
    /* Okabe and Ito's blue; a circle of 2.4 pt covers 310 pixels, error bars and caps far fewer */
    while (blobs < 8 && next_blob(&p, 0x0072b2, 200, 24, seen, &at, centre[blobs]))
        blobs++;
    assert_int_equal(blobs, 5);
    /* p = 1e-4, 1e-5, ... downwards, as c falls; the lowest is the legend's, in the free corner below them */
    double per_decade = (centre[0][0] - centre[3][0]) / 3;
    double scale = (centre[3][1] - centre[0][1]) / log(reference[0][1] / reference[3][1]);
    assert_true(per_decade > 100 && scale > 50);
    for (int k = 0; k < 4; k++) {
        assert_close(centre[k][0], centre[0][0] - k * per_decade, 1.0);
        assert_close(centre[k][1], centre[0][1] + scale * log(reference[0][1] / reference[k][1]), 1.0);
    }
    assert_true(centre[0][1] < 0.25 * p.height); /* no half of the figure is left to the legend */
    free(seen);
    cairo_surface_destroy(p.surface);
}

static void test_png_says_its_resolution(void **state) {
    (void)state;
    size_t size;
    assert_ok(plot_rows(4, reference, in_folder("a.PNG"), &err));
    char *data = read_file(in_folder("a.PNG"), &size);
    assert_memory_equal(data + 37, "pHYs\0\0\x2e\x23\0\0\x2e\x23\1", 13); /* 11811 pixels a metre */
    free(data);
}

/* A triangular pulse without marks or label: the ink is a black line from the zero line to the middle and back. */
static void test_signal_follows_its_data(void **state) {
    (void)state;
    enum { N = 1001 };
    double t[N], f[N];
    for (int k = 0; k < N; k++) {
        t[k] = 0.1 * k;
        f[k] = 3e-3 * (1 - fabs(k - 500.0) / 500);
    }
    const sp_plot_trace trace = {NULL, N, t, f, NAN, NAN, NAN, NULL, NULL, NULL};
    assert_ok(sp_plot_signal(1, &trace, in_folder("pulse.png"), &err));
    picture p = open_picture(in_folder("pulse.png"));
    frame at = find_frame(&p);
    double height[9];
    for (int k = 1; k < 8; k++) {
        int x = at.left + (int)lround(k * (at.right - at.left) / 8.0), count = 0;
        height[k] = 0;
        for (int y = at.top + 25; y < at.bottom - 25; y++)
            if ((pixel(&p, x, y) & 0xff) < 0x40) {
                height[k] += y;
                count++;
            }
        assert_true(count > 2);
        height[k] /= count;
    }
    for (int k = 1; k < 4; k++) {
        assert_close(height[k], height[8 - k], 2.5);
        assert_close(height[k + 1] - height[k], height[2] - height[1], 3.0);
    }
    assert_true(height[1] - height[4] > 0.5 * (at.bottom - at.top));
    cairo_surface_destroy(p.surface);
}

/* Points that share a column of the picture are drawn as their extremes: one point of 200000 is still seen. */
static void test_dense_signal_keeps_its_spikes(void **state) {
    (void)state;
    enum { N = 200000 };
    double *t = malloc(2 * N * sizeof *t), *f = t + N;
    assert_non_null(t);
    for (int k = 0; k < N; k++) {
        t[k] = k;
        f[k] = k == N / 2 + 7 ? 1 : k == N / 4 + 3 ? -1 : 0;
    }
    const sp_plot_trace trace = {NULL, N, t, f, NAN, NAN, NAN, NULL, NULL, NULL};
    assert_ok(sp_plot_signal(1, &trace, in_folder("spikes.png"), &err));
    free(t);
    picture p = open_picture(in_folder("spikes.png"));
    frame at = find_frame(&p);
    const int middle = (at.top + at.bottom) / 2, quarter = (at.bottom - at.top) / 4;
    double up = 0, down = 0; /* where the darkest pixels half way up and down are */
    int counts[2] = {0, 0};
    for (int x = at.left + 25; x < at.right - 25; x++) {
        if ((pixel(&p, x, middle - quarter) & 0xff) < 0x80) {
            up += x;
            counts[0]++;
        }
        if ((pixel(&p, x, middle + quarter) & 0xff) < 0x80) {
            down += x;
            counts[1]++;
        }
    }
    assert_true(counts[0] > 0 && counts[1] > 0);
    assert_close(up / counts[0], 0.5 * (at.left + at.right), 3);
    assert_close(down / counts[1], at.left + 0.25 * (at.right - at.left), 3);
    cairo_surface_destroy(p.surface);
}

/* ---- vector formats --------------------------------------------------------------------------------------------- */

static void same_bytes_twice(const char *one, const char *two) {
    size_t size_one, size_two;
    char *a = read_file(one, &size_one), *b = read_file(two, &size_two);
    assert_int_equal(size_one, size_two);
    assert_memory_equal(a, b, size_one);
    free(a);
    free(b);
}

static void test_svg_holds_labels_and_repeats(void **state) {
    (void)state;
    size_t size;
    assert_ok(plot_rows(4, reference, in_folder("one.svg"), &err));
    assert_ok(plot_rows(2, reference, in_folder("other.svg"), &err));
    assert_ok(plot_rows(4, reference, in_folder("two.svg"), &err));
    same_bytes_twice(in_folder("one.svg"), in_folder("two.svg"));
    char *text = read_file(in_folder("one.svg"), &size);
    assert_non_null(strstr(text, "c_tof ~ p^0.16"));
    assert_non_null(strstr(text, "\nc_l\n"));
    assert_non_null(strstr(text, "\nc_t\n"));
    assert_non_null(strstr(text, "10^" MINUS "7\n"));
    assert_non_null(strstr(text, "Somfai et al."));
    assert_non_null(strstr(text, "width=\"243.77")); /* 8.6 cm in points */
    free(text);
    text = read_file(in_folder("other.svg"), &size);
    assert_non_null(strstr(text, "\nc_tof\n")); /* two points have no exponent */
    free(text);
}

static void test_pdf_repeats(void **state) {
    (void)state;
    size_t size;
    assert_ok(plot_rows(4, reference, in_folder("one.pdf"), &err));
    assert_ok(plot_rows(4, reference, in_folder("two.pdf"), &err));
    same_bytes_twice(in_folder("one.pdf"), in_folder("two.pdf"));
    char *data = read_file(in_folder("one.pdf"), &size);
    assert_memory_equal(data, "%PDF-", 5);
    assert_null(memmem(data, size, "CreationDate", 12));
    assert_non_null(memmem(data, size, "Sound speeds against pressure", 29));
    assert_non_null(memmem(data + size - 8, 8, "%%EOF", 5));
    free(data);
}

static void test_exponent_of_the_table_comes_first(void **state) {
    (void)state;
    size_t size;
    sp_table t = table_of(4, reference);
    assert_ok(sp_table_add_comment(&t, &err, "exponent = 0.1712"));
    assert_ok(sp_table_add_comment(&t, &err, "exponent_err = 0.023"));
    assert_ok(sp_plot_ctof(&t, in_folder("given.svg"), &err));
    sp_table_free(&t);
    char *text = read_file(in_folder("given.svg"), &size);
    assert_non_null(strstr(text, "c_tof ~ p^0.17(2)\n"));
    free(text);
}

/* Pixels of one colour in a column above and below a point, in a row without gaps. */
static int run_of(const picture *p, uint32_t colour, int x, int y) {
    int count = 0;
    for (int step = -1; step <= 1; step += 2)
        for (int k = y + (step > 0); pixel(p, x, k) == colour; k += step)
            count++;
    return count;
}

/* c_l has bars as long as its errors are: of half its value ln(1.5/0.5) in the scale of the points, and of 0.1 less. */
static void test_bars_of_long_waves(void **state) {
    (void)state;
    static const double part[2] = {0.5, 0.3};
    int length[2];
    for (int q = 0; q < 2; q++) {
        sp_table t = sp_table_none();
        static const char *const name[] = {"p", "c_tof", "c_l", "c_l_err"};
        for (int c = 0; c < 4; c++)
            assert_ok(sp_table_add_column(&t, name[c], "", SP_COLUMN_NUMBER, &err));
        for (int r = 0; r < 3; r++) { /* ranges that the bars do not change */
            const double c = r == 1 ? 0.1 : r == 0 ? 0.01 : 1;
            assert_ok(sp_table_add_row(&t, &err, pow(10, r - 7), c, r == 1 ? 0.1 : NAN, part[q] * 0.1));
        }
        assert_ok(sp_plot_ctof(&t, in_folder("bars.png"), &err));
        sp_table_free(&t);
        picture p = open_picture(in_folder("bars.png"));
        length[q] = 0;
        for (int y = 0; y < p.height; y++)
            for (int x = 0; x < p.width; x++)
                if (pixel(&p, x, y) == 0xd55e00) {
                    const int run = run_of(&p, 0xd55e00, x, y);
                    length[q] = run > length[q] ? run : length[q];
                }
        cairo_surface_destroy(p.surface);
    }
    /* the run is the part of the bar outside of the hollow mark */
    assert_true(length[1] > 10 && length[0] > length[1] + 10);
}

/* An exact power law: the fit's exponent is exact, and its error, rounding, is left out. */
static void test_exponent_is_fitted(void **state) {
    (void)state;
    size_t size;
    double value[5][COLUMNS];
    for (int k = 0; k < 5; k++) {
        value[k][0] = pow(10, -3 - k);
        value[k][1] = pow(value[k][0], 0.25);
        value[k][2] = value[k][3] = value[k][4] = NAN;
    }
    assert_ok(plot_rows(5, value, in_folder("fit.svg"), &err));
    char *text = read_file(in_folder("fit.svg"), &size);
    assert_non_null(strstr(text, "c_tof ~ p^0.250\n"));
    assert_null(strstr(text, "\nc_l\n")); /* a column without a number is not in the legend */
    free(text);
}

/* The axes claim sonopack's units for sonopack's signals only. */
static void test_units(void **state) {
    (void)state;
    const double t[3] = {0, 1, 2}, f[3] = {0, 1, 0};
    static const struct {
        const char *unit[2][2]; /* of two traces: t, F */
        const char *x, *y;
    } cases[] = {{{{NULL, NULL}, {NULL, NULL}}, "\nt  [d (", "\nF_sig  [E"},
                 {{{"s", "N"}, {"s", "N"}}, "\nt  [s]\n", "\nF  [N]\n"},
                 {{{"s", "N"}, {"s", ""}}, "\nt  [s]\n", "\nF\n"},
                 {{{"", ""}, {NULL, NULL}}, "\nt\n", "\nF\n"},
                 {{{"", ""}, {"", ""}}, "\nt\n", "\nF\n"},
                 {{{"|m|^_{s}", ""}, {"|m|^_{s}", ""}}, "\nt  [|m|^_{s}]\n", "\nF\n"}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        sp_plot_trace trace[2];
        for (int j = 0; j < 2; j++)
            trace[j] = (sp_plot_trace){"x", 3, t, f, 0.1, 1, 2, cases[k].unit[j][0], cases[k].unit[j][1], NULL};
        assert_ok(sp_plot_signal(2, trace, in_folder("units.svg"), &err));
        size_t size;
        char *text = read_file(in_folder("units.svg"), &size);
        if (!strstr(text, cases[k].x) || !strstr(text, cases[k].y))
            fail_msg("case %zu: %.400s", k, text);
        free(text);
    }
}

/* File names of any bytes in the legend: still well-formed, shortened, signs of markup and XML kept. */
static void test_hostile_labels(void **state) {
    (void)state;
    const double t[3] = {0, 1, 2}, f[3] = {0, 1, 0};
    static const char *const label[] = {"a<b>&c|d_{e}^\\",
                                        "\xff\xfe\xc0\x80\xed\xa0\x80\xf8\xfc\x80\x80\x80",
                                        "tab\tend\n",
                                        "",
                                        "a name of very many characters that nobody can want to read in a legend",
                                        "\xef\xbf\xbf\xef\xb7\x90\xf4\x90\x80\x80",
                                        "\xf0\x9d\x94\xbb"};
    sp_plot_trace trace[7];
    for (int k = 0; k < 7; k++)
        trace[k] = (sp_plot_trace){label[k], 3, t, f, 0.1, 1, 2, NULL, NULL, NULL};
    static const char *const name[] = {"odd.svg", "odd.png", "odd.pdf"};
    for (int k = 0; k < 3; k++)
        assert_ok(sp_plot_signal(7, trace, in_folder(name[k]), &err));
    size_t size;
    char *text = read_file(in_folder("odd.svg"), &size);
    assert_non_null(strstr(text, "\na&lt;b&gt;&amp;c|d_{e}^\\\n"));
    assert_non_null(strstr(text, "\ntab end \n"));
    assert_null(strstr(text, "nobody"));
    assert_non_null(strstr(text, "t_10"));
    for (size_t k = 0; k < size; k++)
        assert_true((unsigned char)text[k] != 0xff && (unsigned char)text[k] != 0xfe);
    free(text);
}

static void test_markup_of_numbers(void **state) {
    (void)state;
    char out[64];
    static const struct {
        double value;
        int digits;
        const char *text;
    } number[] = {{0.0331, 3, "0.0331"},
                  {1.234e-4, 3,
                   "1.23\xc3\x97"
                   "10^{" MINUS "4}"},
                  {1e-7, 1, "10^{" MINUS "7}"},
                  {-5e6, 2,
                   MINUS "5\xc3\x97"
                         "10^{6}"},
                  {9.9996e-5, 3, "10^{" MINUS "4}"},
                  {0, 3, "0"},
                  {20000, 3, "20000"},
                  {-0.5, 3, MINUS "0.5"}};
    for (size_t k = 0; k < sizeof number / sizeof *number; k++) {
        sp_figure_text_number(out, sizeof out, number[k].value, number[k].digits);
        assert_string_equal(out, number[k].text);
    }
    static const struct {
        double value, error;
        const char *text;
    } measured[] = {{0.1656, 0.0042, "0.166(4)"}, {0.1656, 0.0012, "0.1656(12)"}, {0.1656, NAN, "0.166"},
                    {-0.1, 0.3, MINUS "0.1(3)"},  {0.1656, 0, "0.166"},           {2, 5, "2.000"}};
    for (size_t k = 0; k < sizeof measured / sizeof *measured; k++) {
        sp_figure_text_measured(out, sizeof out, measured[k].value, measured[k].error);
        assert_string_equal(out, measured[k].text);
    }
    sp_figure_text_escape(out, sizeof out, "abcdefghij", 6);
    assert_string_equal(out, "abc\xe2\x80\xa6ij");
    sp_figure_text_escape(out, 12, "||||||||||||", 100); /* never past its end */
    assert_true(strlen(out) < 12);
}

/* ---- packings --------------------------------------------------------------------------------------------------- */

/* Two grains side by side across the periodic edge of a box 4 wide and 1 high, each between both walls. */
static sp_packing pair_across_the_edge(void) {
    sp_error err;
    sp_packing p = sp_packing_none();
    assert_int_equal(sp_packing_alloc(&p, 2, 2, 5, &err), SP_OK);
    p.box[0] = 4;
    p.box[1] = 1 - 2e-3;
    p.box[2] = 1;
    p.pressure = 1e-4;
    p.friction = 0.5;
    const double x[2] = {0.4, 3.4 + 1e-3};
    for (int i = 0; i < 2; i++) {
        p.x[3 * i] = x[i];
        p.x[3 * i + 1] = 0.5 - 1e-3;
        p.r[i] = 0.5;
    }
    const sp_contact contact[5] = {{.i = 0, .j = 1, .n = {-1, 0, 0}, .overlap = 1e-3, .fn = 2e-4},
                                   {.i = 0, .j = SP_BOTTOM, .n = {0, -1, 0}, .overlap = 1e-3, .fn = 2e-4},
                                   {.i = 1, .j = SP_BOTTOM, .n = {0, -1, 0}, .overlap = 1e-3, .fn = 2e-4},
                                   {.i = 0, .j = SP_TOP, .n = {0, 1, 0}, .overlap = 1e-3, .fn = 2e-4},
                                   {.i = 1, .j = SP_TOP, .n = {0, 1, 0}, .overlap = 1e-3, .fn = 2e-4}};
    memcpy(p.contacts, contact, sizeof contact);
    assert_int_equal(sp_packing_check(&p, &err), SP_OK);
    return p;
}

/* The contact across the edge is drawn at both edges, at the height of the centres, and nowhere between. */
static void test_contact_across_the_periodic_edge(void **state) {
    (void)state;
    const uint32_t blue = 0x0072b2;
    sp_packing p = pair_across_the_edge();
    assert_ok(sp_plot_network(&p, SP_PLOT_FORCES, 1e-4, in_folder("edge.png"), &err));
    sp_packing_free(&p);
    picture a = open_picture(in_folder("edge.png"));
    int walls[2] = {-1, -1}; /* inner edges of the two dark bars */
    for (int y = 0; y < a.height; y++)
        if (pixel(&a, a.width / 2, y) == 0x404040) {
            if (walls[0] < 0 || y == walls[0] + 1)
                walls[0] = y;
            else if (walls[1] < 0)
                walls[1] = y;
        }
    assert_true(walls[0] > 0 && walls[1] > walls[0]);
    const int middle = (walls[0] + walls[1]) / 2, margin = 13; /* 3 pt and the dashes of the edge */
    double d = (a.width - 2 * margin) / 4.0;
    assert_close(walls[1] - walls[0], d * (1 - 2e-3), 3);
    assert_int_equal(pixel(&a, margin + (int)(0.2 * d), middle), blue);
    assert_int_equal(pixel(&a, a.width - margin - (int)(0.2 * d), middle), blue);
    assert_int_not_equal(pixel(&a, margin + (int)(0.7 * d), middle), blue);
    assert_int_not_equal(pixel(&a, a.width / 2, middle), blue);
    /* and to the walls */
    assert_int_equal(pixel(&a, margin + (int)(0.4 * d), walls[0] + 5), blue);
    assert_int_equal(pixel(&a, margin + (int)(3.4 * d), walls[1] - 5), blue);
    /* the image of the left grain beyond the right edge: its rim passes 0.1 d left of it */
    bool rim = false;
    for (int x = -4; x <= 4; x++)
        rim = rim || pixel(&a, a.width - margin - (int)(0.1 * d) + x, middle + (int)(0.15 * d)) != 0xffffff;
    assert_true(rim);
    cairo_surface_destroy(a.surface);
}

static void test_rattlers_and_strength(void **state) {
    (void)state;
    const uint32_t grey = 0xb8b8b8;
    sp_packing p = pair_across_the_edge();
    for (int k = 0; k < 5; k++)
        p.contacts[k].fn = 1e-12; /* nothing carries */
    assert_ok(sp_plot_network(&p, SP_PLOT_FORCES, 1e-4, in_folder("loose.svg"), &err));
    assert_ok(sp_plot_network(&p, SP_PLOT_FORCES, 1e-4, in_folder("loose.png"), &err));
    sp_packing_free(&p);
    size_t size;
    char *text = read_file(in_folder("loose.svg"), &size);
    assert_non_null(strstr(text, "2 rattlers"));
    assert_null(strstr(text, "mean F"));
    free(text);
    picture a = open_picture(in_folder("loose.png"));
    assert_int_equal(pixel(&a, (int)(0.85 * a.width), a.height / 3), grey);
    cairo_surface_destroy(a.surface);
    /* k_n = 2 E12 sqrt(R12 overlap): 1 sqrt(1e-3/4) between the grains and 2 sqrt(1e-3/2) at the four walls */
    p = pair_across_the_edge();
    assert_ok(sp_plot_network(&p, SP_PLOT_STIFFNESS, 1e-4, in_folder("stiff.svg"), &err));
    sp_packing_free(&p);
    char expected[64], number[32];
    sp_figure_text_number(number, sizeof number, (sqrt(1e-3 / 4) + 8 * sqrt(1e-3 / 2)) / 5, 3);
    snprintf(expected, sizeof expected, "mean k_n = %s E*d\n", number);
    text = read_file(in_folder("stiff.svg"), &size);
    assert_non_null(strstr(text, expected));
    free(text);
}

static void test_other_dimensions(void **state) {
    (void)state;
    sp_pack_spec spec = sp_pack_spec_default();
    sp_packing p = sp_packing_none();
    spec.kind = SP_PACK_CHAIN;
    spec.dim = 1;
    spec.grains = 300;
    spec.friction = 0;
    assert_ok(sp_packing_make(&spec, NULL, NULL, &p, &err));
    assert_ok(sp_plot_network(&p, SP_PLOT_FORCES, 1e-4, in_folder("chain.png"), &err));
    sp_packing_free(&p);
    assert_ok(sp_packing_alloc(&p, 3, 1, 0, &err));
    p.box[0] = p.box[1] = p.box[2] = 4;
    p.x[0] = p.x[1] = p.x[2] = 2;
    p.r[0] = 0.5;
    p.pressure = 1e-4;
    assert_ok(sp_plot_network(&p, SP_PLOT_FORCES, 1e-4, in_folder("d3.png"), &err));
    remove(in_folder("d3.png"));
    p.r[0] = NAN;
    assert_fails(sp_plot_network(&p, SP_PLOT_FORCES, 1e-4, in_folder("d3.png"), &err), SP_EFORMAT, "radius");
    sp_packing_free(&p);
    assert_int_equal(access(in_folder("d3.png"), F_OK), -1);
}

/* ---- refusals --------------------------------------------------------------------------------------------------- */

static void test_refused_tables_leave_no_file(void **state) {
    (void)state;
    const double nan_row[][COLUMNS] = {{1e-4, NAN, NAN, NAN, NAN}, {NAN, .2, .1, .1, .1}};
    const double negative[][COLUMNS] = {{1e-4, .2, NAN, -.1, NAN}};
    const double zero[][COLUMNS] = {{0, .2, NAN, .1, NAN}};
    const double infinite[][COLUMNS] = {{1e-4, INFINITY, NAN, .1, NAN}};
    const double bad_error[][COLUMNS] = {{1e-4, .2, -.1, .1, NAN}};
    const char *path = in_folder("never.png");
    assert_fails(plot_rows(0, reference, path, &err), SP_EREFUSED, "");
    assert_fails(plot_rows(2, nan_row, path, &err), SP_EREFUSED, "2");
    assert_fails(plot_rows(1, negative, path, &err), SP_EREFUSED, "1 c_l -0.1");
    assert_fails(plot_rows(1, zero, path, &err), SP_EREFUSED, "1 p 0");
    assert_fails(plot_rows(1, infinite, path, &err), SP_EREFUSED, "1 c_tof inf");
    assert_fails(plot_rows(1, bad_error, path, &err), SP_EREFUSED, "c_tof_err -0.1");
    sp_table t = sp_table_none();
    assert_fails(sp_plot_ctof(&t, path, &err), SP_EINVAL, "p");
    assert_ok(sp_table_add_column(&t, "p", "", SP_COLUMN_NUMBER, &err));
    assert_ok(sp_table_add_column(&t, "c_tof", "", SP_COLUMN_TEXT, &err));
    assert_ok(sp_table_add_row(&t, &err, 1e-4, "fast"));
    assert_fails(sp_plot_ctof(&t, path, &err), SP_EINVAL, "c_tof");
    sp_table_free(&t);
    const double time[2] = {NAN, 1}, force[2] = {1, INFINITY};
    sp_plot_trace trace = {"x", 2, time, force, NAN, NAN, NAN, NULL, NULL, NULL};
    assert_fails(sp_plot_signal(1, &trace, path, &err), SP_EREFUSED, "1");
    trace.n = 0;
    assert_fails(sp_plot_signal(1, &trace, path, &err), SP_EREFUSED, "");
    trace.n = -1;
    assert_fails(sp_plot_signal(1, &trace, path, &err), SP_EINVAL, "-1 points");
    assert_fails(sp_plot_signal(0, &trace, path, &err), SP_EINVAL, "0");
    assert_int_equal(files_in_folder(), 0);
}

/* What is odd but can be drawn. */
static void test_extreme_data_are_drawn(void **state) {
    (void)state;
    const double wide[][COLUMNS] = {
        {5e-324, 1e-300, NAN, NAN, NAN}, {1, .3, .2, .2, .1}, {1.7e308, 1.7e308, 1e308, 1, 1}};
    const double over[][COLUMNS] = {{1e-4, .2, 5, NAN, NAN}, {1e-4, .2, 0, NAN, NAN}, {1e-4, .21, NAN, NAN, NAN}};
    assert_ok(plot_rows(1, reference, in_folder("one.png"), &err));
    assert_ok(plot_rows(3, wide, in_folder("wide.svg"), &err));
    assert_ok(plot_rows(3, over, in_folder("over.svg"), &err));
    static const double scale[] = {0, 1, 1e-320, 1e308, -1e308, 1e-9};
    static const double start[] = {0, -5, 1e308, 1e15, 5e-324, 1e9};
    for (int k = 0; k < 6; k++) {
        double t[5], f[5];
        for (int i = 0; i < 5; i++) {
            t[i] = start[k] + i;
            f[i] = scale[k] * (i % 2 ? 1 : -1);
        }
        f[3] = NAN; /* a gap */
        sp_plot_trace trace = {"x", 5, t, f, start[k] + 0.5, -INFINITY, 1e300, NULL, NULL, NULL};
        assert_ok(sp_plot_signal(1, &trace, in_folder("extreme.svg"), &err));
    }
    for (size_t n = 1; n <= 40; n += 13) {
        sp_plot_trace many[40];
        const double t[2] = {0, 1}, f[2] = {1, 1};
        for (size_t k = 0; k < n; k++)
            many[k] = (sp_plot_trace){"many", 2, t, f, 0.5, NAN, NAN, NULL, NULL, NULL};
        assert_ok(sp_plot_signal((int)n, many, in_folder("many.png"), &err));
    }
}

static void test_bad_paths(void **state) {
    (void)state;
    sp_table t = table_of(4, reference);
    assert_fails(sp_plot_ctof(&t, NULL, &err), SP_EINVAL, ".png .svg .pdf");
    assert_fails(sp_plot_ctof(&t, "", &err), SP_EINVAL, ".png .svg .pdf");
    assert_fails(sp_plot_ctof(&t, in_folder("a.jpg"), &err), SP_EINVAL, "a.jpg");
    assert_fails(sp_plot_ctof(&t, in_folder("noending"), &err), SP_EINVAL, ".png .svg .pdf");
    assert_fails(sp_plot_ctof(&t, in_folder(".png"), &err), SP_EINVAL, ".png .svg .pdf");
    assert_fails(sp_plot_ctof(&t, in_folder("no/such/a.png"), &err), SP_EIO, "no/such");
    assert_int_equal(mkdir(in_folder("dir.svg"), 0755), 0);
    assert_fails(sp_plot_ctof(&t, in_folder("dir.svg"), &err), SP_EIO, "dir.svg");
    assert_fails(sp_plot_ctof(&t, in_folder("dir.svg/no/a.svg"), &err), SP_EIO, "dir.svg/no");
    rmdir(in_folder("dir.svg"));
    FILE *file = fopen(in_folder("plain.png"), "w");
    fputs("old", file);
    fclose(file);
    assert_fails(sp_plot_ctof(&t, in_folder("plain.png/a.png"), &err), SP_EIO, "plain.png");
    /* refused data leave the old file as it was */
    const double negative[][COLUMNS] = {{1e-4, -1, NAN, NAN, NAN}};
    size_t size;
    assert_fails(plot_rows(1, negative, in_folder("plain.png"), &err), SP_EREFUSED, "c_tof");
    char *old = read_file(in_folder("plain.png"), &size);
    assert_string_equal(old, "old");
    free(old);
    assert_int_equal(files_in_folder(), 1);
    sp_table_free(&t);
}

typedef struct work {
    const sp_table *table;
    const sp_plot_trace *trace;
    const sp_packing *packing;
} work;

static sp_status draw_one(const work *w, int figure, const char *path, sp_error *err) {
    switch (figure) {
    case 0: return sp_plot_ctof(w->table, path, err);
    case 1: return sp_plot_signal(1, w->trace, path, err);
    default: return sp_plot_network(w->packing, SP_PLOT_FORCES, 1e-4, path, err);
    }
}

/* Every allocation fails in turn: SP_ENOMEM, no file, no leak; then it works, with the bytes that it always has. */
static void test_lack_of_memory(void **state) {
    (void)state;
    const double t[3] = {0, 1, 2}, f[3] = {0, 1, 0};
    const sp_plot_trace trace = {"x", 3, t, f, 0.1, 1, 2, NULL, NULL, NULL};
    sp_table table = table_of(4, reference);
    sp_packing p = pair_across_the_edge();
    const work w = {&table, &trace, &p};
    static const char *const ending[] = {"svg", "png", "pdf"};
    for (int figure = 0; figure < 9; figure++) {
        char good[256], path[256];
        snprintf(good, sizeof good, "%s/good.%s", folder, ending[figure % 3]);
        snprintf(path, sizeof path, "%s/poor.%s", folder, ending[figure % 3]);
        assert_ok(draw_one(&w, figure / 3, good, &err));
        sp_status status = SP_ENOMEM;
        int k = 0;
        for (; k < 400 && status != SP_OK; k++) {
            sp_error err = {0};
            sp_alloc_fail_after(k);
            status = draw_one(&w, figure / 3, path, &err);
            sp_alloc_fail_after(-1);
            if (status != SP_OK) {
                assert_int_equal(status, SP_ENOMEM);
                assert_int_equal(files_in_folder(), 1);
            }
        }
        assert_int_equal(status, SP_OK);
        assert_true(k > 3);
        same_bytes_twice(good, path);
        remove(path);
        remove(good);
    }
    sp_packing_free(&p);
    sp_table_free(&table);
}

/* A program around the library may have set a decimal comma; the figure has points all the same. */
static void test_decimal_comma(void **state) {
    (void)state;
    if (!setlocale(LC_ALL, "de_DE.UTF-8") && !setlocale(LC_ALL, "fr_FR.UTF-8"))
        skip();
    sp_status status = plot_rows(4, reference, in_folder("comma.svg"), NULL);
    const bool kept = strcmp(localeconv()->decimal_point, ",") == 0;
    setlocale(LC_ALL, "C");
    assert_int_equal(status, SP_OK);
    assert_true(kept);
    assert_ok(plot_rows(4, reference, in_folder("point.svg"), &err));
    same_bytes_twice(in_folder("comma.svg"), in_folder("point.svg"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_points_are_where_the_data_are, clear),
        cmocka_unit_test_teardown(test_png_says_its_resolution, clear),
        cmocka_unit_test_teardown(test_signal_follows_its_data, clear),
        cmocka_unit_test_teardown(test_dense_signal_keeps_its_spikes, clear),
        cmocka_unit_test_teardown(test_svg_holds_labels_and_repeats, clear),
        cmocka_unit_test_teardown(test_pdf_repeats, clear),
        cmocka_unit_test_teardown(test_exponent_of_the_table_comes_first, clear),
        cmocka_unit_test_teardown(test_bars_of_long_waves, clear),
        cmocka_unit_test_teardown(test_exponent_is_fitted, clear),
        cmocka_unit_test_teardown(test_units, clear),
        cmocka_unit_test_teardown(test_hostile_labels, clear),
        cmocka_unit_test_teardown(test_markup_of_numbers, clear),
        cmocka_unit_test_teardown(test_contact_across_the_periodic_edge, clear),
        cmocka_unit_test_teardown(test_rattlers_and_strength, clear),
        cmocka_unit_test_teardown(test_other_dimensions, clear),
        cmocka_unit_test_teardown(test_refused_tables_leave_no_file, clear),
        cmocka_unit_test_teardown(test_extreme_data_are_drawn, clear),
        cmocka_unit_test_teardown(test_bad_paths, clear),
        cmocka_unit_test_teardown(test_lack_of_memory, clear),
        cmocka_unit_test_teardown(test_decimal_comma, clear),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
