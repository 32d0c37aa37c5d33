#ifndef SP_STORE_FAILURE_H
#define SP_STORE_FAILURE_H
/* NAME.failed is the record of a sample that could not be made, in 'key = value' lines. */

#include <sonopack/study/study.h>

sp_status sp_failure_save(const char *path, const sp_sample *sample, sp_error *err);
sp_status sp_failure_read(const char *path, const char *name, sp_sample *out, sp_error *err);

#endif
