#ifndef SP_PAPER_SIGNALS_H
#define SP_PAPER_SIGNALS_H
/* Signals of the packings of an ensemble, at the same times. */

#include "paper/paper.h"

#include <sonopack/signal.h>

enum { PAPER_SINGLES = 4 };

typedef struct paper_signals {
    int32_t points;
    int64_t n; /* number of packings */
    double *t, *mean,
        *rms;       /* [points] mean and root mean square deviation over the packings; rms is NAN for a single one */
    double *single; /* [PAPER_SINGLES][points] signals of the first packings; NAN if there are fewer */
    double height;  /* mean height [d] */
} paper_signals;

/* Averages over all packings with this pressure and number of grains (0: any). */
sp_status sp_paper_signals_make(paper *p, paper_ensemble e, int32_t grains, double until, int32_t points,
                                paper_signals *out, sp_error *err);
void sp_paper_signals_free(paper_signals *s);
/* Divides all signals by a number. */
void sp_paper_signals_over(paper_signals *s, double by);
/* Height of the first peak of the mean; its largest value if there is no front. */
double sp_paper_signals_peak(const paper_signals *s);

/* Signal of a network with viscous damping, a fraction of critical. */
sp_status sp_paper_damped_signal(const sp_network *net, double damping, double until, int32_t points, sp_signal *out,
                                 sp_error *err);
/* Root mean square of a signal after a time; NAN if it ends before. */
double sp_paper_rms_after(const sp_signal *s, double time);

#endif
