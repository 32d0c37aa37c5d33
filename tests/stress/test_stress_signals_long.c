/* The signals of the stress test with other random numbers, and every method for the longest times. */
#define STRESS_LONG
#include "test_stress_signals.c"
