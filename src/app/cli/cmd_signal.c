/* sonopack signal: the force on the top wall after a short pulse at the bottom wall. */
#include "base/base.h"
#include "cli/places.h"
#include "cli/pulse.h"
#include "cli/springs.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Of dynamics where none is given: its errors fall with the square of the step. */
#define DYNAMICS_TOLERANCE 1e-3

typedef struct arguments {
    cli_common common;
    cli_springs springs;
    double until, tolerance, step, damping, amplitude; /* < 0: not given */
    int64_t points, planes, modes;
    bool front;
    int method, source;
    cli_component component;
    cli_places from, to;
    cli_pulse pulse;
    char *file;
} arguments;

enum {
    KEY_UNTIL = 0x1000,
    KEY_POINTS,
    KEY_METHOD,
    KEY_SOURCE,
    KEY_TOLERANCE,
    KEY_STEP,
    KEY_MODES,
    KEY_FRONT,
    KEY_DAMPING,
    KEY_AMPLITUDE,
    KEY_DETECTOR,
    KEY_FROM,
    KEY_COMPONENT,
    KEY_PLANES,
    KEY_PULSE,
    NOT_GIVEN = -1,
    SIGNALS_MAX = 1000 /* in one table */
};

static const struct argp_option options[] = {
    {"until", KEY_UNTIL, "T", 0, "Last time [d/sqrt(E* / rho)] ((8 H + 40) (p/1e-4)^(-1/6): the first front passes)",
     0},
    {"points", KEY_POINTS, "N", 0, "Equally spaced times 0 .. T (801)", 0},
    {"method", KEY_METHOD, "METHOD", 0, "How the signal is found: see below (auto)", 0},
    {"pulse", KEY_PULSE, "PULSE", 0,
     "Strength of the source against time: delta, gauss:WIDTH, ricker:OMEGA, sine:OMEGA:CYCLES, square:WIDTH or "
     "file:PATH (delta)",
     0},
    {"tolerance", KEY_TOLERANCE, "EPS", 0, "Error asked for, over the largest |F| (1e-10; dynamics: 1e-3)", 0},
    {"modes", KEY_MODES, "K", 0, "Of sparse: the K lowest, whatever the error (as many as the tolerance needs)", 0},
    {"stop-at-front", KEY_FRONT, NULL, 0, "End soon after the first front of every signal, N points or fewer", 0},
    {"damping", KEY_DAMPING, "ZETA", 0, "Dashpots at all contacts, a fraction ZETA of critical damping (0)", 0},
    {"amplitude", KEY_AMPLITUDE, "A", 0, "Of dynamics: how far grains move at the start, over the mean overlap (0.001)",
     0},
    {"step", KEY_STEP, "DT", 0,
     "Step of verlet, lax-wendroff and dynamics, whatever the error (found from the tolerance)", 0},
    {NULL, 0, NULL, 0, "Sources and detectors:", 10},
    {"source", KEY_SOURCE, "KIND[:PLACE]", 0,
     "What a bottom grain gets in proportion to its stiffness at the wall: impulse, velocity or displacement (impulse)",
     10},
    {"from", KEY_FROM, "PLACE", 0, "Source at bottom, part:X0:X1 or grain:I (bottom); repeatable", 10},
    {"detector", KEY_DETECTOR, "PLACE", 0, "Detector at top, plane:Y, part:X0:X1 or grain:I (top); repeatable", 10},
    {"component", KEY_COMPONENT, "normal|shear", 0,
     "Of every PLACE that ends neither in :normal nor in :shear (normal)", 10},
    {"planes", KEY_PLANES, "N", 0, "Detectors at N planes that cut the height into equal layers", 10},
    {0}};
static const struct argp_child children[] = {
    {&cli_springs_argp, 0, "Springs:", 50}, {&cli_common_argp, 0, "Common options:", 90}, {0}};

static void parse_method(arguments *a, const char *word, struct argp_state *state) {
    char names[300] = "";
    for (int k = 0; sp_signal_method_name((sp_signal_method)k); k++) {
        const char *name = sp_signal_method_name((sp_signal_method)k);
        if (strcmp(word, name) == 0) {
            a->method = k;
            return;
        }
        const size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s%s", k > 0 ? ", " : "", name);
    }
    argp_error(state, "--method %.60s: must be one of %s", word, names);
}

/* KIND, or KIND:PLACE, which is a place of its own too. */
static sp_status parse_source(arguments *a, const char *word, sp_error *err) {
    const size_t length = strcspn(word, ":");
    char kind[32] = "";
    sp_source source;
    if (length < sizeof kind)
        memcpy(kind, word, length);
    if (!cli_source_of(kind, &source))
        return sp_fail(err, SP_EINVAL,
                       "--source %.60s: must be impulse, velocity or displacement, and then :PLACE if wanted", word);
    if (a->source != NOT_GIVEN && a->source != (int)source)
        return sp_fail(err, SP_EINVAL, "--source %.60s: must be of one kind, %s was given before", word,
                       cli_source_name((sp_source)a->source));
    a->source = (int)source;
    return word[length] ? cli_places_add(&a->from, "--source", word + length + 1, err) : SP_OK;
}

static sp_status parse_place(int key, const char *word, arguments *a, sp_error *err) {
    switch (key) {
    case KEY_SOURCE: return parse_source(a, word, err);
    case KEY_FROM: return cli_places_add(&a->from, "--from", word, err);
    case KEY_DETECTOR: return cli_places_add(&a->to, "--detector", word, err);
    case KEY_PLANES: return cli_integer("--planes", word, 1, SIGNALS_MAX, &a->planes, err);
    default: break;
    }
    if (!cli_component_of(word, &a->component))
        return sp_fail(err, SP_EINVAL, "--component %.60s: must be normal or shear", word);
    return SP_OK;
}

static error_t parse(int key, char *arg, struct argp_state *state) {
    arguments *a = state->input;
    sp_error err = {0};
    sp_status status = SP_OK;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &a->springs;
        state->child_inputs[1] = &a->common;
        return 0;
    case KEY_UNTIL: status = cli_number("--until", arg, 1e-9, 1e9, &a->until, &err); break;
    case KEY_POINTS: status = cli_integer("--points", arg, 2, 10000000, &a->points, &err); break;
    case KEY_TOLERANCE: status = cli_number("--tolerance", arg, 1e-15, 0.1, &a->tolerance, &err); break;
    case KEY_MODES: status = cli_integer("--modes", arg, 1, INT32_MAX, &a->modes, &err); break;
    case KEY_FRONT: a->front = true; break;
    case KEY_STEP: status = cli_number("--step", arg, 1e-12, 1e9, &a->step, &err); break;
    case KEY_DAMPING: status = cli_number("--damping", arg, 0, 100, &a->damping, &err); break;
    case KEY_AMPLITUDE: status = cli_number("--amplitude", arg, 1e-12, 1000, &a->amplitude, &err); break;
    case KEY_METHOD: parse_method(a, arg, state); break;
    case KEY_PULSE: status = cli_pulse_parse(arg, &a->pulse, &err); break;
    case KEY_SOURCE:
    case KEY_FROM:
    case KEY_DETECTOR:
    case KEY_COMPONENT:
    case KEY_PLANES: status = parse_place(key, arg, a, &err); break;
    case ARGP_KEY_ARG:
        if (a->file)
            argp_error(state, "%.200s: a second file; a signal is a table of its own, one packing at a time", arg);
        a->file = arg;
        break;
    case ARGP_KEY_END:
        if (!a->file)
            argp_error(state, "no file: must be one packing");
        break;
    default: return ARGP_ERR_UNKNOWN;
    }
    if (status != SP_OK)
        argp_error(state, "%s", err.text);
    return 0;
}

static const struct argp argp = {
    options,
    parse,
    "FILE",
    "The force on the top wall, above its value at rest, after a short pulse at the bottom wall, by the linear "
    "equation of motion with both walls fixed.\v"
    "Columns t and F, the response to a pulse of unit strength; comments say height, pressure, method and the bound of "
    "the error of F. The work fails rather than exceed the tolerance. --set takes keys of the groups network and "
    "signal.\n\n"
    "Several sources or detectors make columns F1, F2, ..., every source to every detector, and comments say which is "
    "which. A plane feels the momentum that flows through it; a part of a wall are the grains whose centres lie in X0 "
    "<= x < X1; grain I (from 0) is felt by its contact with the wall, or by the net force on it if it has none.\n\n"
    "Methods: chebyshev (an expansion in matrix products), dense (the sum over all modes), sparse (over the lowest "
    "modes, as many as the tolerance needs), verlet and lax-wendroff (time steps of second and fourth order), faber "
    "(an expansion that allows for damping), dynamics (the nonlinear motion of the packing itself), auto (the "
    "fastest one of the linear ones).\n\n"
    "Pulses: gauss (standard deviation WIDTH) and square have the integral 1; ricker and sine (under a Hann window) "
    "have the angular frequency OMEGA and heights up to 1. Middle at t = 0: gauss, ricker. A file has times and "
    "strengths, with straight lines between.",
    children,
    NULL,
    NULL};

static sp_status wanted(arguments *a, const sp_scene *scene, const sp_packing *p, sp_signal_options *out,
                        sp_error *err) {
    sp_signal_options o = scene->signal;
    if (a->until >= 0)
        o.until = a->until;
    if (a->points >= 0)
        o.points = (int32_t)a->points;
    if (a->tolerance >= 0)
        o.tolerance = a->tolerance;
    if (a->step >= 0)
        o.step = a->step;
    if (a->modes > 0)
        o.modes = a->modes;
    o.front = o.front || a->front;
    if (a->damping >= 0)
        o.damping = a->damping;
    if (a->amplitude >= 0)
        o.amplitude = a->amplitude;
    if (a->method != NOT_GIVEN)
        o.method = (sp_signal_method)a->method;
    if (a->amplitude >= 0 && o.method != SP_SIGNAL_DYNAMICS)
        return sp_fail(err, SP_EINVAL, "--amplitude: must be with --method dynamics; linear signals have none");
    if (o.method == SP_SIGNAL_DYNAMICS && a->tolerance < 0)
        o.tolerance = fmax(o.tolerance, DYNAMICS_TOLERANCE);
    if (a->source != NOT_GIVEN)
        o.source = (sp_source)a->source;
    if (o.until == 0)
        o.until = sp_signal_window(sp_packing_height(p), p->pressure);
    o.threads = a->common.threads;
    sp_status status = cli_places_add_planes(&a->to, a->planes, sp_packing_height(p), err);
    if (status == SP_OK)
        status = cli_places_settle(&a->from, a->component == COMPONENT_SHEAR, err);
    if (status == SP_OK)
        status = cli_places_settle(&a->to, a->component == COMPONENT_SHEAR, err);
    if (status != SP_OK)
        return status;
    if ((int64_t)a->from.n * a->to.n > SIGNALS_MAX)
        return sp_fail(err, SP_EINVAL, "%d sources and %d detectors: must be %d signals at the most in one table",
                       a->from.n, a->to.n, SIGNALS_MAX);
    o.sources = a->from.n;
    o.from = a->from.at;
    o.detectors = a->to.n;
    o.to = a->to.at;
    *out = o;
    return SP_OK;
}

/* Which signal each column is, and how well it is known. */
static sp_status name_columns(const arguments *a, const sp_signal *s, sp_table *t, sp_error *err) {
    char from[CLI_PLACE_TEXT], to[CLI_PLACE_TEXT], error[SP_NUMBER_TEXT], name[16] = "F";
    const int32_t pairs = s->sources * s->detectors;
    sp_status status = sp_table_add_column(t, "t", "d/sqrt(E* / rho)", SP_CELL_NUMBER, err);
    for (int32_t k = 0; k < pairs && status == SP_OK; k++) {
        cli_place_text(&a->from.at[k / s->detectors], true, from);
        cli_place_text(&a->to.at[k % s->detectors], false, to);
        if (pairs > 1)
            snprintf(name, sizeof name, "F%d", k + 1);
        status = sp_table_add_column(t, name, "E* d^2", SP_CELL_NUMBER, err);
        if (status == SP_OK)
            status = sp_table_add_comment(t, err, "%s = from %s to %s, error %s", name, from, to,
                                          sp_number_text(s->errors[k], error));
    }
    return status;
}

static sp_status add_rows(const sp_signal *s, sp_table *t, sp_error *err) {
    const int32_t pairs = s->sources * s->detectors;
    double *row = sp_alloc(1 + (size_t)pairs, sizeof *row);
    sp_status status = row ? SP_OK : sp_fail_memory(err, (1 + (size_t)pairs) * sizeof *row);
    for (int32_t l = 0; l < s->n && status == SP_OK; l++) {
        row[0] = s->t[l];
        for (int32_t k = 0; k < pairs; k++)
            row[1 + k] = s->f[(int64_t)k * s->n + l];
        status = sp_table_add_numbers(t, row, err);
    }
    sp_free(row);
    return status;
}

static sp_status fill(const arguments *a, const sp_packing *p, const sp_signal_options *o, const sp_signal *s,
                      sp_table *t, sp_error *err) {
    char number[SP_NUMBER_TEXT];
    const struct {
        const char *key;
        double value;
    } comments[] = {{"height", sp_packing_height(p)},
                    {"pressure", p->pressure},
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
    sp_status status = sp_table_add_comment(t, err, "file = %s", a->file);
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "method = %s", sp_signal_method_name(s->method));
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "source = %s", cli_source_name(o->source));
    if (status == SP_OK && a->pulse.word)
        status = sp_table_add_comment(t, err, "pulse = %s", a->pulse.word);
    for (size_t k = 0; k < sizeof comments / sizeof *comments && status == SP_OK; k++)
        if (k < ALWAYS || comments[k].value != 0)
            status =
                sp_table_add_comment(t, err, "%s = %s", comments[k].key, sp_number_text(comments[k].value, number));
    if (status == SP_OK)
        status = name_columns(a, s, t, err);
    return status == SP_OK ? add_rows(s, t, err) : status;
}

static sp_status work(arguments *a, sp_error *err) {
    sp_scene scene = sp_scene_default();
    sp_packing p = sp_packing_none();
    sp_network net = sp_network_none();
    sp_signal s = sp_signal_none();
    sp_table t = sp_table_none();
    sp_signal_options o;
    sp_status status = cli_may_write_table(&a->common, err);
    if (status == SP_OK)
        status = cli_springs_scene(&a->common, &a->springs, "network signal", &scene, err);
    if (status == SP_OK)
        status = cli_read_network(a->file, &scene.network, &p, &net, err);
    if (status == SP_OK)
        status = cli_pulse_open(&a->pulse, err);
    if (status == SP_OK)
        status = wanted(a, &scene, &p, &o, err);
    if (status == SP_OK) {
        status = a->pulse.word ? sp_signal_pulse(&net, &o, &a->pulse.pulse, &s, err)
                               : sp_signal_dynamics(&p, &net, &o, &s, err);
        if (status != SP_OK)
            sp_fail_prefix(err, "%s", a->file);
    }
    if (status == SP_OK)
        status = fill(a, &p, &o, &s, &t, err);
    if (status == SP_OK)
        cli_debug(&a->common, "%s: %s, %d products, error %.3g", a->file, sp_signal_method_name(s.method), s.products,
                  s.error);
    if (status == SP_OK)
        status = cli_write_table(&a->common, &t, err);
    sp_table_free(&t);
    sp_signal_free(&s);
    sp_network_free(&net);
    sp_packing_free(&p);
    sp_scene_free(&scene);
    return status;
}

int cmd_signal(int argc, char **argv) {
    arguments a = {.until = -1,
                   .tolerance = -1,
                   .step = -1,
                   .damping = -1,
                   .amplitude = -1,
                   .points = -1,
                   .method = NOT_GIVEN,
                   .source = NOT_GIVEN,
                   .from = {.sources = true}};
    argp_parse(&argp, argc, argv, 0, NULL, &a);
    sp_error err = {0};
    const int status = work(&a, &err) == SP_OK ? CLI_OK : cli_fail(&err);
    cli_pulse_free(&a.pulse);
    cli_places_free(&a.from);
    cli_places_free(&a.to);
    return status;
}
