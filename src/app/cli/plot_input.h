#ifndef SP_CLI_PLOT_INPUT_H
#define SP_CLI_PLOT_INPUT_H
/* What figures are made of, from files. */

#include <sonopack/figure/figure.h>
#include <sonopack/figure/plot.h>
#include <sonopack/study/scene.h>
#include <sonopack/study/study.h>

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
    double distance; /* of the detector from the bottom wall; NAN: not known */
    char name[64];   /* "y = 25", the detector, or "F2": of a table of several, else "" */
} plot_signal;

/* The detector of a signal's column by the table's metadata, "F2 = from bottom:normal to plane:25:normal, ...". */
typedef struct plot_detector {
    char word[100]; /* "plane:25:normal" */
    double plane;   /* its height [d]; NAN if it is not a plane */
} plot_detector;
/* False if the metadata does not name the detector. */
bool plot_find_detector(const sp_table *t, const char *column, plot_detector *out);

/* Columns F1, F2, ... from column `first` on; 1 where that has another name. */
int plot_count_signals(const sp_table *t, int first);

typedef struct plot_signals {
    int n;
    plot_signal *signal;
} plot_signals;

/* Signals: the columns t and F of a table, t and F1, F2, ..., or its first two of numbers; or that of a packing file,
 * made with the scene's network and signal options. */
sp_status plot_read_signals(const char *path, const sp_scene *scene, plot_signals *out, sp_error *err);
void plot_signals_free(plot_signals *s);

#endif
