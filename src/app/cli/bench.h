#ifndef SP_CLI_BENCH_H
#define SP_CLI_BENCH_H
/* Parts of `sonopack bench`. */
#include "cli/cli.h"

enum { BENCH_SAMPLES = 5 };

int bench_ascending(const void *a, const void *b); /* doubles, for qsort */
/* Middle of n values; sorts them. */
double bench_median(int n, double *value);

/* Cases on one network. */
typedef struct bench_subject {
    const cli_common *common;
    const char *name; /* of the network, behind that of the case */
    const sp_network *net;
    double until; /* last time of the signals */
    sp_table *table;
} bench_subject;

/* One row: its names, and what is timed. run() returns the relative error of its result. */
typedef struct bench_row {
    const char *name, *method;
    double parameter;
    sp_status (*run)(const void *job, double *error, sp_error *err);
    const void *job;
} bench_row;
/* Adds the row: the median of 15 runs and more (short ones), one alone if it takes a second; memory in a process of its
 * own. What refuses has no row, and is told. */
sp_status bench_measure(const bench_subject *s, const bench_row *row, sp_error *err);

/* Signals: short ones by every method and parameter; up to a million over Omega; from many sources to many detectors.
 */
sp_status bench_signal(const bench_subject *s, sp_error *err);
sp_status bench_long(const bench_subject *s, sp_error *err);
sp_status bench_many(const bench_subject *s, sp_error *err);
sp_status bench_damped(const bench_subject *s, sp_error *err);
sp_status bench_modes(const bench_subject *s, sp_error *err);
sp_status bench_moduli(const bench_subject *s, sp_error *err);

/* Rows for packings of the scene at 1e-4 .. 1e-7: the median CPU time of BENCH_SAMPLES seeds; error: the largest
 * elastic acceleration at the end over p. */
sp_status bench_pack(const cli_common *common, const sp_scene *scene, sp_table *t, sp_error *err);

/* A comment: by how much `auto` was slower than the fastest row of the same case that is as exact as asked for. */
sp_status bench_judge_auto(sp_table *t, sp_error *err);

#endif
