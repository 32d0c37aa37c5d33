#ifndef SP_STORE_SAMPLE_H5_H
#define SP_STORE_SAMPLE_H5_H
/* Results of a sample inside an HDF5 file that is open. */

#include "store/h5.h"
#include "store/packing_h5.h"

#include <sonopack/study/study.h>

/* What a sample's file holds besides the packing. */
typedef struct sp_record {
    sp_sample sample; /* `have` names the parts that are there */
    sp_sample_arrays arrays;
    char *scene; /* NULL: unknown */
} sp_record;

void sp_record_free(sp_record *r);
sp_status sp_record_put(sp_h5 *h, const sp_record *r, sp_error *err);
/* with_arrays = false leaves the arrays and the scene in the file. */
sp_status sp_record_get(sp_h5 *h, bool with_arrays, sp_record *out, sp_error *err);

/* A sample before anything was read into it: what is not kept is no number. */
sp_sample sp_sample_blank(void);

/* The numbers that a sample consists of, beside its signal and its planes, for what keeps them elsewhere. */
typedef struct sp_result {
    const sp_h5_field *field;
    size_t offset; /* in sp_sample, the field's own included */
    unsigned want; /* the part that it belongs to; 0: every sample has it */
} sp_result;
enum { SP_RESULTS_MAX = 80 };
int sp_results(sp_result out[SP_RESULTS_MAX]);

#endif
