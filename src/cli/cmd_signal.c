/* sonopack signal: prints the force on the top wall after a short pulse at the bottom wall. */
#include "base/base.h"
#include "cli/excitation.h"
#include "cli/files.h"
#include "packing/geometry.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Default of dynamics, whose error falls only with the square of the time step. */
#define DYNAMICS_TOLERANCE 1e-3

enum { NOT_GIVEN = -1, SIGNALS_MAX = 1000 /* in one table */ };

typedef struct arguments {
    cli_common common;
    int64_t planes;
    int source, component; /* NOT_GIVEN or sp_source, 1 for shear */
    int engine;            /* 1: PETSc */
    cli_places sources, detectors;
    cli_pulse pulse;
} arguments;

/* KIND or KIND:PLACE. */
static sp_status set_source(void *user, const char *word, sp_error *err) {
    arguments *a = user;
    const size_t length = strcspn(word, ":");
    char kind[32] = "";
    int source;
    if (length < sizeof kind)
        memcpy(kind, word, length);
    sp_status status = cli_choose("--source", kind, cli_source_names, &source, err);
    if (status == SP_OK && a->source != NOT_GIVEN && a->source != source)
        status = sp_fail(err, SP_EINVAL, "--source %.60s: all sources must be of one kind, and %s was given before",
                         word, cli_source_names[a->source]);
    if (status != SP_OK)
        return status;
    a->source = source;
    return word[length] ? cli_places_add(&a->sources, word + length + 1, err) : SP_OK;
}

static sp_status set_damping(void *scene, const char *word, sp_error *err) {
    sp_signal_options *o = &((sp_scene *)scene)->signal;
    sp_damping law = sp_signal_damping(o);
    const sp_status status = cli_damping_read(word, 0, 100, &law, err);
    o->damping = law.value;
    o->damping_kind = law.kind;
    o->damping_ratio = law.ratio;
    return status;
}

static const char *const engine_words[] = {"sonopack", "petsc", NULL};

static const cli_option options[] = {
    {"until", "T", "Last time [d/sqrt(E* / rho)] ((8 H + 40) (p/1e-4)^(-1/6), after the first front)", CLI_NUMBER,
     .scene = true, .field = offsetof(sp_scene, signal.until), .low = 1e-9, .high = 1e9, .unit = "d/sqrt(E* / rho)"},
    {"points", "N", "Number of equally spaced times from 0 to T (801)", CLI_INT, .scene = true, .key = "signal.points"},
    {"method", "METHOD", "How to compute the signal; see below (auto)", CLI_CHOICE, .scene = true,
     .key = "signal.method"},
    {"pulse", "PULSE",
     "Strength of the source against time: delta, gauss:WIDTH, ricker:OMEGA, sine:OMEGA:CYCLES, square:WIDTH or "
     "file:PATH (delta)",
     .parse = cli_pulse_parse, CLI_FIELD(pulse)},
    {"tolerance", "EPS", "Largest error, relative to the largest |F| (1e-10; dynamics: 1e-3)", CLI_NUMBER,
     .scene = true, .key = "signal.tolerance"},
    {"modes", "K",
     "sparse: use the K lowest modes, regardless of the error (as many as the tolerance needs, nearly always all)",
     CLI_INTEGER, .scene = true, .field = offsetof(sp_scene, signal.modes), .low = 1, .high = INT32_MAX},
    {"solver", CLI_SOLVERS, "sparse: solver of the modes, as in modes (auto)", CLI_CHOICE, .scene = true,
     .field = offsetof(sp_scene, signal.solver), .words = cli_solver_names},
    {"stop-at-front", NULL, "Stop soon after the first front of every signal; there may be fewer than N points",
     CLI_FLAG, .scene = true, .field = offsetof(sp_scene, signal.front)},
    {"damping", CLI_DAMPING,
     "Add dashpots to all contacts: the fraction ZETA of critical damping, the same coefficient C at every contact, or "
     "RATE times the reduced mass; CT and RATET are the tangential ones (C and RATE)",
     .scene = true, .parse = set_damping},
    {"amplitude", "A", "dynamics: initial displacement, relative to the mean overlap (0.001)", CLI_NUMBER,
     .scene = true, .field = offsetof(sp_scene, signal.amplitude), .low = 1e-12, .high = 1000},
    {"step", "DT", "verlet, lax-wendroff and dynamics: time step, regardless of the error (chosen from the tolerance)",
     CLI_NUMBER, .scene = true, .field = offsetof(sp_scene, signal.step), .low = 1e-12, .high = 1e9,
     .unit = "d/sqrt(E* / rho)"},
    {.help = "Sources and detectors:"},
    {"source", "KIND[:PLACE]",
     "What the source imposes on a grain at the bottom wall, in proportion to the stiffness of its contact: impulse, "
     "velocity or displacement (impulse)",
     .parse = set_source, .words = cli_source_names},
    {"from", "PLACE", "Source at bottom, part:X0:X1, disc:X:Y:D, plane:Y or grain:I (bottom); repeatable",
     .parse = cli_places_add, CLI_FIELD(sources)},
    {"detector", "PLACE", "Detector at top, plane:Y, part:X0:X1, disc:X:Y:D or grain:I (top); repeatable",
     .parse = cli_places_add, CLI_FIELD(detectors)},
    {"component", "normal|shear", "Component at every PLACE without :normal or :shear at its end (normal)", CLI_CHOICE,
     CLI_FIELD(component), .words = cli_component_names},
    {"planes", "N", "Detectors at N planes that divide the height into equal layers", CLI_INTEGER, CLI_FIELD(planes),
     .low = 1, .high = SIGNALS_MAX},
    {.help = "Before long work:"},
    CLI_DRY_RUN,
    {.help = "Beyond one machine (docs/cluster.md):"},
    {"engine", "sonopack|petsc", "Program that computes the signal; petsc: on N ranks after mpirun -n N (sonopack)",
     CLI_CHOICE, CLI_FIELD(engine), .words = engine_words},
    {0}};

const cli_syntax cmd_signal_syntax = {
    .usage = "FILE",
    .help =
        "Force on the top wall, minus its value at rest, after a short pulse at the bottom wall, from the linear "
        "equation of motion between fixed walls.\vThe columns t and F are the response to a pulse of unit strength. "
        "Comments give the height, the pressure, the method, and a bound for the error of F (with dynamics and with "
        "--pulse an estimate, error_kind). The command fails rather than exceed the tolerance. --set takes keys of the "
        "groups network and signal. -o FILE.sac and FILE.slist write for SAC and ObsPy, FILE.mat for MATLAB and "
        "Octave.\n"
        "\n"
        "With several sources or detectors there is a column F1, F2, ... for each pair, explained by a comment. A "
        "plane measures the momentum flux through it. part:X0:X1 consists of the grains at the wall whose centres are "
        "at X0 <= x < X1; disc:X:Y:D, in space, of those within D/2 of X, Y: a round transducer. grain:I (from 0) is "
        "measured by its contact with the wall, or by the net force on it if it does not touch the wall. As a source a "
        "plane gives unit momentum (impulse), velocity or displacement to each grain whose centre is within half a "
        "mean diameter of it, and grain:I to a grain that does not touch the wall.\n"
        "\n"
        "In a ring the inner wall is the bottom, the outer the top, and plane:Y the circle at Y from the inner one. A "
        "periodic cell has no walls: give --from and --detector as plane:Y or grain:I. A pulse then travels both up "
        "and down from its plane, and meets itself after a period.\n"
        "\n"
        "Methods: chebyshev (polynomial expansion with matrix products), dense (sum over all modes), sparse (sum over "
        "the lowest modes, as many as the tolerance needs), verlet and lax-wendroff (time steps of second and fourth "
        "order), faber (polynomial expansion with damping), dynamics (nonlinear motion of the packing), auto (the "
        "fastest of the linear methods).\n"
        "\n"
        "Pulses: gauss (standard deviation WIDTH) and square have unit integral; ricker and sine (under a Hann window) "
        "have the angular frequency OMEGA and the amplitude 1. gauss and ricker are centred at t = 0. A file has "
        "columns of times and strengths, which are interpolated linearly.",
    CLI_ONE_PACKING,
    .options = options,
    .springs = true};

/* The scene's options, with what depends on the packing. */
static sp_status set_options(arguments *a, const sp_scene *scene, const sp_packing *p, sp_signal_options *out,
                             sp_error *err) {
    sp_signal_options o = scene->signal;
    if (o.solver != SP_SOLVER_AUTO && o.method != SP_SIGNAL_SPARSE)
        return sp_fail(err, SP_EINVAL, "--solver: applies only to --method sparse");
    if (cli_given(&cmd_signal_syntax, &a->common, "amplitude") && o.method != SP_SIGNAL_DYNAMICS)
        return sp_fail(err, SP_EINVAL, "--amplitude: applies only to --method dynamics, the other signals are linear");
    if (o.method == SP_SIGNAL_DYNAMICS && !cli_given(&cmd_signal_syntax, &a->common, "tolerance"))
        o.tolerance = fmax(o.tolerance, DYNAMICS_TOLERANCE);
    if (a->source != NOT_GIVEN)
        o.source = (sp_source)a->source;
    if (o.until == 0)
        o.until = sp_signal_window(sp_packing_height(p), p->pressure);
    o.threads = a->common.threads;
    sp_status status = cli_places_add_planes(&a->detectors, a->planes, sp_packing_height(p), err);
    if (status != SP_OK)
        return status;
    cli_places_set_component(&a->sources, a->component == 1);
    cli_places_set_component(&a->detectors, a->component == 1);
    if ((int64_t)a->sources.n * a->detectors.n > SIGNALS_MAX)
        return sp_fail(err, SP_EINVAL, "%d sources and %d detectors: a table has at most %d signals", a->sources.n,
                       a->detectors.n, SIGNALS_MAX);
    o.sources = a->sources.n;
    o.from = a->sources.at;
    o.detectors = a->detectors.n;
    o.to = a->detectors.at;
    *out = o;
    return SP_OK;
}

/* Adds the columns; a comment for each names its source, its detector and its error. */
static void name_columns(const arguments *a, const sp_signal *s, cli_writer *w) {
    char from[SP_PLACE_TEXT], to[SP_PLACE_TEXT], error[SP_NUMBER_TEXT], name[16] = "F";
    const int32_t pairs = s->sources * s->detectors;
    cli_columns(w, SP_COLUMN_NUMBER, "t", "d/sqrt(E* / rho)", NULL);
    for (int32_t k = 0; k < pairs && w->status == SP_OK; k++) {
        sp_place_text(&a->sources.at[k / s->detectors], true, from);
        sp_place_text(&a->detectors.at[k % s->detectors], false, to);
        if (pairs > 1)
            snprintf(name, sizeof name, "F%d", k + 1);
        cli_columns(w, SP_COLUMN_NUMBER, name, "E* d^2", NULL);
        cli_comment(w, "%s = from %s to %s, error %s", name, from, to, sp_number_text(s->errors[k], error));
    }
}

static sp_status add_rows(const sp_signal *s, cli_writer *w) {
    const int32_t pairs = s->sources * s->detectors;
    double *row = sp_alloc(1 + (size_t)pairs, sizeof *row);
    sp_status status = row ? SP_OK : sp_fail_memory(w->err, (1 + (size_t)pairs) * sizeof *row);
    for (int32_t l = 0; l < s->n && status == SP_OK; l++) {
        row[0] = s->t[l];
        for (int32_t k = 0; k < pairs; k++)
            row[1 + k] = s->f[(int64_t)k * s->n + l];
        status = sp_table_add_numbers(w->table, row, w->err);
    }
    sp_free(row);
    return status;
}

static sp_status add_signal(const arguments *a, const cli_file *file, const sp_signal_options *o, const sp_signal *s,
                            cli_writer *w) {
    const struct {
        const char *key;
        double value;
    } comments[] = {{"height", sp_packing_height(&file->packing)},
                    {"pressure", file->packing.pressure},
                    {"error", s->error},
                    {"tolerance", o->tolerance},
                    {"until", o->until},
                    {"omega_max", s->omega_max},
                    {"products", (double)s->products},
                    {"damping", o->damping},
                    {"step", s->step},
                    {"amplitude", s->method == SP_SIGNAL_DYNAMICS ? o->amplitude : 0},
                    {"factor", s->amplitude},
                    {"modes", (double)s->modes}};
    enum { ALWAYS = 7 }; /* the first of them; the others belong to some methods */
    cli_comment(w, "file = %s", file->path);
    cli_comment(w, "method = %s", sp_signal_method_name(s->method));
    cli_comment(w, "source = %s", cli_source_names[o->source]);
    if (file->packing.dim == 3) /* heights are z then */
        cli_comment(w, "dimension = 3");
    if (file->packing.cell != SP_CELL_PISTON)
        cli_comment(w, "cell = %s", sp_cell_names[file->packing.cell]);
    if (a->pulse.word)
        cli_comment(w, "pulse = %s", a->pulse.word);
    const sp_damping law = sp_signal_damping(o);
    for (size_t k = 0; k < sizeof comments / sizeof *comments; k++)
        if (strcmp(comments[k].key, "damping") == 0 && law.value > 0)
            cli_damping_comment(w, &law);
        else if (k < ALWAYS || comments[k].value != 0)
            cli_value(w, comments[k].key, comments[k].value);
    if (s->method == SP_SIGNAL_DYNAMICS || a->pulse.word) /* else a bound */
        cli_comment(w, "error_kind = estimate");
    name_columns(a, s, w);
    return w->status == SP_OK ? add_rows(s, w) : w->status;
}

static sp_status open_pulse(void *user, cli_writer *w) { return cli_pulse_open(&((arguments *)user)->pulse, w->err); }

/* The options, and whether their table fits into memory: a value takes 8 bytes in the signal, twice that in the table
 * and about 24 in its text. */
static sp_status set_and_check(arguments *a, const cli_file *file, sp_signal_options *o, sp_error *err) {
    const sp_status status = set_options(a, file->scene, &file->packing, o, err);
    if (status != SP_OK)
        return status;
    const double pairs = (o->sources > 0 ? o->sources : 1.0) * (o->detectors > 0 ? o->detectors : 1.0);
    const double bytes = 48.0 * o->points * (1 + pairs), most = 0.5 * sp_memory_limit();
    if (bytes <= most)
        return SP_OK;
    return sp_fail(err, SP_ENOMEM, "%d points of %.0f signals need about %.3g GB of memory, the limit is %.3g GB",
                   o->points, pairs, 1e-9 * bytes, 1e-9 * most);
}

static sp_status compute(void *user, cli_file *file, cli_writer *w) {
    arguments *a = user;
    sp_signal s = sp_signal_none();
    sp_signal_options o;
    sp_status status = set_and_check(a, file, &o, w->err);
    CLI_THEN(status, a->pulse.word ? sp_signal_pulse(&file->network, &o, &a->pulse.pulse, &s, w->err)
                                   : sp_signal_compute(&file->packing, &file->network, &o, &s, w->err));
    CLI_THEN(status, add_signal(a, file, &o, &s, w));
    if (status == SP_OK)
        cli_debug(&a->common, "%s: %s, %d products, error %.3g", file->path, sp_signal_method_name(s.method),
                  s.products, s.error);
    sp_signal_free(&s);
    return status;
}

static sp_status plan(void *user, const cli_file *file, cli_plan *p, sp_error *err) {
    arguments *a = user;
    sp_signal_options o;
    sp_signal_method method = SP_SIGNAL_AUTO;
    double products = 0;
    char what[64];
    sp_status status = set_and_check(a, file, &o, err);
    if (status != SP_OK)
        return status;
    const sp_network_size net = sp_network_size_of(&file->network, sp_packing_height(&file->packing));
    const sp_cost cost = sp_cost_signal(&net, &o, &p->machine, &method, &products);
    const int pairs = (o.sources > 0 ? o.sources : 1) * (o.detectors > 0 ? o.detectors : 1);
    snprintf(what, sizeof what, "signals by %s", sp_signal_method_name(method));
    if (products > 0)
        cli_comment(&p->w, "products = %.3g", products);
    if (isnan(cost.cpu))
        cli_comment(&p->w, "nan: there is no law for the steps of %s", sp_signal_method_name(method));
    cli_plan_add(p, "network", 1, sp_cost_result(SP_RESULT_NETWORK, &net, 1, &p->machine), 0);
    cli_plan_add(p, what, pairs, cost, a->common.output ? sp_bytes_table(o.points, 1 + pairs) : 0);
    return SP_OK;
}

int cmd_signal(int argc, char **argv) {
    static const cli_files command = {.groups = "network signal",
                                      .contents = CLI_NETWORK,
                                      .stop = true,
                                      .begin = open_pulse,
                                      .add = compute,
                                      .plan = plan,
                                      .kernels =
                                          1U << SP_KERNEL_STEP | 1U << SP_KERNEL_PRODUCT | 1U << SP_KERNEL_DENSE};
    arguments a = {.source = NOT_GIVEN, .sources = {.sources = true}};
    cli_parse(&cmd_signal_syntax, argc, argv, &a);
    if (a.engine)
        return cmd_engine("sonopack signal-petsc", argc, argv);
    const int status = cli_run_files(&command, &a);
    cli_pulse_free(&a.pulse);
    return status;
}
