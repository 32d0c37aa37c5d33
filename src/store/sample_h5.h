#ifndef SP_STORE_SAMPLE_H5_H
#define SP_STORE_SAMPLE_H5_H
/* Results of a sample inside an HDF5 file that is open. */

#include "store/h5.h"

#include <sonopack/study.h>

/* What a sample's file holds besides the packing. */
typedef struct sp_record {
    sp_sample sample; /* `have` names the parts that are there */
    sp_signal signal; /* n = 0: none */
    char *scene;      /* NULL: unknown */
} sp_record;

void sp_record_free(sp_record *r);
sp_status sp_record_put(sp_h5 *h, const sp_record *r, sp_error *err);
/* with_signal = false leaves the signal's data and the scene in the file. */
sp_status sp_record_get(sp_h5 *h, bool with_signal, sp_record *out, sp_error *err);

#endif
