/* sonopack plot: draws figures of tables, signals and packings. */
#include "base/base.h"
#include "cli/cli.h"
#include "cli/output.h"
#include "cli/plot_frames.h"
#include "cli/plot_input.h"
#include "cli/plot_look.h"
#include "cli/plot_motion.h"
#include "cli/plot_packing.h"
#include "cli/plot_sensitivity.h"
#include "cli/plot_signals.h"
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
    plot_look look;
    bool linear, published, unpublished;
    int log; /* index in plot_look_axes; < 0: not given */
    const char *store, *only, *column, *sample, *table;
    bool surface;
    int64_t mode; /* < 0: not given */
    double time;  /* < 0: not given */
    int64_t frames;
    double from, to; /* < 0: not given */
    int files;
    char **file;
};

/* ---- kinds ------------------------------------------------------------------------------------------------------ */

/* If a figure cannot be drawn from a file, the error is the file's, not one of usage. Functions that read files name
 * them in their messages (SP_EFORMAT, SP_EIO); those that draw do not know the file, so it is named here. */
static sp_status blame(sp_status status, const char *path, sp_error *err) {
    if ((status != SP_EINVAL && status != SP_EREFUSED) || plot_look_blamed(err))
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

static sp_status draw_store(const arguments *a, sp_error *err) {
    sp_table t = sp_table_none();
    const sp_plot_table shown = {.table = &t, .label = a->look.label[0], .named = a->look.labels > 0};
    sp_status status = store_table(a, &t, err);
    if (status == SP_OK)
        status = blame(sp_plot_ctof_tables(1, &shown, a->common.output, err), a->store, err);
    sp_table_free(&t);
    return status;
}

static sp_status draw_ctof(const arguments *a, const sp_scene *scene, sp_error *err) {
    if (a->store)
        return draw_store(a, err);
    const plot_tables_want want = {.kind = PLOT_CTOF, .look = &a->look};
    return blame(plot_tables_files(&a->common, scene, &want, a->files, a->file, err), a->file[0], err);
}

static sp_status draw_signal(const arguments *a, const sp_scene *scene, sp_error *err) {
    return blame(plot_signal_files(&a->common, scene, &a->look, a->files, a->file, err), a->file[0], err);
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

static sp_status draw_sensitivity(const arguments *a, const sp_scene *scene, sp_error *err) {
    return blame(plot_sensitivity(&a->common, scene, a->files, a->file, err), a->file[a->files - 1], err);
}

static sp_status draw_grains(const arguments *a, const sp_scene *scene, sp_error *err) {
    sp_packing p = sp_packing_none();
    sp_table t = sp_table_none();
    sp_status status = a->files == 2 ? sp_packing_read(a->file[0], &p, err)
                                     : sp_fail(err, SP_EINVAL, "grains: needs a packing and a table of its grains");
    if (status == SP_OK)
        status = plot_read_table(a->file[1], &t, err);
    if (status == SP_OK)
        status = blame(sp_plot_grains(&p, &t, scene->network.threshold, a->common.output, err), a->file[1], err);
    sp_table_free(&t);
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
        .dispersion = a->kind->variant, .column = a->column, .look = &a->look, .files = a->files, .file = a->file};
    return blame(plot_spectrum_files(&a->common, scene, &spectra, err), a->file[0], err);
}

static sp_status draw_motion(const arguments *a, const sp_scene *scene, sp_error *err) {
    const plot_motion what = {.mode = a->kind->variant,
                              .number = a->mode,
                              .time = a->time,
                              .frames = (int)a->frames,
                              .from = a->from,
                              .to = a->to,
                              .packing = a->file[0],
                              .given = a->files > 1 ? a->file[1] : NULL,
                              .table = a->table};
    return plot_motion_file(&a->common, scene, &what, err);
}

static sp_status draw_contacts(const arguments *a, const sp_scene *scene, sp_error *err) {
    return blame(plot_contacts(&a->common, scene, a->kind->variant, a->files, a->file, err), a->file[0], err);
}

static sp_status draw_tables(const arguments *a, const sp_scene *scene, sp_error *err) {
    const plot_tables_want want = {.kind = (plot_tables_kind)a->kind->variant, .look = &a->look, .sample = a->sample};
    return blame(plot_tables_files(&a->common, scene, &want, a->files, a->file, err), a->sample ? "" : a->file[0], err);
}

static sp_status draw_column(const arguments *a, const sp_scene *scene, sp_error *err) {
    (void)scene;
    const sp_plot_column_options options = {.surface = a->surface, .column = a->column};
    return blame(plot_column_files(&a->common, &options, &a->look, a->files, a->file, err), a->file[0], err);
}

static const char *const kind_names[] = {"ctof",        "signal", "network",   "stiffness", "angles", "forces",
                                         "snapshot",    "fronts", "scaling",   "ensemble",  "pareto", "spectrum",
                                         "dispersion",  "wave",   "amplitude", "column",    "mode",   "modes",
                                         "sensitivity", "grains", "transport", NULL};
enum { ANY = 1 << 16 };
/* in the order of their names */
static const kind kinds[] = {{draw_ctof, 12, "", 0},
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
                             {draw_tables, 6, "", PLOT_AMPLITUDE},
                             {draw_column, 6, "", 0},
                             {draw_motion, 2, "network", true},
                             {draw_tables, 6, "", PLOT_MODES},
                             {draw_sensitivity, 2, "network", 0},
                             {draw_grains, 2, "network", 0},
                             {draw_tables, 6, "", PLOT_TRANSPORT}};

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

static sp_status check_look(arguments *a, sp_error *err) {
    if (a->published && a->unpublished)
        return sp_fail(err, SP_EINVAL, "--published and --no-published: must be one of them");
    if (a->published || a->unpublished)
        a->look.look.published = a->published ? SP_PLOT_PUBLISHED_ALWAYS : SP_PLOT_PUBLISHED_NEVER;
    plot_look_log(&a->look, a->log);
    if (a->linear)
        plot_look_linear(&a->look);
    return plot_look_check(&a->look, a->store ? 1 : a->files, err);
}

static sp_status check_frames(const arguments *a, sp_error *err) {
    if (a->frames == 0 && (a->from >= 0 || a->to >= 0))
        return sp_fail(err, SP_EINVAL, "--%s: needs --frames", a->from >= 0 ? "from" : "to");
    if (a->frames > 0 && (a->time >= 0 || a->table))
        return sp_fail(err, SP_EINVAL, "--frames %lld: a movie takes no --%s", (long long)a->frames,
                       a->table ? "table" : "time");
    if (a->frames > 0 && a->files > 1 && a->kind->draw == draw_motion && !a->kind->variant)
        return sp_fail(err, SP_EINVAL, "--frames %lld: the table %s has one time only", (long long)a->frames,
                       a->file[1]);
    if (a->from >= 0 && a->to >= 0 && a->from >= a->to)
        return sp_fail(err, SP_EINVAL, "--from %g: must be below --to %g", a->from, a->to);
    return SP_OK;
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
    sp_status status = check_look(a, err);
    if (status == SP_OK)
        status = check_frames(a, err);
    return status == SP_OK && a->column ? check_column(a, err) : status;
}

static sp_status set_x(void *user, const char *text, sp_error *err) {
    return plot_look_range("--x", text, ((arguments *)user)->look.look.x, err);
}

static sp_status set_y(void *user, const char *text, sp_error *err) {
    return plot_look_range("--y", text, ((arguments *)user)->look.look.y, err);
}

static sp_status add_label(void *user, const char *text, sp_error *err) {
    return plot_look_label(&((arguments *)user)->look, text, err);
}

/* Kinds with axes, and kinds with a legend of files. */
#define WITH_AXES                                                                                                      \
    "ctof signal forces fronts scaling ensemble pareto spectrum dispersion wave amplitude column modes transport"
#define WITH_LABELS "ctof signal fronts scaling ensemble spectrum dispersion wave amplitude column modes transport"

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
    {"frames", "N",
     "mode, snapshot: a movie of N numbered frames: FIGURE is wave-%04d.png, or wave.png for wave-0001.png, ...",
     CLI_INTEGER, .field = offsetof(arguments, frames), .low = 2, .high = PLOT_FRAMES_MAX, .kinds = "mode snapshot"},
    {"from", "T", "snapshot --frames: time of the first frame (0)", CLI_NUMBER, .field = offsetof(arguments, from),
     .high = 1e9, .kinds = "snapshot", .unit = "d/sqrt(E* / rho)"},
    {"to", "T", "snapshot --frames: time of the last frame (4.3 H (p/1e-4)^(-1/6))", CLI_NUMBER,
     .field = offsetof(arguments, to), .high = 1e9, .kinds = "snapshot", .unit = "d/sqrt(E* / rho)"},
    {"table", "FILE", "mode, snapshot: write the displacements to this table too (.tsv, .csv, .json)", CLI_TEXT,
     .field = offsetof(arguments, table), .kinds = "mode snapshot"},
    {"signal", "FILE", "fronts: a signal or packing, drawn in an inset that explains the marks of the front", CLI_TEXT,
     .field = offsetof(arguments, sample), .kinds = "fronts"},
    {"surface", NULL, "column: draw a trajectory or densities as a surface over particle and time", CLI_FLAG,
     .field = offsetof(arguments, surface), .kinds = "column"},
    {.help = "Look:"},
    {"title", "TEXT", "Title above the figure", CLI_TEXT, .field = offsetof(arguments, look.look.title)},
    {"label", "TEXT", "Name of a file in the legend (repeatable: one for each file, in their order)",
     .parse = add_label, .kinds = WITH_LABELS},
    {"x", "LO:HI", "Limits of the x axis, or LO: or :HI", .parse = set_x, .kinds = WITH_AXES},
    {"y", "LO:HI", "Limits of the y axis, of several panels that of the first", .parse = set_y, .kinds = WITH_AXES},
    {"log", "x|y|xy", "Make these axes logarithmic", CLI_CHOICE, .field = offsetof(arguments, log),
     .words = plot_look_axes, .kinds = WITH_AXES},
    {"linear", NULL, "Make the axes linear that --log does not name", CLI_FLAG, .field = offsetof(arguments, linear),
     .kinds = WITH_AXES},
    {"published", NULL, "ctof: draw the published line even over data that do not say that they are two-dimensional",
     CLI_FLAG, .field = offsetof(arguments, published), .kinds = "ctof"},
    {"no-published", NULL, "ctof: leave out the published line", CLI_FLAG, .field = offsetof(arguments, unpublished),
     .kinds = "ctof"},
    {0}};

static const cli_syntax syntax = {
    .usage = "KIND FILE... -o FIGURE\nctof --store DIR -o FIGURE",
    .help =
        "Draws figures one print column (86 mm) wide, as PNG (300 dpi), SVG or PDF by the ending of FIGURE.\v"
        "ctof: speed against pressure from tables of `sonopack table ctof' (TSV or CSV), with the published c_tof = "
        "0.26 "
        "(p/1e-4)^(1/6) where they say that they are of two dimensions.\n"
        "signal: F(t) of tables with columns t and F (or F1, F2, ...), or of packings, whose signal is computed. The "
        "first front is marked by a triangle at 10% of its peak, a circle at the peak, and a square at the zero "
        "crossing. More than ten signals are drawn one above the other, at their distances if these are known.\n"
        "network: a packing with its contacts as lines, whose width shows the normal force; rattlers are grey.\n"
        "stiffness: the same with the normal stiffness.\n"
        "angles: directions of the contacts of packings, at least 3 d from the walls: all, strong and weak contacts; "
        "a circle of radius 1 is isotropic. In three dimensions angles are those above the horizontal.\n"
        "forces: histograms of normal forces and stiffnesses, divided by their means.\n"
        "snapshot: displacements of the grains at a time after the pulse, which starts at the bottom wall (periodic "
        "cells have none). A second FILE, a table of --table, is drawn "
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
        "amplitude: speed over its linear limit and shares of contacts that opened and slid against amplitude, from "
        "tables of `sonopack amplitude'; with --omega and --planes F2/F1^2 against height.\n"
        "transport: D and mean free path against frequency from tables of `sonopack transport'.\n"
        "column: a table of `sonopack column' (trajectory, strobe, lyapunov, bifurcation, compare, density or "
        "energy); trajectories of lattice, longwave and bsr are drawn as surfaces side by side, two columns of print "
        "wide, and a bifurcation above a table of lyapunov.\n"
        "mode: the displacements of a mode as arrows on the grains, tinted where they rotate. A second FILE, of "
        "`sonopack "
        "modes --vectors' (HDF5 or table) or a table of --table, is drawn in place of computing the mode.\n"
        "In three dimensions network, stiffness, sensitivity, mode and snapshot show three views: along y, along x and "
        "from above.\n"
        "--frames makes a movie of a mode (one period) or of a wave, one numbered file a frame, all at one scale.\n"
        "modes: omega^2 and a b against n, from tables of `sonopack modes'.\n"
        "sensitivity: a packing with what each contact does to the arrival t10 when it becomes stiffer, as the width "
        "of "
        "its line (growing as the root) and its colour: orange, the arrival is later; blue, it is earlier. A second "
        "FILE, a table of `sonopack sensitivity --by kn,kt', is drawn in place of computing that of t10.\n"
        "grains: a packing whose grains are coloured by a table, the second FILE, with the column grain and one of "
        "factor (sonopack design --rows grains), probability (coda), by_mass or by_radius (sensitivity): orange above, "
        "blue below.\n"
        "Axes have the units of the tables; tables of one figure must have the same.\n"
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
    return a->frames > 0 ? plot_frames_may_write(&a->common, a->frames, err) : cli_may_write(&a->common, path, err);
}

/* Figures whose units are those of a table or a signal. */
static bool takes_si(const kind *k) {
    return k->draw != draw_network && k->draw != draw_motion && k->draw != draw_column && k->draw != draw_pareto &&
           k->draw != draw_sensitivity && k->draw != draw_grains;
}

int cmd_plot(int argc, char **argv) {
    arguments a = {.mode = -1, .log = -1, .time = -1, .from = -1, .to = -1, .look = plot_look_default()};
    cli_parse(&syntax, argc, argv, &a);
    sp_plot_set_look(&a.look.look);
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
