#ifndef SP_STUDY_SPEED_H
#define SP_STUDY_SPEED_H
/* Intervals of tables: of a front's speed between two distances, and what the tables say of all of them. */

#include "numeric/interval.h"
#include <sonopack/scaling.h>
#include <sonopack/study/study.h>

/* Arrivals at about one distance; NAN: none. */
typedef struct sp_arrivals {
    int64_t n;
    const double *distance, *time;
} sp_arrivals;

/* Of (<L2> - <L1>) / (<t>2 - <t>1), by studentised bootstrap (numeric/interval.h) with the error to first order in the
 * deviations from the means. Independent samples are drawn by themselves; of joint ones sample k is of one packing, and
 * these are drawn. NAN with fewer than 2 samples of either, and where the speed is none. */
sp_status sp_speed_interval(const sp_arrivals *near, const sp_arrivals *far, bool joint, double level, sp_interval *out,
                            sp_error *err);

/* Mean long-wave speed of the samples that have moduli, and its standard error; NAN without. scratch[n]. */
sp_estimate sp_wave_speed(int64_t n, const sp_sample *const *s, bool transverse, double *scratch);

/* "_low, _high: 95% interval of WHAT, ..." */
sp_status sp_interval_comment(sp_table *t, double level, const char *what, sp_error *err);

#endif
