#ifndef SP_STUDY_GROUPS_H
#define SP_STUDY_GROUPS_H
/* Samples in the one order that every table uses, whatever order they came in. */

#include <sonopack/study/study.h>

/* Pointers to the samples, by pressure, then grains, then seed; of several of one name the one that has most.
 * *count: how many. Caller frees. */
SP_SHARED sp_status sp_samples_sorted(int64_t n, const sp_sample *samples, const sp_sample ***sorted, int64_t *count,
                                      sp_error *err);

/* Samples that may be averaged: one friction, width and dimension, and no seed twice at one pressure and size (that
 * is two scenes which a sample's fields cannot tell apart). Else SP_EREFUSED. */
SP_SHARED sp_status sp_samples_alike(int64_t n, const sp_sample *const *s, sp_error *err);

/* End of the samples of s[begin]'s pressure; of its pressure and grains. */
int64_t sp_pressure_end(int64_t n, const sp_sample *const *s, int64_t begin);
int64_t sp_size_end(int64_t n, const sp_sample *const *s, int64_t begin);
int64_t sp_samples_failed(int64_t n, const sp_sample *const *s);
/* Those with a packing that were to have the part, and do not. */
int64_t sp_samples_lacking(int64_t n, const sp_sample *const *s, unsigned part);

/* Sorts further, for tables that have a row for each height: by pressure, friction, dimension and width, then grains
 * and seed. SP_EREFUSED for a seed that is there twice. */
sp_status sp_samples_by_material(int64_t n, const sp_sample **s, sp_error *err);
/* End of the samples of s[begin]'s pressure, friction, dimension and width, of samples sorted so; of its grains too. */
int64_t sp_material_end(int64_t n, const sp_sample *const *s, int64_t begin);
int64_t sp_height_end(int64_t n, const sp_sample *const *s, int64_t begin);

/* Tables with intervals of a level. Fronts over distance: of whole boxes, a row a height; or of the planes inside of
 * each size of box, a row a plane. */
sp_status sp_scaling_fill(int64_t n, const sp_sample *const *s, bool planes, double level, sp_table *t, sp_error *err);
/* The table "ctof", which is more than means. */
sp_status sp_ctof_fill(int64_t n, const sp_sample *const *s, double level, sp_table *t, sp_error *err);

#endif
