#ifndef SP_PAPER_SIGNALS_H
#define SP_PAPER_SIGNALS_H
/* Signals of an ensemble's packings on one grid of times. */

#include "paper/paper.h"

#include <sonopack/signal.h>

enum { PAPER_SINGLES = 4 };

typedef struct paper_signals {
    int32_t points;
    int64_t n;              /* packings */
    double *t, *mean, *rms; /* [points] over the packings; rms: root mean square deviation, NAN for a single one */
    double *single;         /* [PAPER_SINGLES][points] of the first packings; NAN where there are none */
    double height;          /* mean */
} paper_signals;

/* Of all packings with this pressure and these grains (0: any). */
sp_status sp_paper_signals_make(paper *p, paper_ensemble e, int32_t grains, double until, int32_t points,
                                paper_signals *out, sp_error *err);
void sp_paper_signals_free(paper_signals *s);
/* Divides all of them by a number. */
void sp_paper_signals_over(paper_signals *s, double by);
/* Height of the first peak of the mean (its largest value where there is no front). */
double sp_paper_signals_peak(const paper_signals *s);

#endif
