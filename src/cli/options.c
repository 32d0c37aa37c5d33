/* Reads the command lines of all commands: their own options, the common ones, and the scene of --set. */
#include "cli/excitation.h"

#include "base/base.h"
#include "scene/field.h"

#include <argp.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { FIRST_KEY = 0x1000, USAGE_KEY = 0x2000, OPTIONS_MAX = 60, THREADS_MAX = 4096 };

/* ---- options of many commands ------------------------------------------------------------------------------------ */

static const char *const format_words[] = {[SP_TSV] = "tsv", [SP_CSV] = "csv", [SP_JSON] = "json", NULL};
static const char *const units_words[] = {[CLI_UNITS_OWN] = "own", [CLI_UNITS_SI] = "si", NULL};

static sp_status set_format(void *arguments, const char *text, sp_error *err) {
    cli_common *common = arguments;
    int format = SP_TSV;
    sp_status status = cli_choose("--format", text, format_words, &format, err);
    common->format = (sp_table_format)format;
    common->format_given = true;
    return status;
}

static sp_status set_digits(void *arguments, const char *text, sp_error *err) {
    cli_common *common = arguments;
    int64_t digits = SP_DIGITS_ALL;
    sp_status status = strcmp(text, "all") == 0 ? SP_OK : cli_integer("--digits", text, 1, 17, &digits, err);
    common->digits = (int)digits;
    return status == SP_OK ? SP_OK : sp_fail(err, SP_EINVAL, "--digits %.60s: must be all or 1 .. 17", text);
}

static sp_status add_set(void *arguments, const char *text, sp_error *err) {
    cli_common *common = arguments;
    const int capacity = (int)(sizeof common->set / sizeof *common->set);
    if (common->sets == capacity)
        return sp_fail(err, SP_EINVAL, "--set: may be given at most %d times", capacity);
    common->set[common->sets++] = (char *)text;
    return SP_OK;
}

static const cli_option springs_options[] = {
    {.help = "Springs:"},
    {"threshold", "F", "Use only contacts with a normal force above F p d^2 (1e-4)", CLI_NUMBER, .scene = true,
     .key = "network.threshold"},
    {"prestress", NULL, "Include the effect of the forces at rest when contacts rotate", CLI_FLAG, .scene = true,
     .field = offsetof(sp_scene, network.prestress)},
    {0}};

static const cli_option common_options[] = {
    {.help = "Common options:"},
    {"output", "FILE", "Write to FILE instead of printing; its ending sets the format", CLI_TEXT,
     .field = offsetof(cli_common, output), .letter = 'o'},
    {"format", "tsv|csv|json", "Format of the table (tsv)", .parse = set_format, .words = format_words},
    {"digits", "all|N", "Digits of a table on a terminal (two of the errors, at most six); files and pipes have all",
     .parse = set_digits},
    {"force", NULL, "Replace an existing file of the same kind", CLI_FLAG, .field = offsetof(cli_common, force)},
    {"set", "KEY=VALUE", "Override a key of the scene (repeatable; see `sonopack help scene')", .parse = add_set},
    {"units", "own|si", "Units of tables: own, in d, E* and rho, or SI, for which a material is needed (own)",
     CLI_CHOICE, .field = offsetof(cli_common, units), .words = units_words},
    {"material", "E=..,nu=..,rho=..,d=..",
     "Material of the grains, in Pa, kg/m^3 and m, instead of that of scene or file", .parse = cli_set_material},
    {"threads", "N", "Number of threads (one per core)", CLI_INT, .field = offsetof(cli_common, threads), .low = 1,
     .high = THREADS_MAX},
    {"quiet", NULL, "Print no messages and no progress", CLI_FLAG, .field = offsetof(cli_common, quiet), .letter = 'q'},
    {"verbose", NULL, "Print more messages", CLI_FLAG, .field = offsetof(cli_common, verbose), .letter = 'v'},
    {0}};

/* Instead of argp's own, which know no -h. */
static const struct argp_option help_options[] = {{"help", 'h', NULL, 0, "Print this help", -1},
                                                  {"usage", USAGE_KEY, NULL, 0, "Print the options in short", 0},
                                                  {"version", 'V', NULL, 0, "Print the version", 0}};
enum { HELP_OPTIONS = sizeof help_options / sizeof *help_options };

static int cores(void) {
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) == 0 && CPU_COUNT(&set) > 0)
        return CPU_COUNT(&set);
    const long online = sysconf(_SC_NPROCESSORS_ONLN);
    return online > 0 && online <= THREADS_MAX ? (int)online : 1;
}

/* ---- the command line -------------------------------------------------------------------------------------------- */

/* A command line while argp reads it. The key of option k is FIRST_KEY + k, or its letter. */
typedef struct reading {
    const cli_syntax *syntax;
    const char *command; /* name */
    void *arguments;
    int count, rows;
    const cli_option *option[OPTIONS_MAX];     /* [count] */
    struct argp_option argp[OPTIONS_MAX + 12]; /* [rows], then one of zeros */
} reading;

static void add_help_options(reading *r) {
    memcpy(r->argp + r->rows, help_options, sizeof help_options);
    r->rows += HELP_OPTIONS;
}

static bool is_known(const reading *r, const char *name) {
    for (int k = 0; k < r->count; k++)
        if (strcmp(r->option[k]->name, name) == 0)
            return true;
    return false;
}

/* Adds options; one of the command's own takes the place of a common one of the same name. */
static void add_options(reading *r, const cli_option *options, int first_group) {
    int group = first_group;
    for (; options && (options->name || options->help); options++) {
        const int key = options->letter ? options->letter : FIRST_KEY + r->count;
        if (!options->name) {
            group = group > 0 ? group + 1 : 10; /* argp sorts the options of one group */
            r->argp[r->rows++] = (struct argp_option){.doc = options->help, .group = group};
            continue;
        }
        if (is_known(r, options->name))
            continue;
        r->option[r->count++] = options;
        r->argp[r->rows++] = (struct argp_option){options->name, key, options->argument, 0, options->help, group};
    }
}

static int find_option(const reading *r, int key) {
    for (int k = 0; k < r->count; k++)
        if (key == (r->option[k]->letter ? r->option[k]->letter : FIRST_KEY + k))
            return k;
    return -1;
}

/* An option's value goes to the field; common keeps what has a unit. */
static sp_status set_field(cli_common *common, const cli_option *o, void *field, const char *text, sp_error *err) {
    char name[64];
    const sp_key *range = o->key ? sp_field_limits(sp_field_find(o->key)) : NULL;
    const double low = range ? range->low : o->low, high = range ? range->high : o->high;
    int64_t integer;
    sp_status status;
    snprintf(name, sizeof name, "--%s", o->name);
    switch (o->kind) {
    case CLI_FLAG: *(bool *)field = true; break;
    case CLI_TEXT: *(const char **)field = text; break;
    case CLI_NUMBER:
        if (cli_keep_quantity(common, o, field, text))
            return SP_OK;
        return cli_number(name, text, low, high, field, err);
    case CLI_INTEGER: return cli_integer(name, text, (int64_t)low, high < 9e18 ? (int64_t)high : INT64_MAX, field, err);
    case CLI_INT:
        status = cli_integer(name, text, (int64_t)low, (int64_t)high, &integer, err);
        *(int32_t *)field = status == SP_OK ? (int32_t)integer : 0;
        return status;
    case CLI_CHOICE: return cli_choose(name, text, o->words, field, err);
    case CLI_PAIR: return cli_pair(name, text, low, high, field, err);
    case CLI_DASHPOTS: return cli_damping_read(text, low, high, field, err);
    case CLI_PARSED: return o->parse(field, text, err);
    }
    return SP_OK;
}

static sp_status set_option(const cli_option *o, void *arguments, const char *text, sp_error *err) {
    cli_common *common = arguments;
    if (!o->scene)
        return set_field(common, o, (char *)arguments + o->field, text, err);
    if (common->lates == CLI_LATE_MAX)
        return sp_fail(err, SP_EINVAL, "--%s: too many options", o->name);
    common->late[common->lates++] = (cli_quantity){.option = o, .text = text};
    return SP_OK;
}

static sp_status set_word(const cli_option *o, const sp_word *word, unsigned *field, const char *text, sp_error *err) {
    const char *words[24] = {NULL};
    char name[64];
    int k = 0;
    for (; k < 23 && word[k].word; k++)
        words[k] = word[k].word;
    snprintf(name, sizeof name, "--%s", o->name);
    const sp_status status = cli_choose(name, text, words, &k, err);
    if (status == SP_OK)
        *field = word[k].value;
    return status;
}

sp_status cli_set_scene(cli_common *common, sp_scene *scene, sp_error *err) {
    sp_status status = SP_OK;
    for (int k = 0; k < common->lates && status == SP_OK; k++) {
        const cli_option *o = common->late[k].option;
        const sp_field *f = o->key ? sp_field_find(o->key) : NULL;
        void *field = (char *)scene + (f ? f->offset : o->field);
        status = f && f->words ? set_word(o, f->words, field, common->late[k].text, err)
                               : set_field(common, o, field, common->late[k].text, err);
    }
    return status == SP_OK && common->material.young > 0 ? cli_set_quantities(common, &common->material, err) : status;
}

/* Whether a list of words, separated by blanks, has this word. */
static bool has_word(const char *words, const char *word, size_t length) {
    for (; *words; words += strspn(words, " ")) {
        const size_t n = strcspn(words, " ");
        if (n == length && strncmp(words, word, n) == 0)
            return true;
        words += n;
    }
    return false;
}

static sp_status check_option(const reading *r, const cli_option *o, const char *kind, sp_error *err) {
    char list[200] = "";
    size_t used = 0;
    if (!o->kinds || has_word(o->kinds, kind, strlen(kind)))
        return SP_OK;
    for (const char *at = o->kinds; *at && used < sizeof list; at++) {
        const char *between = strchr(at + 1, ' ') ? ", " : " or ";
        used += (size_t)snprintf(list + used, sizeof list - used, "%s", *at == ' ' ? between : (char[]){*at, '\0'});
    }
    return sp_fail(err, SP_EINVAL, "--%s: not for %s %s, only for %s %s", o->name, r->command, kind, r->command, list);
}

static sp_status check_kind(const reading *r, cli_common *common, sp_error *err) {
    const cli_syntax *s = r->syntax;
    char list[400];
    if (common->files == 0)
        return sp_fail(err, SP_EINVAL, "no %s: must be %s", s->kind_name, cli_list_words(s->kinds, list, sizeof list));
    sp_status status = cli_choose(s->kind_name, common->file[0], s->kinds, &common->kind, err);
    common->file++;
    common->files--;
    return status;
}

/* Refuses options that do not apply to the kind. */
static sp_status check_options(const reading *r, const cli_common *common, const char *const *kinds, sp_error *err) {
    sp_status status = SP_OK;
    for (int k = 0; k < r->count && k < 64 && status == SP_OK; k++)
        if (common->given >> k & 1)
            status = check_option(r, r->option[k], kinds[common->kind], err);
    return status;
}

static sp_status check_arguments(const reading *r, sp_error *err) {
    const cli_syntax *s = r->syntax;
    cli_common *common = r->arguments;
    const char *const *kinds = s->kinds ? s->kinds : s->kinds_by_option;
    sp_status status = s->kinds ? check_kind(r, common, err) : SP_OK;
    if (status == SP_OK && kinds)
        status = check_options(r, common, kinds, err);
    if (status == SP_OK && s->not_si && common->units == CLI_UNITS_SI)
        status = sp_fail(err, SP_EINVAL, "--units si: %s", s->not_si);
    if (status == SP_OK && (common->material.young > 0 || !s->finds_material))
        status = cli_set_quantities(common, &common->material, err);
    if (status == SP_OK && s->check && common->files >= s->files_min && common->files <= s->files_max)
        return s->check(r->arguments, err);
    if (status == SP_OK && common->files < s->files_min)
        return sp_fail(err, SP_EINVAL, "no file: must be a %s", s->file_name);
    if (status == SP_OK && common->files > s->files_max && s->files_max == 0)
        return sp_fail(err, SP_EINVAL, "%.200s: this command takes no file", common->file[0]);
    if (status == SP_OK && common->files > s->files_max)
        return sp_fail(err, SP_EINVAL, s->files_max == 1 ? "%.200s: one %s only" : "%.200s: too many files",
                       common->file[s->files_max], s->file_name);
    return status;
}

/* ---- words of the command line before argp reads them ------------------------------------------------------------ */

/* The row of argp whose long name a word is or begins, as argp takes it; -1: none, -2: several. */
static int find_long(const reading *r, const char *word, size_t length) {
    int found = -1;
    for (int k = 0; k < r->rows; k++) {
        const char *name = r->argp[k].name;
        if (!name || strncmp(name, word, length) != 0)
            continue;
        if (strlen(name) == length)
            return k;
        found = found == -1 ? k : -2;
    }
    return found;
}

static const char *long_name(int k, const void *user) {
    const reading *r = user;
    static const char other[] = "\n"; /* headings have no name; no word is like this */
    return k >= r->rows ? NULL : r->argp[k].name ? r->argp[k].name : other;
}

static bool letter_takes_next(const reading *r, const char *word) {
    for (int k = 0; k < r->rows && word[1] && !word[2]; k++)
        if (r->argp[k].key == word[1])
            return r->argp[k].arg != NULL;
    return false;
}

static void refuse_option(const reading *r, const char *word, size_t length) {
    char name[64];
    snprintf(name, sizeof name, "%.*s", (int)(length < 60 ? length : 60), word + 2);
    const int near = cli_nearest(name, long_name, r);
    if (near >= 0)
        cli_usage("unknown option --%s of %s: did you mean --%s?", name, r->command, r->argp[near].name);
    else
        cli_usage("unknown option --%s: see `sonopack help %s'", name, r->command);
    exit(CLI_USAGE);
}

/* Exits at the first long option that does not exist, with the one that is most like it. argp would not suggest any.
 * -? becomes --help. */
static void check_words(const reading *r, int argc, char **argv) {
    static char help[] = "--help";
    for (int k = 1; k < argc && strcmp(argv[k], "--") != 0; k++) {
        const char *word = argv[k];
        if (strcmp(word, "-?") == 0)
            argv[k] = help;
        if (strncmp(word, "--", 2) != 0) {
            k += word[0] == '-' && letter_takes_next(r, word);
            continue;
        }
        const size_t length = strcspn(word, "=");
        const int row = find_long(r, word + 2, length - 2);
        if (row == -1)
            refuse_option(r, word, length);
        k += row >= 0 && !word[length] && r->argp[row].arg;
    }
}

static void give_help(int key, struct argp_state *state) {
    if (key == 'h')
        argp_state_help(state, stdout, ARGP_HELP_STD_HELP);
    if (key == USAGE_KEY)
        argp_state_help(state, stdout, ARGP_HELP_USAGE | ARGP_HELP_EXIT_OK);
    if (key == 'V') {
        printf("sonopack %s\n", SONOPACK_VERSION);
        exit(CLI_OK);
    }
}

static error_t parse(int key, char *text, struct argp_state *state) {
    reading *r = state->input;
    cli_common *common = r->arguments;
    sp_error err = {0};
    sp_status status = SP_OK;
    const int found = find_option(r, key);
    give_help(key, state);
    if (found >= 0) {
        common->given |= UINT64_C(1) << found;
        status = set_option(r->option[found], r->arguments, text, &err);
    } else if (key == ARGP_KEY_ARGS) {
        common->file = state->argv + state->next;
        common->files = state->argc - state->next;
    } else if (key == ARGP_KEY_END) {
        status = check_arguments(r, &err);
    } else {
        return ARGP_ERR_UNKNOWN;
    }
    if (status != SP_OK)
        argp_error(state, "%s", err.text);
    return 0;
}

const cli_command_row *cli_commands;

const cli_option *cli_option_at(const cli_syntax *syntax, int k) {
    const cli_option *const lists[] = {syntax->options, syntax->springs ? springs_options : NULL, common_options};
    for (size_t l = 0; l < sizeof lists / sizeof *lists; l++)
        for (const cli_option *o = lists[l]; o && (o->name || o->help); o++)
            if (k-- == 0)
                return o;
    return NULL;
}

void cli_parse(const cli_syntax *syntax, int argc, char **argv, void *arguments) {
    cli_common *common = arguments;
    reading r = {.syntax = syntax, .command = argv[0] + strlen("sonopack "), .arguments = arguments};
    add_options(&r, syntax->options, 0);
    if (syntax->springs)
        add_options(&r, springs_options, 50);
    add_options(&r, common_options, 90);
    add_help_options(&r);
    check_words(&r, argc, argv);
    if (common->threads == 0)
        common->threads = cores();
    const struct argp argp = {r.argp, parse, syntax->usage, syntax->help, NULL, NULL, NULL};
    if (argp_parse(&argp, argc, argv, ARGP_NO_HELP, NULL, &r) != 0) { /* wrong usage ends the program in `parse' */
        const sp_error err = {.status = SP_ENOMEM, .text = "no memory for the options"};
        exit(cli_fail(&err));
    }
    cli_watch(common, r.command);
}

bool cli_given(const cli_syntax *syntax, const cli_common *common, const char *name) {
    int k = 0;
    for (const cli_option *o = syntax->options; o->name || o->help; o++) {
        if (o->name && strcmp(o->name, name) == 0)
            return common->given >> k & 1;
        k += o->name != NULL;
    }
    return false;
}

sp_status cli_need(const cli_syntax *syntax, const cli_common *common, const char *name, bool used, const char *other,
                   sp_error *err) {
    if (used || !cli_given(syntax, common, name))
        return SP_OK;
    return sp_fail(err, SP_EINVAL, "--%s: only with %s", name, other);
}

sp_status cli_scene_of_sets(cli_common *common, const char *groups, sp_scene *out, sp_error *err) {
    for (int k = 0; k < common->sets; k++)
        if (strncmp(common->set[k], "material.", 9) != 0 &&
            !has_word(groups, common->set[k], strcspn(common->set[k], ".")))
            return sp_fail(err, SP_EINVAL, "--set %.60s: this command takes only keys of the group %s", common->set[k],
                           groups);
    const sp_status status = cli_read_scene(common, NULL, out, err);
    return status == SP_OK ? cli_set_scene(common, out, err) : status;
}
