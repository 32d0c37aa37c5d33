/* sonopack modes: prints eigenfrequencies and eigenmodes of a packing, all of them or a part. */
#include "base/base.h"
#include "cli/excitation.h"
#include "cli/motion.h"

#include <math.h>
#include <sonopack/modes.h>
#include <sonopack/study/modes_file.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FREQUENCY "sqrt(E* / rho)/d"

typedef struct arguments {
    cli_common common;
    bool frequencies_only, stability, zero;
    int source, solver; /* sp_source, sp_modes_solver */
    int engine;         /* 1: SLEPc */
    sp_modes_range range;
    bool part;          /* --lowest or --band */
    int ranges;         /* how many of --lowest and --band */
    sp_damping damping; /* value 0: none */
    const char *vectors;
    int64_t mode; /* < 0: not given */
} arguments;

static sp_modes_options options_of(const arguments *a, bool vectors) {
    return (sp_modes_options){.vectors = vectors,
                              .source = (sp_source)a->source,
                              .solver = (sp_modes_solver)a->solver,
                              .threads = a->common.threads};
}

/* The same comments in all tables that count zero modes. */
void cli_zero_modes(cli_writer *w, const sp_zero_modes *z) {
    if (z->total >= 0)
        cli_comment(w, "zero_modes = %lld", (long long)z->total);
    cli_comment(w, "rattler_modes = %lld", (long long)z->rattlers);
    cli_comment(w, "free_spins = %lld", (long long)z->spins);
    cli_comment(w, "rigid_motions = %lld", (long long)z->rigid);
    if (z->total >= 0) {
        cli_comment(w, "mechanisms = %lld", (long long)z->mechanisms);
        cli_value(w, "zero_below", z->below);
    } else
        cli_comment(w, "mechanisms are not told apart from soft modes");
}

/* ---- --damping: decaying modes ----------------------------------------------------------------------------------- */

static sp_status damped(const arguments *a, const cli_file *file, cli_writer *w) {
    const sp_source source = (sp_source)a->source;
    sp_damped_modes m = sp_damped_modes_none();
    w->status = sp_damped_modes_with(&file->network, &a->damping, source, &m, w->err);
    cli_columns(w, SP_COLUMN_INTEGER, "n", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "omega", FREQUENCY, "decay", FREQUENCY, "cosine", "E* d^2", "sine", "E* d^2",
                "error", FREQUENCY, "Q", "", "Q_err", "", NULL);
    cli_value(w, "pressure", file->packing.pressure);
    cli_damping_comment(w, &a->damping);
    cli_comment(w, "source = %s", cli_source_names[source]);
    cli_comment(w, "residual = %.3g", m.residual);
    for (int64_t k = 0; k < m.n && w->status == SP_OK; k++) {
        double q, q_error;
        sp_damped_modes_quality(&m, k, &q, &q_error);
        cli_row(w, k, m.omega[k], m.decay[k], m.cosine[k], m.sine[k], m.error[k], q, q_error);
    }
    sp_damped_modes_free(&m);
    return w->status;
}

/* ---- --stability: whether any motion grows ----------------------------------------------------------------------- */

static const char *const verdicts[] = {
    [SP_MODES_STABLE] = "stable", [SP_MODES_UNSTABLE] = "unstable", [SP_MODES_UNDECIDED] = "undecided"};

static double known(int64_t count) { return count < 0 ? NAN : (double)count; }

static sp_status stability(const cli_file *file, cli_writer *w) {
    sp_stability s = {0};
    w->status = sp_stability_make(&file->packing, &file->network, &s, w->err);
    cli_columns(w, SP_COLUMN_TEXT, "verdict", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "negative", "", "flutter", "", "zero", "", "softest", "E* / (rho d^2)", "growth",
                FREQUENCY, "growth_bound", FREQUENCY, "error", "E* / (rho d^2)", NULL);
    cli_value(w, "pressure", file->packing.pressure);
    cli_comment(w, "method = %s", s.dense ? "dense" : "counts");
    cli_comment(w, "degrees_of_freedom = %lld", (long long)s.dofs);
    cli_comment(w, "skew = %.3g", s.skew);
    cli_comment(w, "balance = %.3g", s.balance);
    if (s.unbalanced > 0)
        cli_comment(w,
                    "%lld of the motions that grow are within balance: the forces at rest are as much off theirs, see "
                    "packing.tolerance and network.threshold",
                    (long long)s.unbalanced);
    cli_comment(w, "%s: no motion grows faster than exp(%.3g t)", verdicts[s.verdict], s.growth_bound);
    cli_row(w, verdicts[s.verdict], known(s.negative), known(s.flutter), known(s.zero), s.softest, s.growth,
            s.growth_bound, s.error);
    return w->status;
}

/* ---- --vectors: of all modes as a file, or the displacements of one as a table ----------------------------------- */

/* Whether there is the mode of --mode, and a table can say what it belongs to. */
static sp_status check_mode(const arguments *a, const cli_file *file, int64_t first, int64_t end, sp_error *err) {
    if (a->mode < first || a->mode >= end)
        return sp_fail(err, SP_EINVAL, "--mode %lld: must be in %lld .. %lld", (long long)a->mode, (long long)first,
                       (long long)(end - 1));
    if (file->scene->network.tangential != SP_SPRINGS_CONSTANT)
        return sp_fail_key(err, SP_EREFUSED, "network.tangential",
                           ": must be \"constant\" for a table of displacements, which cannot say otherwise");
    return SP_OK;
}

/* This mode: a vector, or its real part; one more number and what its name and the vector mean. */
typedef struct shown {
    double omega, error;
    const double *e;
    const char *name;
    double number;
    const char *meaning;
} shown;

static void displacement_rows(const sp_network *net, const double *e, cli_writer *w) {
    double u[6];
    for (int32_t i = 0; i < net->n; i++) {
        for (int a = 0; a < net->dof; a++)
            u[a] = e[(int64_t)i * net->dof + a] / sqrt(net->mass[(int64_t)i * net->dof + a]);
        cli_motion_row(net, i, u, w);
    }
}

static sp_status write_displacements(const arguments *a, const cli_file *file, const shown *m, sp_error *err) {
    sp_table t = sp_table_none();
    cli_writer w = {.table = &t, .err = err};
    cli_common there = a->common;
    there.format_given = false;
    cli_motion_columns(&file->network, "1/sqrt(rho d^3)", "1/sqrt(rho d^5)", &w);
    cli_motion_comments(file, "mode", &w);
    cli_comment(&w, "mode = %lld", (long long)a->mode);
    cli_value(&w, "omega", m->omega);
    cli_value(&w, "omega_error", m->error);
    cli_value(&w, m->name, m->number);
    cli_comment(&w, "%s", m->meaning);
    cli_comment(&w, "rattlers = %d, which are left out", file->network.rattlers);
    displacement_rows(&file->network, m->e, &w);
    CLI_THEN(w.status, cli_write_table_to(&there, a->vectors, &t, err));
    sp_table_free(&t);
    return w.status;
}

static sp_status check_vectors(const char *path, int64_t mode, sp_error *err) {
    if (!path)
        return mode < 0 ? SP_OK : sp_fail(err, SP_EINVAL, "--mode %lld: needs --vectors FILE", (long long)mode);
    const bool table = cli_has_ending(path, ".tsv") || cli_has_ending(path, ".csv") || cli_has_ending(path, ".json");
    if (!cli_is_hdf5(path) && !table)
        return sp_fail(err, SP_EINVAL,
                       "--vectors %s: the ending must be .h5, or .tsv, .csv or .json for one mode by --mode N", path);
    if (table && mode < 0)
        return sp_fail(err, SP_EINVAL, "--vectors %s: a table has one mode, which --mode N must select", path);
    if (!table && mode >= 0)
        return sp_fail(err, SP_EINVAL, "--mode %lld: --vectors %s takes all modes", (long long)mode, path);
    return SP_OK;
}

static sp_status write_vectors(const arguments *a, const cli_file *file, const sp_modes *m, sp_error *err) {
    const sp_modes_made made = {.network = file->scene->network, .source = (sp_source)a->source};
    const int64_t row = a->mode - m->first;
    if (cli_is_hdf5(a->vectors))
        return sp_modes_save(m, &file->packing, &file->network, &made, a->vectors, err);
    const sp_status status = check_mode(a, file, m->first + m->n_rattler, m->first + m->n, err);
    if (status != SP_OK)
        return status;
    const shown one = {.omega = m->omega[row],
                       .error = m->error[row],
                       .e = m->vectors + (row - m->n_rattler) * m->dofs,
                       .name = "vector_error",
                       .number = sp_modes_vector_error(m, &file->network, row),
                       .meaning = "u = M^(-1/2) e with |e| = 1; vector_error is a bound of |e - exact|"};
    return write_displacements(a, file, &one, err);
}

/* ---- prestress with friction: modes that may grow --------------------------------------------------------------- */

static sp_status write_growing(const arguments *a, const cli_file *file, const sp_complex_modes *m, sp_error *err) {
    const sp_modes_made made = {.network = file->scene->network, .source = (sp_source)a->source};
    const int64_t row = a->mode - m->first;
    if (cli_is_hdf5(a->vectors))
        return sp_complex_modes_save(m, &file->packing, &file->network, &made, a->vectors, err);
    const sp_status status = check_mode(a, file, m->first + m->rattlers, m->first + m->n, err);
    if (status != SP_OK)
        return status;
    const shown one = {.omega = m->omega[row],
                       .error = m->error[row],
                       .e = m->right + (row - m->rattlers) * m->dofs,
                       .name = "growth",
                       .number = m->growth[row],
                       .meaning = "u = Re M^(-1/2) e with |e| = 1, whose largest component is positive"};
    return write_displacements(a, file, &one, err);
}

static sp_status growing(const arguments *a, const cli_file *file, cli_writer *w) {
    const bool signals = !a->frequencies_only, walls = sp_network_touches(&file->network, SP_BOTTOM);
    const sp_modes_options o = options_of(a, a->vectors != NULL);
    sp_modes_range range = a->range;
    char complete[SP_NUMBER_TEXT];
    sp_complex_modes m = sp_complex_modes_none();
    range.zero = a->zero;
    cli_comment(w, "file = %s", file->path);
    w->status = sp_complex_modes_make(&file->network, &o, &range, &m, w->err);
    cli_columns(w, SP_COLUMN_INTEGER, "n", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "omega", FREQUENCY, "growth", FREQUENCY, NULL);
    if (signals)
        cli_columns(w, SP_COLUMN_NUMBER, "cosine", "E* d^2", "sine", "E* d^2", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "error", FREQUENCY, NULL);
    cli_value(w, "pressure", file->packing.pressure);
    cli_comment(w, "dimension = %d", file->network.dim);
    cli_comment(w, "carrying = %d", file->network.n);
    cli_comment(w, "rattler_modes = %lld", (long long)file->network.rattlers * file->network.dof);
    if (a->part)
        cli_comment(w, "zero_motions = %lld", (long long)m.zero);
    cli_comment(w, "pairs = %lld", (long long)m.pairs);
    if (signals)
        cli_comment(w, "source = %s", walls ? cli_source_names[a->source] : "none");
    cli_comment(w, "skew = %.3g", sp_network_skew(&file->network));
    cli_comment(w, "method = %s", m.sparse ? "sparse" : "dense");
    if (a->part)
        cli_comment(w, "complete = 0:%s", sp_number_text(m.complete, complete));
    if (m.on_edge > 0)
        cli_comment(w, "on_edge = %lld", (long long)m.on_edge);
    if (m.right) {
        cli_comment(w, "residual = %.3g", m.residual);
        cli_comment(w, "orthogonality = %.3g", m.orthogonality);
        CLI_THEN(w->status, write_growing(a, file, &m, w->err));
    }
    for (int64_t k = 0; k < m.n && w->status == SP_OK; k++)
        if (signals)
            cli_row(w, m.first + k, m.omega[k], m.growth[k], walls ? m.cosine[k] : NAN, walls ? m.sine[k] : NAN,
                    m.error[k]);
        else
            cli_row(w, m.first + k, m.omega[k], m.growth[k], m.error[k]);
    sp_complex_modes_free(&m);
    return w->status;
}

/* ---- options ----------------------------------------------------------------------------------------------------- */

static sp_status set_lowest(void *user, const char *text, sp_error *err) {
    arguments *a = user;
    a->range = sp_modes_range_all();
    a->part = true;
    a->ranges++;
    return cli_integer("--lowest", text, 1, 1000000000, &a->range.lowest, err);
}

static sp_status set_band(void *user, const char *text, sp_error *err) {
    arguments *a = user;
    double band[2] = {0, 1};
    const sp_status status = cli_pair("--band", text, 0, INFINITY, band, err);
    a->range = sp_modes_range_band(band[0], band[1]);
    a->part = true;
    a->ranges++;
    return status;
}

static sp_status add_all(void *user, const char *text, sp_error *err) {
    arguments *a = user;
    (void)text, (void)err;
    a->ranges++;
    return SP_OK;
}

static sp_status check(void *user, sp_error *err) {
    const arguments *a = user;
    if (a->vectors && (a->frequencies_only || a->stability || a->damping.value > 0))
        return sp_fail(err, SP_EINVAL,
                       "--vectors cannot be combined with --frequencies-only, --stability or --damping");
    if (a->vectors && a->common.output && strcmp(a->vectors, a->common.output) == 0)
        return sp_fail(err, SP_EINVAL, "--vectors and -o %s: must be two files", a->vectors);
    const sp_status vectors = check_vectors(a->vectors, a->mode, err);
    if (vectors != SP_OK)
        return vectors;
    if (a->zero && a->range.lowest == 0)
        return sp_fail(
            err, SP_EINVAL,
            "--zero: only with --lowest; --all and a band that begins at 0 have all zero modes, any other band none");
    if (a->ranges > 1)
        return sp_fail(err, SP_EINVAL, "--all, --lowest and --band: only one of them may be given, once");
    if (a->solver != SP_SOLVER_AUTO && (a->damping.value > 0 || a->stability))
        return sp_fail(err, SP_EINVAL, "--solver cannot be combined with --damping or --stability");
    if (a->damping.value > 0 && (a->part || a->frequencies_only))
        return sp_fail(err, SP_EINVAL, "--damping cannot be combined with --lowest, --band or --frequencies-only");
    if (a->stability && (a->part || a->frequencies_only || a->damping.value > 0))
        return sp_fail(err, SP_EINVAL,
                       "--stability cannot be combined with --lowest, --band, --frequencies-only or --damping");
    return SP_OK;
}

static const char *const engine_words[] = {"sonopack", "slepc", NULL};

static const cli_option options[] = {
    {"all", NULL, "All modes (the default)", .parse = add_all},
    {"lowest", "K", "Only the K lowest modes that are no zero modes; n starts after those", .parse = set_lowest},
    {"zero", NULL, "With --lowest: all zero modes too, in front", CLI_FLAG, CLI_FIELD(zero)},
    {"band", "LO:HI", "Only the modes with LO <= omega <= HI; n counts from the lowest of all modes. HI may be inf",
     .parse = set_band},
    {"frequencies-only", NULL, "Print only the columns n, omega and error: no amplitudes, no participation ratio",
     CLI_FLAG, CLI_FIELD(frequencies_only)},
    {"damping", CLI_DAMPING,
     "Add dashpots, as in signal: columns n, omega, decay, cosine, sine, error, Q, Q_err (at most 2000 degrees of "
     "freedom)",
     CLI_DASHPOTS, CLI_FIELD(damping), .low = 1e-12, .high = 100},
    {"solver", CLI_SOLVERS, "Solver: block Lanczos, ARPACK, LAPACK, or the fastest of them (auto)", CLI_CHOICE,
     CLI_FIELD(solver), .words = cli_solver_names},
    {"stability", NULL,
     "Print one row instead, with a verdict on whether any motion grows (with --prestress and friction, up to 6000 "
     "degrees of freedom; above that undecided, with a bound)",
     CLI_FLAG, CLI_FIELD(stability)},
    {"vectors", "FILE",
     "Write the eigenvectors too: of all modes to FILE.h5, or with --mode N the displacements in that mode to FILE.tsv "
     "(.csv, .json)",
     CLI_TEXT, CLI_FIELD(vectors)},
    {"mode", "N", "Number of the mode for --vectors FILE.tsv, as in the column n", CLI_INTEGER, CLI_FIELD(mode),
     .high = 1000000000},
    {"source", "impulse|velocity|displacement", "Kind of source for the amplitudes a (impulse)", CLI_CHOICE,
     CLI_FIELD(source), .words = cli_source_names},
    CLI_DRY_RUN,
    {.help = "Beyond one machine (docs/cluster.md):"},
    {"engine", "sonopack|slepc", "Program that finds the modes; slepc: on N ranks after mpirun -n N (sonopack)",
     CLI_CHOICE, CLI_FIELD(engine), .words = engine_words},
    {0}};

const cli_syntax cmd_modes_syntax = {
    .usage = "FILE",
    .help =
        "Eigenfrequencies of the spring network of a packing between fixed walls, and the weight of each mode in the "
        "signal.\vModes are sorted by omega; among the zero modes those of rattlers come first. The signal is F(t) = "
        "sum of ab sin(omega t) (cos for displacements). participation = (sum w)^2/(N sum w^2), where w is the share "
        "of a grain in the mode and N the number of grains without rattlers. error is a bound for the error of omega. "
        "a, b and participation of modes of equal frequencies are not definite. With --prestress and tangential forces "
        "at rest the table has all motions exp(growth t) (cosine cos(omega t) + sine sin(omega t)), columns n, omega, "
        "growth, cosine, sine and error, the bound of |growth + i omega - exact|: a complex pair of omega^2 has two "
        "rows, which grow and decay (at most 6000 degrees of freedom). --lowest K and --band give those that are no "
        "zero motions, of networks of any size, where few lie below; the comment complete says up to which omega none "
        "is missing. A packing that does not touch the bottom (top) wall has no source (detector): a (b) is nan, and a "
        "comment says none. --set takes keys of the group network.\n"
        "\n"
        "The comments count the zero modes of the packing, whichever modes are printed: zero_modes = rattler_modes + "
        "free_spins (a grain that turns alone, such as a sphere with two contacts) + rigid_motions (grains that hang "
        "together and move as a rigid body, such as a packing between walls without friction) + mechanisms (all "
        "others). A mode is a zero mode if omega < zero_below.\n"
        "\n"
        "With --damping, F(t) = sum of exp(-decay t) (cosine cos(omega t) + sine sin(omega t)). Each conjugate pair "
        "has one row, each overdamped mode a row with omega = 0; n starts at 0 without rattlers. Q = |lambda|/(2 "
        "decay) with lambda = -decay + i omega is the quality factor (nan for an overdamped mode), Q_err a bound of "
        "its error.",
    CLI_ONE_PACKING,
    .options = options,
    .springs = true,
    .check = check};

static void add_comments(const arguments *a, const cli_file *file, const sp_modes *m, cli_writer *w) {
    const sp_network *net = &file->network;
    char from[SP_NUMBER_TEXT], to[SP_NUMBER_TEXT];
    cli_comment(w, "file = %s", file->path);
    cli_value(w, "pressure", file->packing.pressure);
    cli_comment(w, "dimension = %d", net->dim);
    cli_comment(w, "carrying = %d", net->n); /* grains without the rattlers */
    cli_zero_modes(w, &m->zero);
    if (!a->frequencies_only)
        cli_comment(w, "source = %s", sp_network_touches(net, SP_BOTTOM) ? cli_source_names[a->source] : "none");
    if (!a->frequencies_only && !sp_network_touches(net, SP_TOP))
        cli_comment(w, "detector = none");
    if (m->vectors) {
        cli_comment(w, "residual = %.3g", m->residual);
        cli_comment(w, "orthogonality = %.3g", m->orthogonality);
    }
    cli_comment(w, "method = %s", m->solver == SP_SOLVER_DENSE ? "dense" : "sparse");
    /* no mode is missing between these two frequencies */
    cli_comment(w, "complete = %s:%s", sp_number_text(m->certified_from, from), sp_number_text(m->certified_to, to));
    cli_comment(w, "solver = %s", cli_solver_names[m->solver]);
    if (m->solver != SP_SOLVER_DENSE) {
        cli_comment(w, "factors = %lld", (long long)m->factors);
        cli_comment(w, "solves = %lld", (long long)m->solves);
    }
    if (m->on_edge > 0)
        cli_comment(w, "on_edge = %lld", (long long)m->on_edge);
}

static void add_columns(bool vectors, cli_writer *w) {
    cli_columns(w, SP_COLUMN_INTEGER, "n", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "omega", FREQUENCY, NULL);
    if (vectors)
        cli_columns(w, SP_COLUMN_NUMBER, "a", "d sqrt(rho d^3)", "b", "E* d/sqrt(rho d^3)", "ab", "E* d^2",
                    "participation", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "error", FREQUENCY, NULL);
}

static sp_status undamped(const arguments *a, const cli_file *file, cli_writer *w) {
    const sp_modes_options o = options_of(a, !a->frequencies_only);
    sp_modes_range range = a->range;
    sp_modes m = sp_modes_none();
    range.zero = a->zero;
    w->status = sp_modes_make(&file->network, &o, &range, &m, w->err);
    add_columns(!a->frequencies_only, w);
    add_comments(a, file, &m, w);
    if (a->vectors && w->status == SP_OK)
        w->status = write_vectors(a, file, &m, w->err);
    for (int64_t k = 0; k < m.n && w->status == SP_OK; k++) {
        const int64_t n = m.first + k;
        if (m.vectors)
            cli_row(w, n, m.omega[k], m.a[k], m.b[k], m.a[k] * m.b[k], m.participation[k], m.error[k]);
        else
            cli_row(w, n, m.omega[k], m.error[k]);
    }
    sp_modes_free(&m);
    return w->status;
}

static sp_status add_rows(void *user, cli_file *file, cli_writer *w) {
    const arguments *a = user;
    if (!a->stability && !(a->damping.value > 0))
        return file->network.carried ? growing(a, file, w) : undamped(a, file, w);
    cli_comment(w, "file = %s", file->path);
    if (w->status == SP_OK && !a->stability)
        w->status = cli_need_walls(&file->packing, "the pulse of damped modes", w->err);
    if (w->status != SP_OK)
        return w->status;
    return a->stability ? stability(file, w) : damped(a, file, w);
}

static sp_status begin(void *user, cli_writer *w) {
    const arguments *a = user;
    return a->vectors ? cli_may_write_modes(&a->common, a->vectors, w->err) : SP_OK;
}

/* How many modes a band has: their density is about even over the spectrum. */
static double expected_modes(const arguments *a, const sp_network_size *net) {
    if (a->range.lowest > 0)
        return (double)a->range.lowest;
    return fmin(net->dofs, net->dofs * (fmin(a->range.to, net->omega) - a->range.from) / net->omega);
}

static sp_status plan(void *user, const cli_file *file, cli_plan *p, sp_error *err) {
    const arguments *a = user;
    if (file->network.carried && !a->stability && a->range.lowest == 0 && isinf(a->range.to) &&
        sp_network_dofs(&file->network) > SP_STABILITY_MAX)
        return sp_fail(err, SP_EREFUSED, "%lld degrees of freedom, must be at most %d for modes of a nonsymmetric K",
                       (long long)sp_network_dofs(&file->network), SP_STABILITY_MAX);
    const sp_network_size net = sp_network_size_of(&file->network, sp_packing_height(&file->packing));
    const sp_modes_options o = options_of(a, !a->frequencies_only);
    const double modes = fmax(0, expected_modes(a, &net));
    sp_cost cost = sp_cost_modes(&net, &o, &a->range, modes, &p->machine);
    if (a->stability || a->damping.value > 0 || file->network.carried) {
        cost.cpu = cost.wall = NAN;
        cli_comment(&p->w, "nan: there is no law for --stability, --damping, and --prestress with friction");
    }
    (void)err;
    cli_plan_add(p, "network", 1, sp_cost_result(SP_RESULT_NETWORK, &net, 1, &p->machine), 0);
    cli_plan_add(p, "modes", (int64_t)modes, cost, a->common.output ? sp_bytes_table(modes, 7) : 0);
    if (a->vectors)
        cli_plan_add(p, "vectors", a->mode >= 0 ? 1 : (int64_t)modes, (sp_cost){0},
                     a->mode >= 0 ? sp_bytes_table(net.grains, 7)
                                  : (file->network.carried ? 32 : 8) * modes * net.dofs);
    return SP_OK;
}

int cmd_modes(int argc, char **argv) {
    static const cli_files command = {CLI_OF_NETWORK, .stop = true,
                                      .begin = begin, .add = add_rows,
                                      .plan = plan,   .kernels = 1U << SP_KERNEL_DENSE | 1U << SP_KERNEL_SPARSE};
    arguments a = {.range = sp_modes_range_all(), .mode = -1};
    cli_parse(&cmd_modes_syntax, argc, argv, &a);
    if (a.engine)
        return cmd_engine("sonopack modes-slepc", argc, argv);
    return cli_run_files(&command, &a);
}
