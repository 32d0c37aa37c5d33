#ifndef SP_CHOOSE_H
#define SP_CHOOSE_H
/* What a signal costs by each method, and which is cheapest. */

#include <sonopack/signal.h>

/* Nanoseconds of a core of 2023, from what the method does: how often, and how large. Only their ratios matter.
 * HUGE_VAL: the method does not serve these options. */
double sp_signal_cost(sp_signal_method method, const sp_network *net, const sp_signal_options *o);

enum { SIGNAL_CHOICES = 4 };
/* The methods that serve these options, the cheapest first; returns their number, 1 or more. The further ones are for
 * where those before them cannot vouch for the tolerance, and take ten seconds or ten times as long at the most. */
int sp_signal_choose(const sp_network *net, const sp_signal_options *o, sp_signal_method choice[SIGNAL_CHOICES]);

#endif
