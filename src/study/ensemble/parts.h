#ifndef SP_STUDY_PARTS_H
#define SP_STUDY_PARTS_H
/* What a part of a sample's results is made of. */

#include <sonopack/study/study.h>

typedef struct part_input {
    const sp_scene *scene;
    const sp_packing *packing;
    const sp_network *net;
} part_input;

/* Every part of `missing' from a packing, as far as it can be made: *sample's `have' says which could. The first
 * reason is returned. */
sp_status sp_parts_make(const sp_scene *scene, unsigned missing, const sp_packing *packing, sp_sample *sample,
                        sp_sample_arrays *arrays, sp_error *err);

#endif
