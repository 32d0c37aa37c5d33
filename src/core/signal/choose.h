#ifndef SP_CHOOSE_H
#define SP_CHOOSE_H
/* Estimates the cost of a signal by each method. */

#include <sonopack/signal.h>

/* What of a network decides the cost. */
typedef struct sp_signal_problem {
    double dofs, springs, omega; /* omega: upper bound of the spectrum */
    int dim;
    bool carried; /* K is not symmetric */
} sp_signal_problem;
/* As sp_signal_cost, of a network that need not exist. */
double sp_signal_problem_cost(sp_signal_method method, const sp_signal_problem *problem, const sp_signal_options *o);

/* Estimated time in nanoseconds on one core of 2023; only ratios matter. HUGE_VAL: the method does not support these
 * options. */
double sp_signal_cost(sp_signal_method method, const sp_network *net, const sp_signal_options *o);

enum { SIGNAL_CHOICES = 4 };
/* The methods that support these options, cheapest first; returns their number, at least 1. The later ones are
 * alternatives if earlier ones miss the tolerance; they take at most ten seconds or ten times as long as the first. */
int sp_signal_choose(const sp_network *net, const sp_signal_options *o, sp_signal_method choice[SIGNAL_CHOICES]);

#endif
