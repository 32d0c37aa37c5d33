#ifndef SP_STUDY_GROUPS_H
#define SP_STUDY_GROUPS_H
/* The order of samples in tables, and groups of samples that are averaged. */

#include <sonopack/study/study.h>

/* Pointers to the samples, sorted by fraction or pressure, then stage, grains, and seed. Of several samples of one
 * name, only that with the most parts is kept. *count is the number of pointers. The caller frees *sorted. */
SP_SHARED sp_status sp_samples_sorted(int64_t n, const sp_sample *samples, const sp_sample ***sorted, int64_t *count,
                                      sp_error *err);

/* SP_EREFUSED unless the samples may be averaged: they need the same friction, width and dimension, and no seed may be
 * there twice at one pressure, stage and size, for then two scenes are mixed. */
SP_SHARED sp_status sp_samples_alike(int64_t n, const sp_sample *const *s, sp_error *err);

/* End of the group that begins at s[begin]: samples of its pressure (or fraction, and stage); and of its number of
 * grains. */
int64_t sp_pressure_end(int64_t n, const sp_sample *const *s, int64_t begin);
int64_t sp_size_end(int64_t n, const sp_sample *const *s, int64_t begin);
int64_t sp_samples_failed(int64_t n, const sp_sample *const *s);
/* How many samples have a packing, but failed to get this part. */
int64_t sp_samples_lacking(int64_t n, const sp_sample *const *s, unsigned part);

/* Sorts samples for tables with a row for each height: by pressure, stage, friction, dimension and width, then grains
 * and seed. SP_EREFUSED for a seed that is there twice. */
sp_status sp_samples_by_material(int64_t n, const sp_sample **s, sp_error *err);
/* End of a group of such samples: of one pressure, stage, friction, dimension and width; and of one number of grains as
 * well.
 */
int64_t sp_material_end(int64_t n, const sp_sample *const *s, int64_t begin);
int64_t sp_height_end(int64_t n, const sp_sample *const *s, int64_t begin);

/* Adds the columns of what else tables go by, if any of the samples has it: fraction; stage and strain; and in tables
 * of means the error of p, which then is a mean, too. */
sp_status sp_state_columns(int64_t n, const sp_sample *const *s, bool means, sp_table *t, sp_error *err);
enum { SP_STATE_COLUMNS = 4 };
/* The numbers in these columns for a group. Returns how many of them the table has. */
int sp_state_put(int64_t n, const sp_sample *const *s, const sp_table *t, double *row);
/* The pressure of a group: that of the scene, or with a fraction or stage the mean of its packings. *error: of the
 * mean, else NAN. */
double sp_state_pressure(int64_t n, const sp_sample *const *s, double *error);

/* Adds columns to a table without rows. */
sp_status sp_columns_add(sp_table *t, int count, const sp_column *column, sp_error *err);
/* Fills the table of fronts over distance: a row for each height of boxes, or a row for each plane inside boxes of one
 * size. level is that of the intervals. */
sp_status sp_scaling_fill(int64_t n, const sp_sample *const *s, bool planes, double level, sp_table *t, sp_error *err);
/* Fills the table ctof. */
sp_status sp_ctof_fill(int64_t n, const sp_sample *const *s, double level, sp_table *t, sp_error *err);

#endif
