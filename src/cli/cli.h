#ifndef SP_CLI_H
#define SP_CLI_H
/* What the commands share: common options, exit statuses, messages and output. Only src/cli prints or exits. */

#include "table/quantity.h"

#include <sonopack/sonopack.h>
#include <sonopack/study/store.h>
#include <stdbool.h>
#include <stddef.h>

/* Default tolerance of `sonopack check' and `study --verify'. By the default rule grains and walls are balanced to
 * about 1e-6 of p d^2; packings that were compressed elsewhere to an acceleration of 1e-10, with a heavy piston, are
 * off by 1e-5 at the walls. */
#define CLI_AUDIT_TOLERANCE 2e-5

enum { CLI_OK = 0, CLI_FAILED = 1, CLI_USAGE = 2 };

/* An option whose number has a unit, "50 us": it waits for the material, which may be that of a file. */
typedef struct cli_quantity {
    const struct cli_option *option;
    const char *text;
    void *field; /* where its value goes */
} cli_quantity;
enum { CLI_QUANTITIES_MAX = 16, CLI_LATE_MAX = 32 };

/* The first member of the arguments of every command. cli_parse fills it in. */
typedef struct cli_common {
    bool quiet, verbose, force, dry_run;
    int threads; /* before cli_parse: the default, 0 for one per core */
    const char *output;
    sp_table_format format;
    bool format_given;
    int digits; /* of tables on a terminal: see sp_table_aligned */
    int sets;
    char *set[256];       /* KEY=VALUE of each --set */
    int units;            /* --units: CLI_UNITS_OWN or CLI_UNITS_SI */
    sp_material material; /* --material; young = 0: not given */
    sp_material found;    /* of the first file, or of the scene, that has one */
    const char *found_in; /* its name */
    bool mixed;           /* files have different ones */
    bool converted;       /* an option got its value from a material */
    int quantities;
    cli_quantity quantity[CLI_QUANTITIES_MAX];
    int lates;
    cli_quantity late[CLI_LATE_MAX]; /* options of the scene, which is made from --set first */
    uint64_t given;                  /* see cli_given */
    int kind;                        /* index of the word KIND */
    int files;                       /* the other arguments */
    char **file;
} cli_common;

/* ---- options ----------------------------------------------------------------------------------------------------- */

typedef enum cli_option_kind {
    CLI_PARSED = 0, /* calls parse() with the field */
    CLI_FLAG,       /* sets a bool to true */
    CLI_TEXT,       /* const char *: the argument itself */
    CLI_NUMBER,     /* double between low and high */
    CLI_INTEGER,    /* int64_t or uint64_t between low and high */
    CLI_INT,        /* the same, int32_t */
    CLI_CHOICE,     /* int: the index of the argument in `words` */
    CLI_PAIR,       /* double[2]: LOW:HIGH, both between low and high */
    CLI_DASHPOTS    /* sp_damping, see cli_damping_read */
} cli_option_kind;

/* One long option, which sets a field of the command's arguments. */
typedef struct cli_option {
    const char *name;     /* NULL: `help` is the heading of the options that follow */
    const char *argument; /* its name in the help; NULL for a flag */
    const char *help;
    cli_option_kind kind;
    size_t field; /* offset in the arguments, or with `scene' in an sp_scene */
    double low, high;
    const char *key; /* the range is that of this scene key, instead of low and high; with `scene' it is this key */
    bool scene;      /* sets a value of the scene, after --set */
    const char *const *words; /* ended by NULL */
    sp_status (*parse)(void *field, const char *text, sp_error *err);
    const char *kinds; /* the words KIND that take the option, separated by blanks; NULL: all */
    int letter;        /* short option */
    const char *unit;  /* of a number: it may be given with another unit of the same dimension */
} cli_option;

#define CLI_FIELD(member) .field = offsetof(arguments, member) /* of the struct of that name in the command */

/* The command line of one command. */
typedef struct cli_syntax {
    const char *usage; /* the arguments; one line for each form */
    const char *help;  /* one sentence, \v, and what follows the options */
    const cli_option *options;
    const char *const *kinds;           /* possible words of the first argument, ended by NULL; NULL: it is a file */
    const char *kind_name;              /* "kind of spectrum", for messages */
    const char *file_name;              /* what a file is, for messages: "packing", "scene" */
    int files_min, files_max;           /* how many */
    const char *const *kinds_by_option; /* the same of an option, which sets common.kind */
    bool springs;                       /* takes --threshold and --prestress */
    bool finds_material;                /* calls cli_take_material */
    const char *not_si;                 /* why the command has no --units si; NULL: it has */
    sp_status (*check)(void *arguments, sp_error *err); /* called after everything has been read; may be NULL */
} cli_syntax;

enum { CLI_ANY_NUMBER = 1 << 30 };

/* ---- commands ---------------------------------------------------------------------------------------------------- */

/* argv[0] is "sonopack NAME". Returns the exit status. */
typedef int cli_command(int argc, char **argv);
cli_command cmd_amplitude, cmd_chain, cmd_check, cmd_clusters, cmd_coda, cmd_column, cmd_completion, cmd_design,
    cmd_front, cmd_modes, cmd_moduli, cmd_pack, cmd_respond, cmd_sensitivity, cmd_signal, cmd_spectrum, cmd_statics,
    cmd_study, cmd_table, cmd_uncertainty, cmd_transport, cmd_wave;
extern const cli_syntax cmd_amplitude_syntax, cmd_chain_syntax, cmd_check_syntax, cmd_clusters_syntax, cmd_coda_syntax,
    cmd_column_syntax, cmd_completion_syntax, cmd_design_syntax, cmd_front_syntax, cmd_modes_syntax, cmd_moduli_syntax,
    cmd_pack_syntax, cmd_respond_syntax, cmd_sensitivity_syntax, cmd_signal_syntax, cmd_spectrum_syntax,
    cmd_statics_syntax, cmd_study_syntax, cmd_table_syntax, cmd_transport_syntax, cmd_uncertainty_syntax,
    cmd_wave_syntax;
cli_command cmd_dispatch; /* executes `sonopack-NAME' of the Python package */
/* The same for a rank of an engine, "sonopack NAME", whose libraries shall start no threads. */
int cmd_engine(const char *name, int argc, char **argv);

/* The commands, in the order of the overview. */
typedef struct cli_command_row {
    const char *name;         /* NULL: after the last */
    cli_command *run;         /* NULL: `help' */
    const cli_syntax *syntax; /* NULL: the program has its own */
    const char *meaning;
} cli_command_row;
extern const cli_command_row *cli_commands; /* set by main */

/* ---- the command line ---------------------------------------------------------------------------------------- */

/* Reads the command line. Prints the reason and exits if it is wrong; prints and exits for --help. */
void cli_parse(const cli_syntax *syntax, int argc, char **argv, void *arguments);
/* Option k of a command's own and the common ones, headings included; NULL after the last. For completion. */
const cli_option *cli_option_at(const cli_syntax *syntax, int k);
/* Whether the command line has this option. */
bool cli_given(const cli_syntax *syntax, const cli_common *common, const char *name);
/* SP_EINVAL if this option is given and not used: it would do nothing without `other`, for the message. */
sp_status cli_need(const cli_syntax *syntax, const cli_common *common, const char *name, bool used, const char *other,
                   sp_error *err);

extern const char *const cli_source_names[]; /* by sp_source */
extern const char *const cli_solver_names[]; /* by sp_modes_solver */
#define CLI_SOLVERS "auto|lanczos|arpack|dense"
/* "a, b or c" */
char *cli_list_words(const char *const *words, char *text, size_t size);
/* The index of a word in a list that NULL ends. SP_EINVAL lists the words. */
sp_status cli_choose(const char *option, const char *word, const char *const *words, int *out, sp_error *err);
/* The index of the name that a misspelt word most likely means; -1 if none is similar. name(k) is NULL after the last.
 */
int cli_nearest(const char *word, const char *(*name)(int k, const void *user), const void *user);
/* A finite decimal number between low and high, and nothing else. The option's name is for the message. */
sp_status cli_number(const char *option, const char *text, double low, double high, double *out, sp_error *err);
sp_status cli_integer(const char *option, const char *text, int64_t low, int64_t high, int64_t *out, sp_error *err);
/* Up to `capacity' numbers with commas between them; where high is infinite, one may be inf. */
sp_status cli_numbers(const char *option, const char *text, double low, double high, int32_t capacity, int32_t *n,
                      double *out, sp_error *err);
/* LOW:HIGH with LOW below HIGH. */
sp_status cli_pair(const char *option, const char *text, double low, double high, double out[2], sp_error *err);
/* Frequencies W, or W1,W2,..., or LOW:HIGH:N of --at; omega has `capacity` elements. */
sp_status cli_frequencies(const char *text, int32_t capacity, int32_t *n, double *omega, sp_error *err);
/* A scene from --set and from options of the scene, for commands that read packings. `groups` names the groups of keys
 * that --set takes, as in "network signal". Free with sp_scene_free. */
sp_status cli_scene_of_sets(cli_common *common, const char *groups, sp_scene *out, sp_error *err);
/* Gives the scene the options that are values of it. */
sp_status cli_set_scene(cli_common *common, sp_scene *scene, sp_error *err);

/* ---- units (material.c) ------------------------------------------------------------------------------------------ */

enum { CLI_UNITS_OWN = 0, CLI_UNITS_SI };
/* Reads --material: E=...,nu=...,rho=...,d=..., whose values may have units. */
sp_status cli_set_material(void *arguments, const char *text, sp_error *err);
/* Keeps an option whose text is a number with a unit until the material is known. False for any other text. */
bool cli_keep_quantity(cli_common *common, const cli_option *option, void *field, const char *text);
/* Gives the kept options their values. SP_EINVAL names the option. */
sp_status cli_set_quantities(void *arguments, const sp_material *m, sp_error *err);
/* The material of a file or of the scene, which may be unknown (young = 0); --material is stronger. Sets the options
 * that wait for it. SP_EINVAL if one of them, or --units si, needs a material and there is none, or not the same one in
 * all files. `arguments` begin with a cli_common. */
sp_status cli_take_material(void *arguments, const sp_material *m, const char *from, sp_error *err);
/* The same of a table's comment "material = ...". */
sp_status cli_take_table_material(void *arguments, const sp_table *t, const char *from, sp_error *err);
/* What counts: --material, else the one that was found; NULL if it is not known. */
const sp_material *cli_material(const cli_common *common);
/* Converts a table with --units si; otherwise it only gets the comment "material = ...", if the material is known and
 * the table has units that it explains. */
sp_status cli_convert_table(const cli_common *common, sp_table *t, sp_error *err);
/* sp_scene_read with the overrides of --set, and with the material of --material. */
sp_status cli_read_scene(const cli_common *common, const char *path, sp_scene *out, sp_error *err);
/* Notes on stderr what is odd about a scene's material. */
void cli_note_material(const cli_common *common, const sp_scene *scene);

/* ---- messages on stderr ------------------------------------------------------------------------------------------ */

/* Prints "sonopack: reason". Returns CLI_USAGE for SP_EINVAL, else CLI_FAILED. */
int cli_fail(const sp_error *err);
/* Prints "sonopack: ...". Returns CLI_USAGE. */
int cli_usage(const char *format, ...) __attribute__((format(printf, 1, 2)));
/* A message, unless --quiet is given; cli_debug: only if --verbose is given. */
#define cli_note(common, ...)  ((common)->quiet ? (void)0 : (void)cli_usage(__VA_ARGS__))
#define cli_debug(common, ...) ((common)->verbose && !(common)->quiet ? (void)cli_usage(__VA_ARGS__) : (void)0)
/* Progress: one line, rewritten in place, on a terminal; elsewhere one line per minute with --verbose. The remaining
 * time is between low and high. Unknown values: fraction < 0, times NAN. */
void cli_progress_between(const cli_common *common, const char *text, double fraction, double low, double high);
#define cli_progress(common, text, fraction, seconds_left)                                                             \
    cli_progress_between(common, text, fraction, seconds_left, seconds_left)
/* Clears the progress line. */
void cli_progress_end(void);
/* From here to cli_watch_end a line tells the time and the memory so far while no message and no progress is told: on a
 * terminal after two seconds, with --verbose after half a minute and every minute. */
void cli_watch(const cli_common *common, const char *command);
void cli_watch_end(void); /* before data are printed, which a pager may show on the same terminal */

/* ---- signals (stop.c) -------------------------------------------------------------------------------------------- */

/* From here on SIGINT, SIGTERM, SIGHUP, SIGXCPU and SIGPIPE end the process as they do by default, but leave no
 * temporary file. SIGXFSZ is ignored: what cannot be written is an error. */
void cli_signals_begin(void);
/* From here on the first of these (without SIGPIPE) makes cli_stopped() true and is acknowledged on stderr; a second
 * one ends the process as by default. A second of work after the first ends it with CLI_FAILED, if it does not by
 * itself. */
void cli_catch_signals(const cli_common *common);
bool cli_stopped(void);
/* Call when the stop has been seen, or may take long: only a second signal ends the process from here on. */
void cli_stop_patiently(void);

/* ---- output ------------------------------------------------------------------------------------------------------ */

/* Whether a file may be written. An existing file is replaced only with --force, and never by a file of another kind.
 * Call before the computation. */
sp_status cli_may_write(const cli_common *common, const char *path, sp_error *err);
/* The same for the packing of an option, .h5 or .txt; and writes it. */
sp_status cli_may_write_packing(const cli_common *common, const char *option, const char *path, sp_error *err);
sp_status cli_save_packing(const sp_packing *p, const char *path, sp_error *err);
/* The same for a file of modes, or a table. */
sp_status cli_may_write_modes(const cli_common *common, const char *path, sp_error *err);
/* The same for the table in common->output, which may be NULL. */
sp_status cli_may_write_table(const cli_common *common, sp_error *err);
/* Prints the table, or writes it to common->output in the format of that ending. Adds a comment with the version. */
sp_status cli_write_table(const cli_common *common, sp_table *t, sp_error *err);
/* The same with another file, or NULL to print. */
sp_status cli_write_table_to(const cli_common *common, const char *path, sp_table *t, sp_error *err);

/* MAT-files, and tables of signals as SAC and SLIST, which the Python package writes: by the ending; whether it is
 * here; and from the text of a table, TSV. */
bool cli_is_foreign_table(const char *path);
sp_status cli_may_save_foreign(sp_error *err);
sp_status cli_save_foreign(const cli_common *common, const char *text, sp_error *err);
/* Whether a file name has this ending, as in ".h5". Upper case and lower case are the same. */
bool cli_has_ending(const char *path, const char *ending);
bool cli_is_hdf5(const char *path); /* .h5 or .hdf5 */
/* Reads the packing that packing.file names, and sets what the scene takes from it. */
sp_status cli_load_start(sp_scene *scene, sp_packing *from, sp_error *err);
/* Prints text on stdout. */
sp_status cli_print(const char *text, sp_error *err);
/* Closes stdout, for atexit: after a write error it prints the reason and exits with CLI_FAILED. */
void cli_close_stdout(void);

/* Adds columns, comments and rows to a table. After a failure the calls do nothing, so that a caller may make several
 * and check `status` once. */
enum { CLI_CELLS_MAX = 64 };
typedef struct cli_writer {
    sp_table *table;
    sp_error *err;
    sp_status status;     /* SP_OK at the start */
    const sp_packing *of; /* the packing of the rows, whose place in a series each row of a table of files ends with; or
                             NULL */
    int cells;            /* of the row that is being made */
    sp_entry cell[CLI_CELLS_MAX];
} cli_writer;

/* Calls, and keeps the status, unless something has failed before. */
#define CLI_THEN(status, call) ((void)((status) == SP_OK && ((status) = (call))))

/* Columns of one kind: pairs of name and unit, ended by NULL. */
void cli_columns(cli_writer *w, sp_column_kind kind, ...) __attribute__((sentinel));
void cli_place_columns(cli_writer *w, int dim); /* x, y and z, as many as there are */
void cli_comment(cli_writer *w, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* The comment "key = value", with all digits of the value. */
void cli_value(cli_writer *w, const char *key, double value);
/* Columns of the quantities of a result, whose symbols stand between blanks. */
void cli_quantity_columns(cli_writer *w, const sp_quantity *all, const char *symbols);
/* The next cells of a row: numbers, as the kinds of their columns have them; a text, which lives until cli_end_row;
 * those of the quantities of a result. */
void cli_put_numbers(cli_writer *w, int n, const double *number);
#define cli_put(w, ...)                                                                                                \
    cli_put_numbers(w, (int)(sizeof((double[]){__VA_ARGS__}) / sizeof(double)), (double[]){__VA_ARGS__})
void cli_put_text(cli_writer *w, const char *text);
void cli_put_quantities(cli_writer *w, const sp_quantity *all, const char *symbols, const void *of);
void cli_end_row(cli_writer *w);
/* Whether the table has no column for the frame of a packing of a series, or for a strain of it. */
bool cli_lacks_series(const sp_table *t, const sp_packing *p);
/* A whole row, as sp_table_add_row takes it. Returns the status. */
sp_status cli_row(cli_writer *w, ...);

#endif
