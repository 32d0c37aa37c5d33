/* sonopack clusters: prints the rigid clusters of a packing's contacts. */
#include "cli/motion.h"

#include <inttypes.h>
#include <math.h>

typedef struct arguments {
    cli_common common;
    int method; /* sp_clusters_method, or after the last: by the dimension */
    double sliding_at;
    bool no_walls, grains;
} arguments;

static const char *const methods[] = {"game", "motions", NULL};
enum { BY_DIMENSION = 2 };

static const cli_option options[] = {
    {"method", "METHOD",
     "game: counts, as if all places were generic (two dimensions; the default there); motions: the packing as it is "
     "(the default in three)",
     CLI_CHOICE, CLI_FIELD(method), .words = methods},
    {"sliding-at", "X", "Contacts with |Ft| >= X mu Fn slide (0.99)", CLI_NUMBER, CLI_FIELD(sliding_at), 0, 1e9},
    {"threshold", "F", "Use only contacts with a normal force above F p d^2 (1e-4)", CLI_NUMBER, .scene = true,
     .key = "network.threshold"},
    {"no-walls", NULL, "Leave out contacts with walls", CLI_FLAG, CLI_FIELD(no_walls)},
    {"grains", NULL, "Print a row for each grain in place of each contact", CLI_FLAG, CLI_FIELD(grains)},
    {0}};

const cli_syntax cmd_clusters_syntax = {
    .usage = "FILE",
    .help = "Rigid clusters of a packing: grains and contacts that no motion deforms which keeps all contacts.\v"
            "A contact that sticks has 2 bars (3 in three dimensions), one that slides or has no friction has 1. Each "
            "wall is a body. Clusters have the numbers 0, 1, ... by falling numbers of grains; -1 is none. redundant "
            "is 1 where bars may be removed and nothing more can move. Without friction a grain may belong to several "
            "clusters, in space a contact too, and has the number of the largest.\n"
            "\n"
            "Comments: floppy_motions are those that keep all bars, without those of all as one body; redundant_bars "
            "is how many bars may be removed together; spans tells the axes across which a cluster touches both walls, "
            "wraps those whose period its contacts lead around, each of the largest cluster that does, or none; "
            "free_spins is the number of grains that can spin in place, which the game does not see. Rattlers are left "
            "out, stiffnesses and prestress do not matter. --set takes keys of the group network.",
    CLI_ONE_PACKING,
    .options = options};

static void largest_with(const sp_clusters *c, const char *key, const int32_t *axes, cli_writer *w) {
    int32_t q = 0;
    while (q < c->count && axes[q] == 0)
        q++;
    char text[4] = "", *end = text;
    for (int a = 0; a < 3 && q < c->count; a++)
        if (axes[q] >> a & 1)
            *end++ = "xyz"[a];
    if (q < c->count)
        cli_comment(w, "%s = %s (cluster %d)", key, text, q);
    else
        cli_comment(w, "%s = none", key);
}

static void comments(const arguments *a, const cli_file *file, const sp_clusters *c, int method, cli_writer *w) {
    const int32_t largest = c->count > 0 ? c->grains[0] : 0;
    cli_comment(w, "file = %s", file->path);
    cli_comment(w, "packing = %016" PRIx64, sp_packing_hash(&file->packing));
    cli_value(w, "threshold", file->scene->network.threshold);
    cli_comment(w, "method = %s", methods[method]);
    cli_value(w, "sliding_at", a->sliding_at);
    cli_comment(w, "walls = %d", !a->no_walls);
    cli_comment(w, "clusters = %d", c->count);
    cli_comment(w, "largest = %d", largest);
    cli_value(w, "largest_fraction", (double)largest / c->n);
    cli_comment(w, "floppy_motions = %" PRId64, c->floppy);
    cli_comment(w, "bars = %" PRId64, c->bars_all);
    cli_comment(w, "redundant_bars = %" PRId64, c->redundant_bars);
    cli_comment(w, "free_spins = %d", c->free_spins);
    largest_with(c, "spans", c->spans, w);
    largest_with(c, "wraps", c->wraps, w);
    if (!isnan(c->equal))
        cli_comment(w, "differences = at most %.2g or at least %.2g", c->equal, c->apart);
}

static void contact_rows(const sp_network *net, const sp_clusters *c, cli_writer *w) {
    cli_columns(w, SP_COLUMN_INTEGER, "contact", "", "i", "", "j", "", "bars", "", "cluster", "", "redundant", "",
                NULL);
    for (int32_t k = 0; k < net->n_springs && w->status == SP_OK; k++) {
        const sp_spring *s = &net->springs[k];
        cli_put(w, s->contact, net->grain[s->i], s->j < 0 ? s->j : net->grain[s->j], c->bars[k], c->cluster[k],
                c->redundant[k]);
        cli_end_row(w);
    }
}

static void grain_rows(const sp_network *net, const sp_clusters *c, cli_writer *w) {
    cli_columns(w, SP_COLUMN_INTEGER, "grain", "", NULL);
    cli_place_columns(w, net->dim);
    cli_columns(w, SP_COLUMN_NUMBER, "radius", "d", NULL);
    cli_columns(w, SP_COLUMN_INTEGER, "cluster", "", NULL);
    for (int32_t i = 0; i < net->n && w->status == SP_OK; i++) {
        cli_put(w, net->grain[i]);
        cli_put_numbers(w, net->dim, net->x + 3 * (int64_t)i);
        cli_put(w, net->r[i], c->of_grain[i]);
        cli_end_row(w);
    }
}

static sp_status add_rows(void *user, cli_file *file, cli_writer *w) {
    const arguments *a = user;
    const int by_dimension = file->packing.dim == 3 ? SP_CLUSTERS_MOTIONS : SP_CLUSTERS_GAME;
    const int method = a->method == BY_DIMENSION ? by_dimension : a->method;
    const sp_clusters_options opt = {(sp_clusters_method)method, a->sliding_at, !a->no_walls};
    sp_clusters c = sp_clusters_none();
    w->status = sp_clusters_make(&file->packing, &file->network, &opt, &c, w->err);
    if (w->status == SP_OK)
        comments(a, file, &c, method, w);
    if (w->status == SP_OK)
        (a->grains ? grain_rows : contact_rows)(&file->network, &c, w);
    sp_clusters_free(&c);
    return w->status;
}

int cmd_clusters(int argc, char **argv) {
    static const cli_files command = {CLI_OF_NETWORK, .stop = true, .tells_network = true, .add = add_rows};
    arguments a = {.method = BY_DIMENSION, .sliding_at = sp_clusters_options_default().sliding_at};
    cli_parse(&cmd_clusters_syntax, argc, argv, &a);
    return cli_run_files(&command, &a);
}
