/* Programs of the Python package: `sonopack plot ...' executes `sonopack-plot ...', and tables for other programs are
 * written by `sonopack-save-table'. */
#include "base/base.h"
#include "base/file.h"
#include "cli/cli.h"

#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

/* Where the programs are, seen from the command: beside it in the folder of a build, SONOPACK_LIBEXEC when installed.
 */
static const char *const places[] = {"", SONOPACK_LIBEXEC "/"};
enum { PROGRAM_MAX = SP_PATH_MAX + 100 };

/* The program sonopack-NAME of the package. */
static sp_status find_program(const char *name, char path[PROGRAM_MAX], sp_error *err) {
    char folder[SP_PATH_MAX];
    const ssize_t length = readlink("/proc/self/exe", folder, sizeof folder - 1);
    folder[length > 0 ? length : 0] = '\0';
    for (size_t k = 0; k < sizeof places / sizeof *places && length > 0; k++) {
        strrchr(folder, '/')[1] = '\0';
        snprintf(path, PROGRAM_MAX, "%s%ssonopack-%s", folder, places[k], name);
        if (access(path, F_OK) == 0)
            return SP_OK;
    }
    return sp_fail(
        err, SP_EFAILED,
        "%s belongs to the Python package of sonopack, which is not here: sonopack-%s is neither beside the command "
        "nor in " SONOPACK_LIBEXEC " (build with -DSONOPACK_PYTHON=ON)",
        name, name);
}

/* Becomes the program, or says why not. Ctrl-C waits until the program lets it through: while Python begins, it would
 * end in a traceback. */
static void become(const char *path, char **argv, sp_error *err) {
    sigset_t interrupt, before;
    sigemptyset(&interrupt);
    sigaddset(&interrupt, SIGINT);
    sigprocmask(SIG_BLOCK, &interrupt, &before);
    execv(path, argv);
    const int reason = errno;
    sigprocmask(SIG_SETMASK, &before, NULL);
    sp_fail(err, SP_EFAILED, "%s: %s", path,
            reason == ENOENT ? "the interpreter that its first line names is not here: install python3"
                             : strerror(reason));
}

/* argv[0] is "sonopack NAME"; it and the arguments go on as they are. */
int cmd_dispatch(int argc, char **argv) {
    char path[PROGRAM_MAX];
    sp_error err = {0};
    (void)argc;
    if (find_program(strchr(argv[0], ' ') + 1, path, &err) == SP_OK)
        become(path, argv, &err);
    return cli_fail(&err);
}

int cmd_engine(const char *name, int argc, char **argv) {
    setenv("OMP_NUM_THREADS", "1", 0);
    setenv("OPENBLAS_NUM_THREADS", "1", 0);
    argv[0] = (char *)name;
    return cmd_dispatch(argc, argv);
}

sp_status cli_may_save_foreign(sp_error *err) {
    char path[PROGRAM_MAX];
    return find_program("save-table", path, err);
}

/* The reason that the program has told, a line "sonopack: REASON". */
static sp_status told(FILE *messages, int status, sp_error *err) {
    char line[SP_ERROR_TEXT] = "sonopack-save-table was ended";
    rewind(messages);
    while (fgets(line, sizeof line, messages) && strncmp(line, "sonopack: ", 10) != 0)
        ;
    line[strcspn(line, "\n")] = '\0';
    return sp_fail(err, WIFEXITED(status) && WEXITSTATUS(status) == CLI_USAGE ? SP_EINVAL : SP_EFAILED, "%s",
                   strncmp(line, "sonopack: ", 10) == 0 ? line + 10 : line);
}

/* Files and not pipes: neither side waits for the other, nor is ended by it. */
sp_status cli_save_foreign(const cli_common *common, const char *text, sp_error *err) {
    char path[PROGRAM_MAX],
        *argv[] = {"sonopack save-table", "-o", (char *)common->output, common->force ? "--force" : NULL, NULL};
    FILE *table = tmpfile(), *messages = tmpfile();
    int result = 0;
    sp_status status = find_program("save-table", path, err);
    if (status == SP_OK && (!table || !messages || fputs(text, table) < 0 || fflush(table) != 0))
        status = sp_fail(err, SP_EIO, "a temporary file: %s", strerror(errno));
    const pid_t child = status == SP_OK ? fork() : -1;
    if (child == 0) {
        if (lseek(fileno(table), 0, SEEK_SET) == 0 && dup2(fileno(table), STDIN_FILENO) >= 0 &&
            dup2(fileno(messages), STDERR_FILENO) >= 0) {
            become(path, argv, err);
            dprintf(STDERR_FILENO, "sonopack: %s\n", err->text);
        }
        _exit(CLI_FAILED);
    }
    if (status == SP_OK && (child < 0 || waitpid(child, &result, 0) != child))
        status = sp_fail(err, SP_EFAILED, "%s: %s", path, strerror(errno));
    if (status == SP_OK && result != 0)
        status = told(messages, result, err);
    if (table)
        fclose(table);
    if (messages)
        fclose(messages);
    return status;
}
