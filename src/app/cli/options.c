/* Options that every command takes, strict numbers, and the scene of --set. */
#include "cli/cli.h"

#include "base/base.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <sched.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { KEY_THREADS = 0x2000, KEY_SET, KEY_FORMAT, KEY_FORCE, MOST_THREADS = 4096 };

static const struct argp_option options[] = {
    {"output", 'o', "FILE", 0, "Write to FILE instead of printing; its ending says the format", 90},
    {"format", KEY_FORMAT, "tsv|csv|json", 0, "Format of the table", 90},
    {"force", KEY_FORCE, NULL, 0, "Replace an existing file of the same kind", 90},
    {"set", KEY_SET, "KEY=VALUE", 0, "Override a key of the scene (repeatable; see `sonopack help scene')", 90},
    {"threads", KEY_THREADS, "N", 0, "Threads to use (as many as there are cores)", 90},
    {"quiet", 'q', NULL, 0, "No log and no progress on stderr", 90},
    {"verbose", 'v', NULL, 0, "More log on stderr", 90},
    {0}};

/* Cores that this process may use. */
static int cores(void) {
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) == 0 && CPU_COUNT(&set) > 0)
        return CPU_COUNT(&set);
    const long online = sysconf(_SC_NPROCESSORS_ONLN);
    return online > 0 && online <= MOST_THREADS ? (int)online : 1;
}

static void parse_format(cli_common *common, const char *word, struct argp_state *state) {
    static const char *const words[] = {[SP_TSV] = "tsv", [SP_CSV] = "csv", [SP_JSON] = "json"};
    for (unsigned k = 0; k < sizeof words / sizeof *words; k++) {
        if (strcmp(word, words[k]) == 0) {
            common->format = (sp_table_format)k;
            common->format_given = true;
            return;
        }
    }
    argp_error(state, "--format %s: must be tsv, csv or json", word);
}

static error_t parse(int key, char *arg, struct argp_state *state) {
    cli_common *common = state->input;
    const int most = (int)(sizeof common->set / sizeof *common->set);
    sp_error err;
    int64_t integer;
    switch (key) {
    case ARGP_KEY_INIT:
        if (common->threads == 0)
            common->threads = cores();
        return 0;
    case 'o': common->output = arg; return 0;
    case 'q':
        common->quiet = true;
        common->verbose = false;
        return 0;
    case 'v':
        common->verbose = true;
        common->quiet = false;
        return 0;
    case KEY_FORCE: common->force = true; return 0;
    case KEY_FORMAT: parse_format(common, arg, state); return 0;
    case KEY_THREADS:
        if (cli_integer("--threads", arg, 1, MOST_THREADS, &integer, &err) == SP_OK)
            common->threads = (int)integer;
        else
            argp_error(state, "%s", err.text);
        return 0;
    case KEY_SET:
        if (common->sets == most)
            argp_error(state, "--set: must be given %d times at the most", most);
        else
            common->set[common->sets++] = arg;
        return 0;
    default: return ARGP_ERR_UNKNOWN;
    }
}

const struct argp cli_common_argp = {options, parse, NULL, NULL, NULL, NULL, NULL};

/* Decimal digits, sign, point and exponent only: strtod would take "nan", "0x1p3" and leading spaces too. */
static bool is_decimal(const char *text) { return *text && text[strspn(text, "0123456789+-.eE")] == '\0'; }

sp_status cli_number(const char *option, const char *text, double low, double high, double *out, sp_error *err) {
    char *end = NULL;
    const double value = is_decimal(text) ? strtod(text, &end) : NAN;
    if (!end || end == text || *end || !isfinite(value) || value < low || value > high)
        return sp_fail(err, SP_EINVAL, "%s %.60s: must be a number %g .. %g", option, text, low, high);
    *out = value;
    return SP_OK;
}

sp_status cli_integer(const char *option, const char *text, int64_t low, int64_t high, int64_t *out, sp_error *err) {
    char *end = NULL;
    errno = 0;
    const long long value = is_decimal(text) ? strtoll(text, &end, 10) : 0;
    if (!end || end == text || *end || errno || value < low || value > high)
        return sp_fail(err, SP_EINVAL, "%s %.60s: must be an integer %lld .. %lld", option, text, (long long)low,
                       (long long)high);
    *out = value;
    return SP_OK;
}

sp_status cli_scene_of_sets(const cli_common *common, const char *groups, sp_scene *out, sp_error *err) {
    for (int k = 0; k < common->sets; k++) {
        const char *key = common->set[k], *dot = strchr(key, '.');
        const size_t length = dot ? (size_t)(dot - key) : strlen(key);
        bool known = false;
        for (const char *at = groups; *at;) {
            const size_t n = strcspn(at, " ");
            known = known || (n == length && strncmp(at, key, n) == 0);
            at += n + strspn(at + n, " ");
        }
        if (!known)
            return sp_fail(err, SP_EINVAL, "--set %.60s: must be a key of %s, no other is used here", key, groups);
    }
    return sp_scene_read(NULL, common->sets, common->set, out, err);
}
