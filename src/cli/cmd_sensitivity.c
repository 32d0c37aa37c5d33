/* sonopack sensitivity: by how much each contact or grain moves a quantity. */
#include "base/base.h"
#include "cli/excitation.h"
#include "cli/files.h"
#include "sensitivity/gradient.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef enum quantity_kind {
    SENSITIVITY_FRONT = 0,
    SENSITIVITY_SIGNAL,
    SENSITIVITY_OMEGA,
    SENSITIVITY_MODULUS
} quantity_kind;

/* A quantity, as --of names it. */
typedef struct quantity {
    const char *word; /* as it was given */
    quantity_kind kind;
    sp_front_quantity front;
    sp_modulus modulus;
    int64_t first, last; /* modes, as in the column n of `modes` */
} quantity;

typedef struct arguments {
    cli_common common;
    quantity of;
    unsigned by; /* of sp_parameter */
    int source;
    double at, until, margin;
    cli_places sources, detectors;
    cli_pulse pulse;
} arguments;

static const char *const fronts[] = {"t10", "t_peak", "peak", "t_zero", "width", NULL}; /* bits of sp_front_quantity */
static const char *const parameters[] = {"kn", "kt", "mass", "radius", "position", "pressure"};

/* The names of the table of moduli; cl and ct serve as well as c_l and c_t. */
static bool is_modulus(const char *word, sp_modulus of) {
    const char *const name = sp_modulus_name(of);
    return strcmp(word, name) == 0 || (name[1] == '_' && word[0] == name[0] && strcmp(word + 1, name + 2) == 0);
}

static sp_status wrong(const char *word, sp_error *err) {
    return sp_fail(err, SP_EINVAL,
                   "--of %.60s: must be t10, t_peak, peak, t_zero, width, F, omega:N, omega:N-M, c_l, c_t or a modulus "
                   "such as C22",
                   word);
}

/* "N" or "N-M". */
static sp_status read_modes(const char *word, const char *text, quantity *out, sp_error *err) {
    char first[32];
    const size_t length = strcspn(text, "-");
    if (length == 0 || length >= sizeof first)
        return wrong(word, err);
    memcpy(first, text, length);
    first[length] = '\0';
    if (cli_integer("--of omega", first, 0, INT32_MAX, &out->first, err) != SP_OK)
        return SP_EINVAL;
    out->last = out->first;
    if (text[length] == '\0')
        return SP_OK;
    return cli_integer("--of omega", text + length + 1, out->first, INT32_MAX, &out->last, err);
}

static sp_status set_quantity(void *field, const char *word, sp_error *err) {
    quantity *q = field;
    *q = (quantity){.word = word, .kind = SENSITIVITY_SIGNAL};
    for (int k = 0; fronts[k]; k++)
        if (strcmp(word, fronts[k]) == 0) {
            q->kind = SENSITIVITY_FRONT;
            q->front = (sp_front_quantity)(1U << k);
            return SP_OK;
        }
    for (int k = 0; k < SP_MODULUS_COUNT; k++)
        if (is_modulus(word, (sp_modulus)k)) {
            q->kind = SENSITIVITY_MODULUS;
            q->modulus = (sp_modulus)k;
            return SP_OK;
        }
    if (strcmp(word, "F") == 0)
        return SP_OK;
    q->kind = SENSITIVITY_OMEGA;
    return strncmp(word, "omega:", 6) == 0 ? read_modes(word, word + 6, q, err) : wrong(word, err);
}

/* Reads --by: kn,kt or mass,radius,position or pressure. */
static sp_status set_parameters(void *field, const char *word, sp_error *err) {
    enum { CONTACTS = SP_BY_KN | SP_BY_KT, GRAINS = SP_BY_MASS | SP_BY_RADIUS | SP_BY_POSITION };
    unsigned by = 0;
    for (const char *at = word; *at;) {
        const size_t length = strcspn(at, ",");
        size_t k = 0;
        while (k < 6 && (strlen(parameters[k]) != length || strncmp(at, parameters[k], length) != 0))
            k++;
        if (k == 6)
            return sp_fail(err, SP_EINVAL, "--by %.60s: must be a list of kn, kt, mass, radius, position, pressure",
                           word);
        by |= 1U << k;
        at += length + (at[length] == ',');
    }
    const int tables = ((by & CONTACTS) != 0) + ((by & GRAINS) != 0) + ((by & SP_BY_PRESSURE) != 0);
    if (tables != 1)
        return sp_fail(err, SP_EINVAL,
                       "--by %.60s: contacts (kn, kt), grains (mass, radius, position) and the pressure have tables of "
                       "their own: one of them at a time",
                       word);
    /* Euler's theorem, the check of the table, needs both */
    *(unsigned *)field = by & CONTACTS ? by | CONTACTS : by;
    return SP_OK;
}

static const char *unit_of(const quantity *of) {
    switch (of->kind) {
    case SENSITIVITY_FRONT: return of->front == SP_FRONT_PEAK ? "E* d^2" : "d/sqrt(E* / rho)";
    case SENSITIVITY_SIGNAL: return "E* d^2";
    case SENSITIVITY_OMEGA: return "E* / (rho d^2)";
    default: return of->modulus >= SP_MODULUS_CL ? "sqrt(E* / rho)" : "E*";
    }
}

static sp_status wave_options(const arguments *a, const cli_file *file, sp_sensitivity_options *out, sp_error *err) {
    sp_sensitivity_options o = sp_sensitivity_options_default();
    if (a->sources.n == 0 && a->detectors.n == 0) {
        const sp_status status = cli_need_walls(&file->packing, "a front", err);
        if (status != SP_OK)
            return status;
    }
    o.parameters = a->by;
    o.source = (sp_source)a->source;
    o.from = a->sources.n > 0 ? a->sources.at : NULL;
    o.to = a->detectors.n > 0 ? a->detectors.at : NULL;
    o.pulse = a->pulse.word ? &a->pulse.pulse : NULL;
    o.until = a->until > 0 ? a->until : 0;
    o.threads = a->common.threads;
    o.packing = &file->packing;
    *out = o;
    return SP_OK;
}

static sp_status of_front(const arguments *a, const cli_file *file, sp_gradient *out, sp_error *err) {
    sp_sensitivity_options o;
    sp_front_gradient g;
    sp_status status = wave_options(a, file, &o, err);
    CLI_THEN(status, sp_sensitivity_front(&file->network, &o, a->of.front, &g, err));
    if (status != SP_OK)
        return status;
    sp_gradient *from = a->of.front == SP_FRONT_T10      ? &g.t10
                        : a->of.front == SP_FRONT_T_PEAK ? &g.t_peak
                        : a->of.front == SP_FRONT_PEAK   ? &g.peak
                        : a->of.front == SP_FRONT_T_ZERO ? &g.t_zero
                                                         : &g.width;
    *out = *from;
    *from = sp_gradient_none();
    sp_front_gradient_free(&g);
    return SP_OK;
}

static sp_status of_signal(const arguments *a, const cli_file *file, sp_gradient *out, sp_error *err) {
    sp_sensitivity_options o;
    const double one = 1;
    const sp_functional j = {1, &a->at, &one, NULL};
    const sp_status status = wave_options(a, file, &o, err);
    return status == SP_OK ? sp_sensitivity_signal(&file->network, &o, 1, &j, out, err) : status;
}

/* All modes up to the last one and one more, which tells how far the group is from the next. */
static sp_status of_modes(const arguments *a, const cli_file *file, sp_gradient *out, sp_error *err) {
    const sp_network *net = &file->network;
    sp_modes_options o = sp_modes_options_default();
    sp_modes m = sp_modes_none();
    o.vectors = true;
    o.threads = a->common.threads;
    const sp_modes_range all = sp_modes_range_all();
    sp_status status = sp_modes_make(net, &o, &all, &m, err);
    CLI_THEN(status, sp_sensitivity_modes(net, &m, a->of.first - m.first, a->of.last - a->of.first + 1, a->by,
                                          &file->packing, out, err));
    sp_modes_free(&m);
    return status;
}

static sp_status of_modulus(const arguments *a, const cli_file *file, sp_gradient *out, sp_error *err) {
    double density;
    sp_status status = sp_packing_density(&file->packing, file->scene->network.threshold, a->margin, &density, err);
    return status == SP_OK
               ? sp_sensitivity_moduli(&file->network, density, 1, &a->of.modulus, a->by, &file->packing, out, err)
               : status;
}

static sp_status differentiate(const arguments *a, const cli_file *file, sp_gradient *out, sp_error *err) {
    switch (a->of.kind) {
    case SENSITIVITY_FRONT: return of_front(a, file, out, err);
    case SENSITIVITY_SIGNAL: return of_signal(a, file, out, err);
    case SENSITIVITY_OMEGA: return of_modes(a, file, out, err);
    default: return of_modulus(a, file, out, err);
    }
}

/* A derivative by the logarithm of a parameter, and its error. */
static void put_partial(cli_writer *w, const sp_partials *d, int64_t k, double parameter) {
    if (d->n == 0)
        return;
    cli_put(w, parameter * d->d[k], parameter * d->error[k]);
}

static void columns_of(cli_writer *w, const sp_partials *d, const char *name, const char *error, const char *unit) {
    if (d->n > 0)
        cli_columns(w, SP_COLUMN_NUMBER, name, unit, error, unit, NULL);
}

/* The middle of the line that a contact is drawn along. */
static void put_contact(cli_writer *w, const sp_network *net, int32_t k) {
    const sp_spring *s = &net->springs[k];
    cli_put(w, s->contact, net->grain[s->i], s->j < 0 ? s->j : net->grain[s->j]);
    for (int a = 0; a < net->dim; a++)
        cli_put(w, net->x[3 * (int64_t)s->i + a] + (s->j < 0 ? 1 : 0.5) * net->length[k] * s->n[a]);
    cli_put(w, s->kn, s->kt);
}

static sp_status contact_rows(const cli_file *file, const sp_gradient *g, const char *unit, cli_writer *w) {
    const sp_network *net = &file->network;
    cli_columns(w, SP_COLUMN_INTEGER, "contact", "", "i", "", "j", "", NULL);
    cli_place_columns(w, net->dim);
    cli_columns(w, SP_COLUMN_NUMBER, "kn", "E* d", "kt", "E* d", NULL);
    columns_of(w, &g->kn, "by_kn", "by_kn_err", unit);
    columns_of(w, &g->kt, "by_kt", "by_kt_err", unit);
    for (int32_t k = 0; k < net->n_springs; k++) {
        put_contact(w, net, k);
        put_partial(w, &g->kn, k, net->springs[k].kn);
        put_partial(w, &g->kt, k, net->springs[k].kt);
        cli_end_row(w);
    }
    return w->status;
}

static sp_status grain_rows(const cli_file *file, const sp_gradient *g, const char *unit, cli_writer *w) {
    static const char *const names[] = {"by_x", "by_y", "by_z"};
    const sp_network *net = &file->network;
    cli_columns(w, SP_COLUMN_INTEGER, "grain", "", NULL);
    cli_place_columns(w, net->dim);
    cli_columns(w, SP_COLUMN_NUMBER, "r", "d", "mass", "rho d^3", NULL);
    columns_of(w, &g->mass, "by_mass", "by_mass_err", unit);
    columns_of(w, &g->radius, "by_radius", "by_radius_err", unit);
    for (int a = 0; a < net->dim && g->position.n > 0; a++)
        cli_columns(w, SP_COLUMN_NUMBER, names[a], unit, NULL);
    if (g->position.n > 0)
        cli_columns(w, SP_COLUMN_NUMBER, "by_position_err", unit, NULL);
    for (int32_t k = 0; k < net->n; k++) {
        const double mass = net->mass[(int64_t)k * net->dof];
        cli_put(w, net->grain[k]);
        for (int a = 0; a < net->dim; a++)
            cli_put(w, net->x[3 * (int64_t)k + a]);
        cli_put(w, net->r[k], mass);
        put_partial(w, &g->mass, k, mass);
        put_partial(w, &g->radius, k, net->r[k]);
        for (int a = 0; a < net->dim && g->position.n > 0; a++)
            cli_put(w, g->position.d[3 * (int64_t)k + a]);
        if (g->position.n > 0)
            cli_put(w, g->position.error[3 * (int64_t)k]);
        cli_end_row(w);
    }
    return w->status;
}

static sp_status pressure_row(const cli_file *file, const sp_gradient *g, const char *unit, cli_writer *w) {
    const double p = file->packing.pressure;
    cli_columns(w, SP_COLUMN_NUMBER, "p", "E*", "by_p", unit, "by_p_err", unit, NULL);
    return w->status == SP_OK ? cli_row(w, p, p * g->pressure.d[0], p * g->pressure.error[0]) : w->status;
}

static sp_status add_rows(const arguments *a, const cli_file *file, const sp_gradient *g, cli_writer *w) {
    const char *unit = unit_of(&a->of);
    if (a->by & (SP_BY_KN | SP_BY_KT))
        return contact_rows(file, g, unit, w);
    return a->by & SP_BY_PRESSURE ? pressure_row(file, g, unit, w) : grain_rows(file, g, unit, w);
}

static const cli_option options[] = {
    {"of", "QUANTITY",
     "What to differentiate: t10, t_peak, peak, t_zero or width of the first front; F, the signal at --at; omega:N or "
     "omega:N-M, the mean omega^2 of modes; c_l, c_t (or cl, ct), C11, C12, ... (t10)",
     .parse = set_quantity, CLI_FIELD(of)},
    {"by", "LIST", "Parameters: kn,kt of the contacts; mass,radius,position of the grains; or pressure (kn,kt)",
     .parse = set_parameters, CLI_FIELD(by)},
    {"at", "T", "Time of F [d/sqrt(E* / rho)]", CLI_NUMBER, CLI_FIELD(at), .high = 1e9, .unit = "d/sqrt(E* / rho)"},
    {"until", "T", "Last time at which the front is sought [d/sqrt(E* / rho)] (as of signal)", CLI_NUMBER,
     CLI_FIELD(until), .low = 1e-9, .high = 1e9, .unit = "d/sqrt(E* / rho)"},
    {"margin", "D", "c_l, c_t: leave layers of this thickness at all walls out of the density [d] (3)", CLI_NUMBER,
     CLI_FIELD(margin), .high = 1e6},
    {"pulse", "PULSE", "Strength of the source against time: delta, gauss:WIDTH or ricker:OMEGA (delta)",
     .parse = cli_pulse_parse, CLI_FIELD(pulse)},
    {"source", "impulse|velocity|displacement", "Kind of source, as in signal (impulse)", CLI_CHOICE, CLI_FIELD(source),
     .words = cli_source_names},
    {"from", "PLACE", "Source at bottom, part:X0:X1, disc:X:Y:D, plane:Y or grain:I (bottom)", .parse = cli_places_add,
     CLI_FIELD(sources)},
    {"detector", "PLACE", "Detector at top, plane:Y, part:X0:X1, disc:X:Y:D or grain:I (top)", .parse = cli_places_add,
     CLI_FIELD(detectors)},
    {0}};

static sp_status check(void *user, sp_error *err) {
    const arguments *a = user;
    const bool wave = a->of.kind == SENSITIVITY_FRONT || a->of.kind == SENSITIVITY_SIGNAL;
    if ((a->of.kind == SENSITIVITY_SIGNAL) != (a->at >= 0))
        return sp_fail(err, SP_EINVAL, "--at T: needed for --of F, and only for it");
    if (a->sources.n > 1 || a->detectors.n > 1)
        return sp_fail(err, SP_EINVAL, "--from and --detector: one place each");
    if (!wave && (a->sources.n > 0 || a->detectors.n > 0 || a->pulse.word))
        return sp_fail(err, SP_EINVAL, "--from, --detector and --pulse: only for a front or for F");
    sp_status status = cli_need(&cmd_sensitivity_syntax, &a->common, "source", wave, "a front or F", err);
    CLI_THEN(status,
             cli_need(&cmd_sensitivity_syntax, &a->common, "until", a->of.kind == SENSITIVITY_FRONT, "a front", err));
    return status == SP_OK ? cli_need(&cmd_sensitivity_syntax, &a->common, "margin", a->of.kind == SENSITIVITY_MODULUS,
                                      "c_l or c_t", err)
                           : status;
}

const cli_syntax cmd_sensitivity_syntax = {
    .usage = "FILE",
    .help =
        "Exact derivatives of the arrival of a pulse, of the signal, of frequencies and of elastic moduli by the "
        "stiffness of each contact, by the mass, radius and position of each grain, and by the pressure.\v"
        "Each row is a contact or a grain that carries force. by_X is the derivative of the quantity by the logarithm "
        "of X: the change for a small relative change of X alone, over that change; by_x, by_y and by_z are "
        "derivatives by the position of the centre in mean diameters d, in all units. by_X_err are bounds of their "
        "errors, by_position_err of each of by_x, by_y and by_z. The momentum of a source at the wall and the force "
        "on a detector change with the stiffness of their contacts. With radius and position the overlaps, and with "
        "them the stiffnesses, follow the contact law, and with radius the mass too; no contact is made or lost. With "
        "pressure the packing follows the load by its linear response, and no contact slides.\n"
        "\n"
        "Comments give the quantity (value; of modes omega^2) and a bound of its error (value_err); homogeneity, the "
        "sum over all contacts, which Euler's theorem knows (if all springs are stiffer by a factor s, times shorten "
        "by sqrt(s)), minus what it should be, over the sum of absolute values; and half_share, the fraction of the "
        "contacts (the largest ones) that have half of the sum of |by_kn| + |by_kt|. A front is that of the "
        "continuous signal. A group of modes of one frequency has a derivative only as a whole: omega:N-M. N counts "
        "as the column n of modes, zero modes first. c_l and c_t have a fixed density. K must be symmetric: with "
        "friction --prestress is refused. --set takes keys of the group network.",
    CLI_ONE_PACKING,
    .options = options,
    .springs = true,
    .check = check};

static sp_status open_pulse(void *user, cli_writer *w) { return cli_pulse_open(&((arguments *)user)->pulse, w->err); }

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

static void add_comments(const arguments *a, const cli_file *file, const sp_gradient *g, cli_writer *w) {
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

static sp_status compute(void *user, cli_file *file, cli_writer *w) {
    const arguments *a = user;
    sp_gradient g = sp_gradient_none();
    w->status = differentiate(a, file, &g, w->err);
    if (w->status == SP_OK) {
        add_comments(a, file, &g, w);
        w->status = w->status == SP_OK ? add_rows(a, file, &g, w) : w->status;
    }
    sp_gradient_free(&g);
    return w->status;
}

int cmd_sensitivity(int argc, char **argv) {
    static const cli_files command = {CLI_OF_NETWORK, .stop = true, .begin = open_pulse, .add = compute};
    arguments a = {.of = {.word = "t10", .front = SP_FRONT_T10},
                   .by = SP_BY_KN | SP_BY_KT,
                   .at = -1,
                   .margin = 3,
                   .sources = {.sources = true}};
    cli_parse(&cmd_sensitivity_syntax, argc, argv, &a);
    const int status = cli_run_files(&command, &a);
    cli_pulse_free(&a.pulse);
    return status;
}
