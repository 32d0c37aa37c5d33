#ifndef SONOPACK_COUNTS_H
#define SONOPACK_COUNTS_H
/* Histograms of contacts: directions (Fig. 2 of Somfai et al. 2005), normal forces and stiffnesses (Fig. 1(c)).
 * Packings are added one at a time and need not be kept. */

#include <sonopack/packing.h>
#include <sonopack/table.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { SP_ANGLE_BINS = 36, SP_ELEVATION_BINS = 12, SP_VALUE_BINS = 100 };

/* Histogram of one quantity. Each packing contributes a density with integral 1; sums of the densities and of their
 * squares are kept. */
typedef struct sp_angle_counts {
    int64_t packings; /* number of packings with such contacts */
    double contacts;
    double sum[SP_ANGLE_BINS], squares[SP_ANGLE_BINS];
} sp_angle_counts;
typedef struct sp_value_counts {
    double sum[SP_VALUE_BINS], squares[SP_VALUE_BINS];
    double beyond; /* fraction of contacts beyond the last bin, summed over packings */
} sp_value_counts;

typedef struct sp_contact_counts {
    int dim; /* dimension of the packings; 0: none added yet */
    int64_t packings;
    double contacts;
    sp_angle_counts all, strong,
        weak; /* bins around 0, 5, ... degrees from the x axis; n and -n are equivalent; isotropic: 1. In three
                 dimensions SP_ELEVATION_BINS bins around 0, 15, ..., 165 degrees of elevation above the walls */
    sp_value_counts force, stiffness; /* bins of width 0.1 of the value over its mean in the same packing */
} sp_contact_counts;
SP_API sp_contact_counts sp_contact_counts_none(void);

/* Adds the force-carrying contacts between grains (threshold as in sp_packing_rattlers) at a distance of at least
 * `margin` [d] from all walls. Strong contacts have a normal force above the mean of these contacts; the others are
 * weak. SP_EREFUSED if there are no such contacts, SP_EINVAL if the dimension differs from that of earlier packings. */
SP_API sp_status sp_contact_counts_add(sp_contact_counts *c, const sp_packing *p, double threshold, double margin,
                                       sp_error *err);

/* Tables of the means over packings with standard errors (nan for one packing). Angles: angle [degrees]
 * all all_err strong strong_err weak weak_err; in three dimensions those of elevation, from 0 to 165 degrees, where a
 * and 180 - a have the same contacts. Values: x forces forces_err stiffnesses stiffnesses_err, where x is the centre of
 * a bin, up to the last nonempty one. SP_EREFUSED without packings, or for angles in one dimension. */
SP_API sp_status sp_contact_angles_table(const sp_contact_counts *c, sp_table *out, sp_error *err);
SP_API sp_status sp_contact_values_table(const sp_contact_counts *c, sp_table *out, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
