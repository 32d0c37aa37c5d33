/* sonopack signal: the force on the top wall after a short pulse at the bottom wall. */
#include "base/base.h"
#include "cli/springs.h"

#include <string.h>

typedef struct arguments {
    cli_common common;
    cli_springs springs;
    double until, tolerance; /* < 0: not given */
    int64_t points;
    int method, source;
    char *file;
} arguments;

enum { KEY_UNTIL = 0x1000, KEY_POINTS, KEY_METHOD, KEY_SOURCE, KEY_TOLERANCE, NOT_GIVEN = -1 };

static const struct argp_option options[] = {
    {"until", KEY_UNTIL, "T", 0, "Last time [d/sqrt(E* / rho)] ((8 H + 40) (p/1e-4)^(-1/6): the first front passes)",
     0},
    {"points", KEY_POINTS, "N", 0, "Equally spaced times 0 .. T (801)", 0},
    {"method", KEY_METHOD, "auto|chebyshev|dense", 0, "Expansion in matrix products, or sum over all modes (auto)", 0},
    {"source", KEY_SOURCE, "impulse|velocity|displacement", 0,
     "What a bottom grain gets in proportion to its stiffness at the wall (impulse)", 0},
    {"tolerance", KEY_TOLERANCE, "EPS", 0, "Error asked for, over the largest |F| (1e-10)", 0},
    {0}};
static const struct argp_child children[] = {
    {&cli_springs_argp, 0, "Springs:", 50}, {&cli_common_argp, 0, "Common options:", 90}, {0}};

static const char *const methods[] = {
    [SP_SIGNAL_AUTO] = "auto", [SP_SIGNAL_CHEBYSHEV] = "chebyshev", [SP_SIGNAL_DENSE] = "dense"};

static void parse_method(arguments *a, const char *word, struct argp_state *state) {
    for (int k = 0; k < (int)(sizeof methods / sizeof *methods); k++)
        if (strcmp(word, methods[k]) == 0) {
            a->method = k;
            return;
        }
    argp_error(state, "--method %.60s: must be auto, chebyshev or dense", word);
}

static error_t parse(int key, char *arg, struct argp_state *state) {
    arguments *a = state->input;
    sp_error err = {0};
    sp_status status = SP_OK;
    sp_source source;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &a->springs;
        state->child_inputs[1] = &a->common;
        return 0;
    case KEY_UNTIL: status = cli_number("--until", arg, 1e-9, 1e9, &a->until, &err); break;
    case KEY_POINTS: status = cli_integer("--points", arg, 2, 10000000, &a->points, &err); break;
    case KEY_TOLERANCE: status = cli_number("--tolerance", arg, 1e-15, 0.1, &a->tolerance, &err); break;
    case KEY_METHOD: parse_method(a, arg, state); break;
    case KEY_SOURCE:
        if (cli_source_of(arg, &source))
            a->source = (int)source;
        else
            argp_error(state, "--source %.60s: must be impulse, velocity or displacement", arg);
        break;
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
    "signal.",
    children,
    NULL,
    NULL};

static sp_signal_options wanted(const arguments *a, const sp_scene *scene, const sp_packing *p) {
    sp_signal_options o = scene->signal;
    if (a->until >= 0)
        o.until = a->until;
    if (a->points >= 0)
        o.points = (int32_t)a->points;
    if (a->tolerance >= 0)
        o.tolerance = a->tolerance;
    if (a->method != NOT_GIVEN)
        o.method = (sp_signal_method)a->method;
    if (a->source != NOT_GIVEN)
        o.source = (sp_source)a->source;
    if (o.until == 0)
        o.until = sp_signal_window(sp_packing_height(p), p->pressure);
    return o;
}

static sp_status fill(const arguments *a, const sp_packing *p, const sp_signal_options *o, const sp_signal *s,
                      sp_table *t, sp_error *err) {
    char number[SP_NUMBER_TEXT];
    const struct {
        const char *key;
        double value;
    } comments[] = {{"height", sp_packing_height(p)}, {"pressure", p->pressure}, {"error", s->error},
                    {"tolerance", o->tolerance},      {"until", o->until},       {"omega_max", s->omega_max},
                    {"products", (double)s->products}};
    sp_status status = sp_table_add_column(t, "t", "d/sqrt(E* / rho)", SP_CELL_NUMBER, err);
    if (status == SP_OK)
        status = sp_table_add_column(t, "F", "E* d^2", SP_CELL_NUMBER, err);
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "file = %s", a->file);
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "method = %s", methods[s->method]);
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "source = %s", cli_source_name(o->source));
    for (size_t k = 0; k < sizeof comments / sizeof *comments && status == SP_OK; k++)
        status = sp_table_add_comment(t, err, "%s = %s", comments[k].key, sp_number_text(comments[k].value, number));
    for (int32_t l = 0; l < s->n && status == SP_OK; l++)
        status = sp_table_add_row(t, err, s->t[l], s->f[l]);
    return status;
}

static sp_status work(const arguments *a, sp_error *err) {
    sp_scene scene = sp_scene_default();
    sp_packing p = sp_packing_none();
    sp_network net = sp_network_none();
    sp_signal s = sp_signal_none();
    sp_table t = sp_table_none();
    sp_status status = cli_may_write_table(&a->common, err);
    if (status == SP_OK)
        status = cli_springs_scene(&a->common, &a->springs, "network signal", &scene, err);
    if (status == SP_OK)
        status = cli_read_network(a->file, &scene.network, &p, &net, err);
    if (status == SP_OK) {
        const sp_signal_options o = wanted(a, &scene, &p);
        status = sp_signal_make(&net, &o, &s, err);
        if (status != SP_OK)
            sp_fail_prefix(err, "%s", a->file);
        else
            status = fill(a, &p, &o, &s, &t, err);
    }
    if (status == SP_OK)
        cli_debug(&a->common, "%s: %s, %d products, error %.3g", a->file, methods[s.method], s.products, s.error);
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
    arguments a = {.until = -1, .tolerance = -1, .points = -1, .method = NOT_GIVEN, .source = NOT_GIVEN};
    argp_parse(&argp, argc, argv, 0, NULL, &a);
    sp_error err = {0};
    return work(&a, &err) == SP_OK ? CLI_OK : cli_fail(&err);
}
