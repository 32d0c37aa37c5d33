/* sonopack chain: the chain of equal balls between walls in closed form; fronts, signals and modes without a packing.
 */
#include "base/base.h"
#include "cli/cli.h"
#include "packing/contact.h"

#include <math.h>
#include <string.h>

enum {
    KEY_GRAINS = 0x1000,
    KEY_INITIAL,
    KEY_FROM,
    KEY_UNTIL,
    KEY_POINTS,
    KEY_PRESSURE,
    KEY_WALL,
    KEY_LAST,
    KEYS = KEY_LAST - KEY_GRAINS,
    LENGTHS_MAX = 1000,
    GRAINS_MAX = 100000000,
    MODES_MAX = 1000000
};
#define BIT(key)   (1u << ((key)-KEY_GRAINS))
#define KIND_NAMES "front, signal or modes"

/* Values of Bessel functions come at 2e9 orders a second: refused is what takes longer than some ten minutes. */
static const double work_max = 1e12;

typedef struct arguments {
    cli_common common;
    const struct kind *kind;
    const char *grains;
    sp_chain_source source;
    double from, until, pressure; /* NAN: not given */
    double wall;
    int64_t points;
    const char *given[KEYS]; /* names of the options that were given */
} arguments;

/* What the units of chain.h are in those of the table. */
typedef struct units {
    double time, force;
    const char *time_name, *force_name;
} units;

typedef sp_status (*chain_table)(const arguments *a, const units *u, sp_table *t, sp_error *err);
static sp_status front_table(const arguments *a, const units *u, sp_table *t, sp_error *err);
static sp_status signal_table(const arguments *a, const units *u, sp_table *t, sp_error *err);
static sp_status modes_table(const arguments *a, const units *u, sp_table *t, sp_error *err);

static const struct kind {
    const char *name;
    chain_table table;
    unsigned options;
} kinds[] = {
    {"front", front_table, BIT(KEY_GRAINS) | BIT(KEY_INITIAL) | BIT(KEY_PRESSURE)},
    {"signal", signal_table,
     BIT(KEY_GRAINS) | BIT(KEY_INITIAL) | BIT(KEY_FROM) | BIT(KEY_UNTIL) | BIT(KEY_POINTS) | BIT(KEY_PRESSURE) |
         BIT(KEY_WALL)},
    {"modes", modes_table, BIT(KEY_GRAINS) | BIT(KEY_INITIAL)},
};
enum { KINDS = sizeof kinds / sizeof *kinds };

static const struct argp_option options[] = {
    {"grains", KEY_GRAINS, "N|N1,N2,...|FROM:TO:FACTOR", 0,
     "Balls; front: several lengths, or each FACTOR times the one before (10:1000000:2)", 0},
    {"initial", KEY_INITIAL, "A|B", 0, "The first ball has a velocity (A), or is displaced (B) (A)", 0},
    {"from", KEY_FROM, "T", 0, "signal: first time (0)", 0},
    {"until", KEY_UNTIL, "T", 0, "signal: last time (twice the way from wall to wall)", 0},
    {"points", KEY_POINTS, "N", 0, "signal: equally spaced times (1001)", 0},
    {"pressure", KEY_PRESSURE, "P", 0,
     "front, signal: in d/sqrt(E* / rho) and E* d^2, of the chain of Hertzian balls under this pressure", 0},
    {"wall", KEY_WALL, "RATIO", 0, "signal: stiffness of the contacts with the walls over that of the others (1)", 0},
    {0}};
static const struct argp_child children[] = {{&cli_common_argp, 0, "Common options:", 90}, {0}};

static const char *name_of(int key) {
    for (int k = 0; options[k].name; k++)
        if (options[k].key == key)
            return options[k].name;
    return "";
}

static void positional(arguments *a, const char *arg, struct argp_state *state) {
    if (a->kind)
        argp_error(state, "%.60s: must be one kind of table only, and no file", arg);
    for (int k = 0; k < KINDS; k++)
        if (strcmp(arg, kinds[k].name) == 0)
            a->kind = &kinds[k];
    if (!a->kind)
        argp_error(state, "%.60s: must be a kind of table: " KIND_NAMES, arg);
}

static void check_usage(const arguments *a, struct argp_state *state) {
    if (!a->kind)
        argp_error(state, "no kind of table: must be " KIND_NAMES);
    if (a->common.sets > 0)
        argp_error(state, "--set %.60s: no key is used here", a->common.set[0]);
    for (int k = 0; k < KEYS; k++)
        if (a->given[k] && !(a->kind->options & 1u << k))
            argp_error(state, "--%s: is no option of chain %s", a->given[k], a->kind->name);
    if (!a->grains && a->kind->table != front_table)
        argp_error(state, "no --grains: must be the number of balls");
}

static error_t parse(int key, char *arg, struct argp_state *state) {
    arguments *a = state->input;
    sp_error err = {0};
    sp_status status = SP_OK;
    if (key >= KEY_GRAINS && key < KEY_LAST)
        a->given[key - KEY_GRAINS] = name_of(key);
    switch (key) {
    case ARGP_KEY_INIT: state->child_inputs[0] = &a->common; return 0;
    case KEY_GRAINS: a->grains = arg; break;
    case KEY_INITIAL:
        if (strcmp(arg, "A") != 0 && strcmp(arg, "B") != 0)
            argp_error(state, "--initial %.60s: must be A or B", arg);
        a->source = *arg == 'A' ? SP_CHAIN_VELOCITY : SP_CHAIN_DISPLACEMENT;
        break;
    case KEY_FROM: status = cli_number("--from", arg, 0, 1e12, &a->from, &err); break;
    case KEY_UNTIL: status = cli_number("--until", arg, 1e-9, 1e12, &a->until, &err); break;
    case KEY_POINTS: status = cli_integer("--points", arg, 2, 10000000, &a->points, &err); break;
    case KEY_PRESSURE: status = cli_number("--pressure", arg, 1e-12, 1e-2, &a->pressure, &err); break;
    case KEY_WALL: status = cli_number("--wall", arg, 1e-6, 1.999, &a->wall, &err); break;
    case ARGP_KEY_ARG: positional(a, arg, state); break;
    case ARGP_KEY_END: check_usage(a, state); break;
    default: return ARGP_ERR_UNKNOWN;
    }
    if (status != SP_OK)
        argp_error(state, "%s", err.text);
    return 0;
}

static const struct argp argp = {
    options,
    parse,
    "KIND",
    "The chain of N equal balls between two walls in closed form (Somfai et al. 2005, Section V A and Appendix C), of "
    "any length. KIND is one of:\n"
    "  front   marks of the first front and its local exponents against length\n"
    "  signal  force on the wall, and the front of an infinitely long chain beside it\n"
    "  modes   frequencies and amplitudes\v"
    "Lengths are in the distance l of two balls, times in l/c, forces in K l, where c is the speed of long waves and K "
    "the stiffness of a contact; the first ball has the speed c (A) or is displaced by l (B). With --pressure they are "
    "those of packing.kind = chain, and its signal that of `sonopack signal', from an impulse (A) or a displacement "
    "(B).",
    children,
    NULL,
    NULL};

/* ---- lengths ---------------------------------------------------------------------------------------------------- */

/* The text up to a separator, as an integer; *text moves behind the separator. */
static sp_status next_length(const char **text, const char *separators, int64_t *out, sp_error *err) {
    char word[64];
    const size_t n = strcspn(*text, separators);
    snprintf(word, sizeof word, "%.*s", (int)(n < 60 ? n : 60), *text);
    const sp_status status = cli_integer("--grains", word, 1, GRAINS_MAX, out, err);
    *text += n + ((*text)[n] != '\0');
    return status;
}

/* FROM:TO:FACTOR, the text behind FROM. */
static sp_status multiply(const char *text, int64_t from, int *count, int64_t *length, sp_error *err) {
    int64_t to;
    double factor;
    if (!strchr(text, ':'))
        return sp_fail(err, SP_EINVAL, "--grains %lld:%.60s: must be FROM:TO:FACTOR", (long long)from, text);
    sp_status status = next_length(&text, ":", &to, err);
    if (status == SP_OK && to < from)
        status = sp_fail(err, SP_EINVAL, "--grains: from %lld to %lld; must not end before it begins", (long long)from,
                         (long long)to);
    if (status == SP_OK)
        status = cli_number("--grains, factor", text, 1.001, 1e9, &factor, err);
    if (status != SP_OK)
        return status;
    int64_t last = 0;
    for (double n = (double)from; *count < LENGTHS_MAX && llround(n) <= to; n *= factor) {
        if (llround(n) > last)
            length[(*count)++] = llround(n);
        last = llround(n);
    }
    return SP_OK;
}

static sp_status lengths_of(const char *text, int *count, int64_t *length, sp_error *err) {
    *count = 0;
    const bool colon = strchr(text, ':') != NULL;
    const char *rest = text;
    do {
        if (*count == LENGTHS_MAX)
            return sp_fail(err, SP_EINVAL, "--grains: more than %d lengths", LENGTHS_MAX);
        const sp_status status = next_length(&rest, colon ? ":" : ",", &length[(*count)++], err);
        if (status != SP_OK)
            return status;
        if (colon) {
            *count = 0;
            return multiply(rest, length[0], count, length, err);
        }
    } while (rest[-1] == ',');
    return SP_OK;
}

static sp_status refuse_work(double work, sp_error *err) {
    if (work <= work_max)
        return SP_OK;
    return sp_fail(err, SP_EINVAL, "chain: would take some %.0f minutes; must be fewer points, or shorter chains",
                   ceil(work / work_max * 10));
}

/* ---- tables ----------------------------------------------------------------------------------------------------- */

/* What the fronts of long chains tend to. */
static sp_status limit_comments(sp_table *t, const sp_chain_limit *limit, const units *u, sp_error *err) {
    sp_status status = sp_table_add_comment(
        t, err, "exponents are local, between N and 2 N; limits of them, of amplitude N^gamma and of widths/N^alpha:");
    const struct {
        const char *key;
        double value;
    } entries[] = {{"gamma_limit", limit->gamma},
                   {"alpha_limit", limit->alpha},
                   {"height_limit", limit->height * u->force},
                   {"width_limit", limit->width * u->time},
                   {"width_peak_limit", limit->width_peak * u->time}};
    for (size_t k = 0; k < sizeof entries / sizeof *entries && status == SP_OK; k++)
        status = cli_add_number(t, entries[k].key, entries[k].value, err);
    return status;
}

static sp_status front_row(const arguments *a, const units *u, int64_t grains, sp_table *t, sp_error *err) {
    sp_front one, two;
    sp_status status = sp_chain_front(grains, a->source, &one, err);
    if (status == SP_OK)
        status = sp_chain_front(2 * grains, a->source, &two, err);
    if (status != SP_OK)
        return status;
    const double width_peak = one.t_zero - one.t_peak;
    return sp_table_add_row(t, err, grains, one.t10 * u->time, one.t_peak * u->time, one.t_zero * u->time,
                            one.amplitude * u->force, one.width * u->time, width_peak * u->time,
                            -log2(two.amplitude / one.amplitude), log2(two.width / one.width),
                            log2((two.t_zero - two.t_peak) / width_peak));
}

static sp_status front_table(const arguments *a, const units *u, sp_table *t, sp_error *err) {
    const char *const columns[] = {
        "t10",         u->time_name, "t_peak",     u->time_name, "t_zero",     u->time_name, "amplitude",
        u->force_name, "width",      u->time_name, "width_peak", u->time_name, "gamma",      "",
        "alpha",       "",           "alpha_peak", "",           NULL};
    const sp_chain_limit limit = sp_chain_limit_of(a->source);
    int64_t length[LENGTHS_MAX];
    int count;
    double work = 0;
    sp_status status = lengths_of(a->grains ? a->grains : "10:1000000:2", &count, length, err);
    for (int k = 0; k < count && status == SP_OK; k++)
        work += 3 * 48.0 * (double)length[k];
    if (status == SP_OK)
        status = refuse_work(work, err);
    if (status == SP_OK)
        status = limit_comments(t, &limit, u, err);
    if (status == SP_OK)
        status = sp_table_add_column(t, "grains", "", SP_CELL_INTEGER, err);
    if (status == SP_OK)
        status = cli_add_columns(t, columns, err);
    for (int k = 0; k < count && status == SP_OK; k++)
        status = front_row(a, u, length[k], t, err);
    return status;
}

/* The one length of `signal' and `modes'. */
static sp_status one_length(const arguments *a, int64_t most, int64_t *grains, sp_table *t, sp_error *err) {
    sp_status status = cli_integer("--grains", a->grains, 1, most, grains, err);
    return status == SP_OK ? sp_table_add_comment(t, err, "grains = %lld", (long long)*grains) : status;
}

static sp_status signal_table(const arguments *a, const units *u, sp_table *t, sp_error *err) {
    const char *const columns[] = {"t", u->time_name, "F", u->force_name, "airy", u->force_name, NULL};
    int64_t grains;
    sp_status status = one_length(a, GRAINS_MAX, &grains, t, err);
    if (status != SP_OK)
        return status;
    const double from = isnan(a->from) ? 0 : a->from / u->time,
                 until = isnan(a->until) ? 2 * ((double)grains + 1) : a->until / u->time;
    if (!(until > from))
        return sp_fail(err, SP_EINVAL, "--from %g: must be below --until, %g", from * u->time, until * u->time);
    status = refuse_work((double)a->points * 0.5 * (from + until), err);
    if (status == SP_OK)
        status = cli_add_number(t, "wall", a->wall, err);
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "airy: of an infinitely long chain, twice (16) of Somfai et al. 2005%s",
                                      a->source == SP_CHAIN_VELOCITY ? "" : ", differentiated");
    if (status == SP_OK)
        status = cli_add_columns(t, columns, err);
    if (status != SP_OK)
        return status;
    const size_t n = (size_t)a->points;
    double *time = sp_alloc(3 * n, sizeof *time);
    if (!time)
        return sp_fail_memory(err, 3 * n * sizeof *time);
    double *f = time + n, *airy = f + n;
    for (size_t l = 0; l < n; l++)
        time[l] = from + (until - from) * ((double)l / (double)(n - 1));
    const sp_chain chain = {.grains = grains, .source = a->source, .wall = a->wall};
    status = sp_chain_walls_signal(&chain, a->points, time, f, err);
    if (status == SP_OK)
        status = sp_chain_airy(grains, a->source, a->points, time, airy, err);
    for (size_t l = 0; l < n && status == SP_OK; l++)
        status = sp_table_add_row(t, err, time[l] * u->time, f[l] * u->force, airy[l] * u->force);
    sp_free(time);
    return status;
}

static sp_status modes_table(const arguments *a, const units *u, sp_table *t, sp_error *err) {
    static const char *const columns[] = {"omega", "c/l", "a", "l", "b", "K", NULL};
    int64_t grains;
    (void)u;
    sp_status status = one_length(a, MODES_MAX, &grains, t, err);
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "F(t) = sum of a b %s(omega t)",
                                      a->source == SP_CHAIN_VELOCITY ? "sin" : "cos");
    if (status == SP_OK)
        status = sp_table_add_column(t, "n", "", SP_CELL_INTEGER, err);
    if (status == SP_OK)
        status = cli_add_columns(t, columns, err);
    for (int64_t n = 1; n <= grains && status == SP_OK; n++) {
        const double b = 0.5 * ((double)grains + 1) * sp_chain_amplitude(grains, n, SP_CHAIN_DISPLACEMENT);
        status = sp_table_add_row(t, err, n, sp_chain_omega(grains, n), sp_chain_amplitude(grains, n, a->source),
                                  n % 2 ? b : -b);
    }
    return status;
}

/* Of equal balls as packing.kind = chain makes them, the first one kicked with K times 1, or displaced by K: what
 * `impulse' and `displacement' of the signal are. */
static units units_of(double pressure, sp_chain_source source) {
    if (isnan(pressure))
        return (units){1, 1, "l/c", "K l"};
    const double e = contact_stiffness(0.5, 0.5);
    const double k = contact_normal_stiffness(e, contact_overlap(e, pressure)), rate = sqrt(k / grain_mass(0.5));
    return (units){1 / rate, k * (source == SP_CHAIN_VELOCITY ? rate : k), "d/sqrt(E* / rho)", "E* d^2"};
}

static sp_status work(const arguments *a, sp_error *err) {
    sp_table t = sp_table_none();
    const units u = units_of(a->pressure, a->source);
    sp_status status = cli_may_write_table(&a->common, err);
    if (status == SP_OK)
        status = sp_table_add_comment(&t, err, "chain of equal balls, initial condition %s",
                                      a->source == SP_CHAIN_VELOCITY ? "A: velocity" : "B: displacement");
    if (status == SP_OK && !isnan(a->pressure))
        status = cli_add_number(&t, "pressure", a->pressure, err);
    if (status == SP_OK)
        status = a->kind->table(a, &u, &t, err);
    if (status == SP_OK)
        status = cli_write_table(&a->common, &t, err);
    sp_table_free(&t);
    return status;
}

int cmd_chain(int argc, char **argv) {
    arguments a = {.from = NAN, .until = NAN, .pressure = NAN, .wall = 1, .points = 1001};
    argp_parse(&argp, argc, argv, 0, NULL, &a);
    sp_error err = {0};
    return work(&a, &err) == SP_OK ? CLI_OK : cli_fail(&err);
}
