#ifndef SP_CLI_H
#define SP_CLI_H
/* What the commands share: common options, exit status, output. The only room that prints or exits. */

#include <argp.h>
#include <sonopack/sonopack.h>
#include <sonopack/study/store.h>
#include <stdbool.h>

enum { CLI_OK = 0, CLI_FAILED = 1, CLI_USAGE = 2 };

/* Options every command takes: --quiet --verbose --threads N --set key=value (repeatable) -o/--output FILE
 * --format tsv|csv|json --force (overwrite). */
typedef struct cli_common {
    bool quiet, verbose, force;
    int threads;
    const char *output;
    sp_table_format format;
    bool format_given;
    int sets;
    char *set[256];
} cli_common;

/* argp child that fills a cli_common given as its input: state->child_inputs[0] = &common in ARGP_KEY_INIT. */
extern const struct argp cli_common_argp;

/* One command: argv[0] is "sonopack NAME". Returns the exit status. */
typedef int (*cli_command)(int argc, char **argv);
int cmd_bench(int argc, char **argv);
int cmd_chain(int argc, char **argv);
int cmd_check(int argc, char **argv);
int cmd_column(int argc, char **argv);
int cmd_convert(int argc, char **argv);
int cmd_front(int argc, char **argv);
int cmd_modes(int argc, char **argv);
int cmd_moduli(int argc, char **argv);
int cmd_pack(int argc, char **argv);
int cmd_plot(int argc, char **argv);
int cmd_reproduce(int argc, char **argv);
int cmd_signal(int argc, char **argv);
int cmd_spectrum(int argc, char **argv);
int cmd_statics(int argc, char **argv);
int cmd_study(int argc, char **argv);
int cmd_table(int argc, char **argv);
int cmd_wave(int argc, char **argv);

/* Prints "sonopack: reason" on stderr; returns CLI_USAGE for SP_EINVAL, else CLI_FAILED. */
int cli_fail(const sp_error *err);
/* "sonopack: ..." on stderr; returns CLI_USAGE. */
int cli_usage(const char *format, ...) __attribute__((format(printf, 1, 2)));
/* Log line on stderr unless quiet; cli_debug only with --verbose. */
void cli_note(const cli_common *common, const char *format, ...) __attribute__((format(printf, 2, 3)));
void cli_debug(const cli_common *common, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Progress: one line rewritten in place on a terminal, a line a minute elsewhere with --verbose; fraction < 0: unknown.
 * seconds_left NAN: unknown. cli_progress_end clears it. */
void cli_progress(const cli_common *common, const char *text, double fraction, double seconds_left);
void cli_progress_end(const cli_common *common);
/* Whether an existing file may be replaced: a file of another kind (by its ending and content) never, one of the same
 * kind only with --force. SP_EINVAL with the reason. Call before the work. */
sp_status cli_may_write(const cli_common *common, const char *path, sp_error *err);
/* cli_may_write for common->output (which may be NULL), and whether its ending and --format name one table format. */
sp_status cli_may_write_table(const cli_common *common, sp_error *err);
/* The table on stdout, or in common->output with the format its ending names. Adds a comment with the version. */
sp_status cli_write_table(const cli_common *common, sp_table *t, sp_error *err);
/* A comment "key = value" with a number that reads back as it is. */
sp_status cli_add_number(sp_table *t, const char *key, double value, sp_error *err);
/* Columns of numbers: pairs of name and unit, ended by NULL. */
sp_status cli_add_columns(sp_table *t, const char *const *names, sp_error *err);
/* The scene of --set alone, for commands that read finished packings: only keys of `groups` ("network", "network
 * signal") are taken. Free with sp_scene_free. */
sp_status cli_scene_of_sets(const cli_common *common, const char *groups, sp_scene *out, sp_error *err);
/* Turns on clean stopping by Ctrl-C and SIGTERM; cli_stopped() says whether one came. A second one ends at once. */
void cli_catch_signals(void);
bool cli_stopped(void);
/* Strict numbers from options: the whole text, finite, in range; else cli_usage-style SP_EINVAL. */
sp_status cli_number(const char *option, const char *text, double low, double high, double *out, sp_error *err);
sp_status cli_integer(const char *option, const char *text, int64_t low, int64_t high, int64_t *out, sp_error *err);
/* Frequencies of --at: W, or W1,W2,..., or LOW:HIGH:N; omega has room for `most`. */
sp_status cli_frequencies(const char *text, int32_t most, int32_t *n, double *omega, sp_error *err);

#endif
