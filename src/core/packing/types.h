#ifndef SP_TYPES_H
#define SP_TYPES_H
/* Grains of several materials. A type is the number of a material; grains of one material have type 0. */

#include "numeric/random.h"

#include <sonopack/packing.h>

/* What a contact's law has beside the radii. stiffness: E12 over that of two grains with E* = 1, at a wall over that of
 * one. eta: k_t/k_n. */
typedef struct contact_rule {
    double stiffness, eta, sqrt_eta, friction;
} contact_rule;

/* Number of materials, 1 for none. */
static inline int sp_types_count(const sp_pack_spec *s) { return s->types.fractions > 0 ? s->types.fractions : 1; }
/* Whether contacts differ from those of one material with E* = 1, so that packings have stiffnesses of their own. */
bool sp_types_mixed(const sp_pack_spec *s);
/* The lists' lengths and sums, and what does not go with them. The values are in their ranges. SP_EINVAL. */
sp_status sp_types_check_counts(const sp_pack_spec *s, sp_error *err);
sp_status sp_types_check(const sp_pack_spec *s, sp_error *err);

/* The law between types s and t; t < 0: at a wall. */
contact_rule sp_types_rule(const sp_pack_spec *spec, int s, int t);
/* Largest and smallest density and E*. */
typedef struct sp_types_range {
    double densest, lightest, stiffest, softest;
} sp_types_range;
sp_types_range sp_types_limits(const sp_pack_spec *spec);
double sp_types_mass(const sp_pack_spec *spec, int type, double r);
/* I/(m R^2). */
static inline double sp_types_inertia(const sp_pack_spec *spec) { return spec->shape == SP_SHAPE_DISK ? 0.5 : 0.4; }
/* The types of the grains one after another: of each as many as its fraction says, at random. */
typedef struct sp_type_draw {
    sp_random stream;
    int32_t left[SP_TYPES_MAX], grains;
} sp_type_draw;
sp_type_draw sp_types_begin(const sp_pack_spec *spec);
int sp_types_next(sp_type_draw *draw);
/* The types of all grains [grains]; NULL if there is no memory. */
int32_t *sp_types_draw(const sp_pack_spec *spec);
/* Gives a packing whose contacts know their forces and overlaps its masses, and stiffnesses where materials are mixed.
 * type [n] in the order of its grains. SP_ENOMEM. */
sp_status sp_types_finish(const sp_pack_spec *spec, const int32_t *type, sp_packing *p, sp_error *err);

#endif
