/* Commands of the Python package: `sonopack plot ...' executes `sonopack-plot ...'. */
#include "cli/cli.h"

#include "base/base.h"
#include "base/file.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* Where the programs are, seen from the command: beside it in the folder of a build, SONOPACK_LIBEXEC when installed.
 */
static const char *const places[] = {"", SONOPACK_LIBEXEC "/"};

/* The folder of the running command, with its last slash. */
static bool own_folder(char *path, size_t size) {
    const ssize_t length = readlink("/proc/self/exe", path, size - 1);
    if (length <= 0)
        return false;
    path[length] = '\0';
    strrchr(path, '/')[1] = '\0';
    return true;
}

/* argv[0] is "sonopack NAME"; it and the arguments go on as they are. */
int cmd_dispatch(int argc, char **argv) {
    const char *name = strchr(argv[0], ' ') + 1;
    char folder[SP_PATH_MAX], path[SP_PATH_MAX + 100];
    sp_error err = {0};
    (void)argc;
    for (size_t k = 0; k < sizeof places / sizeof *places && own_folder(folder, sizeof folder); k++) {
        snprintf(path, sizeof path, "%s%ssonopack-%s", folder, places[k], name);
        execv(path, argv);
        if (errno != ENOENT) {
            sp_fail(&err, SP_EFAILED, "%s: %s", path, strerror(errno));
            return cli_fail(&err);
        }
    }
    sp_fail(
        &err, SP_EFAILED,
        "%s belongs to the Python package of sonopack, which is not here: sonopack-%s is neither beside the command "
        "nor in " SONOPACK_LIBEXEC " (build with -DSONOPACK_PYTHON=ON)",
        name, name);
    return cli_fail(&err);
}
