/* sonopack sensitivity: by how much each contact or grain moves a quantity. */
#include "base/base.h"
#include "cli/sensitivity.h"

#include <math.h>
#include <stdlib.h>

static sp_status set_quantity(void *user, const char *word, sp_error *err) {
    return sensitivity_read_quantity(word, &((sensitivity_arguments *)user)->of, err);
}

static sp_status set_parameters(void *user, const char *word, sp_error *err) {
    return sensitivity_read_parameters(word, &((sensitivity_arguments *)user)->by, err);
}

static sp_status set_pulse(void *user, const char *word, sp_error *err) {
    return cli_pulse_parse(word, &((sensitivity_arguments *)user)->pulse, err);
}

static sp_status set_source(void *user, const char *word, sp_error *err) {
    return cli_places_add(&((sensitivity_arguments *)user)->sources, "--from", word, err);
}

static sp_status set_detector(void *user, const char *word, sp_error *err) {
    return cli_places_add(&((sensitivity_arguments *)user)->detectors, "--detector", word, err);
}

static const cli_option options[] = {
    {"of", "QUANTITY",
     "What to differentiate: t10, t_peak, peak, t_zero or width of the first front; F, the signal at --at; omega:N or "
     "omega:N-M, the mean omega^2 of modes; c_l, c_t (or cl, ct), C11, C12, ... (t10)",
     .parse = set_quantity},
    {"by", "LIST", "Parameters: kn,kt of the contacts; mass,radius,position of the grains; or pressure (kn,kt)",
     .parse = set_parameters},
    {"at", "T", "Time of F [d/sqrt(E* / rho)]", CLI_NUMBER, .field = offsetof(sensitivity_arguments, at), .high = 1e9,
     .unit = "d/sqrt(E* / rho)"},
    {"until", "T", "Last time at which the front is sought [d/sqrt(E* / rho)] (as of signal)", CLI_NUMBER,
     .field = offsetof(sensitivity_arguments, until), .low = 1e-9, .high = 1e9, .unit = "d/sqrt(E* / rho)"},
    {"margin", "D", "c_l, c_t: leave layers of this thickness at all walls out of the density [d] (3)", CLI_NUMBER,
     .field = offsetof(sensitivity_arguments, margin), .high = 1e6},
    {"pulse", "PULSE", "Strength of the source against time: delta, gauss:WIDTH or ricker:OMEGA (delta)",
     .parse = set_pulse},
    {"source", "impulse|velocity|displacement", "Kind of source, as in signal (impulse)", CLI_CHOICE,
     .field = offsetof(sensitivity_arguments, source), .words = cli_source_names},
    {"from", "PLACE", "Source at bottom, part:X0:X1, plane:Y or grain:I (bottom)", .parse = set_source},
    {"detector", "PLACE", "Detector at top, plane:Y, part:X0:X1 or grain:I (top)", .parse = set_detector},
    {0}};

static const cli_syntax syntax;

static sp_status check(void *user, sp_error *err) {
    const sensitivity_arguments *a = user;
    const bool wave = a->of.kind == SENSITIVITY_FRONT || a->of.kind == SENSITIVITY_SIGNAL;
    if ((a->of.kind == SENSITIVITY_SIGNAL) != (a->at >= 0))
        return sp_fail(err, SP_EINVAL, "--at T: needed for --of F, and only for it");
    if (a->sources.n > 1 || a->detectors.n > 1)
        return sp_fail(err, SP_EINVAL, "--from and --detector: one place each");
    if (!wave && (a->sources.n > 0 || a->detectors.n > 0 || a->pulse.word))
        return sp_fail(err, SP_EINVAL, "--from, --detector and --pulse: only for a front or for F");
    sp_status status = cli_need(&syntax, &a->common, "source", wave, "a front or F", err);
    if (status == SP_OK)
        status = cli_need(&syntax, &a->common, "until", a->of.kind == SENSITIVITY_FRONT, "a front", err);
    return status == SP_OK
               ? cli_need(&syntax, &a->common, "margin", a->of.kind == SENSITIVITY_MODULUS, "c_l or c_t", err)
               : status;
}

static const cli_syntax syntax = {
    .usage = "FILE",
    .help =
        "Exact derivatives of the arrival of a pulse, of the signal, of frequencies and of elastic moduli by the "
        "stiffness of each contact, by the mass, radius and position of each grain, and by the pressure.\v"
        "Each row is a contact or a grain that carries force. by_X is the derivative of the quantity by the logarithm "
        "of X: the change for a small relative change of X alone, over that change; by_x, by_y and by_z are "
        "derivatives by the position of the centre in mean diameters d, in all units. by_X_err are bounds of their "
        "errors, by_position_err of each of by_x, by_y and by_z. The momentum of a source at "
        "the wall and the force on a detector change with the stiffness of their contacts. With radius and position "
        "the overlaps, and with them the stiffnesses, follow the contact law, and with radius the mass too; no "
        "contact is made or lost. With pressure the packing follows the load by its linear response, and no contact "
        "slides.\n"
        "\n"
        "Comments give the quantity (value; of modes omega^2) and a bound of its error (value_err); homogeneity, the "
        "sum over all contacts, which Euler's "
        "theorem knows (if all springs are stiffer by a factor s, times shorten by sqrt(s)), minus what it should "
        "be, over the sum of absolute values; and half_share, the fraction of the contacts (the largest ones) that "
        "have half of the sum of |by_kn| + |by_kt|. A "
        "front is that of the continuous signal. A group of modes of one frequency has a derivative only as a whole: "
        "omega:N-M. N counts as the column n of modes, zero modes first. c_l and c_t have a fixed density. K must be "
        "symmetric: with friction "
        "--prestress is refused. --set takes keys of the group network.",
    .finds_material = true,
    .options = options,
    .file_name = "packing",
    .files_min = 1,
    .files_max = 1,
    .springs = true,
    .check = check};

static sp_status open_pulse(void *user, sp_table *t, sp_error *err) {
    (void)t;
    return cli_pulse_open(&((sensitivity_arguments *)user)->pulse, err);
}

static int by_size(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x < y) - (x > y);
}

/* The fraction of the contacts that have half of the sum of all sizes; NAN without contacts. */
static double half_share(const sp_network *net, const sp_gradient *g) {
    double sum = 0, part = 0, *size = sp_alloc((size_t)net->n_springs, sizeof *size);
    int32_t k = 0;
    if (!size || (g->kn.n == 0 && g->kt.n == 0)) {
        sp_free(size);
        return NAN;
    }
    for (int32_t c = 0; c < net->n_springs; c++) {
        size[c] = (g->kn.n ? fabs(net->springs[c].kn * g->kn.d[c]) : 0) +
                  (g->kt.n ? fabs(net->springs[c].kt * g->kt.d[c]) : 0);
        sum += size[c];
    }
    qsort(size, (size_t)net->n_springs, sizeof *size, by_size);
    while (k < net->n_springs && part < 0.5 * sum)
        part += size[k++];
    sp_free(size);
    return (double)k / net->n_springs;
}

static void add_comments(const sensitivity_arguments *a, const cli_file *file, const sp_gradient *g, cli_writer *w) {
    const double share = half_share(&file->network, g);
    cli_comment(w, "file = %s", file->path);
    cli_value(w, "pressure", file->packing.pressure);
    cli_comment(w, "dimension = %d", file->packing.dim);
    cli_comment(w, "quantity = %s", a->of.word);
    if (a->of.kind == SENSITIVITY_SIGNAL)
        cli_value(w, "t", a->at);
    cli_value(w, "value", g->value);
    cli_comment(w, "value_err = %.3g", g->error);
    if (a->of.kind == SENSITIVITY_FRONT || a->of.kind == SENSITIVITY_SIGNAL) {
        cli_comment(w, "source = %s", cli_source_names[a->source]);
        if (a->pulse.word)
            cli_comment(w, "pulse = %s", a->pulse.word);
    }
    if (isfinite(g->homogeneity))
        cli_comment(w, "homogeneity = %.2g", g->homogeneity_size > 0 ? g->homogeneity / g->homogeneity_size : 0);
    if (isfinite(share))
        cli_comment(w, "half_share = %.4g", share);
}

static sp_status compute(void *user, cli_file *file, sp_table *t, sp_error *err) {
    const sensitivity_arguments *a = user;
    sp_gradient g = sp_gradient_none();
    cli_writer w = {.table = t, .err = err, .status = sensitivity_compute(a, file, &g, err)};
    if (w.status == SP_OK) {
        add_comments(a, file, &g, &w);
        w.status = w.status == SP_OK ? sensitivity_table(a, file, &g, &w) : w.status;
    }
    sp_gradient_free(&g);
    return w.status;
}

int cmd_sensitivity(int argc, char **argv) {
    static const cli_files command = {
        .groups = "network", .contents = CLI_NETWORK, .stop = true, .begin = open_pulse, .add = compute};
    sensitivity_arguments a = {.of = {.word = "t10", .front = SP_FRONT_T10},
                               .by = SP_BY_KN | SP_BY_KT,
                               .at = -1,
                               .margin = 3,
                               .sources = {.sources = true}};
    cli_parse(&syntax, argc, argv, &a);
    const int status = cli_run_files(&command, &a);
    cli_pulse_free(&a.pulse);
    return status;
}
