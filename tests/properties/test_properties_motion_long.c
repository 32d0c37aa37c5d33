/* The properties of random motions, on more scenes. */
#define SCENES 1500
#include "test_properties_motion.c"
