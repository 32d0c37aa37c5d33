/* The table of commands. */
#include "cli/output.h"

#include "base/base.h"
#include "base/file.h"
#include "scene/field.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

extern void openblas_set_num_threads(int threads) __attribute__((weak));

__attribute__((visibility("default"))) const char *argp_program_version = "sonopack " SONOPACK_VERSION;

static int help(int argc, char **argv);

static const struct command {
    const char *name;
    cli_command run;
    const char *meaning;
} commands[] = {
    {"pack", cmd_pack, "makes one packing of a scene"},
    {"check", cmd_check, "audits packings: overlaps, balance of forces, Coulomb, walls"},
    {"statics", cmd_statics, "densities, contacts, forces and stress of packings"},
    {"moduli", cmd_moduli, "elastic moduli and the speeds of long waves"},
    {"modes", cmd_modes, "eigenfrequencies, and what each mode adds to the signal"},
    {"spectrum", cmd_spectrum, "density of states, transmission, waves and harmonic driving"},
    {"signal", cmd_signal, "force on the top wall after a short pulse at the bottom wall"},
    {"front", cmd_front, "arrival, peak and width of the first wave front"},
    {"study", cmd_study, "an ensemble of packings and what is wanted of them; resumes by itself"},
    {"table", cmd_table, "tables of a finished or running study"},
    {"wave", cmd_wave, "phase speed and attenuation of the coherent wave inside packings"},
    {"chain", cmd_chain, "the chain of equal balls in closed form, of any length"},
    {"column", cmd_column, "the tapped column of particles, as lattice and as continuum"},
    {"reproduce", cmd_reproduce, "a paper's tables and figures beside our own values"},
    {"plot", cmd_plot, "figures"},
    {"convert", cmd_convert, "import and export of packings"},
    {"bench", cmd_bench, "run time against error of the methods"},
    {"help", help, "this text, or that of a command, or of `scene': the keys of scene files"},
};
enum { COMMANDS = sizeof commands / sizeof *commands };

static const struct command *find(const char *name) {
    for (int k = 0; k < COMMANDS; k++)
        if (strcmp(commands[k].name, name) == 0)
            return &commands[k];
    return NULL;
}

static int unknown(const char *name) {
    const char *near = NULL;
    for (int k = 0, least = 1000; k < COMMANDS; k++) {
        const int distance = sp_edit_distance(name, commands[k].name);
        if (distance < least && sp_is_near(name, distance)) {
            least = distance;
            near = commands[k].name;
        }
    }
    if (near)
        return cli_usage("unknown command %.60s: did you mean %s?", name, near);
    return cli_usage("unknown command %.60s: must be one that `sonopack help' lists", name);
}

static void overview(FILE *out) {
    fputs("Usage: sonopack COMMAND [OPTIONS] [FILES]\n\n"
          "Sound in compressed granular packings: makes packings, finds the force on the top wall after a short pulse "
          "at\nthe bottom wall, and what that says about the speed of sound.\n\nCommands:\n",
          out);
    for (int k = 0; k < COMMANDS; k++)
        fprintf(out, "  %-9s %s\n", commands[k].name, commands[k].meaning);
    fputs("\n`sonopack help COMMAND' explains a command, `sonopack help scene' the scene files; `sonopack --version'.\n"
          "Data go to stdout, log and progress to stderr. Exit status: 0 done, 1 the work failed, 2 wrong usage or "
          "scene.\n",
          out);
}

static int run(const struct command *command, int argc, char **argv) {
    char name[64]; /* as messages of argp shall begin */
    snprintf(name, sizeof name, "sonopack %s", command->name);
    argv[0] = name;
    return command->run(argc, argv);
}

static int help(int argc, char **argv) {
    if (argc == 1 || argv[1][0] == '-') {
        overview(stdout);
        return CLI_OK;
    }
    if (argc > 2)
        return cli_usage("help %.60s %.60s: must be one command", argv[1], argv[2]);
    if (strcmp(argv[1], "scene") == 0) {
        sp_error err = {0};
        char *text = sp_scene_help();
        sp_status status = text ? cli_print(text, &err) : sp_fail_memory(&err, 1 << 14);
        sp_free(text);
        return status == SP_OK ? CLI_OK : cli_fail(&err);
    }
    const struct command *command = find(argv[1]);
    if (!command)
        return unknown(argv[1]);
    if (command->run == help) {
        overview(stdout);
        return CLI_OK;
    }
    char option[] = "--help", *arguments[] = {NULL, option, NULL};
    return run(command, 2, arguments);
}

/* Files 0, 1 and 2 must be open, or a result file would take their place and get what is printed. */
static void keep_standard_files(void) {
    for (int file = 0; file <= 2; file++)
        if (fcntl(file, F_GETFD) == -1 && open("/dev/null", file == 0 ? O_WRONLY : O_RDONLY) != file)
            _Exit(CLI_FAILED);
}

/* Where the address space is limited, OpenBLAS cannot start its threads, and at the end of a process would wait for
 * them for ever. All files are closed by then. */
static void leave(int status, void *nothing) {
    struct rlimit space;
    (void)nothing;
    if (getrlimit(RLIMIT_AS, &space) == 0 && space.rlim_cur != RLIM_INFINITY)
        _exit(status);
}

/* OpenBLAS on one thread: its sums then do not depend on the number of cores, and samples that are computed side by
 * side do not take each other's cores. It reads the variable when it is loaded; where it is loaded already, the call
 * counts. */
static void use_one_blas_thread(void) {
    setenv("OPENBLAS_NUM_THREADS", "1", 1);
    if (openblas_set_num_threads)
        openblas_set_num_threads(1);
}

int main(int argc, char **argv) {
    keep_standard_files();
    if (!SONOPACK_LATE) /* else it is loaded so */
        sp_hdf5_exit_silently();
    use_one_blas_thread();
    if (on_exit(leave, NULL) != 0 || atexit(cli_close_stdout) != 0) /* the last one first */
        return CLI_FAILED;
    argp_err_exit_status = CLI_USAGE;
    if (argc < 2) {
        overview(stderr);
        return CLI_USAGE;
    }
    const char *word = argv[1];
    if (strcmp(word, "--version") == 0 || strcmp(word, "-V") == 0) {
        printf("%s\n", argp_program_version);
        return CLI_OK;
    }
    if (strcmp(word, "--help") == 0 || strcmp(word, "-?") == 0 || strcmp(word, "-h") == 0) {
        overview(stdout);
        return CLI_OK;
    }
    if (word[0] == '-')
        return cli_usage("option %.60s: the command must come first, as in `sonopack pack --quiet'", word);
    const struct command *command = find(word);
    return command ? run(command, argc - 1, argv + 1) : unknown(word);
}
