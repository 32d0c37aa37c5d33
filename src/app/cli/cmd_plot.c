/* sonopack plot: draws figures of tables, signals and packings. */
#include "base/base.h"
#include "cli/cli.h"
#include "cli/output.h"
#include "cli/plot_input.h"
#include "cli/plot_motion.h"
#include "cli/plot_packing.h"
#include "cli/plot_spectrum.h"
#include "cli/plot_tables.h"
#include "cli/plot_units.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define LEAK_CHECKED
#endif
#elif defined(__SANITIZE_ADDRESS__)
#define LEAK_CHECKED
#endif
#ifdef LEAK_CHECKED
/* fontconfig, which cairo uses, stores offsets instead of pointers: the leak checker takes its memory for lost. */
__attribute__((visibility("default"))) const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) { return "leak:libfontconfig"; }
__attribute__((visibility("default"))) const char *__lsan_default_options(void);
const char *__lsan_default_options(void) { return "print_suppressions=0"; }
#endif

typedef struct arguments arguments;

typedef sp_status (*draw_function)(const arguments *a, const sp_scene *scene, sp_error *err);

typedef struct kind {
    draw_function draw;
    int files_max;
    const char *sets; /* groups of keys that --set may change */
    int variant;      /* for functions that draw several kinds */
} kind;

struct arguments {
    cli_common common;
    const kind *kind;
    const char *store, *only, *column, *sample, *table;
    bool surface;
    int64_t mode; /* < 0: not given */
    double time;  /* < 0: not given */
    int files;
    char **file;
};

/* ---- kinds ------------------------------------------------------------------------------------------------------ */

/* If a figure cannot be drawn from a file, the error is the file's, not one of usage. Functions that read files name
 * them in their messages (SP_EFORMAT, SP_EIO); those that draw do not know the file, so it is named here. */
static sp_status blame(sp_status status, const char *path, sp_error *err) {
    if (status != SP_EINVAL && status != SP_EREFUSED)
        return status;
    err->status = status == SP_EINVAL ? SP_EFORMAT : status;
    return *path ? sp_fail_prefix(err, "%s", path) : err->status;
}

static sp_status store_table(const arguments *a, sp_table *out, sp_error *err) {
    sp_store *store = NULL;
    sp_sample *samples = NULL;
    int64_t n = 0, bad = 0;
    sp_error reason = {0};
    sp_status status = sp_store_open(a->store, false, &store, err);
    if (status != SP_OK)
        return status;
    status = sp_store_samples(store, &n, &samples, &bad, &reason);
    if (status != SP_OK)
        *err = reason;
    else if (bad > 0)
        cli_note(&a->common, "%lld files of the store are not used: %s", (long long)bad, reason.text);
    if (status == SP_OK)
        status = blame(sp_study_table("ctof", n, samples, NULL, out, err), a->store, err);
    if (status == SP_OK)
        status = plot_units_convert(out, err);
    sp_free(samples);
    sp_store_close(store);
    return status;
}

static sp_status draw_ctof(const arguments *a, const sp_scene *scene, sp_error *err) {
    (void)scene;
    sp_table t = sp_table_none();
    sp_status status = a->store ? store_table(a, &t, err) : plot_read_table(a->file[0], &t, err);
    if (status == SP_OK)
        status = blame(sp_plot_ctof(&t, a->common.output, err), a->store ? a->store : a->file[0], err);
    sp_table_free(&t);
    return status;
}

/* The label of a signal: the file name without folder and ending, and the column if the file has several signals. With
 * a single file the column alone is enough. */
static char *label_of(const char *path, const char *column, bool files) {
    enum { SIZE = 256 };
    const char *slash = strrchr(path, '/'), *name = slash && slash[1] ? slash + 1 : path;
    const char *dot = strrchr(name, '.');
    const int length = (int)(dot && dot > name ? dot - name : (ptrdiff_t)strlen(name));
    char *label = sp_alloc(SIZE, 1);
    if (label && *column)
        snprintf(label, SIZE, "%.*s%s%s", files ? length : 0, name, files ? " " : "", column);
    else if (label)
        snprintf(label, SIZE, "%.*s", length, name);
    return label;
}

/* The trace points to the arrays and units of the signal. */
static sp_status make_trace(const arguments *a, const char *path, const plot_signal *s, sp_plot_trace *out,
                            sp_error *err) {
    char *label = label_of(path, s->name, a->files > 1);
    if (!label)
        return sp_fail_memory(err, strlen(path));
    sp_front front = {.t10 = NAN, .t_peak = NAN, .t_zero = NAN};
    sp_front_options rule = sp_front_options_default();
    sp_error reason = {0};
    rule.window = s->window;
    if (sp_front_find(s->n, s->t, s->f, &rule, &front, &reason) != SP_OK)
        cli_note(&a->common, "%s%s%s: the first front is not marked: %s", path, *s->name ? ", " : "", s->name,
                 reason.text);
    *out = (sp_plot_trace){.label = label,
                           .n = s->n,
                           .t = s->t,
                           .f = s->f,
                           .t10 = front.t10,
                           .t_peak = front.t_peak,
                           .t_zero = front.t_zero,
                           .t_unit = s->foreign ? s->t_unit : NULL,
                           .f_unit = s->foreign ? s->f_unit : NULL};
    return SP_OK;
}

/* Too many signals for a legend are drawn one above the other, up to the number that is still legible. */
static bool is_section(const arguments *a, int traces, const plot_signals *read) {
    enum { LEGEND_MAX = 10, SECTION_MAX = 60 };
    bool ours = traces > LEGEND_MAX && traces <= SECTION_MAX;
    for (int k = 0; k < a->files; k++)
        for (int j = 0; j < read[k].n; j++)
            ours = ours && !read[k].signal[j].foreign;
    return ours;
}

/* Whether all distances are known and no two are nearly equal. */
static bool are_distinct(int n, const sp_plot_record *record) {
    double low = INFINITY, high = -INFINITY, least = INFINITY;
    bool known = true;
    for (int k = 0; k < n; k++) {
        known = known && isfinite(record[k].distance);
        low = fmin(low, record[k].distance);
        high = fmax(high, record[k].distance);
        for (int j = 0; j < k; j++)
            least = fmin(least, fabs(record[k].distance - record[j].distance));
    }
    return known && least > 0.1 * (high - low) / (n - 1);
}

static sp_status draw_section(const arguments *a, int traces, const plot_signals *read, sp_error *err) {
    int count = 0;
    sp_plot_record *record = sp_alloc((size_t)traces, sizeof *record);
    if (!record)
        return sp_fail_memory(err, (size_t)traces * sizeof *record);
    for (int k = 0; k < a->files; k++)
        for (int j = 0; j < read[k].n; j++) {
            const plot_signal *s = &read[k].signal[j];
            record[count++] = (sp_plot_record){.distance = s->distance, .n = s->n, .t = s->t, .f = s->f};
        }
    if (!are_distinct(traces, record))
        for (int k = 0; k < traces; k++)
            record[k].distance = NAN;
    const sp_status status = blame(sp_plot_section(traces, record, a->common.output, err), a->file[0], err);
    sp_free(record);
    return status;
}

static sp_status draw_signal(const arguments *a, const sp_scene *scene, sp_error *err) {
    plot_signals *read = sp_alloc((size_t)a->files, sizeof *read);
    sp_plot_trace *trace = NULL;
    int traces = 0, count = 0;
    sp_status status = read ? SP_OK : sp_fail_memory(err, (size_t)a->files * sizeof *read);
    for (int k = 0; k < a->files && status == SP_OK; k++) {
        status = plot_read_signals(a->file[k], scene, &read[k], err);
        traces += read[k].n;
    }
    const bool section = status == SP_OK && is_section(a, traces, read);
    if (section)
        status = draw_section(a, traces, read, err);
    if (status == SP_OK && !section) {
        trace = sp_alloc((size_t)traces, sizeof *trace);
        status = trace ? SP_OK : sp_fail_memory(err, (size_t)traces * sizeof *trace);
    }
    for (int k = 0; k < a->files && status == SP_OK && trace; k++)
        for (int j = 0; j < read[k].n && status == SP_OK; j++)
            status = make_trace(a, a->file[k], &read[k].signal[j], &trace[count++], err);
    if (status == SP_OK && trace)
        status = blame(sp_plot_signal(traces, trace, a->common.output, err), a->file[0], err);
    for (int j = 0; j < count; j++)
        sp_free((void *)trace[j].label);
    for (int k = 0; k < a->files && read; k++)
        plot_signals_free(&read[k]);
    sp_free(trace);
    sp_free(read);
    return status;
}

static sp_status draw_network(const arguments *a, const sp_scene *scene, sp_error *err) {
    const sp_plot_links links = (sp_plot_links)a->kind->variant;
    sp_packing p = sp_packing_none();
    sp_status status = sp_packing_read(a->file[0], &p, err);
    if (status == SP_OK)
        status = blame(sp_plot_network(&p, links, scene->network.threshold, a->common.output, err), a->file[0], err);
    sp_packing_free(&p);
    return status;
}

static sp_status draw_pareto(const arguments *a, const sp_scene *scene, sp_error *err) {
    (void)scene;
    sp_table t = sp_table_none();
    sp_status status = plot_read_table(a->file[0], &t, err);
    if (status == SP_OK)
        status = blame(sp_plot_pareto(&t, a->only, a->common.output, err), a->file[0], err);
    sp_table_free(&t);
    return status;
}

static sp_status draw_spectra(const arguments *a, const sp_scene *scene, sp_error *err) {
    const plot_spectra spectra = {
        .dispersion = a->kind->variant, .column = a->column, .files = a->files, .file = a->file};
    return blame(plot_spectrum_files(&a->common, scene, &spectra, err), a->file[0], err);
}

static sp_status draw_motion(const arguments *a, const sp_scene *scene, sp_error *err) {
    const plot_motion what = {.mode = a->kind->variant,
                              .number = a->mode,
                              .time = a->time,
                              .packing = a->file[0],
                              .given = a->files > 1 ? a->file[1] : NULL,
                              .table = a->table};
    return plot_motion_file(&a->common, scene, &what, err);
}

static sp_status draw_contacts(const arguments *a, const sp_scene *scene, sp_error *err) {
    return blame(plot_contacts(&a->common, scene, a->kind->variant, a->files, a->file, err), a->file[0], err);
}

static sp_status draw_tables(const arguments *a, const sp_scene *scene, sp_error *err) {
    const plot_tables_kind of = (plot_tables_kind)a->kind->variant;
    return blame(plot_tables_files(&a->common, scene, of, a->sample, a->files, a->file, err),
                 a->sample ? "" : a->file[0], err);
}

static sp_status draw_column(const arguments *a, const sp_scene *scene, sp_error *err) {
    (void)scene;
    const sp_plot_column_options options = {.surface = a->surface, .column = a->column};
    return blame(plot_column_files(&a->common, &options, a->files, a->file, err), a->file[0], err);
}

static const char *const kind_names[] = {"ctof",       "signal", "network", "stiffness", "angles", "forces",
                                         "snapshot",   "fronts", "scaling", "ensemble",  "pareto", "spectrum",
                                         "dispersion", "wave",   "column",  "mode",      "modes",  NULL};
enum { ANY = 1 << 16 };
/* in the order of their names */
static const kind kinds[] = {{draw_ctof, 1, "", 0},
                             {draw_signal, ANY, "network signal", 0},
                             {draw_network, 1, "network", SP_PLOT_FORCES},
                             {draw_network, 1, "network", SP_PLOT_STIFFNESS},
                             {draw_contacts, ANY, "network", false},
                             {draw_contacts, ANY, "network", true},
                             {draw_motion, 2, "network signal", false},
                             {draw_tables, 32, "network signal", PLOT_FRONTS},
                             {draw_tables, 32, "", PLOT_SCALING},
                             {draw_tables, 6, "", PLOT_ENSEMBLE},
                             {draw_pareto, 1, "", 0},
                             {draw_spectra, 32, "network", false},
                             {draw_spectra, 2, "network", true},
                             {draw_tables, 6, "", PLOT_WAVE},
                             {draw_column, 6, "", 0},
                             {draw_motion, 2, "network", true},
                             {draw_tables, 1, "", PLOT_MODES}};

/* ---- the command ------------------------------------------------------------------------------------------------ */

static sp_status check_column(const arguments *a, sp_error *err) {
    const char *c = a->column;
    if (a->kind->draw == draw_column) {
        if (c[0] == 'y' && c[1] >= '1' && c[1] <= '9' && c[1 + strspn(c + 1, "0123456789")] == '\0')
            return SP_OK;
        return sp_fail(err, SP_EINVAL, "--column %.60s: must be y1, y2, ...", c);
    }
    static const char *const words[] = {"alpha", "k", "speed", NULL};
    int word;
    return cli_choose("--column", c, words, &word, err);
}

static sp_status check(void *user, sp_error *err) {
    arguments *a = user;
    const char *name = kind_names[a->common.kind];
    a->kind = &kinds[a->common.kind];
    a->files = a->common.files;
    a->file = a->common.file;
    if (a->store && a->files > 0)
        return sp_fail(err, SP_EINVAL, "%s: must be a file or --store, not both", a->file[0]);
    if (!a->store && a->files == 0)
        return sp_fail(err, SP_EINVAL, "plot %s: no file to draw", name);
    if (a->files > a->kind->files_max)
        return sp_fail(err, SP_EINVAL, "plot %s: %d files, must be at most %d", name, a->files, a->kind->files_max);
    if (a->table && strcmp(a->table, a->common.output ? a->common.output : "") == 0)
        return sp_fail(err, SP_EINVAL, "--table %s: must be another file than the figure", a->table);
    if (a->common.sets > 0 && !a->kind->sets[0])
        return sp_fail(err, SP_EINVAL, "--set: no key of a scene changes a figure of %s", name);
    if (!a->common.output)
        return sp_fail(err, SP_EINVAL, "no -o FILE: must end in .svg, .png or .pdf");
    return a->column ? check_column(a, err) : SP_OK;
}

static const cli_option options[] = {
    {"store", "DIR", "ctof: use the samples in this folder instead of a table", CLI_TEXT,
     .field = offsetof(arguments, store), .kinds = "ctof"},
    {"case", "CASE", "pareto: this case of the table (the first one)", CLI_TEXT, .field = offsetof(arguments, only),
     .kinds = "pareto"},
    {"column", "NAME",
     "spectrum: alpha, k or speed of a harmonic response (the force); column: y2, ... of a bifurcation (y1)", CLI_TEXT,
     .field = offsetof(arguments, column), .kinds = "spectrum column"},
    {"mode", "N", "mode: number of the mode, as in `sonopack modes' (the first that is not a zero mode)", CLI_INTEGER,
     .field = offsetof(arguments, mode), .high = 1000000000, .kinds = "mode"},
    {"time", "T",
     "snapshot: time after the pulse (3.2 H (p/1e-4)^(-1/6), with the wave about three quarters of the way)",
     CLI_NUMBER, .field = offsetof(arguments, time), .high = 1e9, .kinds = "snapshot", .unit = "d/sqrt(E* / rho)"},
    {"table", "FILE", "mode, snapshot: write the displacements to this table too (.tsv, .csv, .json)", CLI_TEXT,
     .field = offsetof(arguments, table), .kinds = "mode snapshot"},
    {"signal", "FILE", "fronts: a signal or packing, drawn in an inset that explains the marks of the front", CLI_TEXT,
     .field = offsetof(arguments, sample), .kinds = "fronts"},
    {"surface", NULL, "column: draw a trajectory or densities as a surface over particle and time", CLI_FLAG,
     .field = offsetof(arguments, surface), .kinds = "column"},
    {0}};

static const cli_syntax syntax = {
    .usage = "KIND FILE... -o FIGURE\nctof --store DIR -o FIGURE",
    .help =
        "Draws figures one print column (86 mm) wide, as PNG (300 dpi), SVG or PDF by the ending of FIGURE.\v"
        "ctof: speed against pressure, with the published c_tof = 0.26 (p/1e-4)^(1/6), from a table of `sonopack "
        "table ctof' (TSV or CSV).\n"
        "signal: F(t) of tables with columns t and F (or F1, F2, ...), or of packings, whose signal is computed. The "
        "first front is marked by a triangle at 10% of its peak, a circle at the peak, and a square at the zero "
        "crossing. More than ten signals are drawn one above the other, at their distances if these are known.\n"
        "network: a packing with its contacts as lines, whose width shows the normal force; rattlers are grey.\n"
        "stiffness: the same with the normal stiffness.\n"
        "angles: directions of the contacts of packings, at least 3 d from the walls: all, strong and weak contacts; "
        "a circle of radius 1 is isotropic.\n"
        "forces: histograms of normal forces and stiffnesses, divided by their means.\n"
        "snapshot: displacements of the grains at a time after the pulse. A second FILE, a table of --table, is drawn "
        "in place of computing them.\n"
        "fronts: arrival times against distance, with fitted lines.\n"
        "scaling: local exponents gamma and alpha.\n"
        "fronts and scaling take tables of `sonopack table scaling' or `planes', `sonopack chain front' or (fronts) "
        "`sonopack front'.\n"
        "ensemble: tables with columns t, mean and rms, and low and high for a band around the mean.\n"
        "pareto: run time against error from a table of `sonopack bench', one symbol per method, hollow for other "
        "programs, and the Pareto frontier.\n"
        "spectrum: tables of `sonopack spectrum' dos, transmission, harmonic or participation, of `sonopack modes', "
        "of `sonopack table spectrum', or packings (their density of states).\n"
        "dispersion: a table of `sonopack spectrum dispersion', or a packing; bars are half widths.\n"
        "wave: phase speed and attenuation against wave number from tables of `sonopack wave', and Rayleigh's alpha "
        "= a k^(dimension + 1) through the points with alpha below k/10.\n"
        "column: a table of `sonopack column' (trajectory, strobe, lyapunov, bifurcation, compare, density or "
        "energy); trajectories of lattice, longwave and bsr are drawn as surfaces side by side, two columns of print "
        "wide, and a bifurcation above a table of lyapunov.\n"
        "mode: the displacements of a mode as arrows on the grains, tinted where they rotate. A second FILE, of "
        "`sonopack "
        "modes --vectors' (HDF5 or table) or a table of --table, is drawn in place of computing the mode.\n"
        "In three dimensions mode and snapshot show two views, along y and along x; far grains are paler.\n"
        "modes: omega^2 and a b against n, from a table of `sonopack modes'.\n"
        "\n"
        "--set changes keys of network and signal.",
    .finds_material = true,
    .options = options,
    .kinds = kind_names,
    .kind_name = "kind of figure",
    .file_name = "table or packing",
    .files_max = CLI_ANY_NUMBER,
    .check = check};

static sp_status may_write_table(const arguments *a, sp_error *err) {
    cli_common there = a->common;
    there.output = a->table;
    there.format_given = false;
    return a->table ? cli_may_write_table(&there, err) : SP_OK;
}

static sp_status may_write(const arguments *a, sp_error *err) {
    const char *path = a->common.output;
    if (!cli_has_ending(path, ".svg") && !cli_has_ending(path, ".png") && !cli_has_ending(path, ".pdf"))
        return sp_fail(err, SP_EINVAL, "-o %s: the ending of a figure must be .svg, .png or .pdf", path);
    if (a->common.format_given)
        return sp_fail(err, SP_EINVAL, "--format: applies only to tables; a figure has the format of its ending");
    return cli_may_write(&a->common, path, err);
}

/* Figures whose units are those of a table or a signal. */
static bool takes_si(const kind *k) {
    return k->draw != draw_network && k->draw != draw_motion && k->draw != draw_column && k->draw != draw_pareto;
}

int cmd_plot(int argc, char **argv) {
    arguments a = {.mode = -1, .time = -1};
    cli_parse(&syntax, argc, argv, &a);
    sp_error err = {0};
    sp_scene scene = sp_scene_default();
    sp_status status = may_write(&a, &err);
    if (status == SP_OK)
        status = may_write_table(&a, &err);
    if (status == SP_OK)
        status = cli_scene_of_sets(&a.common, a.kind->sets, &scene, &err);
    if (status == SP_OK)
        status = plot_units_choose(&a, takes_si(a.kind), kind_names[a.common.kind], &err);
    if (status == SP_OK)
        status = a.kind->draw(&a, &scene, &err);
    sp_scene_free(&scene);
    return status == SP_OK ? CLI_OK : cli_fail(&err);
}
