/* sonopack column: computes the motion of a column of particles on a tapped floor. */
#include "base/base.h"
#include "cli/files.h"

#include <string.h>

typedef struct arguments {
    cli_common common;
    double begun;
} arguments;

const cli_syntax cmd_column_syntax = {
    .usage = "[SCENE]",
    .help =
        "A vertical column of particles on a floor that is tapped, described by the keys column.* of a scene (cm, g, "
        "s). column.output selects the table.\v"
        "trajectory: heights of the floor (y0) and of the particles, one row per column.step.\n"
        "strobe: heights of the particles and density of the column at the end of each tap, at .99T, 1.99T, ...\n"
        "energy: one row per tap, with the work of the floor, the energy lost in contacts, the time until everything "
        "is at rest (nan: never), and the smallest separation of two neighbouring centres, with its time and its "
        "contact (0 is the contact with the floor, i that of particles i and i + 1).\n"
        "density: along the column.\n"
        "compare: differences between the continuum models longwave and bsr and the particles.\n"
        "bifurcation: heights of the particles at .99T, ... for each of column.points values of column.parameter from "
        "column.from to column.to.\n"
        "lyapunov: the largest Lyapunov exponent per tap for the same values.\n"
        "\n"
        "Without a SCENE, that of packings/column.cfg is used. Comments of the table give every parameter. Comments "
        "that begin with \"warning:\", which also go to stderr, say where the model breaks down: where a particle is "
        "pressed beyond the centre of its neighbour, so that no contact law applies, or where a method or an equation "
        "does not reproduce the column.\n"
        "\n"
        "  sonopack column packings/column.cfg -o column.tsv\n"
        "  sonopack column --set column.output=strobe\n"
        "  sonopack column packings/column-bifurcation.cfg -o b.tsv",
    .not_si = "the tapped column has units of its own, cm, g and s",
    .file_name = "scene",
    .files_max = 1};

static bool stopped(void *user) {
    (void)user;
    return cli_stopped();
}

static bool watch(double share, void *user) {
    const arguments *a = user;
    const double spent = sp_clock_wall() - a->begun;
    if (spent > 1) /* shorter computations need no progress */
        cli_progress(&a->common, "column", share, spent * (1 - share) / share);
    return !cli_stopped();
}

static void warn(const arguments *a, const sp_table *t) {
    for (int k = 0; k < t->comments; k++)
        if (strncmp(t->comment[k], "warning: ", strlen("warning: ")) == 0)
            cli_note(&a->common, "%s", t->comment[k]);
}

static sp_status work(void *user, cli_writer *w) {
    arguments *a = user;
    sp_scene scene = sp_scene_default();
    sp_status status = sp_scene_read_tapped(a->common.files > 0 ? a->common.file[0] : NULL, a->common.sets,
                                            a->common.set, &scene, w->err);
    cli_catch_signals(&a->common);
    scene.tapped.stopped = stopped;
    a->begun = sp_clock_wall();
    CLI_THEN(status, sp_tapped_table_watched(&scene.tapped, a->common.threads, (sp_tapped_watcher){watch, a}, w->table,
                                             w->err));
    cli_progress_end();
    if (status == SP_OK)
        warn(a, w->table);
    sp_scene_free(&scene);
    return status;
}

int cmd_column(int argc, char **argv) {
    arguments a = {0};
    cli_parse(&cmd_column_syntax, argc, argv, &a);
    return cli_run_table(&a, work);
}
