#ifndef SONOPACK_PLOT_H
#define SONOPACK_PLOT_H
/* Figures from plain arrays and tables: PNG, SVG or PDF by the ending of the path. */

#include <sonopack/status.h>
#include <sonopack/table.h>

#ifdef __cplusplus
extern "C" {
#endif

/* c_tof (with error bars), c_l and c_t against p, log-log, with the published c_tof ~ 0.26 (p/1e-4)^(1/6). `ctof` is
 * the table of sp_study_table("ctof"). */
sp_status sp_plot_ctof(const sp_table *ctof, const char *path, sp_error *err);

typedef struct sp_plot_trace {
    const char *label;
    int64_t n;
    const double *t, *f;
    double t10, t_peak, t_zero; /* marks of the first front, NAN: none */
} sp_plot_trace;
/* F(t) of one or several signals. */
sp_status sp_plot_signal(int traces, const sp_plot_trace *trace, const char *path, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
