#ifndef SP_CLI_PLOT_INPUT_H
#define SP_CLI_PLOT_INPUT_H
/* Reads the tables and signals that figures show. */

#include <sonopack/figure/figure.h>
#include <sonopack/figure/plot.h>
#include <sonopack/study/scene.h>
#include <sonopack/study/study.h>

/* Reads a table of numbers: CSV if the file ends in .csv, else TSV. */
sp_status plot_read_table(const char *path, sp_table *out, sp_error *err);

typedef struct plot_signal {
    int64_t n;
    double *t, *f;           /* one block, t its start */
    double window;           /* the first front is searched for up to this time; 0: everywhere */
    bool foreign;            /* the times are not in d/sqrt(E* / rho) */
    const char *length_unit; /* of height and distance; "": unknown */
    char t_unit[sizeof((sp_column *)0)->unit], f_unit[sizeof((sp_column *)0)->unit]; /* "": unknown */
    double height;                                                                   /* of the packing; NAN: unknown */
    double distance; /* from the bottom wall, or the plane of the source, to the detector; NAN: unknown */
    char name[64];   /* of one signal of several: "y = 25", the detector, or "F2"; else "" */
    char place[64];  /* the same for a plane as markup with its unit; else "" */
} plot_signal;

typedef struct plot_signals {
    int n;
    plot_signal *signal;
} plot_signals;

/* Reads the columns t and F of a table, or t and F1, F2, ..., or the first two columns of numbers. The signal of a
 * packing is computed, with the options of the scene. */
sp_status plot_read_signals(const char *path, const sp_scene *scene, plot_signals *out, sp_error *err);
void plot_signals_free(plot_signals *s);

#endif
