/* The properties of random networks on more scenes. */
#define SCENES 4000
#include "test_properties_network.c"
