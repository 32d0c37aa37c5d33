/* The command sonopack: finds the subcommand and runs it. */
#include "base/base.h"
#include "base/file.h"
#include "cli/cli.h"

#include <argp.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

extern void openblas_set_num_threads(int threads) __attribute__((weak)); /* other BLAS do not have them */
extern int blas_thread_shutdown_(void) __attribute__((weak));

static int help(int argc, char **argv);

static const cli_command_row commands[] = {
    {"pack", cmd_pack, &cmd_pack_syntax, "compress one packing of a scene"},
    {"check", cmd_check, &cmd_check_syntax, "check packings: overlaps, balance of forces, Coulomb's condition, walls"},
    {"statics", cmd_statics, &cmd_statics_syntax, "densities, contacts, forces and stress of packings"},
    {"moduli", cmd_moduli, &cmd_moduli_syntax, "elastic moduli and speeds of long waves"},
    {"respond", cmd_respond, &cmd_respond_syntax,
     "displacements and forces of a static load: a force, a strain, a grain"},
    {"clusters", cmd_clusters, &cmd_clusters_syntax, "rigid clusters of the contacts, redundant ones, floppy motions"},
    {"modes", cmd_modes, &cmd_modes_syntax, "eigenfrequencies, and the weight of each mode in the signal"},
    {"spectrum", cmd_spectrum, &cmd_spectrum_syntax, "density of states, transmission, dispersion, harmonic driving"},
    {"signal", cmd_signal, &cmd_signal_syntax, "force on the top wall after a short pulse at the bottom wall"},
    {"front", cmd_front, &cmd_front_syntax, "arrival, peak and width of the first wave front"},
    {"wave", cmd_wave, &cmd_wave_syntax, "phase speed and attenuation of the coherent wave inside packings"},
    {"transport", cmd_transport, &cmd_transport_syntax,
     "diffusivity of sound's energy and mean free paths of its waves"},
    {"amplitude", cmd_amplitude, &cmd_amplitude_syntax, "speed and shape of the front as the pulse grows loud"},
    {"chain", cmd_chain, &cmd_chain_syntax, "chain of equal balls in closed form, of any length"},
    {"sensitivity", cmd_sensitivity, &cmd_sensitivity_syntax,
     "what each contact and grain does to the arrival, frequencies, moduli"},
    {"uncertainty", cmd_uncertainty, &cmd_uncertainty_syntax,
     "errors of the sound of a measured packing, from those of its grains"},
    {"coda", cmd_coda, &cmd_coda_syntax, "where a packing has changed, from the change of late signals"},
    {"design", cmd_design, &cmd_design_syntax, "which grains to change so that a front is late, or a band is left out"},
    {"study", cmd_study, &cmd_study_syntax, "compute an ensemble of packings and their results; can be interrupted"},
    {"table", cmd_table, &cmd_table_syntax, "tables of a finished or running study"},
    {"demo", cmd_dispatch, NULL, "make a packing, a signal and a page in some seconds, and show the commands"},
    {"reproduce", cmd_dispatch, NULL, "compare the results of a paper with our own"},
    {"column", cmd_column, &cmd_column_syntax, "tapped column of particles, discrete and as a continuum"},
    {"trace", cmd_dispatch, NULL, "arrivals, speeds and spectra of measured traces, with errors from their noise"},
    {"plot", cmd_dispatch, NULL, "draw figures"},
    {"view", cmd_dispatch, NULL, "write a page that shows packings, modes and waves in a browser"},
    {"convert", cmd_dispatch, NULL, "import and export packings"},
    {"bench", cmd_dispatch, NULL, "measure each method's run time against its error"},
    {"completion", cmd_completion, &cmd_completion_syntax, "print the completions for a shell: bash, zsh or fish"},
    {"help", NULL, NULL, "explain a command, a key of scenes (`friction'), or all of them (`scene')"},
    {NULL, NULL, NULL, NULL}};
enum { COMMANDS = sizeof commands / sizeof *commands - 1 };

static const cli_command_row *find(const char *name) {
    for (int k = 0; k < COMMANDS; k++)
        if (strcmp(commands[k].name, name) == 0)
            return &commands[k];
    return NULL;
}

static const char *command_name(int k, const void *unused) {
    (void)unused;
    return k < COMMANDS ? commands[k].name : NULL;
}

static int unknown(const char *name) {
    const int near = cli_nearest(name, command_name, NULL);
    if (near >= 0)
        return cli_usage("unknown command %.60s: did you mean %s?", name, commands[near].name);
    return cli_usage("unknown command %.60s: see `sonopack help'", name);
}

static void overview(FILE *out) {
    fputs(
        "Usage: sonopack COMMAND [OPTIONS] [FILES]\n\n"
        "Sound in compressed granular packings: compresses packings, computes the force on the top wall after a short\n"
        "pulse at the bottom wall, and derives the speed of sound from it.\n\nCommands:\n",
        out);
    for (int k = 0; k < COMMANDS; k++)
        fprintf(out, "  %-11s %s\n", commands[k].name, commands[k].meaning);
    fputs(
        "\n`sonopack help COMMAND' explains a command, `sonopack help scene' the scene files, `sonopack help KEY' one\n"
        "of their keys, or a group. `sonopack --version' prints the version. Data go to stdout, messages and progress\n"
        "to stderr.\n"
        "Exit status: 0 success, 1 the command failed, 2 wrong usage or scene.\n",
        out);
}

static int run(const cli_command_row *command, int argc, char **argv) {
    char name[64]; /* with which messages of argp begin */
    snprintf(name, sizeof name, "sonopack %s", command->name);
    argv[0] = name;
    return command->run ? command->run(argc, argv) : help(argc, argv);
}

static int print_help(char *text) {
    sp_error err = {0};
    sp_status status = text ? cli_print(text, &err) : sp_fail_memory(&err, 1 << 14);
    sp_free(text);
    return status == SP_OK ? CLI_OK : cli_fail(&err);
}

/* Commands, keys, and keys without their group, in one list. */
static const char *topic(int k, const void *unused) {
    if (k < COMMANDS)
        return command_name(k, unused);
    const char *key = sp_scene_key((k - COMMANDS) / 2);
    return key && k % 2 ? strchr(key, '.') + 1 : key;
}

/* Explains a key of scenes, where the word is no command. */
static int help_key(const char *word) {
    char *text = sp_scene_help_key(word);
    if (!text || text[0])
        return print_help(text);
    sp_free(text);
    const int near = cli_nearest(word, topic, NULL);
    if (near >= 0)
        return cli_usage("help %.60s: no command and no key of scenes: did you mean %s?", word, topic(near, NULL));
    return cli_usage("help %.60s: no command and no key of scenes: see `sonopack help' and `sonopack help scene'",
                     word);
}

static int help(int argc, char **argv) {
    if (argc == 1 || argv[1][0] == '-') {
        overview(stdout);
        return CLI_OK;
    }
    if (argc > 2)
        return cli_usage("help %.60s %.60s: one command only", argv[1], argv[2]);
    if (strcmp(argv[1], "scene") == 0)
        return print_help(sp_scene_help());
    const cli_command_row *command = find(argv[1]);
    if (!command)
        return help_key(argv[1]);
    if (!command->run) {
        overview(stdout);
        return CLI_OK;
    }
    char option[] = "--help", *arguments[] = {NULL, option, NULL};
    return run(command, 2, arguments);
}

/* If file 0, 1 or 2 were closed, a result file would get its number, and with it what is printed. */
static void keep_standard_files(void) {
    for (int file = 0; file <= 2; file++)
        if (fcntl(file, F_GETFD) == -1 && open("/dev/null", file == 0 ? O_WRONLY : O_RDONLY) != file)
            _Exit(CLI_FAILED);
}

/* If the address space is limited, OpenBLAS cannot start its threads, and would wait for ever for them to end. */
static bool may_lack_threads(void) {
    struct rlimit space;
    return getrlimit(RLIMIT_AS, &space) == 0 && space.rlim_cur != RLIM_INFINITY;
}

/* All files are closed by now. */
static void leave(int status, void *nothing) {
    (void)nothing;
    sp_drafts_abandon(); /* of other threads, if one has ended the process */
    if (may_lack_threads())
        _exit(status);
}

/* Without a message the process would end by SIGSEGV. Its threads get a stack of this size too. */
static bool has_stack(void) {
    const rlim_t least = 256 << 10;
    struct rlimit stack;
    if (getrlimit(RLIMIT_STACK, &stack) != 0 || stack.rlim_cur >= least)
        return true;
    fprintf(stderr, "sonopack: the stack is limited to %lu kB, must have %lu kB or more (see ulimit -s)\n",
            (unsigned long)stack.rlim_cur >> 10, (unsigned long)least >> 10);
    return false;
}

/* OpenBLAS on one thread: its sums then do not depend on the number of cores, and samples that are computed side by
 * side do not take each other's cores. Its other threads, which have begun with the process, spin for 30 ms: they end.
 */
static void use_one_blas_thread(void) {
    if (openblas_set_num_threads)
        openblas_set_num_threads(1);
    if (openblas_set_num_threads && blas_thread_shutdown_ && !may_lack_threads())
        blas_thread_shutdown_();
}

int main(int argc, char **argv) {
    cli_commands = commands;
    setenv("HDF5_PLUGIN_PRELOAD", "::", 1); /* no file may ask for a filter that is a library to be loaded */
    keep_standard_files();
    if (!has_stack())
        return CLI_FAILED;
    cli_signals_begin();
    sp_hdf5_exit_silently();
    use_one_blas_thread();
    if (on_exit(leave, NULL) != 0 || atexit(cli_close_stdout) != 0) { /* called in reverse order */
        fputs("sonopack: no memory\n", stderr);
        return CLI_FAILED;
    }
    argp_err_exit_status = CLI_USAGE;
    if (argc < 2) {
        overview(stderr);
        return CLI_USAGE;
    }
    const char *word = argv[1];
    if (strcmp(word, "--version") == 0 || strcmp(word, "-V") == 0) {
        printf("sonopack %s\n", SONOPACK_VERSION);
        return CLI_OK;
    }
    if (strcmp(word, "--help") == 0 || strcmp(word, "-?") == 0 || strcmp(word, "-h") == 0) {
        overview(stdout);
        return CLI_OK;
    }
    if (word[0] == '-')
        return cli_usage("option %.60s: the command comes first, as in `sonopack pack --quiet'", word);
    const cli_command_row *command = find(word);
    return command ? run(command, argc - 1, argv + 1) : unknown(word);
}
