/* sonopack plot: figures of tables, signals and packings. */
#include "base/base.h"
#include "cli/cli.h"
#include "cli/output.h"
#include "cli/plot_input.h"
#include "cli/plot_packing.h"
#include "cli/plot_spectrum.h"
#include "cli/plot_tables.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define WATCHED
#endif
#elif defined(__SANITIZE_ADDRESS__)
#define WATCHED
#endif
#ifdef WATCHED
/* fontconfig, behind cairo, keeps offsets in place of pointers: the leak checker cannot see that its memory is held. */
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) { return "leak:libfontconfig"; }
const char *__lsan_default_options(void);
const char *__lsan_default_options(void) { return "print_suppressions=0"; }
#endif

typedef struct arguments arguments;

typedef struct kind {
    const char *name;
    sp_status (*draw)(const arguments *a, const sp_scene *scene, sp_error *err);
    int most; /* files */
    bool store;
    const char *sets; /* groups of keys that --set may change */
} kind;

struct arguments {
    cli_common common;
    const kind *kind;
    const char *store, *only, *column, *sample;
    bool surface;
    int64_t mode; /* < 0: not given */
    double time;  /* < 0: not given */
    int files;
    char **file;
};

/* ---- kinds ------------------------------------------------------------------------------------------------------ */

/* A figure that cannot be made of a file is that file's fault, not one of usage. Reading it fails with SP_EFORMAT or
 * SP_EIO and names the file; drawing does not know the file, which is named here. */
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
        cli_note(&a->common, "%lld files of the store are left out: %s", (long long)bad, reason.text);
    if (status == SP_OK)
        status = blame(sp_study_table("ctof", n, samples, NULL, out, err), a->store, err);
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

/* File name without folders and ending; of one signal of several its column, behind the name where there are more
 * files. */
static char *label_of(const char *path, const char *column, bool files) {
    enum { MOST = 256 };
    const char *slash = strrchr(path, '/'), *name = slash && slash[1] ? slash + 1 : path;
    const char *dot = strrchr(name, '.');
    const int length = (int)(dot && dot > name ? dot - name : (ptrdiff_t)strlen(name));
    char *label = sp_alloc(MOST, 1);
    if (label && *column)
        snprintf(label, MOST, "%.*s%s%s", files ? length : 0, name, files ? " " : "", column);
    else if (label)
        snprintf(label, MOST, "%.*s", length, name);
    return label;
}

/* s: its arrays and units are what the trace points to. */
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
        cli_note(&a->common, "%s%s%s: no first front is marked: %s", path, *s->name ? ", " : "", s->name, reason.text);
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

/* More signals than a legend tells apart stand one above the other, as long as that can be read. */
static bool is_section(const arguments *a, int traces, const plot_signals *read) {
    enum { LEGEND_MOST = 10, SECTION_MOST = 60 };
    bool ours = traces > LEGEND_MOST && traces <= SECTION_MOST;
    for (int k = 0; k < a->files; k++)
        for (int j = 0; j < read[k].n; j++)
            ours = ours && !read[k].signal[j].foreign;
    return ours;
}

/* Whether all distances are known and no two nearly the same. */
static bool apart(int n, const sp_plot_record *record) {
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
    int made = 0;
    sp_plot_record *record = sp_alloc((size_t)traces, sizeof *record);
    if (!record)
        return sp_fail_memory(err, (size_t)traces * sizeof *record);
    for (int k = 0; k < a->files; k++)
        for (int j = 0; j < read[k].n; j++) {
            const plot_signal *s = &read[k].signal[j];
            record[made++] = (sp_plot_record){.distance = s->distance, .n = s->n, .t = s->t, .f = s->f};
        }
    if (!apart(traces, record))
        for (int k = 0; k < traces; k++)
            record[k].distance = NAN;
    const sp_status status = blame(sp_plot_section(traces, record, a->common.output, err), a->file[0], err);
    sp_free(record);
    return status;
}

static sp_status draw_signal(const arguments *a, const sp_scene *scene, sp_error *err) {
    plot_signals *read = sp_alloc((size_t)a->files, sizeof *read);
    sp_plot_trace *trace = NULL;
    int traces = 0, made = 0;
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
            status = make_trace(a, a->file[k], &read[k].signal[j], &trace[made++], err);
    if (status == SP_OK && trace)
        status = blame(sp_plot_signal(traces, trace, a->common.output, err), a->file[0], err);
    for (int j = 0; j < made; j++)
        sp_free((void *)trace[j].label);
    for (int k = 0; k < a->files && read; k++)
        plot_signals_free(&read[k]);
    sp_free(trace);
    sp_free(read);
    return status;
}

static sp_status draw_links(const arguments *a, const sp_scene *scene, sp_plot_links links, sp_error *err) {
    sp_packing p = sp_packing_none();
    sp_status status = sp_packing_read(a->file[0], &p, err);
    if (status == SP_OK)
        status = blame(sp_plot_network(&p, links, scene->network.threshold, a->common.output, err), a->file[0], err);
    sp_packing_free(&p);
    return status;
}

static sp_status draw_network(const arguments *a, const sp_scene *scene, sp_error *err) {
    return draw_links(a, scene, SP_PLOT_FORCES, err);
}

static sp_status draw_stiffness(const arguments *a, const sp_scene *scene, sp_error *err) {
    return draw_links(a, scene, SP_PLOT_STIFFNESS, err);
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

static sp_status draw_spectrum(const arguments *a, const sp_scene *scene, sp_error *err) {
    const plot_spectra want = {.column = a->column, .files = a->files, .file = a->file};
    return blame(plot_spectrum_files(&a->common, scene, &want, err), a->file[0], err);
}

static sp_status draw_dispersion(const arguments *a, const sp_scene *scene, sp_error *err) {
    const plot_spectra want = {.waves = true, .files = a->files, .file = a->file};
    return blame(plot_spectrum_files(&a->common, scene, &want, err), a->file[0], err);
}

static sp_status draw_mode(const arguments *a, const sp_scene *scene, sp_error *err) {
    return plot_mode_file(&a->common, scene, a->file[0], a->mode, err);
}

static sp_status draw_angles(const arguments *a, const sp_scene *scene, sp_error *err) {
    return blame(plot_contacts(&a->common, scene, false, a->files, a->file, err), a->file[0], err);
}

static sp_status draw_forces(const arguments *a, const sp_scene *scene, sp_error *err) {
    return blame(plot_contacts(&a->common, scene, true, a->files, a->file, err), a->file[0], err);
}

static sp_status draw_snapshot(const arguments *a, const sp_scene *scene, sp_error *err) {
    return plot_snapshot_file(&a->common, scene, a->file[0], a->time, err);
}

static sp_status draw_tables(const arguments *a, const sp_scene *scene, plot_tables_kind of, sp_error *err) {
    return blame(plot_tables_files(&a->common, scene, of, a->sample, a->files, a->file, err),
                 a->sample ? "" : a->file[0], err);
}

static sp_status draw_fronts(const arguments *a, const sp_scene *scene, sp_error *err) {
    return draw_tables(a, scene, PLOT_FRONTS, err);
}

static sp_status draw_scaling(const arguments *a, const sp_scene *scene, sp_error *err) {
    return draw_tables(a, scene, PLOT_SCALING, err);
}

static sp_status draw_ensemble(const arguments *a, const sp_scene *scene, sp_error *err) {
    return draw_tables(a, scene, PLOT_ENSEMBLE, err);
}

static sp_status draw_modes(const arguments *a, const sp_scene *scene, sp_error *err) {
    return draw_tables(a, scene, PLOT_MODES, err);
}

static sp_status draw_wave(const arguments *a, const sp_scene *scene, sp_error *err) {
    return draw_tables(a, scene, PLOT_WAVE, err);
}

static sp_status draw_column(const arguments *a, const sp_scene *scene, sp_error *err) {
    (void)scene;
    const sp_plot_column_options options = {.surface = a->surface, .column = a->column};
    return blame(plot_column_files(&a->common, &options, a->files, a->file, err), a->file[0], err);
}

static const kind kinds[] = {{"ctof", draw_ctof, 1, true, ""},
                             {"signal", draw_signal, 1 << 16, false, "network signal"},
                             {"network", draw_network, 1, false, "network"},
                             {"stiffness", draw_stiffness, 1, false, "network"},
                             {"pareto", draw_pareto, 1, false, ""},
                             {"spectrum", draw_spectrum, 32, false, "network"},
                             {"dispersion", draw_dispersion, 2, false, "network"},
                             {"mode", draw_mode, 1, false, "network"},
                             {"modes", draw_modes, 1, false, ""},
                             {"angles", draw_angles, 1 << 16, false, "network"},
                             {"forces", draw_forces, 1 << 16, false, "network"},
                             {"snapshot", draw_snapshot, 1, false, "network signal"},
                             {"fronts", draw_fronts, 32, false, "network signal"},
                             {"scaling", draw_scaling, 32, false, ""},
                             {"ensemble", draw_ensemble, 6, false, ""},
                             {"wave", draw_wave, 6, false, ""},
                             {"column", draw_column, 6, false, ""}};
#define KIND_NAMES                                                                                                     \
    "ctof, signal, network, stiffness, angles, forces, snapshot, fronts, scaling, ensemble, pareto, spectrum, "        \
    "dispersion, wave, column, mode or modes"

/* ---- the command ------------------------------------------------------------------------------------------------ */

enum { KEY_STORE = 0x1000, KEY_CASE, KEY_MODE, KEY_COLUMN, KEY_TIME, KEY_SIGNAL, KEY_SURFACE };

static const struct argp_option options[] = {
    {"store", KEY_STORE, "DIR", 0, "ctof: of the samples in this folder, instead of a table", 0},
    {"case", KEY_CASE, "CASE", 0, "pareto: of this case, instead of the table's first", 0},
    {"column", KEY_COLUMN, "NAME", 0,
     "spectrum, of harmonic: alpha, k or speed instead of the force; column, of bifurcations: y2, ... instead of y1",
     0},
    {"mode", KEY_MODE, "N", 0, "mode: its number in `sonopack modes' (the first that is no zero mode)", 0},
    {"time", KEY_TIME, "T", 0, "snapshot: after the pulse (3.2 H (p/1e-4)^(-1/6): the wave is well on its way)", 0},
    {"signal", KEY_SIGNAL, "FILE", 0, "fronts: a signal or packing whose front shows in an inset what the marks are",
     0},
    {"surface", KEY_SURFACE, NULL, 0, "column: a trajectory or densities as a surface over particle and time", 0},
    {0}};
static const struct argp_child children[] = {{&cli_common_argp, 0, "Common options:", 90}, {0}};

static const kind *find_kind(const char *name) {
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++)
        if (strcmp(kinds[k].name, name) == 0)
            return &kinds[k];
    return NULL;
}

static bool column_fits(const arguments *a) {
    const char *c = a->column;
    if (a->kind->draw == draw_column)
        return c[0] == 'y' && c[1] >= '1' && c[1] <= '9' && c[1 + strspn(c + 1, "0123456789")] == '\0';
    return strcmp(c, "alpha") == 0 || strcmp(c, "k") == 0 || strcmp(c, "speed") == 0;
}

static void check(const arguments *a, struct argp_state *state) {
    if (!a->kind)
        argp_error(state, "no kind: must be " KIND_NAMES);
    else if (a->store && !a->kind->store)
        argp_error(state, "--store: only plot ctof draws a store");
    else if (a->mode >= 0 && a->kind->draw != draw_mode)
        argp_error(state, "--mode: only plot mode draws a mode");
    else if (a->time >= 0 && a->kind->draw != draw_snapshot)
        argp_error(state, "--time: only plot snapshot draws one time");
    else if (a->sample && a->kind->draw != draw_fronts)
        argp_error(state, "--signal: only plot fronts has an inset with a signal");
    else if (a->column && a->kind->draw != draw_spectrum && a->kind->draw != draw_column)
        argp_error(state,
                   "--column: only plot spectrum draws a column of a harmonic response, and plot column one of a "
                   "bifurcation");
    else if (a->column && !column_fits(a))
        argp_error(state, "--column %.60s: must be %s", a->column,
                   a->kind->draw == draw_column ? "y1, y2, ..." : "alpha, k or speed");
    else if (a->surface && a->kind->draw != draw_column)
        argp_error(state, "--surface: only plot column draws one");
    else if (a->store && a->files > 0)
        argp_error(state, "%s: must be a file or --store, not both", a->file[0]);
    else if (a->only && a->kind->draw != draw_pareto)
        argp_error(state, "--case: only plot pareto draws a case of a table");
    else if (!a->store && a->files == 0)
        argp_error(state, "plot %s: no file to draw", a->kind->name);
    else if (a->files > a->kind->most)
        argp_error(state, "plot %s: %d files, must be %d at the most", a->kind->name, a->files, a->kind->most);
    else if (a->common.sets > 0 && !a->kind->sets[0])
        argp_error(state, "--set: no key of a scene changes a figure of %s", a->kind->name);
    else if (!a->common.output)
        argp_error(state, "no -o FILE: must end in .svg, .png or .pdf");
}

static error_t parse(int key, char *arg, struct argp_state *state) {
    arguments *a = state->input;
    sp_error err = {0};
    switch (key) {
    case ARGP_KEY_INIT: state->child_inputs[0] = &a->common; return 0;
    case KEY_STORE: a->store = arg; return 0;
    case KEY_MODE:
        if (cli_integer("--mode", arg, 0, 1000000000, &a->mode, &err) != SP_OK)
            argp_error(state, "%s", err.text);
        return 0;
    case KEY_TIME:
        if (cli_number("--time", arg, 0, 1e9, &a->time, &err) != SP_OK)
            argp_error(state, "%s", err.text);
        return 0;
    case KEY_SIGNAL: a->sample = arg; return 0;
    case KEY_CASE: a->only = arg; return 0;
    case KEY_COLUMN: a->column = arg; return 0;
    case KEY_SURFACE: a->surface = true; return 0;
    case ARGP_KEY_ARG:
        if (a->kind)
            return ARGP_ERR_UNKNOWN; /* the rest are files */
        a->kind = find_kind(arg);
        if (!a->kind)
            argp_error(state, "unknown kind %.60s: must be " KIND_NAMES, arg);
        return 0;
    case ARGP_KEY_ARGS:
        a->file = state->argv + state->next;
        a->files = state->argc - state->next;
        return 0;
    case ARGP_KEY_END: check(a, state); return 0;
    default: return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp argp = {
    options,
    parse,
    "KIND FILE... -o FIGURE\nctof --store DIR -o FIGURE",
    "Figures at the width of a column of print: PNG (300 dpi), SVG or PDF by the ending of FIGURE.\v"
    "ctof: speeds against pressure with the published c_tof = 0.26 (p/1e-4)^(1/6), from a table that `sonopack "
    "table ctof' prints (TSV or CSV). signal: F(t) of one or more tables with columns t and F (or F1, F2, ...), or "
    "of packings (their signal is made), with the first front marked: a triangle at 10% of its peak, a circle at "
    "the peak, a square at the zero crossing; more than ten are drawn one above the other, at "
    "their distances where these are known. ensemble: tables with columns t, mean and rms, and low and high for a band "
    "around the mean. network: a packing with its "
    "contacts that carry "
    "as lines, as wide as "
    "their normal force is large; rattlers are grey. stiffness: the same with the normal stiffness. pareto: run "
    "time against error of a table of `sonopack bench', a symbol a method, hollow for those of other programs, and "
    "the frontier. spectrum: tables of `sonopack spectrum' dos, transmission, harmonic or participation, of "
    "`sonopack modes', of `sonopack table spectrum', or packings (their density of states). dispersion: a table of "
    "`sonopack spectrum dispersion', or a packing; bars are half widths. mode: the displacements of a mode as arrows "
    "on the grains of a packing, tinted where they turn. modes: a table of `sonopack modes', omega^2 and a b against "
    "n. angles: "
    "directions of the contacts of packings (all, strong and weak ones, 3 d from the walls; a circle of radius 1 where "
    "they are isotropic). forces: histograms of their normal forces and stiffnesses over the means. snapshot: "
    "displacements of the grains of a packing some time after the pulse. fronts: arrival times against distance, with "
    "lines, and scaling: local exponents gamma and alpha, of tables of `sonopack table scaling' or `planes', `sonopack "
    "chain front' or (fronts) `sonopack front'. wave: phase speed and attenuation against the wave number, of tables "
    "of "
    "`sonopack wave', and Rayleigh's alpha = a k^(dimension + 1) through the points with alpha below k/10. column: a "
    "table of `sonopack column' (trajectory, strobe, lyapunov, bifurcation, compare, density or energy); several "
    "trajectories, of lattice, longwave and bsr, as surfaces side by side, two columns of print wide; a bifurcation "
    "and a table of lyapunov one above the other. --set "
    "changes keys of network and signal.",
    children,
    NULL,
    NULL};

static sp_status may_write(const arguments *a, sp_error *err) {
    const char *path = a->common.output;
    if (!cli_has_ending(path, ".svg") && !cli_has_ending(path, ".png") && !cli_has_ending(path, ".pdf"))
        return sp_fail(err, SP_EINVAL, "-o %s: a figure's ending must be .svg, .png or .pdf", path);
    if (a->common.format_given)
        return sp_fail(err, SP_EINVAL, "--format: is for tables; the ending of -o names a figure's format");
    return cli_may_write(&a->common, path, err);
}

int cmd_plot(int argc, char **argv) {
    arguments a = {.mode = -1, .time = -1};
    argp_parse(&argp, argc, argv, 0, NULL, &a);
    sp_error err = {0};
    sp_scene scene = sp_scene_default();
    sp_status status = may_write(&a, &err);
    if (status == SP_OK)
        status = cli_scene_of_sets(&a.common, a.kind->sets, &scene, &err);
    if (status == SP_OK)
        status = a.kind->draw(&a, &scene, &err);
    sp_scene_free(&scene);
    return status == SP_OK ? CLI_OK : cli_fail(&err);
}
