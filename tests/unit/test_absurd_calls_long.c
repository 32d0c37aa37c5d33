/* The rounds of test_absurd_calls, ten thousand times. */
#define ROUNDS 10000
#include "test_absurd_calls.c"
