#ifndef SP_CLI_BENCH_H
#define SP_CLI_BENCH_H
/* The cases of `sonopack bench'. */
#include "cli/cli.h"

enum { BENCH_SAMPLES = 5 };

int bench_ascending(const void *a, const void *b); /* doubles, for qsort */
/* Median of n values, which are sorted. */
double bench_median(int n, double *value);

/* The network of a case. */
typedef struct bench_subject {
    const cli_common *common;
    const char *name; /* of the network */
    const sp_network *net;
    double until;   /* last time of the signals */
    double seconds; /* CPU time that is spent on a row; the first run may take longer */
    sp_table *table;
} bench_subject;

/* One row. run() is timed, and sets the relative error of its result. */
typedef struct bench_row {
    const char *name, *method;
    double parameter;
    sp_status (*run)(const void *job, double *error, sp_error *err);
    const void *job;
} bench_row;
/* Adds a row with the median time of 15 or more runs (fewer where these take too long), and the memory that the first
 * one needs. A method that refuses gets a message instead of a row. */
sp_status bench_measure(const bench_subject *s, const bench_row *row, sp_error *err);

/* Short signals with all methods and parameters; long ones, up to 10^6 over Omega; many sources and detectors. */
sp_status bench_signal(const bench_subject *s, sp_error *err);
sp_status bench_long(const bench_subject *s, sp_error *err);
sp_status bench_many(const bench_subject *s, sp_error *err);
sp_status bench_damped(const bench_subject *s, sp_error *err);
sp_status bench_modes(const bench_subject *s, sp_error *err);
sp_status bench_moduli(const bench_subject *s, sp_error *err);

/* Rows for packings of the scene at 1e-4 .. 1e-7: median CPU time over BENCH_SAMPLES seeds; the error is the largest
 * elastic acceleration at the end, over p. */
sp_status bench_pack(const cli_common *common, const sp_scene *scene, sp_table *t, sp_error *err);

/* Adds a comment: how much slower `auto' was than the fastest row of its case that is exact enough. */
sp_status bench_compare_auto(sp_table *t, sp_error *err);

#endif
