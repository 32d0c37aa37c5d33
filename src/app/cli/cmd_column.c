/* sonopack column: a stack of particles on a floor that is tapped. */
#include "base/base.h"
#include "cli/cli.h"

#include <string.h>

typedef struct arguments {
    cli_common common;
    const char *scene;
    double begun;
} arguments;

static const struct argp_child children[] = {{&cli_common_argp, 0, "Common options:", 90}, {0}};

static error_t parse(int key, char *arg, struct argp_state *state) {
    arguments *a = state->input;
    switch (key) {
    case ARGP_KEY_INIT: state->child_inputs[0] = &a->common; return 0;
    case ARGP_KEY_ARG:
        if (a->scene)
            argp_error(state, "%.60s: must be one scene only", arg);
        a->scene = arg;
        return 0;
    default: return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp argp = {
    NULL,
    parse,
    "[SCENE]",
    "A vertical column of particles on a floor that is tapped, by the keys column.* of a scene (cm, g, s); "
    "column.output says which table.\v"
    "trajectory: heights of the floor (y0) and of the particles, a row each column.step. strobe: the particles and "
    "the density of the whole at the end of each tap, at .99T, 1.99T, ... energy: a row a tap, with the work of the "
    "floor, what the contacts took of it, the time until all rests (nan: it does not), and the smallest separation "
    "of two neighbouring centres, when, and at which contact: 0 is that with the floor, i that between particles i and "
    "i + 1. density: along the column. compare: distances of the continua longwave and bsr from the particles. "
    "bifurcation: the particles at .99T, ... for each of column.points values of column.parameter from column.from "
    "to column.to. lyapunov: the largest Lyapunov exponent a tap over the same.\n\n"
    "Without a SCENE it is that of packings/column.cfg. Comments of the table say every parameter that was used. "
    "Those that begin with \"warning:\", which go to stderr, too, say where the model is at its end: where a "
    "particle is pressed beyond its neighbour's centre, so that no contact law holds, or where a method or an equation "
    "does not give what the column does.\n\n"
    "  sonopack column packings/column.cfg -o column.tsv\n"
    "  sonopack column --set column.output=strobe\n"
    "  sonopack column packings/column-bifurcation.cfg -o b.tsv",
    children,
    NULL,
    NULL};

static bool stopped(void *user) {
    (void)user;
    return cli_stopped();
}

static bool watch(double share, void *user) {
    const arguments *a = user;
    const double spent = sp_clock_wall() - a->begun;
    if (spent > 1) /* what takes less needs no bar */
        cli_progress(&a->common, "column", share, spent * (1 - share) / share);
    return !cli_stopped();
}

/* What its comments warn of, on stderr. */
static void warn(const arguments *a, const sp_table *t) {
    for (int k = 0; k < t->comments; k++)
        if (strncmp(t->comment[k], "warning: ", strlen("warning: ")) == 0)
            cli_note(&a->common, "%s", t->comment[k]);
}

static sp_status make(arguments *a, sp_scene *scene, sp_table *t, sp_error *err) {
    cli_catch_signals();
    scene->tapped.stopped = stopped;
    a->begun = sp_clock_wall();
    sp_status status =
        sp_tapped_table_watched(&scene->tapped, a->common.threads, (sp_tapped_watcher){watch, a}, t, err);
    cli_progress_end(&a->common);
    return status;
}

static sp_status work(arguments *a, sp_scene *scene, sp_table *t, sp_error *err) {
    sp_status status = cli_may_write_table(&a->common, err);
    if (status == SP_OK)
        status = sp_scene_read_tapped(a->scene, a->common.sets, a->common.set, scene, err);
    if (status == SP_OK)
        status = make(a, scene, t, err);
    if (status == SP_OK)
        warn(a, t);
    return status == SP_OK ? cli_write_table(&a->common, t, err) : status;
}

int cmd_column(int argc, char **argv) {
    arguments a = {0};
    argp_parse(&argp, argc, argv, 0, NULL, &a);
    sp_error err = {0};
    sp_scene scene = sp_scene_default();
    sp_table t = sp_table_none();
    sp_status status = work(&a, &scene, &t, &err);
    sp_table_free(&t);
    sp_scene_free(&scene);
    return status == SP_OK ? CLI_OK : cli_fail(&err);
}
