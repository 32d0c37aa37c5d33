#ifndef SP_STORE_MODES_H5_H
#define SP_STORE_MODES_H5_H
/* Layout of a file of modes. */

#include "store/h5.h"
#include "store/packing_h5.h"

#include <sonopack/study/modes_file.h>

/* Increased when older versions would misread the format. */
enum { SP_MODES_FORMAT = 1 };

extern const sp_h5_name sp_modes_name_vector, sp_modes_name_mass, sp_modes_name_grain, sp_modes_name_column,
    sp_modes_name_rattler, sp_modes_name_packing, sp_modes_name_source, sp_modes_name_solver;

/* An array with one number for each mode. */
typedef struct sp_modes_array {
    sp_h5_name name;
    size_t offset; /* of the pointer in sp_modes */
} sp_modes_array;
enum { SP_MODES_ARRAYS = 5 };
extern const sp_modes_array sp_modes_arrays[SP_MODES_ARRAYS];

/* Single numbers: counts and certificate, in sp_modes; and the network, in sp_modes_numbers. */
extern const sp_h5_field sp_modes_fields[], sp_modes_network_fields[];
extern const int sp_modes_field_count, sp_modes_network_field_count;
typedef struct sp_modes_numbers {
    double threshold;
    int32_t prestress, sliding_free, dim, dof;
} sp_modes_numbers;

extern const char *const sp_modes_sources[3]; /* by sp_source */
extern const char *const sp_modes_solvers[4]; /* by sp_modes_solver */

static inline double **sp_modes_array_at(const sp_modes_array *a, sp_modes *m) {
    return (double **)(void *)((char *)m + a->offset);
}

#endif
