#ifndef SP_STUDY_SPEED_H
#define SP_STUDY_SPEED_H
/* Speeds in tables, and their confidence intervals. */

#include "numeric/interval.h"
#include <sonopack/scaling.h>
#include <sonopack/study/study.h>

/* Arrivals of fronts at about the same distance. A time of NAN is no arrival. */
typedef struct sp_arrivals {
    int64_t n;
    const double *distance, *time;
} sp_arrivals;

/* Interval of (<L2> - <L1>) / (<t>2 - <t>1) by studentised bootstrap (numeric/interval.h). The error is to first order
 * in the deviations from the means. Independent samples of the two distances are resampled separately. If they are
 * joint, sample k of both is of the same packing, and packings are resampled. NAN with fewer than 2 samples at either
 * distance, and where the differences are not positive. */
sp_status sp_speed_interval(const sp_arrivals *near, const sp_arrivals *far, bool joint, double level, sp_interval *out,
                            sp_error *err);

/* Mean long-wave speed of the samples that have moduli, and its standard error; NAN if none has. scratch[n]. */
sp_estimate sp_wave_speed(int64_t n, const sp_sample *const *s, bool transverse, double *scratch);

/* Adds the comment on the columns _low and _high of a table. */
sp_status sp_interval_comment(sp_table *t, double level, const char *what, sp_error *err);

#endif
