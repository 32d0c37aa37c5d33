#ifndef SP_CLI_BENCH_H
#define SP_CLI_BENCH_H
/* Parts of `sonopack bench`. */
#include "cli/cli.h"

enum { BENCH_SAMPLES = 5 };

int bench_ascending(const void *a, const void *b); /* doubles, for qsort */
/* Middle of n values; sorts them. */
double bench_median(int n, double *value);
/* Rows for packings of the scene at 1e-4 .. 1e-7: the median CPU time of BENCH_SAMPLES seeds; error: the largest
 * elastic acceleration at the end over p. */
sp_status bench_pack(const cli_common *common, const sp_scene *scene, sp_table *t, sp_error *err);

#endif
