#ifndef SP_STUDY_PARTS_H
#define SP_STUDY_PARTS_H
/* The parts of a sample's results. */

#include <sonopack/study/study.h>

typedef struct part_input {
    const sp_scene *scene;
    const sp_packing *packing;
    const sp_network *net;
} part_input;

/* Makes the `missing' parts of a sample from its packing. sample->have tells which of them succeeded. Returns the
 * reason of the first that failed. */
sp_status sp_parts_make(const sp_scene *scene, unsigned missing, const sp_packing *packing, sp_sample *sample,
                        sp_sample_arrays *arrays, sp_error *err);

#endif
