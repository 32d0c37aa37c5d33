#ifndef SP_PERTURB_H
#define SP_PERTURB_H
/* Packings drawn with errors of measurement. */

#include <sonopack/uncertainty.h>

/* A grain and another one, or a wall, that do not touch as listed but may. */
typedef struct sp_near {
    int32_t i, j;
} sp_near;

/* What all draws of a packing share. */
typedef struct sp_drawing {
    const sp_packing *p;
    const sp_errors *errors;
    int32_t candidates;
    sp_near *candidate; /* [candidates] pairs within the gap that are not listed */
    double mean_force;  /* of the listed contacts above the threshold 0 */
} sp_drawing;

sp_status sp_errors_check(const sp_errors *e, sp_error *err);
/* Does not copy p and errors. */
sp_status sp_drawing_make(const sp_packing *p, const sp_errors *errors, sp_drawing *out, sp_error *err);
void sp_drawing_free(sp_drawing *d);
/* sp_packing_perturb. */
sp_status sp_drawing_draw(const sp_drawing *d, uint64_t seed, int64_t sample, sp_packing *out, sp_error *err);

#endif
