#ifndef SP_STORE_SAMPLE_H5_H
#define SP_STORE_SAMPLE_H5_H
/* Results of a sample in an open HDF5 file. */

#include "store/h5.h"
#include "store/packing_h5.h"

#include <sonopack/study/study.h>

/* Content of a sample's file, except for the packing. */
typedef struct sp_record {
    sp_sample sample; /* `have`: the parts in the file */
    sp_sample_arrays arrays;
    char *scene; /* NULL: unknown */
} sp_record;

void sp_record_free(sp_record *r);
void sp_record_put(sp_h5 *h, const sp_record *r);
/* Without with_arrays, neither the arrays nor the scene are read. */
sp_status sp_record_get(sp_h5 *h, bool with_arrays, sp_record *out);

/* Which of the numbers that tables sort and divide by, or count with, is none that a sample can have; NULL: none. */
const char *sp_sample_fault(const sp_sample *s);
/* A sample before anything was read into it. Numbers that are not stored are NAN. */
sp_sample sp_sample_blank(void);

/* One of the numbers in a sample. The manifest stores the same numbers as the file. */
typedef struct sp_result {
    const sp_h5_field *field;
    size_t offset; /* in sp_sample */
    unsigned want; /* its part; 0: every sample has it */
} sp_result;
enum { SP_RESULTS_MAX = 96 };
int sp_results(sp_result out[SP_RESULTS_MAX]);
/* Whether a number of every sample is 0. */
bool sp_is_zero(const sp_h5_field *f, const sp_sample *s);

/* The numbers of each plane: its height, and the front there. */
typedef struct sp_plane_field {
    sp_h5_name name;
    size_t offset, stride; /* of the first plane's in sp_sample; from one plane's to the next one's */
} sp_plane_field;
enum { SP_PLANE_FIELDS = 6 };
extern const sp_plane_field sp_plane_fields[SP_PLANE_FIELDS];
double sp_plane_number(const sp_plane_field *f, const sp_sample *s, int32_t plane);
void sp_plane_set(const sp_plane_field *f, sp_sample *s, int32_t plane, double number);

#endif
