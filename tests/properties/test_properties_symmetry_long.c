/* The properties of random packings seen otherwise, on more scenes. */
#define SCENES 4000
#include "test_properties_symmetry.c"
