#ifndef SP_STUDY_SAMPLE_H
#define SP_STUDY_SAMPLE_H
/* Names of samples, and how one sample is computed. */

#include <sonopack/front.h>
#include <sonopack/study/study.h>
#include <stddef.h>

/* FNV-1a of 128 bits, as 32 hexadecimal digits. */
void sp_hash128(const void *data, size_t size, char text[SP_NAME_MAX]);
/* Scene and name of sample k of a study. */
SP_SHARED sp_status sp_study_sample(const sp_scene *study, int64_t k, sp_scene *scene, char name[SP_NAME_MAX],
                                    sp_error *err);
/* Hash of the scene's keys of the group signal, by which one signal of a sample differs from another. 0: no memory. */
uint64_t sp_signal_keys(const sp_scene *scene);

/* Fills in the name and the keys of a sample. scene: resolved. SP_ENOMEM. */
sp_status sp_sample_describe(const sp_scene *scene, sp_sample *sample, sp_error *err);
/* Adds what the packing decides where the scene does not: the pressure. */
void sp_sample_measure(const sp_packing *p, sp_sample *sample);

/* Spacing of the times at which a signal is sampled for its front. */
double sp_front_spacing(double pressure);
/* Options for a signal over the times 0 .. window whose front is to be found. */
sp_status sp_front_grid(const sp_network *net, sp_source source, double window, sp_signal_options *out, sp_error *err);
/* sp_sample_make with hooks for the compression of the packing. */
sp_status sp_sample_make_with(const sp_scene *scene, unsigned want, const sp_pack_hooks *hooks, sp_packing *packing,
                              sp_sample *sample, sp_sample_arrays *arrays, sp_error *err);
/* Makes the `missing' parts of a sample from its packing. sample->have tells which of them succeeded. Returns the
 * reason of the first that failed. */
sp_status sp_parts_make(const sp_scene *scene, unsigned missing, const sp_packing *packing, sp_sample *sample,
                        sp_sample_arrays *arrays, sp_error *err);

#endif
