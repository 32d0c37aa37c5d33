#ifndef SP_CLI_PLOT_INPUT_H
#define SP_CLI_PLOT_INPUT_H
/* What figures are made of, from files. */

#include <sonopack/sonopack.h>

/* A table of numbers, TSV or (by its ending .csv) CSV. */
sp_status plot_read_table(const char *path, sp_table *out, sp_error *err);

/* Whether a file is a packing rather than a table: binary, or text with a packing's header. A pipe, which cannot be
 * looked into without using it up, is taken for a table. */
sp_status plot_is_packing(const char *path, bool *yes, sp_error *err);

typedef struct plot_signal {
    int64_t n;
    double *t, *f; /* one block, t its start */
    double window; /* times in which the first front is looked for; 0: all */
    bool foreign;  /* a table whose times are not in d/sqrt(E* / rho) */
    char t_unit[sizeof((sp_column *)0)->unit], f_unit[sizeof((sp_column *)0)->unit]; /* of a foreign one, "" unknown */
} plot_signal;

/* A signal: the columns t and F of a table (or its first two of numbers), or that of a packing file, made with the
 * scene's network and signal options. Free t with sp_free. */
sp_status plot_read_signal(const char *path, const sp_scene *scene, plot_signal *out, sp_error *err);

#endif
