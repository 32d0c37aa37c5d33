/* The properties of waves on more scenes. */
#define SCENES 600
#include "test_properties_waves.c"
