#ifndef SP_CHOOSE_H
#define SP_CHOOSE_H
/* Estimates the cost of a signal by each method. */

#include <sonopack/signal.h>

/* Estimated time in nanoseconds on one core of 2023; only ratios matter. HUGE_VAL: the method does not support these
 * options. */
double sp_signal_cost(sp_signal_method method, const sp_network *net, const sp_signal_options *o);

enum { SIGNAL_CHOICES = 4 };
/* The methods that support these options, cheapest first; returns their number, at least 1. The later ones are
 * alternatives if earlier ones miss the tolerance; they take at most ten seconds or ten times as long as the first. */
int sp_signal_choose(const sp_network *net, const sp_signal_options *o, sp_signal_method choice[SIGNAL_CHOICES]);

#endif
