#ifndef SP_CLI_CHILD_H
#define SP_CLI_CHILD_H
/* Runs another program, without a shell, and waits for it. */

#include <sonopack/status.h>
#include <stdbool.h>

/* The absolute path of a program: `name' itself if it has a slash, else the first in PATH. out has SP_PATH_MAX bytes.
 * SP_EIO if there is none that can be run. */
sp_status sp_child_find(const char *name, char *out, sp_error *err);

/* How a program has ended. */
typedef struct sp_child_end {
    int status;     /* exit status; -1: it was ended by a signal */
    int signal;     /* 0: none */
    double seconds; /* CPU time, its own children included */
    bool stopped;   /* because watch() said so */
} sp_child_end;

/* Runs words[0], a path, with the other words, up to NULL, as arguments, in a folder. What it prints goes to a file
 * there, and it reads nothing. Calls watch(user) several times a second; once that returns false the program is asked
 * to end, and killed if it does not. It also ends if this process does. SP_EIO if it cannot be started. */
sp_status sp_child_run(const char *const *words, const char *folder, const char *printed, bool (*watch)(void *user),
                       void *user, sp_child_end *end, sp_error *err);

#endif
