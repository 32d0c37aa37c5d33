#ifndef SONOPACK_COUNTS_H
#define SONOPACK_COUNTS_H
/* Histograms of the contacts of packings: directions (Fig. 2 of Somfai et al. 2005), normal forces and stiffnesses
 * (Fig. 1(c)). Packings are added one at a time, so that thousands of them need no memory. */

#include <sonopack/packing.h>
#include <sonopack/table.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { SP_ANGLE_BINS = 36, SP_VALUE_BINS = 100 };

/* Density of one quantity: of each packing its own, with the integral 1; sums of it and of its square over packings. */
typedef struct sp_angle_counts {
    int64_t packings; /* that have such contacts */
    double contacts;
    double sum[SP_ANGLE_BINS], squares[SP_ANGLE_BINS];
} sp_angle_counts;
typedef struct sp_value_counts {
    double sum[SP_VALUE_BINS], squares[SP_VALUE_BINS];
    double beyond; /* part of the contacts beyond the last bin, summed over packings */
} sp_value_counts;

typedef struct sp_contact_counts {
    int dim; /* of the packings; 0: none yet */
    int64_t packings;
    double contacts;
    sp_angle_counts all, strong,
        weak; /* bins around 0, 5, ... degrees from the x axis, n and -n being the same; 1: isotropic */
    sp_value_counts force, stiffness; /* bins of 0.1 of the value over its mean in its own packing */
} sp_contact_counts;
SP_API sp_contact_counts sp_contact_counts_none(void);

/* Adds the contacts between grains that carry (threshold as in sp_packing_rattlers) and whose points lie at least
 * `margin` from both walls. Strong: the normal force is above the mean of these contacts, weak: it is not. SP_EREFUSED
 * for a packing without such contacts, SP_EINVAL for one of another dimension than those before. */
SP_API sp_status sp_contact_counts_add(sp_contact_counts *c, const sp_packing *p, double threshold, double margin,
                                       sp_error *err);

/* Means over packings with their standard errors (nan for one packing). Columns: angle [degrees] all all_err strong
 * strong_err weak weak_err, of packings in two dimensions (SP_EREFUSED for others); x forces forces_err stiffnesses
 * stiffnesses_err, at the middle of the bins, up to the last that is not empty. SP_EREFUSED without a packing. */
SP_API sp_status sp_contact_angles_table(const sp_contact_counts *c, sp_table *out, sp_error *err);
SP_API sp_status sp_contact_values_table(const sp_contact_counts *c, sp_table *out, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
