/* The properties of packings made from random scenes, on more of them. */
#define SCENES 300
#include "test_properties_packed.c"
